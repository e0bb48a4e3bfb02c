"""The robust cost on which all decisions of the consistency detector are based."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array

# Residuals of natural motion over their local σ: 95 % within 2-2.6, 99 % within 3.4-5, 99.9 %
# within 6-13 (CMU, 30 and 120 Hz, plain and rich). Student's t with ν = 4 has about these tails.
NU = 4.0
CAP = 14.0  # beyond ~16 σ a residual is a jump, and all jumps are equally unlikely


def residual_cost(z: Array, cap: float | Array = CAP) -> Array:
    """Return the negative log-likelihood of a residual of z σ relative to 0, at most `cap`."""
    return np.minimum(0.5 * (NU + 1.0) * np.log1p(z * z / NU), cap)
