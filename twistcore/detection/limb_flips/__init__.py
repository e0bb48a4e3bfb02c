"""Flips of a whole limb about the line from its first joint to its end.

From one frame to the next, a knee is suddenly on the other side of the leg; some frames later it is
back. The ankle stays where it is.
"""

from twistcore.detection.limb_flips.flips import LimbFlipAnalysis, LimbFlips, analyse_limbs
from twistcore.detection.limb_flips.swivel import BENT

__all__ = ["BENT", "LimbFlipAnalysis", "LimbFlips", "analyse_limbs"]
