"""A trial: made files of one kind are read, case after case, in a process with bounded memory.

A case is made again by its kind, seed and number alone. It is read well ("read"), or refused with
one sentence of ours ("refused"); anything else fails: another exception or warning ("traceback"), a
refusal that is no sentence ("unworded"), more than 2 s of processor time ("slow"), more memory than
the bound ("large"), no end ("hung"), or the end of the process ("ended").
"""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import queue
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import Any

from twistcore.errors import TwistError

try:
    import resource
except ImportError:  # Windows has no such bounds
    resource = None

READ, REFUSED = "read", "refused"
TRACEBACK, UNWORDED, SLOW, LARGE = "traceback", "unworded", "slow", "large"
HUNG, ENDED = "hung", "ended"
FAILED = (TRACEBACK, UNWORDED, SLOW, LARGE, HUNG, ENDED)

SLOW_S = 2.0  # of processor time
HUNG_S = 20.0  # of processor time, at which a case is ended
WAIT_S = 900.0  # of the clock, for a case that waits and computes nothing: a machine may be busy
SPACE = 1 << 30  # bytes of address space beyond what the programs take that are loaded
GROWTH = 128 << 20  # bytes in memory that any file may take …
GROWTH_PER_BYTE = 40  # … and for each of its bytes: a list in a list has 3 there and 64 in memory
LONGEST_SENTENCE = 1000  # characters: a sentence that nobody reads to its end is none
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff\u2028\u2029]")


@dataclass(frozen=True)
class Kind:
    """A kind of files that are read together.

    make: names below a folder and their bytes; read: what reads them from that folder and does what
    the program does next, raising TwistError where the files are no good; growth: bytes in memory
    that it may take whatever the size of the files.
    """

    name: str
    make: Callable[[random.Random], Mapping[str, bytes]]
    read: Callable[[Path], object]
    growth: int = GROWTH


@dataclass(frozen=True)
class Outcome:
    """What became of a case; seconds: of processor time; grown: bytes; told: sentence or trace."""

    case: int
    outcome: str
    seconds: float = 0.0
    grown: int = 0
    told: str = ""


@dataclass
class Report:
    """What became of all cases of a kind."""

    kind: str
    seed: int
    counts: Counter[str] = field(default_factory=Counter)
    failures: list[Outcome] = field(default_factory=list)
    slowest: Outcome = Outcome(-1, READ)
    largest: Outcome = Outcome(-1, READ)

    @property
    def number(self) -> int:
        return self.counts.total()

    def add(self, one: Outcome) -> None:
        self.counts[one.outcome] += 1
        if one.outcome in FAILED:
            self.failures.append(one)
        self.slowest = max(self.slowest, one, key=lambda o: o.seconds)
        self.largest = max(self.largest, one, key=lambda o: o.grown)

    def __str__(self) -> str:
        counts = ", ".join(f"{self.counts[k]} {k}" for k in (READ, REFUSED))
        counts += "".join(f", {n} {k}" for k, n in self.counts.items() if k in FAILED)
        return (
            f"{self.kind}, seed {self.seed}: {self.number} tried, {len(self.failures)} failed "
            f"({counts}; at most {self.slowest.seconds:.2f} s, "
            f"{self.largest.grown / 2**20:.0f} MiB)"
        )


def files_of(kind: Kind, seed: int, case: int) -> Mapping[str, bytes]:
    """The files of a case, always the same."""
    return kind.make(random.Random(f"{kind.name}/{seed}/{case}"))


def write_files(files: Mapping[str, bytes], folder: Path) -> int:
    """Write a case's files; how many bytes they have."""
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return sum(map(len, files.values()))


def tried(kind: Kind, seed: int, case: int, folder: Path) -> Outcome:
    """Make a case in an empty folder and read it, in this process."""
    with _any_space():
        size = write_files(files_of(kind, seed, case), folder)
    outcome, told = READ, ""
    with _unraisable() as missed:
        _forget_peak()
        before, begun = _memory(), time.process_time()
        try:
            kind.read(folder)
        except TwistError as error:
            told = str(error)
            outcome = REFUSED if _is_sentence(told) else UNWORDED
        except MemoryError:
            outcome, told = LARGE, "MemoryError"  # there is no room for more words
        except Exception:
            outcome, told = TRACEBACK, _trace()
        seconds, grown = time.process_time() - begun, _memory() - before
    if missed:
        outcome, told = TRACEBACK, missed[0]
    elif outcome in (READ, REFUSED):
        if grown > kind.growth + GROWTH_PER_BYTE * size:
            outcome = LARGE
        elif seconds > SLOW_S:
            outcome = SLOW
    return Outcome(case, outcome, seconds, max(grown, 0), told[:4000])


def _is_sentence(told: str) -> bool:
    return 0 < len(told.strip()) <= LONGEST_SENTENCE and not _CONTROL.search(told)


def _trace() -> str:
    """The innermost lines: those of a recursion fill pages."""
    return "".join(traceback.format_exc(limit=-6))


@contextmanager
def _unraisable() -> Iterator[list[str]]:
    """What cannot be raised, as a file that nobody closed; a warning is an error."""
    found: list[str] = []
    hook = sys.unraisablehook
    sys.unraisablehook = lambda what: found.append(f"{what.exc_value!r} in {what.object!r}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            yield found
    finally:
        sys.unraisablehook = hook


def _forget_peak() -> None:
    with suppress(OSError):  # Linux alone has it
        Path("/proc/self/clear_refs").write_bytes(b"5")


def _memory() -> int:
    """Bytes in memory at most, since they were forgotten where that can be."""
    with suppress(OSError):
        status = Path("/proc/self/status").read_bytes()
        return int(re.search(rb"VmHWM:\s+(\d+)", status)[1]) * 1024
    if resource is None:
        return 0
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


# -- the process that reads --------------------------------------------------------------------


def child(kind: Kind, seed: int, first: int, stop: int) -> None:
    """Try cases, a line before each and one after; what is read may print what it likes."""
    say = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    _bound_space()
    with tempfile.TemporaryDirectory() as above:
        for case in range(first, stop):
            folder = Path(above, str(case))
            folder.mkdir()
            _bound_time()
            print(case, file=say, flush=True)
            one = tried(kind, seed, case, folder)
            print(json.dumps(vars(one)), file=say, flush=True)
            shutil.rmtree(folder, ignore_errors=True)


def _bound_space() -> None:
    if resource is None or sys.platform == "darwin":  # which knows the bound and ignores it
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with suppress(OSError):
        pages = int(Path("/proc/self/statm").read_bytes().split()[0])
        used = pages * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (used + SPACE, resource.RLIM_INFINITY))


@contextmanager
def _any_space() -> Iterator[None]:
    """Room to make a case in: what is tried is to read it."""
    if resource is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _bound_time() -> None:
    if resource is not None:
        most = int(time.process_time() + HUNG_S) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))


# -- the process that asks ---------------------------------------------------------------------


def trial(
    kind: Kind,
    number: int,
    seed: int,
    *,
    first: int = 0,
    seconds: float = float("inf"),
    wait: float = WAIT_S,
) -> Report:
    """Try so many cases of a kind, or as many as these seconds of the clock allow."""
    report, end = Report(kind.name, seed), time.monotonic() + seconds
    case, stop = first, first + number
    while case < stop and time.monotonic() < end:
        for one in _of_child(kind, seed, case, stop, wait):
            report.add(one)
            case = one.case + 1
            if time.monotonic() >= end:
                break
    return report


def _of_child(kind: Kind, seed: int, first: int, stop: int, wait: float) -> Iterator[Outcome]:
    """The outcomes of one process, until it is through or a case is its end."""
    room = kind.make.__module__
    words = [kind.name, "--seed", str(seed), "--room", room, "--child", str(first), str(stop)]
    one_thread = {"OPENBLAS_NUM_THREADS": "1", "QT_QPA_PLATFORM": "offscreen"}
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz", *words],
            cwd=Path(__file__).parents[2],
            env=os.environ | one_thread,
            stdout=subprocess.PIPE,
            stderr=errors,
        )
        begun, silent = None, False
        with process, closing(_lines(process, wait)) as lines:
            for line in lines:
                if not line:
                    silent = True
                elif line.isdigit():
                    begun = int(line)
                else:
                    yield Outcome(**json.loads(line))
                    begun = None
        if process.returncode == 0 and begun is None:
            return
        errors.seek(0)
        told = errors.read().decode("utf-8", "replace")[-4000:]
        if begun is None:
            raise RuntimeError(f"{kind.name} cannot be tried: {told}")
        hung = silent or process.returncode == -getattr(signal, "SIGXCPU", 0)
        yield Outcome(begun, HUNG if hung else ENDED, told=f"{process.returncode} {told}")


def _lines(process: subprocess.Popen[bytes], wait: float) -> Iterator[str]:
    """The lines that a process prints; the last is empty where it is silent for too long."""
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def listen() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            lines.put(line)
        process.wait()
        lines.put(b"")

    thread = Thread(target=listen, daemon=True)
    thread.start()
    try:
        with suppress(queue.Empty):
            patience = WAIT_S  # to begin with: much is loaded
            while line := lines.get(timeout=patience):
                yield line.decode("utf-8").strip()
                patience = wait
            return
        yield ""  # silent for too long
    finally:
        process.kill()
        thread.join()


def kind_of(room: str, name: str) -> Kind:
    """A kind by its module and name, without the others, which take their time to load."""
    there = getattr(importlib.import_module(room), "KINDS", ())
    return next((kind for kind in there if kind.name == name), None) or kinds()[name]


def kinds() -> dict[str, Kind]:
    """Every kind by its name: KINDS of the modules here whose names end with _kinds."""
    found: dict[str, Any] = {}
    room = __name__.rpartition(".")[0]
    for module in pkgutil.iter_modules([str(Path(__file__).parent)], f"{room}."):
        if module.name.endswith("_kinds"):
            found |= {kind.name: kind for kind in importlib.import_module(module.name).KINDS}
    return found
