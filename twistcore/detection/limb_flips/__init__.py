"""Find limb flips, in which a limb rotates about the line from its first joint to its end.

For example, a knee is suddenly on the wrong side of the leg, and some frames later it is on the
right side again. Meanwhile, the ankle does not move.
"""

from twistcore.detection.limb_flips.flips import LimbFlipAnalysis, LimbFlips, analyse_limbs
from twistcore.detection.limb_flips.swivel import BENT

__all__ = ["BENT", "LimbFlipAnalysis", "LimbFlips", "analyse_limbs"]
