"""The curves of one limb: its swivel, its jumps, how far it is bent, and what is taken out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from inspector.language import of_core, tr
from inspector.session.document import Document
from inspector.timeline.curve_values import above, rarest, unreliable_spans
from inspector.timeline.curves import NOTHING, SAME, Curves, in_degrees, number, widened
from inspector.timeline.pane import Pane
from twistcore.detection.limb_flips import BENT
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import wrap


class LimbCurves(Curves):
    """Computes the curves of the document's selected limb and hands them to the plots."""

    panes: Mapping[str, str] = {
        "theta": "φ (°)",
        "height": tr("off line (%)"),
        "strength": "Δφ (°)",
        "offset": tr("offset (°)"),
    }
    unreliable_words = tr("φ unreliable")
    unreliable_hint = tr("Limb nearly straight: its swivel φ means nothing here.")

    def __init__(self, document: Document) -> None:
        limb, flips = document.find_chain(document.chain), document.limb
        assert isinstance(limb, Limb)
        assert flips is not None
        super().__init__(document)
        self._limb, self._flips = limb, flips
        self.unreliable = unreliable_spans(flips.swivel.height, BENT)
        self._height = 100.0 * flips.swivel.height
        self._departures = flips.departures
        self._after = flips.swivel.angle
        # Flipped or not, on one side of a place where it seldom stands: jumps stay whole.
        usual = document.detector.intervals(limb.name, document.detector.automatic_tau(limb.name))
        expected = flips.swivel.angle.copy()
        for flip in usual:
            expected[flip.start : flip.stop] -= flip.offset
        self._seam = rarest(np.concatenate([flips.swivel.angle, expected]))

    def show_clip(self, panes: Mapping[str, Pane]) -> None:
        """The curves that no decision changes, and the ranges."""
        for key, name in (("theta", "c_before"), ("theta", "c_after"), ("strength", "m")):
            panes[key].set_curve(name, NOTHING)
        panes["strength"].set_curve("strength", self.strength)
        panes["height"].set_curve("height", self._height)
        panes["height"].show_values(0.0, max(10.0, float(self._height.max(initial=0.0))))
        y, _ = above(self._flips.swivel.angle, self._seam)
        self.grow(panes["theta"], y)

    def show_review(self, panes: Mapping[str, Pane]) -> None:
        """The curves after correction by the review's intervals, and the offset."""
        document, was = self.document, self._flips.swivel.angle
        self._after = now = document.corrected.swivel(self._limb)
        y, seams = above(now, self._seam)
        panes["theta"].set_curve("p_after", y, seams)
        self.grow(panes["theta"], y)
        y, seams = above(was, self._seam)
        apart = widened(np.abs(wrap(was - now)) > SAME)
        panes["theta"].set_curve("p_before", np.where(apart, y, np.nan), seams)
        offset = document.offset(self._limb.name)
        self._departures = self._flips.departures_without(offset)
        size = np.degrees(np.abs(self._departures))
        apart = widened(np.abs(size - self.strength) > np.degrees(SAME))
        panes["strength"].set_curve("after", np.where(apart, size, np.nan))
        self.show_offset(panes["offset"])

    def titles(self, frame: int) -> dict[str, list[tuple[str, str]]]:
        """Words and the numbers at a frame, as (text, colour role), by plot."""
        swivel, after = self._flips.swivel, float(np.degrees(np.abs(self._departures[frame])))
        joint = of_core(self._limb.middle_word)
        joint = joint[:1].upper() + joint[1:]
        return {
            "theta": [
                (f"{tr('Swivel')} ", "soft"),
                ("φ", "text"),
                (number(swivel.angle, frame), "before"),
                (number(self._after, frame), "after"),
                ("   ", "soft"),
                (f"{tr('━ before')} ", "before"),
                (tr("━ after"), "after"),
            ],
            "height": [
                (f"{tr('{joint} off the line', joint=joint)} ", "soft"),
                (f"{self._height[frame]:5.1f} %", "text"),
                (f" {tr('of the limb')}", "soft"),
            ],
            "strength": [
                (f"{tr('Jump per frame')} ", "soft"),
                ("Δφ", "text"),
                (in_degrees(float(self.strength[frame])), "before"),
                (in_degrees(after), "after"),
                (f"   {tr('√ scale')}", "soft"),
            ],
            "offset": self.offset_title(frame),
        }
