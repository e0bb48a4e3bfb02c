"""All tests, every module of window tests by itself, several at a time."""

from __future__ import annotations

import collections
import contextlib
import os
import signal
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, TYPE_CHECKING
from xml.etree import ElementTree

from checkout import places
from checkout.screens import QT_API, screen
from checkout.starting import RUNNING, finish, say, start
from inspector.system_libraries import has_screen

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.gui.forked import Parent

# The modules of window tests that take longest: first, so that all lanes end together.
LONG = (
    *("nothing_lost", "taken_away", "kill", "test_looks", "starts_and_ends"),
    *("by_hand", "uncovered", "in_browser", "test_teaching", "test_tour"),
)
TEST_MINUTES = "about 15 minutes on two cores"


def run_all() -> int:
    """Run every module of window tests by itself, the rest together; the exit status.

    Three parts at a time where each has a virtual screen of its own: on a real one windows would
    take each other's keys, and only what has no windows runs beside them.
    """
    say(f"All tests take {TEST_MINUTES}; dev.py test -k WORD runs some.")
    counts: collections.Counter[str] = collections.Counter()
    notes: list[str] = []

    def run_twice(part: list[str], parent: Parent | None = None) -> int:
        with tempfile.TemporaryFile() as output:
            done = run_part(part, output, parent)
            if done is None and not given_up:  # it crashed, or hung until pytest gave it up
                notes.append(f"{part[0]}: its process did not come to its end and was run again.")
                done = run_part(part, output, parent)
            output.seek(0)
            say(output.read().decode(errors="replace"))
        counts.update(done or {"failed": 1})
        return int(not done or done["failed"] > 0)

    def test_windows() -> int:
        status = 0
        # A program has one window: hundreds in one process try Qt's bindings, not the program.
        for module in waiting:  # one list for all lanes
            status |= 0 if given_up else run_twice([module], parent)
        return status

    def test_the_rest() -> int:
        status = run_twice(["tests", "--ignore=tests/gui"])
        return status if has_screen() else status | test_windows()

    waiting, given_up = iter(window_tests()), False
    # Windows wait for half their time, on the screen and on each other: a core has room for more.
    more = [test_windows] if not has_screen() else []
    with parent_of_tests() as parent, ThreadPoolExecutor(3) as lanes:
        running = [lanes.submit(lane) for lane in (test_the_rest, test_windows, *more)]
        try:
            status = max([lane.result() for lane in running])
        except BaseException:  # Ctrl+C, or we were told to end
            given_up = True
            for child in tuple(RUNNING):
                child.terminate()
            raise
    for note in notes:
        say(note)
    say(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return status


def window_tests() -> list[str]:
    """The modules of window tests, the long ones first."""
    files = sorted(places.ROOT.glob("tests/gui/test_*.py"))
    files.sort(key=lambda file: not any(name in file.name for name in LONG))
    return [file.relative_to(places.ROOT).as_posix() for file in files]


@contextlib.contextmanager
def parent_of_tests() -> Iterator[Parent | None]:
    """What has imported all that window tests need; None where processes cannot be forked off."""
    if not sys.platform.startswith("linux"):
        yield None
        return
    from tests.gui.forked import Parent

    parent = Parent(str(places.PYTHON), QT_API)
    try:
        yield parent
    finally:
        parent.end()


def run_part(
    part: list[str], output: IO[bytes] | None = None, parent: Parent | None = None
) -> collections.Counter[str] | None:
    """Run some of the tests on a screen of their own and count; None if pytest did not end.

    What it says goes to `output`, or to where we say things. parent: it is forked off that.
    """
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder, screen() as env:
        report = Path(folder) / "report.xml"
        words = ["-m", "pytest", f"--junitxml={report}", *part]
        forked = run_forked(parent, words, env, output) if parent and output else None
        command = [str(places.PYTHON), *words]
        status = start(command, env, places.ROOT, output) if forked is None else forked
        if status > 2 or not report.exists():
            return None
        suite = ElementTree.parse(report).getroot()[0]
    number = {key: int(value) for key, value in suite.attrib.items() if value.isdecimal()}
    failed = number["failures"] + number["errors"]
    if status == 2 and not failed:
        raise KeyboardInterrupt
    passed = number["tests"] - failed - number["skipped"]
    failed = failed or status  # what went wrong outside of any test
    return collections.Counter(passed=passed, failed=failed, skipped=number["skipped"])


def run_forked(
    parent: Parent, words: list[str], env: dict[str, str], output: IO[bytes]
) -> int | None:
    """The exit status of Python, forked off; None where it is not known, as its parent is gone."""
    try:
        with contextlib.closing(parent.start(words, env, output, places.ROOT)) as child:
            try:
                return finish(child)
            except (OSError, ValueError):  # it may go on, on the screen that is needed
                os.kill(child.pid, signal.SIGKILL)
    except (OSError, AssertionError):
        pass
    return None
