"""Work put off: once for many requests, one number for many steps, one answer for many asks."""

import os
import subprocess
import sys
from pathlib import Path

from PySide6.QtCore import QObject

from inspector.widgets.background import OneTask
from inspector.widgets.later import Burst, Latest, RedrawRequests


def test_a_view_is_told_once_for_all_that_a_change_makes_stale(qtbot, qapp):
    stale, told = RedrawRequests(qapp), []
    stale.due.connect(lambda: told.append(stale.take()))
    for mark in (stale.mark, stale.mark_all, stale.mark):
        mark()
    assert told == []
    qtbot.wait(1)
    assert told == [(True, True)]
    stale.mark()
    assert stale.take() == (True, False)  # drawn at once, for somebody who cannot wait
    qtbot.wait(1)
    assert told[1:] == [(False, False)]


def test_only_the_last_of_many_requests_is_carried_out(qtbot, qapp):
    latest, done = Latest(qapp), []
    for number in range(3):
        latest.ask(lambda n=number: done.append(n))
    latest.flush()
    qtbot.wait(1)
    assert done == [2]


def test_steps_in_quick_succession_have_one_number(qtbot, qapp):
    numbers = iter(range(10))
    burst = Burst(lambda: next(numbers), qapp)
    assert [burst.drag(), burst.drag()] == [0, 0]
    qtbot.waitUntil(lambda: not burst.active)
    assert burst.drag() == 1


def test_another_work_takes_the_place_of_what_is_under_way(qtbot, qapp):
    owner = QObject()
    task, told = OneTask(owner), []
    task.run(lambda _: 1, told.append)
    task.run(lambda _: 1 / 0, told.append, lambda error: told.append(type(error)))
    assert task.running
    qtbot.waitUntil(lambda: not task.running)
    task.run(lambda _: 2, told.append)
    task.cancel()
    qtbot.wait(20)
    assert told == [ZeroDivisionError]


def test_what_a_thread_works_for_may_be_deleted_meanwhile():
    """An answer must not come through an object that is just being deleted: a crash."""
    script = Path(__file__).with_name("deleted_tasks.py")
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, env=environment)
    assert done.stdout == "still there\n", done.stderr
