"""τ per joint: from the clips' own noise and from errors injected into these very clips.

[Choi26] has a threshold τ and names no value. Ours is chosen by what it costs: at every τ of a grid
the share of injected error frames that is repaired (FSR), and the false alarms in the clips once
their own errors are taken out. `twistcore tune` and the window's tuning tab both read this.
"""

from twistcore.tuning.cleaning import Verdicts, cleaned
from twistcore.tuning.clip_curves import ClipTuning, clip_curves, clip_tuning
from twistcore.tuning.profile import Profile, read_profile, write_profile
from twistcore.tuning.tau_curve import GRID, TauCurve, Tuned, tau_curve, tuned

__all__ = [
    "GRID",
    "ClipTuning",
    "Profile",
    "TauCurve",
    "Tuned",
    "Verdicts",
    "cleaned",
    "clip_curves",
    "clip_tuning",
    "read_profile",
    "tau_curve",
    "tuned",
    "write_profile",
]
