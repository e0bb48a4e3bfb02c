"""What of a motion cannot be examined, and why: never passed over in silence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.body import Body, Unexamined
from twistcore.chain import Chain
from twistcore.motion import Motion

SHORTEST = 0.25  # seconds: in less no error can be told from motion
FEWEST_FRAMES = 5
_STILL = 1e-6  # of a quaternion's component: rounding of a joint that never turns


def why_not_examined(motion: Motion, chains: Sequence[Chain]) -> str:
    """Why nothing in a motion could be examined: a clause, or '' where something could."""
    if not chains:
        return "no arm or leg was found in its skeleton"
    if motion.frames < max(FEWEST_FRAMES, round(SHORTEST * motion.fps)):
        one = motion.frames == 1
        return f"{motion.frames} frame{' is' if one else 's are'} too few to tell error from motion"
    joints = sorted({j for c in chains for j in (c.parent, c.child)})
    if np.ptp(motion.rotations[:, joints], axis=0).max() < _STILL:
        return "no joint of its arms and legs moves"
    return ""


def unexamined_limbs(body: Body, chains: Sequence[Chain]) -> tuple[Unexamined, ...]:
    """The limbs of a body that no chain examines; chains: those of a person among them."""
    covered = {
        (c.person, body.names[c.parent].side or body.names[c.child].side, _kind_of(body, c))
        for c in chains
        if not c.segment
    }
    return tuple(u for u in body.missing if (u.person, u.side, u.kind) not in covered)


def _kind_of(body: Body, chain: Chain) -> str:
    """'arm' or 'leg' by the names of a chain's joints, '' where they do not say."""
    roles = {role for j in (chain.parent, chain.child) for role in body.names[j].roles}
    if roles & {"shoulder", "arm", "forearm", "hand"}:
        return "arm"
    return "leg" if roles & {"upleg", "leg", "foot", "toe"} else ""
