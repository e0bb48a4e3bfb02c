"""Hypothesis strategies: rotations, axes, offsets."""

import numpy as np
from hypothesis import strategies as st

from twistcore.skeleton.rotation import normalise

finite = st.floats(-1.0, 1.0, allow_nan=False).map(lambda x: round(x, 6))


def _unit(values: list[float]) -> np.ndarray:
    return normalise(np.array(values))


quaternions = (
    st.lists(finite, min_size=4, max_size=4)
    .filter(lambda v: sum(x * x for x in v) > 1e-3)
    .map(_unit)
)
axes = (
    st.lists(finite, min_size=3, max_size=3)
    .filter(lambda v: sum(x * x for x in v) > 1e-3)
    .map(_unit)
)
angles = st.floats(-np.pi, np.pi, allow_nan=False)
orders = st.permutations("XYZ").map("".join)
