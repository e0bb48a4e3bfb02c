"""The values of one limb's curves: its swivel, its jumps, how far it is bent."""

from __future__ import annotations

import numpy as np

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.curve_values import rarest, unreliable_spans
from inspector.timeline.curves import Curves
from twistcore.detection.limb_flips import BENT
from twistcore.skeleton.limb import Limb


class LimbCurves(Curves):
    """The curves of the document's selected limb.

    swivel: as captured; after: its angle after correction; height: of the middle joint over the
    line, percent; departures: jumps of the swivel that are left, radians; seam: where a line is
    broken.
    """

    unreliable_words = tr("φ unreliable")
    unreliable_hint = tr("Limb nearly straight: its swivel φ means nothing here.")

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
        # Flipped or not, on one side of a place where it seldom stands: jumps stay whole.
        usual = document.detector.intervals(limb.name, document.detector.automatic_tau(limb.name))
        expected = flips.swivel.angle.copy()
        for flip in usual:
            expected[flip.start : flip.stop] -= flip.offset
        self.seam = rarest(np.concatenate([flips.swivel.angle, expected]))

    def follow_review(self) -> None:
        """Take the values after correction by the review's intervals."""
        self.after = self.document.corrected.swivel(self.limb)
        self.departures = self._flips.departures_without(self.offset)
