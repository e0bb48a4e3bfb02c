"""Functions that find spikes, joint jumps, place jumps and body steps, as intervals of chains.

A joint outside all chains is listed under the nearest chain: fingers under the forearm, toes under
the shin, and the spine under the nearest chain below it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twistcore.detection import lone_jumps
from twistcore.detection.all_joints.body_steps import body_steps, position_jumps
from twistcore.detection.all_joints.joint_steps import (
    JointStep,
    StepLimits,
    joint_step_degrees,
    jumps,
    spikes,
    step_search_margin_frames,
)
from twistcore.detection.cuts import find_cuts
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind, create_interval_without_offset
from twistcore.detection.noise_bursts import noise_bursts
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.joint_owners import (
    chain_of_joint,
    farthest_descendant_distance,
    joints_below_hands_and_feet,
    nearest_chain_by_joint,
)
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.notation import DistinctFrames, without_repeated_frames
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array

Mask = NDArray[np.bool_]

_NUMBERS = 1 << 17  # frames times joints in a block
_BESIDE = 3  # maximum distance in frames from a step to the edge of an error that explains it
_LEFT = 0.5  # an error explains a step if its correction leaves less than this share of the step
_MORE = 4.0  # a joint's step is listed if it is larger than the body step by this factor


def find_spikes(search: KindSearch) -> Found:
    """Return the spikes of all joints, keyed by the name of the chain that lists each joint."""
    return _by_chain(search, Kind.SPIKE, search.once(_joint_steps).spikes)


def find_joint_jumps(search: KindSearch) -> Found:
    """Return the jumps of all joints, except lone jumps, keyed by chain name."""
    return _by_chain(search, Kind.JOINT_JUMP, search.once(_joint_steps).jumps)


def find_place_jumps(search: KindSearch) -> Found:
    """Return the jumps in position of roots and other joints, keyed by chain name."""
    motion = search.motion
    if (held := without_repeated_frames(motion)) is not None:
        motion = held.motion
    owner, names = _owners(search), motion.skeleton.names
    found: dict[str, list[Interval]] = {}
    for step in position_jumps(motion, ~find_cuts(motion)):
        if (chain := owner.get(step.joint)) is None:
            continue
        start, stop = _frames_in_clip(step.start, step.stop, held)
        evidence = {"joint": names[step.joint], "way_percent": 100.0 * step.way}
        one = create_interval_without_offset(
            Kind.PLACE_JUMP, chain.name, start, stop, 0.0, evidence
        )
        found.setdefault(chain.name, []).append(one)
    return found


def find_body_steps(search: KindSearch) -> Found:
    """Return the body steps of each person, keyed by the name of the person's first chain."""
    skeleton = search.motion.skeleton
    first = {chain.person: chain for chain in reversed(search.chosen)}
    found: dict[str, list[Interval]] = {}
    for step in body_steps(search.motion):
        if (chain := first.get(step.person)) is None:
            continue
        evidence = {
            "joint": skeleton.names[_top(skeleton, chain.parent)],
            "angle_deg": step.degrees,
            "joints_percent": 100.0 * step.share,
        }
        angle = math.radians(step.degrees)
        one = create_interval_without_offset(
            Kind.BODY_STEP, chain.name, step.start, step.stop, angle, evidence
        )
        found.setdefault(chain.name, []).append(one)
    return found


@dataclass(frozen=True)
class _JointSteps:
    """The spikes and jumps of joints, with the frame numbers of the clip."""

    spikes: tuple[JointStep, ...]
    jumps: tuple[JointStep, ...]


def _joint_steps(search: KindSearch) -> _JointSteps:
    """Return the spikes and jumps of all joints that are not explained by a different error."""
    motion, held = search.motion, without_repeated_frames(search.motion)
    if motion.frames < 4 * _BESIDE or not search.chains:
        return _JointSteps((), ())
    shown = motion if held is None else held.motion
    spiking, jumping = _in_blocks(shown, limits_of(shown, search.chains))
    if not (spiking or jumping):
        return _JointSteps((), ())
    own, others = _owners(search), _Others.of(search)
    at = {(s.joint, t) for s in spiking for t in range(s.start, s.stop + 1)}
    alone = (j for j in jumping if (j.joint, j.start) not in at)
    listed = (
        (
            written
            for step in steps
            if step.joint in own
            and not others.explain(written := _step_in_clip(step, held, jump=jump), jump=jump)
        )
        for steps, jump in ((spiking, False), (alone, True))
    )
    return _JointSteps(*map(tuple, listed))


def limits_of(motion: Motion, chains: Sequence[Chain]) -> StepLimits:
    """Return the minimum spike and the minimum jump to report for each joint of a motion.

    A joint without three rotation channels has limits that are never reached.
    """
    small = joints_below_hands_and_feet(motion.skeleton, chains)
    step = math.degrees(motion.angle_step)
    limits = StepLimits.of(len(motion.skeleton), motion.fps, small, step)
    if (rotatable := motion.skeleton.rotatable) is not None:
        limits.spike[~rotatable] = limits.jump[~rotatable] = 360.0
    return limits


def _in_blocks(motion: Motion, limits: StepLimits) -> tuple[list[JointStep], list[JointStep]]:
    """Return the spikes and the jumps of a motion, examined in blocks to save memory."""
    cut, parents = find_cuts(motion), motion.skeleton.parents
    calm = ~cut
    for k in range(1, limits.longest + 1):  # no cut within a spike
        calm[:-k] &= ~cut[k:]
    around, step = (
        step_search_margin_frames(limits),
        max(256, _NUMBERS // max(len(motion.skeleton), 1)),
    )
    found: tuple[list[JointStep], list[JointStep]] = [], []
    for low in range(0, motion.frames, step):
        high = min(low + step, motion.frames)
        first, stop = max(low - around, 0), min(high + around, motion.frames)
        rotations = motion.rotations[first:stop]
        counted = calm[first:stop].copy()
        counted[: low - first] = counted[high - first :] = False
        for own, search in zip(found, (spikes, jumps), strict=True):
            for one in search(rotations, parents, counted, limits):
                own.append(replace(one, start=first + one.start, stop=first + one.stop))
    return found


@dataclass(frozen=True)
class _Others:
    """The other errors of a clip, which may explain the step (spike or jump) of a joint.

    Attributes
    ----------
    search
        The clip.
    errors
        The correctable errors that rotate a joint, keyed by joint.
    edges
        For each joint, the indices of the errors that begin in a frame or end directly before it,
        keyed by frame.
    of_joints
        Masks of the frames with lone jumps or noise, shape (frames,), keyed by joint.
    of_body
        The size of the body steps of the joint's person, degrees, shape (frames,), keyed by joint.
    """

    search: KindSearch
    errors: dict[int, list[Interval]]
    edges: dict[int, dict[int, list[int]]]
    of_joints: dict[int, Mask]
    of_body: dict[int, Array]

    @staticmethod
    def of(search: KindSearch) -> _Others:
        """Collect the other errors in the clip that is searched."""
        motion = search.motion
        frames, index = motion.frames, {name: j for j, name in enumerate(motion.skeleton.names)}
        errors: dict[int, list[Interval]] = {}
        named = {chain.name: chain for chain in search.named}
        for error in search.errors():
            chain = named[error.chain]
            for joint in chain.changed_joints(motion.skeleton, carried=error.carried):
                errors.setdefault(joint, []).append(error)
        spans = [(b.joint, b.start, b.stop) for b in noise_bursts(motion)]
        for own in lone_jumps.find_lone_jumps(search).values():
            spans += [(index[jump.joint], jump.start, jump.stop + 1) for jump in own]
        of_joints: dict[int, Mask] = {}
        for joint, start, stop in spans:
            of_joints.setdefault(joint, np.zeros(frames, dtype=bool))[start:stop] = True
        of_body: dict[int, Array] = {}
        for person in find_people(motion.skeleton):
            steps = [step for step in body_steps(motion) if step.person == person.name]
            size = np.zeros(frames if steps else 0)
            for step in steps:
                size[max(step.start - 1, 0) : step.stop + 1] = step.degrees
            of_body |= dict.fromkeys(person.joints, size) if steps else {}
        edges: dict[int, dict[int, list[int]]] = {joint: {} for joint in errors}
        for joint, listed in errors.items():
            for k, error in enumerate(listed):
                for edge in (error.start, error.stop):
                    edges[joint].setdefault(edge, []).append(k)
        return _Others(search, errors, edges, of_joints, of_body)

    def explain(self, step: JointStep, *, jump: bool) -> bool:
        """Return True if a different error explains the step (spike or jump) of a joint.

        An error explains a step if it affects the same joint in the same frames, or if its
        correction removes the step. `jump` is True for a jump and False for a spike.
        """
        at, own = slice(step.start, step.stop + 1), self.of_joints.get(step.joint)
        body = self.of_body.get(step.joint)
        if body is not None and step.degrees < _MORE * body[at].max():
            return True
        if own is not None and own[at].any():
            return True
        near = self._near(step.joint, step)
        groups = [[error] for error in near]
        # Errors of neighbouring chains may begin and end in the same frame.
        joints = {joint for error in near for joint in self._turned(error)}
        together = {id(e): e for joint in joints for e in self._near(joint, step)}
        if len(together) > 1:
            groups.append(list(together.values()))
        return any(self._correction_removes(group, step, jump=jump) for group in groups)

    def _near(self, joint: int, step: JointStep) -> list[Interval]:
        """Return the errors that rotate a joint and begin or end near a step."""
        errors, edges = self.errors.get(joint, []), self.edges.get(joint, {})
        frames = range(step.start - _BESIDE, step.stop + _BESIDE + 1)
        return [errors[k] for k in sorted({k for t in frames for k in edges.get(t, ())})]

    def _turned(self, error: Interval) -> tuple[int, ...]:
        """Return the joints that an error rotates.

        Of the parent joint's children, only the child that belongs to the chain is included.
        """
        chain = next(c for c in self.search.named if c.name == error.chain)
        joints = chain.changed_joints(self.search.motion.skeleton, carried=error.carried)
        # The other children may not have rotated back.
        return (chain.parent, chain.child) if chain.child in joints else joints

    def _correction_removes(
        self, errors: Sequence[Interval], step: JointStep, *, jump: bool
    ) -> bool:
        """Return True if correcting errors removes most of a step from all joints that they rotate.

        `jump` is True for a jump and False for a spike.
        """
        if self.search.without is None:
            return False
        motion = self.search.motion
        turned = {joint for error in errors for joint in self._turned(error)}
        first, stop = step.start - 1, step.stop + 1
        as_is, corrected = (
            sum(
                joint_step_degrees(
                    rotations, replace(step, joint=joint, start=1, stop=stop - first - 1), jump=jump
                )
                for joint in turned
            )
            for rotations in (
                motion.rotations[first:stop],
                self.search.without(errors)(first, stop).rotations,
            )
        )
        return corrected < _LEFT * as_is


def _by_chain(search: KindSearch, kind: Kind, steps: Sequence[JointStep]) -> Found:
    skeleton = search.motion.skeleton
    owner = _owners(search) if steps else {}
    found: dict[str, list[Interval]] = {}
    for step in steps:
        chain = owner[step.joint]
        evidence = {
            "joint": skeleton.names[step.joint],
            "angle_deg": step.degrees,
            "times_usual": step.degrees / step.usual,
            "reach": farthest_descendant_distance(skeleton, step.joint),
        }
        angle = math.radians(step.degrees)
        one = create_interval_without_offset(
            kind, chain.name, step.start, step.stop, angle, evidence
        )
        one = replace(one, carried=True)  # everything below the joint moves with it
        found.setdefault(chain.name, []).append(one)
    return found


def _step_in_clip(step: JointStep, held: DistinctFrames | None, *, jump: bool) -> JointStep:
    """Convert a step from frame numbers without held frames to frame numbers in the clip.

    If `jump` is True, held frames after the jump are excluded, as for a lone jump.
    """
    start, stop = _frames_in_clip(step.start, step.stop, held)
    if jump and held is not None:
        stop = held.end(step.stop - 1) + 1
    return replace(step, start=start, stop=stop)


def _frames_in_clip(start: int, stop: int, held: DistinctFrames | None) -> tuple[int, int]:
    """Convert frames [start, stop) from numbers without held frames to numbers in the clip."""
    return (start, stop) if held is None else (held.begin(start), held.end(stop))


def _owners(search: KindSearch) -> dict[int, Chain]:
    if search.whole:
        return nearest_chain_by_joint(search.motion.skeleton, search.chains)
    return chain_of_joint(search.chains)


def _top(skeleton: Skeleton, joint: int) -> int:
    while (above := int(skeleton.parents[joint])) >= 0:
        joint = above
    return joint
