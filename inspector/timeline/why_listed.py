"""A plot of the measured quantity that explains why the selected interval is listed."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtWidgets import QWidget

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.timeline.curves import Title
from inspector.timeline.dots import Dots
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import CurveStyle, Pane
from inspector.widgets.axes import UnitAxis
from inspector.widgets.background import OneTask
from inspector.widgets.signed_numbers import format_number
from twistcore.detection import Interval
from twistcore.detection.quantity import Quantity, evidence_curve_of_interval

_STYLES = (
    CurveStyle("limit", "tau", dashed=True),
    CurveStyle("size", "text"),
    CurveStyle("value", "before"),
)


def selected_plottable_interval(document: Document) -> Interval | None:
    """Return the selected interval if its kind of error has a quantity to plot, or None.

    In an exercise, the result is None, because the curve would reveal the error.
    """
    judged = document.interval
    if document.data is None or document.data.blind or judged is None:
        return None
    return judged.interval if judged.interval.kind.info.quantity else None


class WhyListed(Pane):
    """A plot of the quantity that explains why the selected interval is listed, with its limit.

    The interval's kind of error defines the quantity. The quantity is computed in the background
    or, for a figure, immediately.
    """

    def __init__(self, document: Document, scenery: Scenery, parent: QWidget | None = None) -> None:
        super().__init__("why", _STYLES, scenery, shade=False, parent=parent)
        self.least_part = 0.0  # any range is allowed, because the limit is always visible
        self._document = document
        self._task = OneTask(self)
        # The interval whose quantity is shown or being computed
        self._interval: Interval | None = None
        self.quantity: Quantity | None = None
        self._failure = ""
        self.dot = Dots(self.view, scenery, "before")
        document.frame_changed.connect(self._describe)

    def refresh(self) -> None:
        """Show the quantity of the selected interval, unless the plot is hidden."""
        interval = selected_plottable_interval(self._document)
        if interval is None or self.isHidden():
            return
        if interval is self._interval:
            self._describe()  # the playhead may have moved while the plot was hidden
            return
        if self._interval is None or not self._interval.may_be_same(interval):
            self.forget()  # keep a curve of the same error until the new curve is ready
        self._interval = interval
        assert self._document.data is not None
        search = self._document.data.analysis.search(self._document.method)
        work = partial(evidence_curve_of_interval, search, interval)
        if self.scenery.still:
            self._show(work())
        else:
            self._describe()
            self._task.run(lambda _: work(), self._show, self._fail)

    def forget(self) -> None:
        """Discard the quantity and cancel its computation."""
        self._task.cancel()
        self._interval = self.quantity = None
        self._failure = ""
        self.dot.dots = []
        for name in self.curves:
            self.set_curve(name, np.zeros(0))

    def _fail(self, error: Exception) -> None:
        self._failure = translate_core_sentence(str(error))
        self._describe()

    def _show(self, quantity: Quantity | None) -> None:
        interval, self.quantity = self._interval, quantity
        if interval is None:
            return
        if quantity is None:
            self._failure = tr("There is no curve for this interval.")
            self._describe()
            return
        values = quantity.values
        axis = self.axes["left"]
        assert isinstance(axis, UnitAxis)
        axis.unit, axis.picture = quantity.unit, None
        turns = np.abs(np.diff(values)) > 180.0 if quantity.unit == "°" else np.zeros(0)
        self.set_curve("value", values, np.flatnonzero(turns))
        self.set_curve("limit", quantity.limit if quantity.limit is not None else np.zeros(0))
        size = np.full(len(values), np.nan)
        if quantity.size is not None:
            size[interval.start : interval.stop] = quantity.size
            inside = np.abs(values[interval.start : interval.stop] - quantity.size)
            if np.isfinite(inside).any():  # a dot marks the number that the interval has
                self.dot.frame = interval.start + int(np.nanargmin(inside))
                self.dot.dots = [(float(values[self.dot.frame]), False)]
        self.set_curve("size", size)
        self._fit()
        self._describe()
        self.touch()

    def _fit(self) -> None:
        """Fit the value axis to the values in the visible frames."""
        seen = np.concatenate([y for y, _ in self.values.values()])
        seen = seen[np.isfinite(seen)]
        low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 0.0)
        self.time.forget_zoom()
        self.show_values(low, high)
        self.show_part(*self.view.viewRange()[0])

    def _describe(self, *_: object) -> None:
        """Show a title with the quantity and its limit at the playhead."""
        if self._interval is None or self.isHidden():
            return
        quantity, frame = self.quantity, self._document.frame
        if quantity is None:
            self.show_title([(self._failure or "…", "soft")])
            return
        title: Title = [(f"{translate_core_sentence(quantity.label)} ", "soft")]
        title.append((_number(quantity, float(quantity.values[frame])), "before"))
        if quantity.limit is not None:
            title.append((f"   {tr('limit')} ", "soft"))
            title.append((_number(quantity, float(quantity.limit[frame])), "tau"))
        self.show_title(title)


def _number(quantity: Quantity, value: float) -> str:
    """Return a value with its unit, or a dash if it is undefined."""
    return f"{format_number(value)}{quantity.unit}" if np.isfinite(value) else "–"
