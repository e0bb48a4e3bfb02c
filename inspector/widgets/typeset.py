"""Typeset TeX with matplotlib as outlines, which Qt can fill at any scale and in any colour."""

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

EM = 100.0  # length of an em (the font size) in the units of the outlines
# Maximum length of a formula, because matplotlib takes seconds for many thousand letters
_LONGEST = 1000
_SHOWN = 60  # number of letters of a formula that a message shows
_one_at_a_time = Lock()  # matplotlib's TeX parser is not thread-safe


@dataclass(frozen=True, eq=False)
class Formula:
    """The outlines of a formula.

    The baseline is at y = 0, and y points down. The length of an em is EM units.

    Attributes
    ----------
    path
        The outlines as a path.
    box
        The bounding box of the path.
    """

    path: QPainterPath
    box: QRectF


class Typesetter(QObject):
    """A typesetter that works in a background thread.

    Formulas that are requested together become available together. Typesetting takes half a second,
    or several seconds if matplotlib must first index the fonts.
    """

    ready = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._known: dict[str, Formula] = {}
        self._requested: dict[str, None] = {}
        self._waiting: list[tuple[str, ...]] = []  # requests that have not been started
        self._task: Task | None = None
        self.trouble = ""  # an error message if no formula could be typeset, or ''
        # An error message if a formula of the latest request could not be typeset, or ''
        self.left_out = ""

    def start(self, texts: Iterable[str]) -> None:
        """Start to typeset the formulas that have not been requested before.

        When they are available, `ready` is emitted.
        """
        fresh = tuple(tex for tex in texts if tex not in self._requested)
        self._requested |= dict.fromkeys(fresh)
        if fresh:
            self._waiting.append(fresh)
            self._next()

    def _next(self) -> None:
        if self._task is None and self._waiting:
            texts = self._waiting.pop(0)
            self._task = Task(lambda _: formula_outlines(texts), self)
            self._task.finished.connect(lambda found: self._take(texts, found))
            self._task.failed.connect(self._fail)
            self._task.start()

    def formula(self, tex: str) -> Formula | None:
        """Return the outlines of a formula, or None if they are not available."""
        return self._known.get(tex)

    def has(self, texts: Iterable[str]) -> bool:
        """Return True if the outlines of all these formulas are available."""
        return all(tex in self._known for tex in texts)

    @property
    def started(self) -> bool:
        """True if any formula has been requested."""
        return bool(self._requested)

    @property
    def done(self) -> bool:
        """True if formulas have been typeset and no request is in progress."""
        return bool(self._known) and self._task is None

    def _take(self, texts: tuple[str, ...], found: dict[str, Any]) -> None:
        self._known |= {tex: _formula(*outline) for tex, outline in found.items()}
        bad = next((tex for tex in texts if tex not in found), None)
        self.left_out = ""
        if bad is not None:
            self.left_out = tr(
                "An equation could not be typeset and is shown as TeX: {tex}",
                tex=bad if len(bad) <= _SHOWN else f"{bad[:_SHOWN]}…",
            )
        self._over()

    def _fail(self, error: Exception) -> None:
        self.trouble = tr("The equations could not be typeset: {error}.", error=error)
        self._over()

    def _over(self) -> None:
        self._task = None
        self._next()
        self.ready.emit()


def formula_outlines(texts: Iterable[str]) -> dict[str, Any]:
    """Return the vertices and path codes of each formula, keyed by its TeX. Thread-safe.

    In these outlines, y points up. Strings that are not valid TeX, too long or nested too deeply
    are omitted.
    """
    out = {}
    with _one_at_a_time:
        from matplotlib.font_manager import FontProperties
        from matplotlib.textpath import TextPath

        font = FontProperties(math_fontfamily="stix")
        for tex in texts:
            if len(tex) > _LONGEST:
                continue
            with suppress(Exception):  # TeX in other people's files can raise almost anything
                path = TextPath((0, 0), f"${tex}$", size=EM, prop=font)
                out[tex] = (path.vertices.copy(), path.codes.copy())
    return out


def _formula(vertices: Any, codes: Any) -> Formula:
    """Convert a matplotlib outline, with y pointing up, to a Qt path, with y pointing down."""
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
