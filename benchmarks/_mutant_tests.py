"""How benchmarks/mutation.py tries mutants: the tests of a module, in a forked process for each.

The parent has imported pytest and numpy, never what is mutated, so that a child has only to import
the changed module and the tests. What tests start as other programs sees the unchanged code.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from importlib.util import spec_from_file_location
from pathlib import Path
from types import CodeType

import coverage
import hypothesis
import numpy as np  # noqa: F401  every child needs these four
import pytest
import scipy.stats  # noqa: F401

from benchmarks._mutants import Mutant

SHARED = "fixtures of more than one test"
SAID = "said.txt"
MEMORY = 2 * 1024**3

hypothesis.settings.register_profile(
    "mutation",  # the same examples for each mutant; shrinking would tell nobody anything
    database=None,
    deadline=None,
    derandomize=True,
    phases=(hypothesis.Phase.explicit, hypothesis.Phase.generate),
)


@dataclass(frozen=True)
class Tests:
    """Which tests reach which line of a file, and how long each takes.

    reached: line → names of tests, SHARED among them. seconds: name of a test → its processor time.
    """

    files: tuple[str, ...]
    reached: Mapping[int, Set[str]]
    seconds: Mapping[str, float]

    def of(self, mutant: Mutant) -> tuple[str, ...]:
        """Tests that could see a mutant, the fastest first; all of them if any might.

        A line that is run on import (a constant, a default) is seen by what runs its function, and
        otherwise by every test.
        """
        names = self._within(mutant.lines)
        if not names and mutant.function:
            names = self._within(mutant.function)
            if not names:
                return ()  # nothing runs this function
        quick = sorted(names - {SHARED}, key=self.seconds.__getitem__)
        if names and SHARED not in names:
            return tuple(quick)
        others = sorted(self.seconds.keys() - names, key=self.seconds.__getitem__)
        return (*quick, *others)

    def limit(self, name: str) -> float:
        """Seconds of processor time that a test may take; it may be first to want a fixture."""
        return 3.0 + 4.0 * self.seconds[name]

    def _within(self, lines: tuple[int, int]) -> set[str]:
        return set().union(*(self.reached.get(n, ()) for n in range(lines[0], lines[1] + 1)))


def learn(path: Path, files: Sequence[str], slowest: float) -> Tests:
    """Run all tests once, unchanged; those that take longer than slowest (seconds) are left out.

    Raises ValueError if one fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result.json"
        child = _start(lambda: _learn(path, files, result), Path(folder))
        _, status = os.waitpid(child, 0)
        if status or not result.exists():
            said = (Path(folder) / SAID).read_text(errors="replace")
            raise ValueError(f"{said}\n{' '.join(files)}: these fail before anything is mutated")
        found = json.loads(result.read_text())
    seconds = {name: s for name, s in found["seconds"].items() if s <= slowest}
    quick = seconds.keys() | {SHARED}
    reached = {int(line): quick.intersection(names) for line, names in found["reached"].items()}
    return Tests(tuple(files), reached, seconds)


def outcomes(
    mutants: Sequence[Mutant], tests: Tests, jobs: int = 1
) -> Iterator[tuple[Mutant, str]]:
    """Each mutant with "killed", "survived" or "timeout", as they end."""
    waiting = list(reversed(mutants))
    running: dict[int, tuple[Mutant, Path, float]] = {}
    while waiting or running:
        while waiting and len(running) < jobs:
            mutant = waiting.pop()
            chosen = tests.of(mutant)
            if not chosen:
                yield mutant, "survived"
                continue
            folder = Path(tempfile.mkdtemp(prefix="mutant-"))
            child = _start(_trial(mutant, tests, chosen), folder)
            limit = sum(tests.limit(name) for name in chosen)
            running[child] = (mutant, folder, time.monotonic() + 10 * limit)
        if running:
            ended, status = _next(running)
            mutant, folder, _ = running.pop(ended)
            shutil.rmtree(folder, ignore_errors=True)
            yield mutant, _said(status)


def _next(running: Mapping[int, tuple[Mutant, Path, float]]) -> tuple[int, int]:
    """The next child that ends, and its status; one that waits for ever is ended."""
    while True:
        for child, (_, _, until) in running.items():
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return child, status
            if time.monotonic() > until:
                os.kill(child, signal.SIGPROF)
        time.sleep(0.01)


def _said(status: int) -> str:
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF:
        return "timeout"
    return "survived" if status == 0 else "killed"


def _start(action: Callable[[], int], folder: Path) -> int:
    """The id of a forked child that does this, silently, its temporary files below folder."""
    sys.stdout.flush()
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        said = os.open(folder / SAID, os.O_CREAT | os.O_RDWR)
        for stream in range(3):
            os.dup2(said, stream)
        os.environ["TMPDIR"] = tempfile.tempdir = str(folder)
        code = action()
        sys.stdout.flush()
    except BaseException:
        os.write(2, traceback.format_exc().encode())
    finally:
        os._exit(code)  # whatever was raised: nothing of the parent's may go on here


def _trial(mutant: Mutant, tests: Tests, chosen: Sequence[str]) -> Callable[[], int]:
    def action() -> int:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        sys.meta_path.insert(0, _Instead(mutant.path, mutant.source()))
        files = [f for f in tests.files if any(name.startswith(f + "::") for name in chosen)]
        return _run(files, _Chosen(chosen, tests))

    return action


def _run(files: Sequence[str], plugin: object) -> int:
    options = ["-x", "-q", "-p", "no:cacheprovider", "--tb=no"]
    options += ["-o", "faulthandler_timeout=0", "--hypothesis-profile=mutation"]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # of hypothesis, imported above
    return int(pytest.main([*options, *files], plugins=[plugin]))


class _Instead(importlib.abc.MetaPathFinder):
    """Imports one module from changed source."""

    def __init__(self, path: Path, source: str) -> None:
        self.name = ".".join(path.with_suffix("").parts)
        self.path, self.source = path, source

    def find_spec(self, name: str, *_: object) -> importlib.machinery.ModuleSpec | None:
        if name != self.name:
            return None
        return spec_from_file_location(
            name, self.path, loader=_Loader(name, self.path, self.source)
        )


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, name: str, path: Path, source: str) -> None:
        super().__init__(name, str(path))
        self._source = source

    def get_code(self, _: str) -> CodeType:
        return compile(self._source, self.path, "exec")


class _Chosen:
    """Runs some tests, in the order given, and ends the process if one takes too long."""

    def __init__(self, names: Sequence[str], tests: Tests) -> None:
        self.place = {name: place for place, name in enumerate(names)}
        self.limit = tests.limit
        signal.setitimer(signal.ITIMER_PROF, 10.0)  # for what is imported

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        kept = [item for item in items if item.nodeid in self.place]
        items[:] = sorted(kept, key=lambda item: self.place[item.nodeid])

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logstart(self, nodeid: str) -> None:
        signal.setitimer(signal.ITIMER_PROF, self.limit(nodeid))


def _learn(path: Path, files: Sequence[str], result: Path) -> int:
    traced = coverage.Coverage(data_file=None, include=[str(path.resolve())], config_file=False)
    noted = _Noted(traced)
    traced.start()
    code = _run(files, noted)
    traced.stop()
    data = traced.get_data()
    lines = data.contexts_by_lineno(str(path.resolve()))
    reached = {line: [name for name in names if name] for line, names in lines.items()}
    result.write_text(json.dumps({"reached": reached, "seconds": noted.seconds}))
    return code


class _Noted:
    """Notes which test runs, for coverage, and how long each takes."""

    def __init__(self, traced: coverage.Coverage) -> None:
        self.traced = traced
        self.seconds: dict[str, float] = {}
        self.test = ""  # that runs

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.test = item.nodeid
        self.traced.switch_context(self.test)
        before = time.process_time()
        result = yield
        self.seconds[item.nodeid] = time.process_time() - before
        self.traced.switch_context("")
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[object]) -> Iterator[None]:
        if fixturedef.scope != "function":
            self.traced.switch_context(SHARED)
        result = yield
        if fixturedef.scope != "function":
            self.traced.switch_context(self.test)
        return result
