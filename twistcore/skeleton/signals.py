"""Measure the twist signals of a chain: θp, θc, their increments and the strength m(t) [Choi26]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.skeleton.chain import Chain, chain_named, find_chains
from twistcore.skeleton.motion import HasMotion, Motion, motion_of
from twistcore.skeleton.rotation import (
    Array,
    rotate,
    twist_angle,
    twist_reliability,
    vector_lengths,
    wrap,
)
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress


@dataclass(frozen=True, eq=False)
class TwistSignals:
    """The twist signals of one chain in every frame.

    Parameters
    ----------
    theta_p : ndarray, shape (frames,)
        θp, the twist of the parent about its bone axis, radians in (−π, π] [Choi26 Eq. 8].
    theta_c : ndarray, shape (frames,)
        θc, the azimuth of the child relative to frame 0, radians: the sum of its increments.
    dtheta_p, dtheta_c : ndarray, shape (frames,)
        Increments of θp and θc from the previous frame, radians in (−π, π], 0 in frame 0 [Choi26
        Eq. 9, 12].
    strength : ndarray, shape (frames,)
        m(t), the angle by which parent and child twist in opposite directions, radians ≥ 0 [Choi26
        Eq. 1, 13].
    swing_reliability : ndarray, shape (frames,)
        How well θp is defined, 0…1: √(w² + (v·a)²) for the parent's rotation (w, v) and bone axis
        a.
    azimuth_reliability : ndarray, shape (frames,)
        How well θc is defined, 0…1: the sine of the angle between the two bones, 0 if the limb is
        straight.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> signals = tc.twist_signals(tc.read_clip("assets/walk_injected.bvh"), "LeftForeArm")
    >>> signals
    <TwistSignals: 344 frames, m up to 152.5°>
    >>> bool(np.all(signals.strength >= 0.0))
    True
    """

    theta_p: Array
    theta_c: Array
    dtheta_p: Array
    dtheta_c: Array
    strength: Array
    swing_reliability: Array
    azimuth_reliability: Array

    def __repr__(self) -> str:
        peak = float(np.degrees(self.strength.max(initial=0.0)))
        return f"<TwistSignals: {len(self.strength)} frames, m up to {peak:.1f}°>"


def twist_signals(clip: Motion | HasMotion, chain: Chain | str) -> TwistSignals:
    """Measure the twist signals of a chain in every frame [Choi26 Eq. 8-13].

    Parameters
    ----------
    clip : Clip or Motion
        The clip to measure.
    chain : Chain or str
        A chain of the clip, or the name or label of a chain that :func:`find_chains` finds.

    Returns
    -------
    TwistSignals
        θp, θc, their increments and m(t), in radians, each of shape (frames,).

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.
    TwistError
        If the clip has no chain of this name.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> signals = tc.twist_signals(clip, "LeftForeArm")
    >>> signals.theta_p.shape
    (344,)
    >>> int(signals.strength.argmax())  # the frame of the strongest counter-rotation
    323
    """
    motion = motion_of(clip)
    if isinstance(chain, str):
        chain = chain_named(find_chains(motion), chain, str(getattr(clip, "path", "motion")))
    axis = chain.axis
    q_p, q_c = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
    theta_p = twist_angle(q_p, axis)
    dtheta_p = _increments(theta_p)
    v = rotate(q_c, chain.arm)
    across = v - np.einsum("...i,...i->...", v, np.broadcast_to(axis, v.shape))[:, None] * axis
    dtheta_c = azimuth_increments(across, axis)
    return TwistSignals(
        theta_p=theta_p,
        theta_c=np.cumsum(dtheta_c),
        dtheta_p=dtheta_p,
        dtheta_c=dtheta_c,
        strength=counter_rotation(dtheta_p, dtheta_c),
        swing_reliability=twist_reliability(q_p, axis),
        azimuth_reliability=vector_lengths(across),
    )


def signals_of_chains(
    motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
) -> dict[str, TwistSignals]:
    """Return the twist signals of several chains, keyed by chain name.

    `tell` is called with the progress, 0…1, before each chain.
    """
    tell = tell or ignore_progress
    found = {}
    for k, chain in enumerate(chains):
        tell(k / len(chains))
        found[chain.name] = twist_signals(motion, chain)
    return found


def azimuth_increments(across: Array, axis: Array) -> Array:
    """Return the increments Δθc of the child's azimuth, radians, shape (frames,) [Choi26 Eq. 12].

    Parameters
    ----------
    across
        The child's direction, projected onto the plane perpendicular to the bone axis, shape
        (frames, 3).
    axis
        Unit bone axis, shape (3,) or (frames, 3).
    """
    out = np.zeros(len(across))
    before, now = across[:-1], across[1:]
    a = np.broadcast_to(axis, across.shape)[1:]
    out[1:] = np.arctan2(
        np.einsum("ij,ij->i", np.cross(before, now), a), np.einsum("ij,ij->i", before, now)
    )
    return out


def counter_rotation(dtheta_p: Array, dtheta_c: Array) -> Array:
    """Return the strength m = min(|Δθp|, |Δθc|) where Δθp·Δθc < 0, and 0 elsewhere.

    This is [Choi26 Eq. 1, 13]. Angles are in radians, shape (frames,).
    """
    opposite = dtheta_p * dtheta_c < 0.0
    return np.where(opposite, np.minimum(np.abs(dtheta_p), np.abs(dtheta_c)), 0.0)


def _increments(angle: Array) -> Array:
    return wrap(np.diff(angle, prepend=angle[:1]))
