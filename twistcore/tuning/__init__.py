"""Choose thresholds τ from injected errors and people's verdicts, and learn the confidence.

[Choi26] uses a threshold τ but does not specify its value. This package computes the cost of every
τ in a grid and suggests the τ with the lowest cost. The cost depends on

- the share of injected error frames that are repaired (FSR), and
- the number of false alarms in the clips, whose existing errors are removed first.

The command `twistcore tune` and the tuning tab of the window use this package.
"""

from twistcore.tuning.cleaning import Verdicts, without_known_errors
from twistcore.tuning.clip_curves import ClipTuning, clip_tau_curves, prepare_clip_tuning
from twistcore.tuning.drawn_errors import DrawnErrors
from twistcore.tuning.injected_curve import GRID, Span, injected_tau_curve
from twistcore.tuning.profile import Profile, read_profile, write_profile
from twistcore.tuning.shared_tau import SharedTau, shared_tau
from twistcore.tuning.tau_curve import Cost, TauCurve, Tuned, tau_with_cost, total_tuning_cost

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
    "clip_tau_curves",
    "injected_tau_curve",
    "prepare_clip_tuning",
    "read_profile",
    "shared_tau",
    "tau_with_cost",
    "total_tuning_cost",
    "without_known_errors",
    "write_profile",
]
