"""Test each mutant of benchmarks/mutation.py in a forked process.

A mutant is a copy of a module with one small change. One process imports the tests of the module
and forks for each mutant. The child process replaces the code of functions and runs the tests that
reach them. In two cases, the mutant is tested again in a child that imports the changed module from
scratch:

- Replacing functions had no effect, for example because a constant was changed.
- The mutant survived, but its function also runs when the tests are imported.

Other programs that tests start run the unchanged code.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import inspect
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
from types import CodeType, FunctionType, ModuleType

import coverage
import hypothesis
import numpy as np  # noqa: F401  imported here so that children need not import these four
import pytest
import scipy.stats  # noqa: F401

from benchmarks._mutants import Mutant

SHARED = "fixtures of more than one test"
Trial = Callable[[Mutant, Sequence[str]], Callable[[], int]]
AFRESH = 77  # exit status of a child in which replacing functions had no effect
SAID = "said.txt"
MEMORY = 2 * 1024**3

hypothesis.settings.register_profile(
    "mutation",  # the same examples for each mutant, and no shrinking
    database=None,
    deadline=None,
    derandomize=True,
    phases=(hypothesis.Phase.explicit, hypothesis.Phase.generate),
)


@dataclass(frozen=True)
class Tests:
    """The tests of a module, with the lines that they reach and their durations.

    Attributes
    ----------
    files
        The test files.
    reached
        The names of the tests that reach each line, keyed by line. The names may include SHARED,
        and "" for a line that runs on import.
    seconds
        The processor time of each test, keyed by name.
    """

    files: tuple[str, ...]
    reached: Mapping[int, Set[str]]
    seconds: Mapping[str, float]

    def of(self, mutant: Mutant) -> tuple[str, ...]:
        """Return the tests that may detect a mutant, the fastest first.

        For a line that runs on import (a constant or a default value), these are the tests that run
        the enclosing function, or all tests if the line is outside functions.
        """
        names = self._within(mutant.lines) - {""}
        if not names and mutant.function:
            names = self._within(mutant.function) - {""}
            if not names:
                return ()  # nothing runs this function
        quick = sorted(names - {SHARED, ""}, key=self.seconds.__getitem__)
        if names and SHARED not in names:
            return tuple(quick)
        others = sorted(self.seconds.keys() - names, key=self.seconds.__getitem__)
        return (*quick, *others)

    def on_import(self, lines: tuple[int, int]) -> bool:
        """Return True if any of the lines from `lines[0]` to `lines[1]` ran outside tests."""
        return "" in self._within(lines)

    def limit(self, name: str) -> float:
        """Return the time limit for a test and its fixtures, in seconds of processor time."""
        return 3.0 + 4.0 * self.seconds[name]

    def _within(self, lines: tuple[int, int]) -> set[str]:
        return set().union(*(self.reached.get(n, ()) for n in range(lines[0], lines[1] + 1)))


def learn(path: Path, files: Sequence[str], slowest: float) -> Tests:
    """Run all tests once without a mutant, and record the lines that they reach.

    Tests that take more than `slowest` seconds are left out. Raises ValueError if a test fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result.json"
        child = _start(lambda: _learn(path, files, result), Path(folder))
        _, status = os.waitpid(child, 0)
        if status or not result.exists():
            said = (Path(folder) / SAID).read_text(errors="replace")
            raise ValueError(f"{said}\n{' '.join(files)}: these tests fail before any mutation")
        found = json.loads(result.read_text())
    seconds = {name: s for name, s in found["seconds"].items() if s <= slowest}
    quick = seconds.keys() | {SHARED, ""}
    reached = {int(line): quick.intersection(names) for line, names in found["reached"].items()}
    return Tests(tuple(files), reached, seconds)


def outcomes(
    mutants: Sequence[Mutant], tests: Tests, jobs: int = 1
) -> Iterator[tuple[Mutant, str]]:
    """Yield each mutant with "killed", "survived" or "timeout" as soon as its tests end.

    `jobs` is the number of mutants that are tested at the same time.
    """
    afresh = [m for m in mutants if not m.function]
    in_place = [m for m in mutants if m.function]
    if in_place:
        with tempfile.TemporaryDirectory() as folder:
            told, tell = os.pipe()
            served = _Served(in_place, tests, jobs, tell)
            server = _start(lambda: _run(tests.files, served), Path(folder))
            os.close(tell)
            with os.fdopen(told) as lines:
                for line in lines:
                    place, outcome = line.split()
                    mutant = in_place[int(place)]
                    again = mutant.function and tests.on_import(mutant.function)
                    if outcome == "afresh" or (outcome == "survived" and again):
                        afresh.append(mutant)
                    else:
                        yield mutant, outcome
            os.waitpid(server, 0)
    for place, outcome in _tried(afresh, tests, jobs, lambda m, chosen: _trial(m, tests, chosen)):
        yield afresh[place], outcome


def _tried(
    mutants: Sequence[Mutant], tests: Tests, jobs: int, trial: Trial
) -> Iterator[tuple[int, str]]:
    waiting = list(enumerate(mutants))[::-1]
    running: dict[int, tuple[int, Path, float]] = {}
    while waiting or running:
        while waiting and len(running) < jobs:
            place, mutant = waiting.pop()
            chosen = tests.of(mutant)
            if not chosen:
                yield place, "survived"
                continue
            folder = Path(tempfile.mkdtemp(prefix="mutant-"))
            child = _start(trial(mutant, chosen), folder)
            limit = sum(tests.limit(name) for name in chosen)
            running[child] = (place, folder, time.monotonic() + 300 + 30 * limit)
        if running:
            ended, status = _next({child: until for child, (_, _, until) in running.items()})
            place, folder, _ = running.pop(ended)
            shutil.rmtree(folder, ignore_errors=True)
            yield place, _said(status)


def _next(running: Mapping[int, float]) -> tuple[int, int]:
    """Wait until a child process ends, and return its id and status. Kill children that hang.

    `running` has the time at which each child is killed, keyed by id.
    """
    while True:
        for child, until in running.items():
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return child, status
            if time.monotonic() > until:
                os.kill(child, signal.SIGPROF)
        time.sleep(0.01)


def _said(status: int) -> str:
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF:
        return "timeout"
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) == AFRESH:
        return "afresh"
    return "survived" if status == 0 else "killed"


def _start(action: Callable[[], int], folder: Path) -> int:
    """Fork a child process that runs `action` without output, and return its id.

    `folder` is the folder for the child's temporary files.
    """
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
        os._exit(code)  # even after an exception, so that the parent's code does not run here


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


def changed_in_place(name: str, source: str) -> bool:
    """Replace the code of an imported module's functions by their code in the source of a mutant.

    Return False if no function differs, which means that the change is outside functions. Raises
    any exception that occurs when the source is run.
    """
    module = sys.modules.get(name)
    if module is None:
        return False
    other = ModuleType(name)
    vars(other).update(__file__=module.__file__, __package__=module.__package__)
    exec(compile(source, str(module.__file__), "exec"), vars(other))
    changed = False
    now = dict(_functions(vars(other), name))
    for qualified, function in _functions(vars(module), name):
        code = now[qualified].__code__ if qualified in now else function.__code__
        if code.co_freevars == function.__code__.co_freevars and not _alike(
            code, function.__code__
        ):
            function.__code__ = code
            changed = True
    return changed


def _alike(one: CodeType, other: CodeType) -> bool:
    """Return True if two code objects do the same. (== also depends on whether they have run.)"""
    pairs = zip(one.co_consts, other.co_consts, strict=False)
    return (
        (one.co_code, one.co_names, one.co_varnames, len(one.co_consts))
        == (other.co_code, other.co_names, other.co_varnames, len(other.co_consts))
    ) and all(
        _alike(a, b) if isinstance(a, CodeType) and isinstance(b, CodeType) else repr(a) == repr(b)
        for a, b in pairs
    )


def _functions(found: Mapping[str, object], module: str) -> Iterator[tuple[str, FunctionType]]:
    """Yield the functions and methods of a module with their names, including decorated ones."""
    for at, thing in list(found.items()):
        for name in ("", "fget", "fset", "__func__", "func"):
            inner = getattr(thing, name, None) if name else thing
            inner = inspect.unwrap(inner) if callable(inner) else inner
            if getattr(inner, "__module__", None) != module:
                continue
            if isinstance(inner, FunctionType):
                yield f"{at} {name}", inner
            elif isinstance(inner, type):
                for below, function in _functions(vars(inner), module):
                    yield f"{at}.{below}", function


def module_name(path: Path) -> str:
    """Return the name of the module at a path, which is relative to the root of the checkout."""
    return ".".join(path.with_suffix("").parts)


class _Instead(importlib.abc.MetaPathFinder):
    """An import hook that loads one module from changed source code."""

    def __init__(self, path: Path, source: str) -> None:
        self.name = module_name(path)
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


class _Limited:
    """A pytest plugin that ends the process if a test exceeds its time limit."""

    def __init__(self, tests: Tests) -> None:
        self.tests = tests

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logstart(self, nodeid: str) -> None:
        signal.setitimer(signal.ITIMER_PROF, self.tests.limit(nodeid))


class _Chosen(_Limited):
    """A pytest plugin that runs only the chosen tests, in the given order."""

    def __init__(self, names: Sequence[str], tests: Tests) -> None:
        super().__init__(tests)
        self.place = {name: place for place, name in enumerate(names)}
        signal.setitimer(signal.ITIMER_PROF, 10.0)  # for imports

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        kept = [item for item in items if item.nodeid in self.place]
        items[:] = sorted(kept, key=lambda item: self.place[item.nodeid])


class _Served(_Limited):
    """A pytest plugin that forks for each mutant instead of running the tests.

    The outcome for each mutant is written to the file descriptor `tell`.
    """

    def __init__(self, mutants: Sequence[Mutant], tests: Tests, jobs: int, tell: int) -> None:
        super().__init__(tests)
        self.mutants, self.jobs, self.tell = mutants, jobs, tell

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        items = {item.nodeid: item for item in session.items}

        def trial(mutant: Mutant, chosen: Sequence[str]) -> Callable[[], int]:
            def action() -> int:
                resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
                try:
                    if not changed_in_place(module_name(mutant.path), mutant.source()):
                        return AFRESH
                except Exception:
                    return 1  # the mutant cannot even be imported
                wanted = [items[name] for name in chosen]
                for item, following in zip(wanted, [*wanted[1:], None], strict=True):
                    item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                    if session.testsfailed:
                        return 1
                return 0

            return action

        for place, outcome in _tried(self.mutants, self.tests, self.jobs, trial):
            os.write(self.tell, f"{place} {outcome}\n".encode())
        return True


def _learn(path: Path, files: Sequence[str], result: Path) -> int:
    traced = coverage.Coverage(data_file=None, include=[str(path.resolve())], config_file=False)
    noted = _Noted(traced, module_name(path))
    traced.start()
    code = _run(files, noted)
    traced.stop()
    data = traced.get_data()
    lines = data.contexts_by_lineno(str(path.resolve()))
    result.write_text(json.dumps({"reached": lines, "seconds": noted.seconds}))
    return code


class _Noted:
    """A pytest plugin that records the duration of each test, and the lines that it reaches.

    Caches of the module (functools.cache) are cleared before each test, because a filled cache
    hides lines that the test needs.
    """

    def __init__(self, traced: coverage.Coverage, module: str) -> None:
        self.traced, self.module = traced, module
        self.seconds: dict[str, float] = {}
        self.test = ""  # the running test

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.test = item.nodeid
        self.traced.switch_context(self.test)
        for thing in list(vars(sys.modules.get(self.module, object)).values()):
            if callable(forget := getattr(thing, "cache_clear", None)):
                forget()
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
