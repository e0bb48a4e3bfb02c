"""Choose τ for each joint, from the clips' own noise and from errors injected into these clips.

[Choi26] uses a threshold τ but gives no value. This package chooses τ by its cost. At every τ of a
grid, the cost consists of the share of injected error frames that is corrected (FSR), and of the
false alarms in the clips after their own errors are removed. `twistcore tune` and the window's
tuning tab both use it.
"""

from twistcore.tuning.cleaning import Verdicts, cleaned
from twistcore.tuning.clip_curves import ClipTuning, clip_curves, clip_tuning
from twistcore.tuning.drawn_errors import DrawnErrors
from twistcore.tuning.injected_curve import GRID, Span, tau_curve
from twistcore.tuning.profile import Profile, read_profile, write_profile
from twistcore.tuning.shared_tau import SharedTau, shared_tau
from twistcore.tuning.tau_curve import Cost, TauCurve, Tuned, cost_of_all, tuned

__all__ = [
    "GRID",
    "ClipTuning",
    "Cost",
    "DrawnErrors",
    "Profile",
    "SharedTau",
    "Span",
    "TauCurve",
    "Tuned",
    "Verdicts",
    "cleaned",
    "clip_curves",
    "clip_tuning",
    "cost_of_all",
    "read_profile",
    "shared_tau",
    "tau_curve",
    "tuned",
    "write_profile",
]
