"""TeX as outlines: matplotlib sets it once, Qt fills the outlines at any scale and colour."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from threading import Lock
from typing import Any

from PySide6.QtCore import QObject, QRectF, Qt, Signal
from PySide6.QtGui import QPainterPath

from inspector.language import tr
from inspector.widgets.background import Task

EM = 100.0  # of the outlines: units an em
_one_at_a_time = Lock()  # matplotlib's parser of TeX is one for all threads


@dataclass(frozen=True, eq=False)
class Formula:
    """Outlines with the baseline at y = 0, y down, EM units high; advance: their width."""

    path: QPainterPath
    box: QRectF


class Typesetter(QObject):
    """Formulas by TeX; those asked for together come together, from a thread: no window waits.

    It takes half a second, several where matplotlib has to look at all fonts first.
    """

    ready = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._known: dict[str, Formula] = {}
        self._asked: dict[str, None] = {}
        self._waiting: list[tuple[str, ...]] = []  # one thread at a time uses matplotlib
        self._task: Task | None = None
        self.trouble = ""

    def start(self, texts: Iterable[str]) -> None:
        """Set these; `ready` tells when. What was asked for before is not set again."""
        wanted = tuple(tex for tex in texts if tex not in self._asked)
        self._asked |= dict.fromkeys(wanted)
        if wanted:
            self._waiting.append(wanted)
            self._next()

    def _next(self) -> None:
        if self._task is None and self._waiting:
            wanted = self._waiting.pop(0)
            self._task = Task(lambda _: outlines(wanted), self)
            self._task.finished.connect(self._take)
            self._task.failed.connect(self._fail)
            self._task.start()

    def formula(self, tex: str) -> Formula | None:
        """A formula, or None while it is being set."""
        return self._known.get(tex)

    def has(self, texts: Iterable[str]) -> bool:
        """Whether all of these are set."""
        return all(tex in self._known for tex in texts)

    @property
    def started(self) -> bool:
        """Whether anything was ever asked for."""
        return bool(self._asked)

    @property
    def done(self) -> bool:
        """Whether all formulas that were asked for are there."""
        return bool(self._known) and self._task is None

    def _take(self, outlines: dict[str, Any]) -> None:
        self._known |= {tex: _formula(*outline) for tex, outline in outlines.items()}
        self._over()

    def _fail(self, error: Exception) -> None:
        self.trouble = tr("The equations cannot be typeset ({error}).", error=error)
        self._over()

    def _over(self) -> None:
        self._task = None
        self._next()
        self.ready.emit()


def outlines(texts: Iterable[str]) -> dict[str, Any]:
    """Vertices, y up, and codes of every text; safe in any thread.

    A text that is no TeX, as a person may write one, has none.
    """
    out = {}
    with _one_at_a_time:
        from matplotlib.font_manager import FontProperties
        from matplotlib.textpath import TextPath

        font = FontProperties(math_fontfamily="stix")
        for tex in texts:
            with suppress(ValueError):
                path = TextPath((0, 0), f"${tex}$", size=EM, prop=font)
                out[tex] = (path.vertices.copy(), path.codes.copy())
    return out


def _formula(vertices: Any, codes: Any) -> Formula:
    """matplotlib's path as Qt's; y turned down."""
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.WindingFill)
    points = [(float(x), -float(y)) for x, y in vertices]
    steps: dict[int, tuple[int, Callable[..., object]]] = {
        1: (1, path.moveTo),
        2: (1, path.lineTo),
        3: (2, path.quadTo),
        4: (3, path.cubicTo),
        79: (1, lambda *_: path.closeSubpath()),
    }
    at = 0
    while at < len(points):
        count, draw = steps[int(codes[at])]
        draw(*(c for p in points[at : at + count] for c in p))
        at += count
    box = path.boundingRect()
    return Formula(path, box)
