"""A plot that shows a second detector for comparison: its strength, τ and intervals."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.document import Document
from inspector.timeline.gestures import Gestures, Hit, Part
from inspector.timeline.layers import Scenery
from inspector.timeline.pane import CurveStyle, Pane
from inspector.timeline.tau_line import colour_tau, tau_line_label
from inspector.widgets.background import OneTask
from inspector.widgets.labels import capitalised
from inspector.widgets.theme import Colours, Theme
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DETECTORS
from twistcore.review import Judged
from twistcore.skeleton.helper import Helper

_HEADROOM = 2.2  # smallest range of the plot, as a multiple of τ


class ReadOnlyGestures(Gestures):
    """Mouse gestures for a read-only plot: panning, zooming and moving the playhead."""

    draws = False

    def hit(self, frame: float, pixel: float) -> Hit:
        """Return a hit on the playhead if it is at `frame`, or else a hit on empty space."""
        hit = super().hit(frame, pixel)
        return hit if hit.part is Part.PLAYHEAD else Hit(Part.EMPTY)


class OtherDetector(Pane):
    """A plot of the selected chain with a second detector at its automatic τ.

    The analysis with this detector runs in the background. It starts when the plot is first shown.
    """

    def __init__(self, document: Document, colours: Colours, parent: QWidget | None = None) -> None:
        self._document = document
        self.scenery = Scenery(colours)
        super().__init__(
            "other", (CurveStyle("strength", "before"),), self.scenery, root=True, parent=parent
        )
        self._clip: ClipAnalysis | None = None  # the clip being analysed
        self._used = ["", ""]  # the current detector, and the previous one or ''
        self._task = OneTask(self)
        self._line = pg.InfiniteLine(angle=0)
        self.addItem(self._line)
        colours.follow(self._colour_line)

    @property
    def method(self) -> str:
        """The name of the detector to show.

        This is the detector that was used before the current one or, if there was none, any
        detector except the current one.
        """
        if self._used[0] != (now := self._document.method):
            self._used = [now, self._used[0]]
        before = self._used[1]
        there = DETECTORS.ready()
        return before if before in there else next(m for m in there if m != now)

    @property
    def _name(self) -> str:
        return capitalised(translate_core_sentence(DETECTORS.info(self.method).label))

    @property
    def intervals(self) -> tuple[Judged, ...]:
        """The intervals that this detector finds in the chain, or () during the analysis."""
        return self.scenery.intervals

    def _colour_line(self, theme: Theme) -> None:
        colour_tau(self._line, theme)

    def move_playhead(self, before: int, after: int) -> None:
        """Repaint the plot at the old and the new frame of the playhead."""
        self.scenery.frame = after
        super().move_playhead(before, after)

    def refresh(self) -> None:
        """Show the selected chain, or start the analysis if this detector has not run yet."""
        data = self._document.data
        if data is None or not self._document.chain or self._document.limb is not None:
            return  # there is only one detector for limb flips
        if isinstance(self._document.find_chain(self._document.chain), Helper):
            self.forget()
            self.show_title([(tr("There is only one detector for twist bones"), "soft")])
            self.touch()
            return
        analysis = data.analysis.kept(self.method)
        if analysis is None:
            self._begin(data.analysis)
            self.show_title([(f"{self._name} … ", "soft")])
            return
        chain = self._document.chain
        tau = analysis.automatic_tau(chain)
        found = analysis.intervals(chain, tau)
        self.scenery.frames, self.scenery.frame = self._document.frames, self._document.frame
        self.scenery.set_intervals(tuple(Judged(k, i) for k, i in enumerate(found)))
        strength = np.degrees(analysis.strength(chain))
        self.set_curve("strength", strength)
        degrees = float(np.degrees(tau))
        self._line.setValue(float(np.sqrt(degrees)))
        self.show_tau(self._line.value(), tau_line_label(degrees))
        self.show_values(0.0, max(float(strength.max(initial=0.0)), _HEADROOM * degrees))
        count = plural("{n} interval", "{n} intervals", len(found))
        symbol = translate_core_sentence(DETECTORS.info(self.method).strength)
        title = [(f"{self._name} ", "soft"), (symbol, "text")]
        self.show_title([*title, (f"   {count}", "text"), (f"   {tr('√ scale')}", "soft")])
        self.touch()

    def _begin(self, clip: ClipAnalysis) -> None:
        if self._clip is clip:
            return
        self.forget()
        self._clip, method = clip, self.method
        self._task.run(lambda tell: clip.by(method, tell), self._finished)

    def _finished(self, _: object) -> None:
        self._clip = None
        self.refresh()

    def forget(self) -> None:
        """Discard the data of the clip, and cancel a running analysis."""
        self._task.cancel()
        self._clip = None
        self.scenery.set_intervals(())
        self.set_curve("strength", np.zeros(0))
