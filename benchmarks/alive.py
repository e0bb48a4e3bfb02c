"""Count what the program keeps alive: memory, files, threads, widgets, clips and reviews."""

from __future__ import annotations

import ctypes
import gc
import logging
import sys
import threading
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass, field, fields
from pathlib import Path
from types import TracebackType

from PySide6.QtCore import QObject, QtMsgType, qInstallMessageHandler
from PySide6.QtWidgets import QApplication
from shiboken6 import isValid

from inspector.session.opening import Analysed
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import Interval
from twistcore.formats.clip import Clip
from twistcore.review import Review, ReviewState

_PROCESS = Path("/proc/self")


@dataclass(frozen=True)
class Alive:
    """Counts of living objects after a garbage collection.

    The fields without a description have the names of the objects that they count.

    Attributes
    ----------
    mib
        The resident memory in MiB.
    windows
        Number of widgets without a parent.
    ours
        Number of objects of our Qt classes that Python references and Qt has not deleted.
    """

    mib: float
    files: int
    threads: int
    processes: int
    windows: int
    widgets: int
    ours: int
    clips: int
    analyses: int
    reviews: int
    states: int
    intervals: int

    def __str__(self) -> str:
        first, *rest = astuple(self)
        return f"{first:8.1f}" + "".join(f"{n:10d}" for n in rest)

    @classmethod
    def heads(cls) -> str:
        """Return the column headings, each padded to the width of its column."""
        first, *rest = (f.name for f in fields(cls))
        return f"{first:>8}" + "".join(f"{name:>10}" for name in rest)


def alive() -> Alive:
    """Collect garbage, and count the objects that remain."""
    gc.collect()
    gc.collect()
    give_back()
    kinds: Counter[type] = Counter()
    ours = 0
    for thing in gc.get_objects():
        kind = type(thing)  # isinstance would return the class of a proxy's target
        kinds[kind] += 1
        # Some types have a __module__ that is not a string, so the base class is checked first.
        if issubclass(kind, QObject) and kind.__module__.startswith("inspector."):
            ours += isValid(thing)

    def count(*wanted: type) -> int:
        return sum(n for kind, n in kinds.items() if issubclass(kind, wanted))

    return Alive(
        resident(),
        len(list((_PROCESS / "fd").iterdir())),
        len(list((_PROCESS / "task").iterdir())),
        len(children()),
        len(QApplication.topLevelWidgets()),
        len(QApplication.allWidgets()),
        ours,
        count(Clip),
        count(ClipAnalysis, Analysed),
        count(Review),
        count(ReviewState),
        count(Interval),
    )


def give_back() -> None:
    """Return unused memory from the allocator to the system, if the platform supports this."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def resident() -> float:
    """Return the resident memory of this process in MiB."""
    pages = (_PROCESS / "statm").read_text(encoding="ascii").split()[1]
    return int(pages) * 4096 / 2**20


def children() -> list[str]:
    """Return the command lines of the running processes that this process has started.

    Python's resource tracker is left out, because it always runs until the program ends.
    """
    numbers = [n for t in (_PROCESS / "task").iterdir() for n in _read(t / "children").split()]
    lines = [_read(Path("/proc", n, "cmdline")).replace("\0", " ").strip() for n in numbers]
    return [line for line in lines if "resource_tracker" not in line]


def _read(file: Path) -> str:
    try:
        return file.read_text("utf-8", "replace")
    except OSError:  # the process has ended
        return ""


@dataclass
class Said:
    """The problems that were reported: uncaught exceptions, and warnings of Qt and logs."""

    wrong: list[str] = field(default_factory=list)

    def note(self, kind: type[BaseException], error: object, trace: TracebackType | None) -> None:
        """Record an exception and the place where it was last raised."""
        while trace is not None and trace.tb_next is not None:
            trace = trace.tb_next
        place = ""
        if trace is not None:
            code = trace.tb_frame.f_code
            place = f" ({Path(code.co_filename).name}:{trace.tb_lineno} {code.co_name})"
        self.wrong.append(f"{kind.__name__}: {error}{place}")


class _Logged(logging.Handler):
    def __init__(self, said: Said) -> None:
        super().__init__(logging.WARNING)
        self._said = said

    def emit(self, record: logging.LogRecord) -> None:
        self._said.wrong.append(f"{record.levelname}: {record.getMessage()}")


@contextmanager
def heard() -> Iterator[Said]:
    """Record all uncaught exceptions, and warnings of Qt and logs, while the block runs."""
    said = Said()

    def message(kind: QtMsgType, _context: object, text: str) -> None:
        if kind not in (QtMsgType.QtDebugMsg, QtMsgType.QtInfoMsg):
            said.wrong.append(f"Qt: {text}")

    def warning(text: object, kind: type[Warning], *_place: object) -> None:
        caught = sys.exc_info()  # pyqtgraph turns exceptions of a drag into warnings
        said.note(*caught) if caught[0] is not None else said.wrong.append(
            f"{kind.__name__}: {text}"
        )

    hooks = sys.excepthook, threading.excepthook, sys.unraisablehook
    before = qInstallMessageHandler(message)
    logged = _Logged(said)
    logging.getLogger().addHandler(logged)
    sys.excepthook = said.note
    threading.excepthook = lambda a: said.note(a.exc_type, a.exc_value, a.exc_traceback)
    sys.unraisablehook = lambda a: said.note(a.exc_type, a.exc_value, a.exc_traceback)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", RuntimeWarning)
            warnings.showwarning = warning
            yield said
    finally:
        sys.excepthook, threading.excepthook, sys.unraisablehook = hooks
        logging.getLogger().removeHandler(logged)
        qInstallMessageHandler(before)
