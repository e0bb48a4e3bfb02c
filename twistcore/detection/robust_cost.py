"""The robust cost on which all decisions of the consistency detector are based."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.rotation import Array

# The degrees of freedom of Student's t. Of the residuals of natural motion (CMU clips, 30 and 120
# Hz), 95 % are within 2-2.6 local σ, 99 % within 3.4-5 σ and 99.9 % within 6-13 σ, as in Student's
# t with ν = 4.
NU = 4.0
CAP = 14.0  # nats: a residual above about 16 σ is a jump, and all jumps are equally unlikely


def residual_cost(z: Array, cap: float | Array = CAP) -> Array:
    """Return the costs, in nats, of residuals that are z times σ.

    The cost is the negative log-likelihood relative to a residual of 0, limited to `cap`.
    """
    return np.minimum(0.5 * (NU + 1.0) * np.log1p(z * z / NU), cap)
