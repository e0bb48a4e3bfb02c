"""Counter-rotations as a search for edges meets them: made, with jumps that it may find."""

import numpy as np
from hypothesis import strategies as st

from twistcore.detection.counter_twist.counter_rotation import (
    CounterRotation,
    combine_counter_rotation_residuals,
)
from twistcore.skeleton.rotation import wrap

seeds = st.integers(0, 2**32 - 1)


ROW = 1  # of the chains that are made, that which tests ask about


def counter_of(seed, chains=2, frames=90, jumps=0.08):
    """Residuals of some noise; runs of jumps that both signals show, or one, or each otherwise."""
    rng = np.random.default_rng(seed)
    shape = chains, frames
    sigma = np.exp(rng.uniform(-7.0, -3.5, (2, chains, 1)) + rng.uniform(0.0, 0.7, (2, *shape)))
    residual = sigma * rng.standard_normal((2, *shape))
    for row, t in zip(*np.nonzero(rng.random(shape) < jumps), strict=True):
        length = int(rng.choice([1, 1, 2, 3, 5, 8, 15]))
        at = slice(t, t + length)
        size = rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(-4.0, 1.1)) / length**0.5
        turn = size * rng.uniform(0.8, 1.2, len(residual[0, row, at]))
        way = rng.choice(["both", "both", "x", "y", "apart"])
        residual[0, row, at] += turn * (way != "y")
        residual[1, row, at] -= turn * (way != "x") * (0.7 if way == "apart" else 1.0)
    residual = wrap(residual)
    d, apart, sigma_d, sigma_apart = combine_counter_rotation_residuals(residual, sigma)
    denied = np.abs(apart) > 0.4 * np.abs(d) + 3.0 * sigma_apart
    event = (np.abs(d) > 4.0 * sigma_d) & ~denied
    lone = (np.abs(residual) > 6.0 * sigma).any(axis=0)
    return CounterRotation(*residual, *residual, *sigma, d, sigma_d, event, lone)
