"""Find limbs that do not move for a while, because markers were lost or a pose was held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.skeleton.chain import Chain, chain_limb_name
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notation import without_repeated_frames
from twistcore.skeleton.runs import runs_of_true

_LEAST, _FEWEST = 0.25, 6  # minimum length of a span in seconds and in frames
_ALIVE = 0.7  # minimum share of the other frames in which the limb moves


def frozen_spans(motion: Motion, chains: Sequence[Chain]) -> tuple[tuple[str, int, int], ...]:
    """Return (limb, start, stop) for each span of frames [start, stop) in which a limb is frozen.

    `limb` is the limb's name. The spans are sorted by start. Spans at the start or the end of the
    clip are excluded, because a pose may be held there on purpose. For a clip with held (repeated)
    frames, the result is empty.
    """
    if motion.frames < 3 or without_repeated_frames(motion) is not None:
        return ()
    limbs: dict[str, set[int]] = {}
    for chain in chains:
        if name := chain_limb_name(chain):
            limbs.setdefault(name, set()).update((chain.parent, chain.child))
    least = max(_FEWEST, round(_LEAST * motion.fps))
    found = []
    for name, joints in limbs.items():
        still = np.ones(motion.frames, dtype=bool)
        still[:1] = False
        for joint in joints:
            q = motion.rotations[:, joint]
            still[1:] &= (q[1:] == q[:-1]).all(axis=1)
        for start, stop in runs_of_true(still):
            others = np.concatenate([still[1:start], still[stop:]])
            alive = len(others) and others.mean() < 1.0 - _ALIVE
            if alive and stop - start + 1 >= least:
                found.append((name, start - 1, stop))
    inner = (f for f in found if f[1] > 0 and f[2] < motion.frames)
    return tuple(sorted(inner, key=lambda f: (f[1], f[2], f[0])))
