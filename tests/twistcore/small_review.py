"""A review of a small clip, made here and known by heart: no detector runs, no file is read."""

from types import MappingProxyType

import numpy as np

from tests.twistcore.test_chain import both, line, rig
from twistcore.detection import Interval, Kind
from twistcore.quamo.tracking_settings import Tracking
from twistcore.review.model import Decision, Judged, ReviewState, chain_index_by_name
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs

CLIP = rig({**line("hip chest"), **both("*Clavicle *UpperArm *LowerArm *Hand", "chest")})
FRAMES = CLIP.motion.frames  # 2
ARM, FOREARM, SHOULDER = "LeftUpperArm", "LeftLowerArm", "LeftClavicle"
LIMB = "LeftUpperArm-LeftHand"
CHAINS = find_chains(CLIP.motion)
LIMBS = find_limbs(CLIP.motion, CHAINS)
TAU = {c.name: np.radians(5.0) for c in (*CHAINS, *LIMBS)}
TRACKING = Tracking(("LeftHand", "hip"), 500.0, 12.5, 0.25)


def twist(chain=ARM, start=0, stop=2, degrees=30.0, **more):
    """An interval of one offset, or of one for every frame where `degrees` lists them."""
    return Interval(chain, start, stop, np.radians(np.broadcast_to(degrees, stop - start)), **more)


def flip(chain=LIMB, start=0, stop=1, degrees=170.0, **more):
    return twist(chain, start, stop, degrees, kind=Kind.LIMB_FLIP, **more)


def state(*judged, tau=None, **more):
    """A review of these intervals; with the τ of chains alone unless others are given."""
    tau = {c.name: TAU[c.name] for c in CHAINS} if tau is None else tau
    number = max((j.id for j in judged), default=0) + 1
    return ReviewState(
        "paper", MappingProxyType(tau), tuple(judged), number, chain_index_by_name(tau), **more
    )


SEEN = Judged(
    2,
    twist(FOREARM, 0, 2, (20.0, -10.5), confidence=0.75, open=True, residual=np.radians(-1.5)),
    Decision.REJECTED,
    edited=True,
    supported=False,
    reviewer="Ada",
    decided_at="2026-01-02T03:04:05+00:00",
    note="a real turn",
    reason="motion",
)
BULK = Judged(1, twist(confidence=0.5), Decision.ACCEPTED, by_hand=True, in_bulk=True)
FLIPPED = Judged(3, flip(carried=True, joint="LeftHand"))
