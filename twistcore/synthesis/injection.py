"""Drawing errors and putting them into a motion."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.chain import Chain
from twistcore.detection import Kind
from twistcore.encoding import encoded
from twistcore.limb import Limb
from twistcore.motion import Motion, Skeleton
from twistcore.refinement import remove_twist
from twistcore.rotation import Array, multiply, normalise, quaternion_from_axis_angle
from twistcore.synthesis.protocol import PROTOCOLS, Protocol

_APART = 2  # frames between two intervals of a chain
_TRIES = 50


@dataclass(frozen=True, eq=False)
class InjectedError:
    """A known error: name of chain or limb, frames [start, stop), offset in radians, a frame each.

    leak: radians by which the compensation of the child, or of a limb's end, misses, likewise, or
    None; kind: a counter-twist or a limb flip; carried: of a flip, whether the end went along.
    """

    chain: str
    start: int
    stop: int
    offset: Array
    leak: Array | None = None
    kind: Kind = Kind.COUNTER_TWIST
    carried: bool = False

    def changed_joints(self, chain: Chain, skeleton: Skeleton) -> tuple[int, ...]:
        """Joints of its chain or limb with another rotation of their own: not an end carried."""
        joints = chain.changed_joints(skeleton)
        return joints[:1] if self.carried and self.leak is None else joints


def generator(seed: int, clip: str, *more: int) -> np.random.Generator:
    """Random numbers that depend on the seed, the clip's name and `more`, on nothing else."""
    return np.random.default_rng([seed, zlib.crc32(encoded(Path(clip).stem)), *more])


def draw_targets(
    chains: Sequence[Chain], rng: np.random.Generator, protocol: Protocol = PROTOCOLS["P0"]
) -> tuple[Chain, ...]:
    """Two chains that share no joint [Choi26 §4.1.1]; with `both`, a chain and the one below it."""
    if protocol.clean or not chains:
        return ()
    pairs = [
        (a, b)
        for k, a in enumerate(chains)
        for b in chains[k + 1 :]
        if (a.child == b.parent if protocol.both else not _joints(a) & _joints(b))
    ]
    if not pairs:
        return tuple(chains[:1])
    return pairs[int(rng.integers(len(pairs)))]


def _joints(chain: Chain) -> set[int]:
    return {chain.parent, chain.child, chain.grandchild} - {-1}


def draw_errors(
    chains: Sequence[Chain],
    frames: int,
    rng: np.random.Generator,
    protocol: Protocol = PROTOCOLS["P0"],
    *,
    fps: float = 120.0,
    first: int = 1,
) -> tuple[InjectedError, ...]:
    """2-5 intervals in each chain as the protocol has them, at least 2 frames apart.

    chains: limbs, and only those, where the protocol is one of limb flips.
    first: the first frame of the capture; 1 leaves a T-pose in frame 0 alone. But for the border
    protocol every edge lies inside the capture. A clip too short for 2 intervals gets fewer.
    """
    errors: list[InjectedError] = []
    for chain in chains:
        taken = np.zeros(frames, dtype=bool)
        for k in range(0 if protocol.clean else int(rng.integers(2, 6))):
            place = _place(taken, first, rng, protocol, fps, k)
            if place is None:
                continue
            start, stop = place
            taken[start:stop] = True
            offset = _offset(start > first, stop < frames, stop - start, rng, protocol)
            carried = protocol.limb and bool(rng.integers(2))
            leak = None
            if protocol.leak and not carried:
                leak = np.radians(protocol.leak) * rng.standard_normal(stop - start)
            kind = Kind.LIMB_FLIP if protocol.limb else Kind.COUNTER_TWIST
            errors.append(InjectedError(chain.name, start, stop, offset, leak, kind, carried))
    return tuple(sorted(errors, key=lambda e: (e.chain, e.start)))


def _place(
    taken: np.typing.NDArray[np.bool_],
    first: int,
    rng: np.random.Generator,
    protocol: Protocol,
    fps: float,
    k: int,
) -> tuple[int, int] | None:
    frames = len(taken)
    low, high = protocol.length
    if protocol.drift:
        low, high = (max(int(seconds * fps), 3) for seconds in protocol.drift)
    for _ in range(_TRIES):
        length = int(rng.integers(low, high + 1))
        inside = frames - 1 - length - (first + 1)
        if length > (frames - first) // 3 or inside < 1:
            continue
        start = first + 1 + int(rng.integers(inside))
        if protocol.border and k < 2:
            start = first if k == 0 else frames - length
        if not taken[max(0, start - _APART) : start + length + _APART].any():
            return start, start + length
    return None


def _offset(
    onset: bool, end: bool, length: int, rng: np.random.Generator, protocol: Protocol
) -> Array:
    delta = np.radians(rng.uniform(*protocol.delta)) * rng.choice([-1.0, 1.0])
    offset = np.full(length, delta)
    if protocol.drift:
        offset *= np.interp(np.arange(length), [0, (length - 1) / 2, length - 1], [0.0, 1.0, 0.0])
    if protocol.ramp:
        rise = np.arange(1, protocol.ramp + 1) / (protocol.ramp + 1)
        if onset:
            offset[: protocol.ramp] *= rise
        if end:
            offset[-protocol.ramp :] *= rise[::-1]
    if protocol.jitter:
        offset = offset + np.radians(protocol.jitter) * rng.standard_normal(length)
    return offset


def inject(motion: Motion, chains: Sequence[Chain], errors: Sequence[InjectedError]) -> Motion:
    """q_P ← q_P ⊗ R_a(δ), and R_a(−δ + leak) ⊗ q_X on every child X [Choi26 §4.1.3].

    chains: limbs too, where errors are flips; there a is the limb's line and X its end, unless it
    is carried.
    """
    offsets: dict[str, Array] = {}
    along: dict[str, Array] = {}
    by_name = {chain.name: chain for chain in chains}
    leaking = []
    for error in errors:
        at = slice(error.start, error.stop)
        offsets.setdefault(error.chain, np.zeros(motion.frames))[at] -= error.offset
        if isinstance(by_name.get(error.chain), Limb):
            carried = along.setdefault(error.chain, np.zeros(motion.frames))
            carried[at] -= error.offset if error.carried else 0.0
            carried[at] -= 0.0 if error.leak is None else error.leak
        elif error.leak is not None:
            leaking.append((error, error.leak))
    dirty = remove_twist(motion, chains, offsets, along)
    if not leaking:
        return dirty
    rotations = dirty.rotations.copy()
    for error, leak in leaking:
        chain, at = by_name[error.chain], slice(error.start, error.stop)
        axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
        turn = quaternion_from_axis_angle(axis, leak)
        rotations[at, chain.child] = normalise(multiply(turn, rotations[at, chain.child]))
    return dirty.with_rotations(rotations)
