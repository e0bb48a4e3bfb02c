"""Another clip opens while a hand is busy with the last one: nothing of it reaches the new one.

And a round of reviews, over and over: as much is alive behind each as behind the one before.
"""

import random
import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent

from benchmarks.alive import heard
from benchmarks.endurance import Sitting
from inspector.session.opening import analyse_file
from tests.gui.pictures import INJECTED, WALK
from tests.gui.test_plots import LEFT, NONE, send, shown, spot
from tests.gui.windows import act, open_clip
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Decision


@pytest.fixture
def document(open_document):
    """The walk with eight errors."""
    return open_document(INJECTED)


@pytest.fixture
def next_clip(tmp_path):
    """A clip that has intervals of the same ids, in other places."""
    folder = tmp_path / "next"
    folder.mkdir()
    return Path(shutil.copy(INJECTED, folder))


def press(qtbot, timeline, start, other):
    """Hold the mouse at a place and pull; what the last move asks for is still to be done."""
    pane = timeline.panes["strength"]
    send(pane, QEvent.Type.MouseMove, start, NONE, NONE)
    send(pane, QEvent.Type.MouseButtonPress, start, LEFT, LEFT)
    for k in range(1, 9):
        qtbot.wait(5)
        send(pane, QEvent.Type.MouseMove, start + (other - start) * (k / 8), NONE, LEFT)


def pull_on(qtbot, timeline, place):
    """The hand goes on, and lets go."""
    pane = timeline.panes["strength"]
    send(pane, QEvent.Type.MouseMove, place, NONE, LEFT)
    qtbot.wait(10)
    send(pane, QEvent.Type.MouseButtonRelease, place, LEFT, NONE)
    qtbot.wait(10)


@pytest.mark.thorough
@pytest.mark.parametrize("what", ["edge", "body", "new interval", "tau"])
@pytest.mark.parametrize("opens", ["at once", "before the last move is done"])
def test_a_drag_ends_with_its_clip(qtbot, document, next_clip, what, opens):
    timeline = shown(qtbot, document)
    judged = max(document.intervals, key=lambda j: j.interval.frames)
    document.select_interval(judged.id)
    frame = {
        "edge": judged.interval.start - 0.5,
        "body": (judged.interval.start + judged.interval.stop) / 2,
    }.get(what, 3.0)
    share = 0.5
    if what == "tau":
        low, high = timeline.panes["strength"].view.viewRange()[1]
        share = (high - timeline.tau_line.value()) / (high - low)
    qtbot.wait(20)
    start = spot(timeline, "strength", frame, share)
    before = document.review.state
    press(qtbot, timeline, start, spot(timeline, "strength", frame + 12, share - 0.2))
    if opens == "at once":
        qtbot.wait(20)
        assert document.review.state is not before or what == "new interval"
    with heard() as said:
        document.show_clip(analyse_file(next_clip))
        state = document.review.state
        pull_on(qtbot, timeline, spot(timeline, "strength", frame + 25, share - 0.3))
    assert document.review.state is state
    assert said.wrong == []


def test_what_a_plots_menu_offers_goes_with_the_clip(qtbot, document, next_clip):
    timeline = shown(qtbot, document)
    position = timeline.mapToGlobal(timeline.rect().center())
    menu = timeline.gestures.open_menu("strength", 100.0, 1.0, position)
    gone = []
    menu.destroyed.connect(lambda: gone.append(True))
    document.show_clip(analyse_file(next_clip))
    qtbot.waitUntil(lambda: gone == [True])


def test_a_command_for_an_interval_that_is_gone_is_dropped(document):
    document.show_clip(analyse_file(WALK))
    state, gone = document.review.state, 1 + max((j.id for j in document.intervals), default=0)
    told = []
    document.message.connect(lambda _text, wrong: told.append(wrong))
    document.edit(gone, new_constant_offset_interval(document.chain, 3, 9, 1.0))
    document.decide(Decision.ACCEPTED, [gone])
    document.select_interval(gone)
    assert document.review.state is state
    assert document.interval_id is None
    assert not any(told)


@pytest.mark.thorough
def test_a_suspicious_moment_of_the_last_clip_is_not_put_into_this_one(qtbot, window, clip):
    open_clip(qtbot, window, clip)
    document, actions = window.document, window.review_actions
    for chain in document.data.chains:
        document.set_tau(1.2 * float(np.max(document.detector.strength(chain.name))), chain.name)
    act(window, "next_faint")
    assert actions._faint is not None
    faint, frame = actions._faint, document.frame
    open_clip(qtbot, window, shutil.copy(WALK, clip.with_name("other.bvh")))
    document.select_chain(faint.chain)
    document.go_to(frame)
    act(window, "insert_interval")
    assert document.interval is not None
    assert document.interval.interval.frames != faint.frames


@pytest.mark.thorough
def test_as_much_is_alive_behind_every_round_of_reviews(show_window, clip):
    window = show_window(size=(1280, 800))
    copies = [clip.with_name(f"{k}.bvh") for k in range(2)]
    clips = [clip, *(Path(shutil.copy(INJECTED, copy)) for copy in copies)]
    sitting = Sitting(window, clips, random.Random(1))
    counts = []
    with heard() as said:
        for k in range(9):
            sitting.open(clips[k % len(clips)])
            sitting.judge()
            sitting.edit()
            sitting.drag_tau()
            if k % 3 == 0:
                sitting.dialog("export_dialog")
            if k % 3 == 2:
                counts.append(sitting.count())
    assert said.wrong == []
    first, *_, last = counts
    assert (last.clips, last.analyses, last.reviews) == (first.clips, first.analyses, first.reviews)
    for name in ("files", "threads", "processes", "windows", "widgets", "ours"):
        assert getattr(last, name) <= getattr(first, name), name
    assert last.intervals <= first.intervals + 2 * len(window.document.intervals)
