"""Draw random errors and inject them into a motion."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.detection import Kind
from twistcore.detection.carried_rolls import bent_frames
from twistcore.errors import TwistError
from twistcore.files.encoding import encode_utf8
from twistcore.skeleton.chain import Chain, chain_named
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import HasMotion, Motion, Skeleton, motion_of
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rig import AS_FOUND
from twistcore.skeleton.rotation import Array, multiply, normalise, quaternion_from_axis_angle
from twistcore.synthesis.offset_shape import (
    Place,
    frames_added_by_offset_filter,
    gap_filling_offset,
    injected_offset_over_time,
    spans_with_straight_chain,
)
from twistcore.synthesis.protocol import PROTOCOLS, Protocol
from twistcore.work.frozen import dataclass

_APART = 2  # minimum number of frames between two intervals of a chain
_TRIES = 50
LEAST = float(np.radians(0.1))  # an error begins and ends with an offset of at least this angle


@dataclass(frozen=True, eq=False)
class InjectedError:
    """A known error that :func:`inject` adds to a motion.

    Parameters
    ----------
    chain : str
        Name of the chain or limb.
    start, stop : int
        Frames [start, stop) of the error, from 0.
    offset : ndarray, shape (stop − start,)
        Offset δ, the angle by which the parent is rotated in each frame, radians.
    leak : ndarray, shape (stop − start,), optional
        Error in the counter-rotation of the child, or of a limb's end, in each frame, radians.
    kind : Kind
        A counter-twist, a limb flip, a carried roll or, for an error of the child alone, a stretch
        or a spike.
    carried : bool
        True if the error also rotates the joints below: in a flip whose limb's end rotates with the
        limb, in a carried roll, in which the child rolls with its parent, and in an error of the
        child alone.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> error = tc.InjectedError("LeftArm", 100, 120, np.radians(np.full(20, 60.0)))
    >>> dirty = tc.inject(tc.read_clip("assets/walk.bvh"), [error])
    >>> tc.detect(dirty)["LeftArm"][0]
    <Interval LeftArm 100–120: +60.0°, confidence 1.00>
    """

    chain: str
    start: int
    stop: int
    offset: Array
    leak: Array | None = None
    kind: Kind = Kind.COUNTER_TWIST
    carried: bool = False

    def changed_joints(self, chain: Chain, skeleton: Skeleton) -> tuple[int, ...]:
        """Return the indices of the joints whose local rotation the error changes.

        A limb's end is not included if it rotates with the limb.
        """
        if self.single:
            return (chain.child,)
        joints = chain.changed_joints(skeleton)
        end_stays = self.kind == Kind.LIMB_FLIP and self.carried and self.leak is None
        return joints[:1] if end_stays else joints

    @property
    def single(self) -> bool:
        """True for an error of the child alone: a stretch or a spike."""
        return bool(self.kind.info.repairer)

    def measured_joints(self, chain: Chain) -> tuple[int, ...]:
        """Return the indices of the joints at which the size of the error is measured.

        The size is the angle between the joint's rotations in the clean clip and in the clip with
        the error.
        """
        if self.single:
            return (chain.child,)
        return (chain.parent, chain.end) if isinstance(chain, Limb) else (chain.parent,)


def clip_random_generator(seed: int, clip: str, *more: int) -> np.random.Generator:
    """Return a random generator that depends only on the seed, the clip's name and `more`."""
    return np.random.default_rng([seed, zlib.crc32(encode_utf8(Path(clip).stem)), *more])


def draw_targets(
    chains: Sequence[Chain], rng: np.random.Generator, protocol: Protocol = PROTOCOLS["P0"]
) -> tuple[Chain, ...]:
    """Draw two chains that share no joint [Choi26 §4.1.1].

    If `protocol.both` is True, two chains that share a joint are drawn instead. If
    `protocol.together` is greater than 1, that many chains are chosen in order, starting with a
    random one.
    """
    if protocol.clean or not chains:
        return ()
    if protocol.together > 1:
        return independent_chains(chains, int(rng.integers(len(chains))), protocol.together)
    pairs = [
        (a, b)
        for k, a in enumerate(chains)
        for b in chains[k + 1 :]
        if (a.child == b.parent if protocol.both else not _joints(a) & _joints(b))
    ]
    if not pairs:
        return tuple(chains[:1])
    return pairs[int(rng.integers(len(pairs)))]


def independent_chains(chains: Sequence[Chain], first: int, most: int) -> tuple[Chain, ...]:
    """Choose up to `most` chains of which no two change the same joint.

    The chains are tried in order, from index `first` to the end and then from the beginning.
    """
    chosen: list[Chain] = []
    for k in range(len(chains)):
        chain = chains[(first + k) % len(chains)]
        turned = {j for c in chosen for j in (c.parent, c.child)}
        if len(chosen) < most and not turned & {chain.parent, chain.child}:
            chosen.append(chain)
    return tuple(chosen)


def last_limb_chains(skeleton: Skeleton, chains: Sequence[Chain]) -> tuple[Chain, ...]:
    """Return the last chain of each limb, unless its child, a foot or hand, has no bone axis."""
    parents = {chain.parent for chain in chains}
    last = (chain for chain in chains if chain.child not in parents)
    return tuple(chain for chain in last if own_bone_axis(skeleton, chain.child) is not None)


def _joints(chain: Chain) -> set[int]:
    return {chain.parent, chain.child, chain.grandchild} - {-1}


def draw_errors(
    motion: Motion,
    chains: Sequence[Chain],
    rng: np.random.Generator,
    protocol: Protocol = PROTOCOLS["P0"],
    *,
    first: int = 1,
) -> tuple[InjectedError, ...]:
    """Draw 2 to 5 errors for each chain, at least 2 frames apart.

    Some protocols draw a different number, and fewer errors are drawn if a clip is too short.
    Except in the border protocols, every error begins and ends inside the capture.

    Parameters
    ----------
    motion
        The clean motion.
    chains
        The chains in which to inject errors. A protocol of limb flips needs limbs.
    rng
        The random generator.
    protocol
        The protocol.
    first
        The first frame that may be changed, such as 1 for a clip with a T-pose in frame 0.
    """
    errors: list[InjectedError] = []
    shared: list[Place] = []
    for chain in () if protocol.clean else chains:
        if protocol.straight:
            places = spans_with_straight_chain(motion, chain, first)
        elif shared:
            places = iter(shared)
        else:
            places = _places(motion, chain, first, rng, protocol)
        # Places and errors are drawn alternately. Do not change this order, because a seed must
        # always give the same errors.
        for start, stop in places:
            if protocol.together > 1 and chain is chains[0]:
                shared.append((start, stop))
            if error := _drawn(motion, chain, (start, stop), first, rng, protocol):
                errors.append(error)
    return tuple(sorted(errors, key=lambda e: (e.chain, e.start)))


def _places(
    motion: Motion, chain: Chain, first: int, rng: np.random.Generator, protocol: Protocol
) -> Iterator[Place]:
    """Yield the frames of a chain's errors, before a low-pass filter makes them longer."""
    margin = frames_added_by_offset_filter(protocol, motion.fps)
    taken = np.zeros(motion.frames, dtype=bool)
    if protocol.carried:  # no signal shows that a straight limb rolls
        taken |= ~bent_frames(motion, chain)
    for k in range(_number(rng, protocol)):
        place = _place(taken, first, rng, protocol, motion.fps, k)
        if place is not None:
            taken[max(0, place[0] - 2 * margin) : place[1] + 2 * margin] = True
            yield place


def _number(rng: np.random.Generator, protocol: Protocol) -> int:
    """Return how many errors to draw for a chain.

    Only one stretch is drawn, because several may cover most of a clip.
    """
    if protocol.single == Kind.STRETCH.value:
        return 1
    return 2 if protocol.persists else int(rng.integers(2, 6))


def _place(
    taken: NDArray[np.bool_],
    first: int,
    rng: np.random.Generator,
    protocol: Protocol,
    fps: float,
    k: int,
) -> Place | None:
    frames, margin = len(taken), frames_added_by_offset_filter(protocol, fps)
    low, high = protocol.length
    if protocol.drift:
        low, high = (max(int(seconds * fps), 3) for seconds in protocol.drift)
    for _ in range(_TRIES):
        length = int(rng.integers(low, high + 1))
        inside = frames - 1 - length - (first + 1) - 2 * margin
        if length > (frames - first) // 3 or inside < 1:
            continue
        start = first + 1 + margin + int(rng.integers(inside))
        if protocol.border and k < 2:
            start = first if k == 0 else frames - length
        if not taken[max(0, start - _APART) : start + length + _APART].any():
            return start, start + length
    return None


def _drawn(
    motion: Motion,
    chain: Chain,
    place: Place,
    first: int,
    rng: np.random.Generator,
    protocol: Protocol,
) -> InjectedError | None:
    """Draw one error, or return None if its offset is 0, for example in a gap without motion."""
    start, stop = place
    onset, end = start > first, stop < motion.frames
    if protocol.fill:
        offset = gap_filling_offset(motion, chain, place, protocol.fill)
    else:
        delta = np.radians(rng.uniform(*protocol.delta)) * rng.choice([-1.0, 1.0])
        offset = injected_offset_over_time(
            delta, stop - start, onset, end, rng, protocol, motion.fps
        )
        start -= (len(offset) - (stop - start)) // 2
    seen = np.flatnonzero(np.abs(offset) >= LEAST) if protocol.fill or protocol.low_pass else None
    if seen is not None:
        if not len(seen):
            return None
        offset = offset[seen[0] : seen[-1] + 1]
        start += int(seen[0])
    stop = start + len(offset)
    carried = protocol.limb and bool(rng.integers(2))
    leak = None
    if protocol.leak and not carried:
        leak = np.radians(protocol.leak) * rng.standard_normal(stop - start)
    if protocol.compensated < 1.0:
        leak = (1.0 - protocol.compensated) * offset + (0.0 if leak is None else leak)
    kind = Kind.LIMB_FLIP if protocol.limb else Kind.COUNTER_TWIST
    if protocol.carried or protocol.single:
        kind, carried = Kind(protocol.single) if protocol.single else Kind.CARRIED_ROLL, True
    return InjectedError(chain.name, start, stop, offset, leak, kind, carried)


@overload
def inject(clip: Motion | HasMotion, errors: Sequence[InjectedError], /) -> Motion: ...


@overload
def inject(
    clip: Motion | HasMotion, chains: Sequence[Chain], errors: Sequence[InjectedError]
) -> Motion: ...


def inject(
    clip: Motion | HasMotion,
    chains: Sequence[Chain] | Sequence[InjectedError],
    errors: Sequence[InjectedError] | None = None,
) -> Motion:
    """Add known errors to a motion, to measure detection and correction [Choi26 §4.1.3].

    Call it as ``inject(clip, errors)`` or as ``inject(clip, chains, errors)``. The rotation of the
    parent P becomes q_P ⊗ R_a(δ), where a is the bone axis, and the rotation of every child X of P
    becomes R_a(−δ + leak) ⊗ q_X. In a limb flip, a is the limb's line, and X is the limb's end,
    unless it rotates with the limb. In a carried roll, the child C also rotates by R_b(δ) about its
    own bone b. In a stretch, only C rotates, by R_b(δ). In a spike, only C rotates, about an axis
    perpendicular to its bone.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to which the errors are added. It is not changed.
    chains : sequence of Chain, optional
        The chains and limbs to which the errors belong. By default, they are found in the clip.
    errors : sequence of InjectedError
        The errors to add.

    Returns
    -------
    Motion
        The motion with the errors.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.
    TwistError
        If an error ends after the last frame, or if its chain is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> error = tc.InjectedError("LeftForeArm", 120, 140, np.radians(np.full(20, 90.0)))
    >>> tc.detect(tc.inject(clip, [error]), "LeftForeArm")[:]
    (<Interval LeftForeArm 120–140: +90.0°, confidence 0.99>,)
    """
    motion = motion_of(clip)
    if errors is None:
        errors = [e for e in chains if isinstance(e, InjectedError)]
        every, where = AS_FOUND.chains(motion), str(getattr(clip, "path", "motion"))
        chains = [chain_named(every, e.chain, where) for e in errors]
        errors = [replace(e, chain=c.name) for e, c in zip(errors, chains, strict=True)]
        chains = [c for c in every if c in chains]
    chains = [c for c in chains if isinstance(c, Chain)]
    if beyond := next((e for e in errors if e.stop > motion.frames), None):
        named = f"{beyond.chain} {beyond.start}–{beyond.stop}"
        raise TwistError(f"expected errors within {motion.frames} frames, found {named}")
    offsets: dict[str, Array] = {}
    along: dict[str, Array] = {}
    by_name = {chain.name: chain for chain in chains}
    leaking = []
    single = [error for error in errors if error.single]
    for error in (error for error in errors if not error.single):
        at = slice(error.start, error.stop)
        offsets.setdefault(error.chain, np.zeros(motion.frames))[at] -= error.offset
        is_limb = isinstance(by_name.get(error.chain), Limb)
        if is_limb or error.carried:
            carried = along.setdefault(error.chain, np.zeros(motion.frames))
            carried[at] -= error.offset if error.carried else 0.0
        if is_limb:
            carried[at] -= 0.0 if error.leak is None else error.leak
        elif error.leak is not None:
            leaking.append((error, error.leak))
    dirty = remove_twist(motion, chains, offsets, along)
    if not (leaking or single):
        return dirty
    rotations = dirty.rotations.copy()
    for error in single:
        joint, at = by_name[error.chain].child, slice(error.start, error.stop)
        turn = quaternion_from_axis_angle(_axis_of(error, motion.skeleton, joint), error.offset)
        rotations[at, joint] = normalise(multiply(rotations[at, joint], turn))
    for error, leak in leaking:
        chain, at = by_name[error.chain], slice(error.start, error.stop)
        axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
        turn = quaternion_from_axis_angle(axis, leak)
        rotations[at, chain.child] = normalise(multiply(turn, rotations[at, chain.child]))
    return dirty.with_rotations(rotations)


def _axis_of(error: InjectedError, skeleton: Skeleton, joint: int) -> Array:
    """Return the axis, (3,), about which an error of a single joint rotates this joint.

    Raises TwistError if the joint has no bone.
    """
    axis = own_bone_axis(skeleton, joint)
    if axis is None:
        raise TwistError(f"expected a joint with a bone, found {skeleton.names[joint]!r}")
    if error.kind == Kind.STRETCH:
        return axis
    return normalise(np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())]))
