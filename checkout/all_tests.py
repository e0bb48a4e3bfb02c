"""Run the tests in several processes: slow modules of window tests alone, short ones together."""

from __future__ import annotations

import collections
import contextlib
import os
import re
import signal
import sys
import tempfile
import textwrap
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING
from xml.etree import ElementTree

from checkout import places
from checkout.screens import QT_API, screen
from checkout.starting import RUNNING, finish, say, start
from inspector.system_libraries import has_screen

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from tests.gui.forked import Parent

# The slowest modules of window tests, in this order. They start first, because a slow module at
# the end would run alone while the other lanes are idle.
LONG = (
    *("tuning_pages", "nothing_lost", "taken_away", "kill", "sessions", "starts_and_ends"),
    *("recording", "test_tuning", "folder", "in_browser", "quality", "by_hand", "language"),
    *("switched_clips", "test_tour", "test_teaching", "uncovered", "test_looks", "test_video"),
)
QUICK_MINUTES = "about 6 minutes on two cores"
ALL_MINUTES = "about 27 minutes on two cores"
EXAMPLES = "TWIST_INSPECTOR_EXAMPLES"  # set by the user, it overrides the tier's profile
NO_TESTS = 5  # the exit status of pytest if no test was selected
CORE_PARTS = 16  # small, so that no lane is idle for long at the end
GROUP = 8  # modules of window tests in a process, at most


@dataclass(frozen=True)
class Tier:
    """A selection of tests.

    - words: the arguments for pytest
    - examples: the profile of Hypothesis, see tests/conftest.py
    - group: the number of modules of window tests that share a process
    - alone: parts of the names of modules of window tests that have a process of their own
    """

    words: tuple[str, ...]
    examples: str
    group: int
    alone: tuple[str, ...]


QUICK = Tier(("-m", "not thorough"), "quick", GROUP, ("by_hand", "in_browser", "language"))
ALL = Tier((), "patient", GROUP // 2, LONG)


@dataclass
class Outcome:
    """The result of some tests.

    - counts: the number of tests, keyed by 'passed', 'failed' and 'skipped'
    - failures: a line for each failed test
    """

    counts: collections.Counter[str] = field(default_factory=collections.Counter)
    failures: list[str] = field(default_factory=list)


def run_all(*, everything: bool = False) -> int:
    """Run the quick tests, or all tests, and return the exit status.

    Modules of window tests that take long run in a process of their own, and several others share
    one, because a process and its first window take seconds. Two processes run at a time for each
    core, each with its own virtual screen. If there is a real screen, the window tests run one
    after another, because several windows would receive each other's keys. The other tests run at
    the same time.
    """
    if everything:
        say(f"All tests take {ALL_MINUTES}; dev.py test runs the quick ones.")
    else:
        say(f"The quick tests take {QUICK_MINUTES}. All of them, in {ALL_MINUTES}:")
        say("    python3 dev.py test --all")
    whole, notes = Outcome(), list[str]()
    given_up = False
    tier = ALL if everything else QUICK

    def run_twice(part: list[str], parent: Parent | None) -> None:
        with tempfile.TemporaryFile() as output:
            outcomes = {part[0]: run_part(part, output, parent, tier)}
            if outcomes[part[0]] is None and not given_up:  # a crash, or a timeout of pytest
                again = [[module] for module in part] if len(part) <= GROUP else [part]
                names = ", ".join(part if len(part) <= GROUP else part[:1])
                notes.append(f"{names}: the process did not come to its end and was run again.")
                outcomes = {few[0]: run_part(few, output, parent, tier) for few in again}
            output.seek(0)
            say(output.read().decode(errors="replace"))
        for name, done in outcomes.items():
            whole.counts.update(done.counts if done else {"failed": 1})
            whole.failures.extend(done.failures if done else [f"{name}: its process crashed."])

    def lane(parent: Parent | None, *queues: Iterator[list[str]]) -> None:
        for queue in queues:  # all lanes share each queue
            for part in queue:
                if not given_up:
                    run_twice(part, parent)

    with parent_of_tests() as parent, ThreadPoolExecutor(count := number_of_lanes()) as lanes:
        windows, core = iter(window_parts(tier)), iter(core_tests())
        # Window tests are idle half of the time, so more processes than cores are useful.
        queues = (
            [(core,), (windows,)]
            if has_screen()
            else [(core, windows), *[(windows, core)] * (count - 1)]
        )
        running = [lanes.submit(lane, parent, *these) for these in queues]
        try:
            for each in running:
                each.result()
        except BaseException:  # Ctrl+C or SIGTERM
            given_up = True
            for child in tuple(RUNNING):
                child.terminate()
            raise
    for line in (*notes, *failure_lines(whole.failures)):
        say(line)
    counts = whole.counts
    say(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return int(counts["failed"] > 0)


def failure_lines(failures: Iterable[str]) -> list[str]:
    """Return lines that list every failed test once, with the first line of the reason."""
    lines = [f"  {line}" for line in dict.fromkeys(failures)]
    return ["", "Failed:", *lines] if lines else []


def core_tests() -> list[list[str]]:
    """Return the test modules that open no window, in parts of about the same size."""
    files = sorted(places.ROOT.glob("tests/**/test_*.py"))
    names = [file.relative_to(places.ROOT).as_posix() for file in files]
    names = [name for name in names if not name.startswith("tests/gui/")]
    return [part for k in range(CORE_PARTS) if (part := names[k::CORE_PARTS])]


def window_tests() -> list[str]:
    """Return the modules of window tests, with the slow ones first."""
    files = sorted(places.ROOT.glob("tests/gui/test_*.py"))
    files.sort(key=lambda file: [name not in file.name for name in LONG])
    return [file.relative_to(places.ROOT).as_posix() for file in files]


def window_parts(tier: Tier) -> list[list[str]]:
    """Return the modules of window tests in the parts that run in one process each.

    In the quick tier, modules without quick tests are left out. The parts with several modules come
    first.
    """
    modules = [m for m in window_tests() if tier is ALL or has_quick(m)]
    alone = [m for m in modules if any(name in m for name in tier.alone)]
    others = [m for m in modules if m not in alone]
    count = -(-len(others) // tier.group)
    return [*(others[k::count] for k in range(count)), *([m] for m in alone)]


def number_of_lanes() -> int:
    """Return how many processes with tests run at a time: two for each core, at most eight."""
    return max(3, min(8, 2 * (os.cpu_count() or 1)))


def has_quick(module: str) -> bool:
    """Return True unless all tests of the module are thorough."""
    text = (places.ROOT / module).read_text("utf-8")
    return not re.search(r"^pytestmark = (\[\s*)?pytest\.mark\.thorough", text, re.MULTILINE)


@contextlib.contextmanager
def parent_of_tests() -> Iterator[Parent | None]:
    """Start a process that has imported everything, to fork the processes of tests from it.

    On systems other than Linux, yield None.
    """
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
    part: list[str],
    output: IO[bytes] | None = None,
    parent: Parent | None = None,
    tier: Tier = ALL,
) -> Outcome | None:
    """Run some of the tests on a screen and count the results. Return None if pytest did not end.

    The output is written to `output`, or to the terminal. With a `parent`, the tests run in a
    process forked from it.
    """
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder, screen() as env:
        report = Path(folder) / "report.xml"
        words = [
            "-m",
            "pytest",
            f"--junitxml={report}",
            "--continue-on-collection-errors",
            *tier.words,
            *part,
        ]
        env = {EXAMPLES: tier.examples, **env}
        forked = run_forked(parent, words, env, output) if parent and output else None
        command = [str(places.PYTHON), *words]
        status = start(command, env, places.ROOT, output) if forked is None else forked
        if status == NO_TESTS:
            return Outcome()
        if status > 2 or not report.exists():
            return None
        suite = ElementTree.parse(report).getroot()[0]
    number = {key: int(value) for key, value in suite.attrib.items() if value.isdecimal()}
    failed = number["failures"] + number["errors"]
    if status == 2 and not failed:
        raise KeyboardInterrupt
    passed = number["tests"] - failed - number["skipped"]
    failures = [line for case in suite.iter("testcase") for line in failure_of(case)]
    if status and not failed:  # an error outside of all tests
        failed, failures = 1, [f"{part[-1]}: pytest ended with {status}, outside of any test."]
    counts = collections.Counter(passed=passed, failed=failed, skipped=number["skipped"])
    return Outcome(counts, failures)


def failure_of(case: ElementTree.Element) -> list[str]:
    """Return lines with a failed test's name and the first line of each reason."""
    module, name = case.get("classname", ""), case.get("name", "")
    if not module:  # a module that could not be collected
        module, name = name, ""
    # The first dotted name that begins with test_ is the file.
    file = re.sub(r"^((?:\w+\.)*?test_\w+)", lambda m: m[0].replace(".", "/") + ".py", module)
    name = "::".join(filter(None, [*file.replace(".py.", ".py::").split("::"), name]))
    lines = []
    for found in (*case.iterfind("failure"), *case.iterfind("error")):
        message, text = found.get("message", ""), found.text or ""
        if message.startswith("collection failure"):  # only the text has the reason
            errors = [line[1:] for line in text.splitlines() if line.startswith("E ")]
            message = errors[-1] if errors else text.strip()
        reason = next(iter(message.strip().splitlines()), "no reason was given")
        lines.append(f"{name}: {textwrap.shorten(reason, 160, placeholder=' …')}")
    return lines


def run_forked(
    parent: Parent, words: list[str], env: dict[str, str], output: IO[bytes]
) -> int | None:
    """Run Python in a forked process and return its exit status.

    `words` are Python's arguments. If the parent process has ended, the status is unknown: None.
    """
    try:
        with contextlib.closing(parent.start(words, env, output, places.ROOT)) as child:
            try:
                return finish(child)
            except (OSError, ValueError):  # it may still use the screen
                os.kill(child.pid, signal.SIGKILL)
    except (OSError, AssertionError):
        pass
    return None
