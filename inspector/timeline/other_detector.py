"""The other detector beside the one in use: its strength, its τ and its intervals, to compare."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.timeline.gestures import Gestures, Hit, Part
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.tau_line import colour_tau
from inspector.widgets.background import Task
from inspector.widgets.theme import Theme
from twistcore.detection import DETECTORS, Analysis
from twistcore.review import Judged

_NAMES = {"paper": "Paper's detector", "consistency": "Our detector"}
_STRENGTHS = {"paper": "m", "consistency": "strength"}
_HEADROOM = 2.2  # times τ that the plot reaches at least


class Onlooker(Gestures):
    """Time can be moved and zoomed; what the other detector found is not for editing."""

    def hit(self, frame: float, pixel: float) -> Hit:
        """The playhead, or nothing."""
        hit = super().hit(frame, pixel)
        return hit if hit.part is Part.PLAYHEAD else Hit(Part.EMPTY)


class OtherDetector(Pane):
    """A plot of what the detector that is not in use says of the selected chain.

    It is analysed in the background the first time it is seen, at its own automatic τ.
    """

    def __init__(self, document: Document, theme: Theme, parent: QWidget | None = None) -> None:
        self._document = document
        self.scenery = Scenery(theme)
        super().__init__(
            "other", (CurveStyle("strength", "before"),), self.scenery, root=True, parent=parent
        )
        self._data: Analysed | None = None  # what the analysis is of
        self._analysis: Analysis | None = None
        self._task: Task | None = None
        self._line = pg.InfiniteLine(
            angle=0, label="", labelOpts={"position": 0.985, "anchors": [(1.0, 1.15), (1.0, 1.15)]}
        )
        self.addItem(self._line)

    @property
    def method(self) -> str:
        """The detector that is not in use."""
        return next(m for m in DETECTORS if m != self._document.review.state.method)

    @property
    def intervals(self) -> tuple[Judged, ...]:
        """What it found in the selected chain; empty while it is at work."""
        return self.scenery.intervals

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self.scenery.theme = theme
        super().set_theme(theme)
        colour_tau(self._line, theme)

    def move_playhead(self, before: int, after: int) -> None:
        """Repaint where it was and where it is, in frames."""
        self.scenery.frame = after
        super().move_playhead(before, after)

    def refresh(self) -> None:
        """Show the selected chain; analyse the clip first where that is still to do."""
        data = self._document.data
        if data is None or not self._document.chain:
            return
        if self._data is not data:
            self._begin(data)
        if self._analysis is None:
            self.show_title([(f"{_NAMES[self.method]} … ", "soft")])
            return
        chain, analysis = self._document.chain, self._analysis
        tau = analysis.automatic_tau(chain)
        found = analysis.intervals(chain, tau)
        self.scenery.frames, self.scenery.frame = self._document.frames, self._document.frame
        self.scenery.set_intervals(tuple(Judged(k, i) for k, i in enumerate(found)))
        strength = np.degrees(analysis.strength(chain))
        self.set_curve("strength", strength)
        degrees = float(np.degrees(tau))
        self._line.setValue(float(np.sqrt(degrees)))
        self._line.label.setFormat(f"τ {degrees:.1f}°")
        self.show_values(0.0, max(float(strength.max(initial=0.0)), _HEADROOM * degrees))
        count = "1 interval" if len(found) == 1 else f"{len(found)} intervals"
        title = [(f"{_NAMES[self.method]} ", "soft"), (_STRENGTHS[self.method], "text")]
        self.show_title([*title, (f"   {count}", "text"), ("   √ scale", "soft")])
        self.touch()

    def _begin(self, data: Analysed) -> None:
        self.forget()
        self._data = data
        detector = DETECTORS[self.method]
        self._task = task = Task(
            lambda: detector.analyse(data.motion, data.chains, task.tell), self
        )
        self._task.finished.connect(self._finished)
        self._task.start()

    def _finished(self, analysis: Analysis) -> None:
        self._task = None
        self._analysis = analysis
        self.refresh()

    def forget(self) -> None:
        """Let the clip go; an analysis under way is not waited for."""
        if self._task is not None:
            self._task.cancel()
        self._task = self._data = self._analysis = None
        self.scenery.set_intervals(())
        self.set_curve("strength", np.zeros(0))
