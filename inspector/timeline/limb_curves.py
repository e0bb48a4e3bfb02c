"""The values of a limb's curves: its swivel, the jumps of the swivel, and its bend."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.curve_values import rarest_angle, unreliable_spans
from inspector.timeline.curves import Curves
from twistcore.detection.limb_flips import BENT
from twistcore.skeleton.limb import Limb


class LimbCurves(Curves):
    """The curves of the limb that is selected in the document.

    Attributes
    ----------
    swivel
        The captured swivel: the angle of the middle joint about the line between the limb's ends.
    after
        The swivel after correction, in radians, (frames,).
    height
        The distance of the middle joint from the line between the limb's ends, in per cent of the
        limb's length, (frames,).
    departures
        The jumps of the swivel that remain after correction, in radians, (frames,).
    seam
        The angle, in radians, at which the lines of the swivel wrap around and are broken.
    """

    unreliable_words = tr("φ unreliable")
    unreliable_hint = tr("The limb is nearly straight here, so its swivel φ is unreliable.")

    def __init__(self, document: Document) -> None:
        limb, flips = document.find_chain(document.chain), document.limb
        assert isinstance(limb, Limb)
        assert flips is not None
        super().__init__(document)
        self.limb, self._flips, self.swivel = limb, flips, flips.swivel
        self.unreliable = unreliable_spans(flips.swivel.height, BENT)
        self.height = 100.0 * flips.swivel.height
        self.departures = flips.departures
        self.after = flips.swivel.angle
        # Break lines at an angle that is rare with and without flips, so jumps are not broken.
        usual = document.detector.intervals(limb.name, document.detector.automatic_tau(limb.name))
        expected = flips.swivel.angle.copy()
        for flip in usual:
            expected[flip.start : flip.stop] -= flip.offset
        self.seam = rarest_angle(np.concatenate([flips.swivel.angle, expected]))

    def follow_review(self) -> None:
        """Update the values after correction from the review's intervals."""
        self.after = self.document.corrected.swivel(self.limb)
        self.departures = self._flips.departures_without(self.offset)
