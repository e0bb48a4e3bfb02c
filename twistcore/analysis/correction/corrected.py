"""Compute the corrected clip: its offsets, poses, joint paths and angles."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.joint_repairs import JointRepairs, repaired_joints
from twistcore.analysis.correction.twist_removal import (
    joints_lacking_channels,
    offset_remover,
    offsets_by_chain,
    offsets_carried_to_child,
)
from twistcore.detection import Interval
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb, joint_path, limb_middle_and_end_positions
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import (
    Array,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    twist_angle,
    wrap,
)
from twistcore.skeleton.signals import twist_signals
from twistcore.work.frozen import dataclass

_ZERO = 1e-9
_SAME_AXIS = 1.0 - 1e-12


@dataclass(frozen=True, eq=False)
class Angles:
    """The angles of a chain in every frame, radians, as in :class:`TwistSignals`.

    Attributes
    ----------
    theta_p, theta_c
        The angles θp and θc, shape (frames,).
    dtheta_p, dtheta_c
        Their increments, shape (frames,).
    """

    theta_p: Array
    theta_c: Array
    dtheta_p: Array
    dtheta_c: Array


class Corrected:
    """A clip after the correction of the intervals that were passed to :meth:`take`.

    Results of unchanged chains are reused, because the corrected clip must be updated quickly while
    a user drags τ.
    """

    def __init__(self, analysis: ClipAnalysis) -> None:
        self._analysis = analysis
        self._motion, self._chains = analysis.motion, (*analysis.chains, *analysis.limbs)
        # Corrections that an export could not write are not shown.
        self._free = {c.name for c in self._chains if not uncorrectable_joints(self._motion, c)}
        self._free_carried = {
            c.name for c in self._chains if not uncorrectable_joints(self._motion, c, carried=True)
        }
        self._none = np.zeros(self._motion.frames)
        self._none.flags.writeable = False
        self._offsets: dict[str, Array] = {}
        self._carried: dict[str, Array] = {}
        self._repairs = JointRepairs(())
        self._alone: list[Interval] = []  # intervals of single joints
        # The intervals whose offsets were added up, keyed by chain name.
        self._summed: dict[str, list[Interval]] = {}
        self._forms: dict[str, _ClosedForm | None] = {}
        # The last frame that was requested, and its pose.
        self._last: tuple[int, tuple[Array, Array]] | None = None

    def take(self, intervals: Iterable[Interval]) -> bool:
        """Set the intervals to correct. Return True if they differ from the previous ones.

        Offsets of unchanged chains are reused.
        """
        chosen: dict[str, list[Interval]] = {}
        alone: list[Interval] = []
        by_name = {chain.name: chain for chain in self._chains}
        for interval in intervals:
            if interval.kind.info.repairer:
                lists = by_name.get(interval.chain)
                if lists is not None and not joints_lacking_channels(
                    self._motion, lists, [interval]
                ):
                    alone.append(interval)
            elif interval.chain in (self._free_carried if interval.carried else self._free):
                chosen.setdefault(interval.chain, []).append(interval)
        changed = chosen != self._summed or alone != self._alone
        if changed:
            self._last = None
        self._repairs, self._alone = JointRepairs(alone), alone
        for chain in [c for c in self._summed if self._summed[c] != chosen.get(c)]:
            del self._summed[chain], self._offsets[chain]
            self._carried.pop(chain, None)
        for chain, own in chosen.items():
            if chain not in self._summed:
                self._offsets |= offsets_by_chain(own, self._motion.frames)
                self._carried |= offsets_carried_to_child(own, self._motion.frames)
                self._summed[chain] = own
        return changed

    def offset(self, chain: str) -> Array:
        """Return the angle removed from the twist of a chain's parent, radians, (frames,)."""
        return self._offsets.get(chain, self._none)

    def carried(self, limb: str) -> Array:
        """Return the part of a limb's offset by which its end also rotated, radians, (frames,)."""
        return self._carried.get(limb, self._none)

    def repairs(self, frame: int) -> tuple[Interval, ...]:
        """Return the intervals with single-joint errors that are corrected in a frame."""
        return self._repairs.at(frame, frame + 1)

    def pose(self, frame: int) -> tuple[Array, Array]:
        """Return a frame's global rotations, (joints, 4), and positions, (joints, 3).

        The arrays are read-only. The last pose is cached, because several views need it.
        """
        if (last := self._last) is None or last[0] != frame:
            rotations, positions = (part[0].view() for part in self._poses(frame, frame + 1))
            rotations.flags.writeable = positions.flags.writeable = False
            self._last = last = frame, (rotations, positions)
        return last[1]

    def joint_paths(self, joints: NDArray[np.int64], start: int, stop: int) -> Array:
        """Return the paths of joints in frames [start, stop), shape (frames, joints, 3).

        The positions are recomputed from the corrected rotations, even where the correction should
        not change them.
        """
        return self._poses(start, stop)[1][:, joints]

    def _poses(self, start: int, stop: int) -> tuple[Array, Array]:
        offsets = {name: o[start:stop] for name, o in self._offsets.items()}
        if not (any(o.any() for o in offsets.values()) or self._repairs.at(start, stop)):
            rotations, positions = self._analysis.poses
            return rotations[start:stop], positions[start:stop]
        return forward_kinematics(self._part(start, stop))

    def _part(self, start: int, stop: int) -> Motion:
        """Return frames [start, stop) of the corrected motion."""
        made = offset_remover(
            self._motion, self._chains, self._offsets, self._carried, self._repairs
        )
        return made(start, stop)

    def angles(self, chain: Chain) -> Angles:
        """Return a chain's angles after the correction.

        They are computed in closed form if possible, or else from quaternions.
        """
        if chain.name not in self._forms:
            exact = not isinstance(chain, Helper) and _has_closed_form(
                self._analysis, chain, self._free
            )
            form = _ClosedForm(self._analysis, chain, self._free) if exact else None
            self._forms[chain.name] = form
        if (form := self._forms[chain.name]) and not self._is_turned_by_others(chain):
            return form.angles(self)
        s = twist_signals(self._part(0, self._motion.frames), chain)
        return Angles(s.theta_p, s.theta_c, s.dtheta_p, s.dtheta_c)

    def swivel(self, limb: Limb) -> Array:
        """Return a limb's swivel angle φ after the correction, radians, (frames,).

        The limb's offset is subtracted from φ. A correction of the chain above, whose child is the
        limb's first joint, rotates the coordinate system in which φ is measured. In frames with
        such a correction, φ is computed from the corrected pose.
        """
        swivel = self._analysis.flips.limbs[limb.name].swivel
        angle, children = swivel.angle, self._motion.skeleton.children
        for chain in self._analysis.chains:
            at = np.flatnonzero(self.offset(chain.name))
            if len(at) and limb.parent in children[chain.parent]:
                axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
                ahead = quaternion_from_axis_angle(axis, self.offset(chain.name)[at])
                child, end = (
                    rotate(ahead, p)
                    for p in limb_middle_and_end_positions(self._motion.at(at), limb)
                )
                angle = angle.copy()
                angle[at] = swivel.angle_at(child, end)
        angle = wrap(angle - self.offset(limb.name))
        path = limb.parent, *joint_path(self._motion.skeleton, limb.parent, limb.end)[:-1]
        for interval in self._repairs_among(path):
            start, stop = interval.start, interval.stop
            angle[start:stop] = swivel.angle_at(
                *limb_middle_and_end_positions(self._part(start, stop), limb)
            )
        return angle

    def _is_turned_by_others(self, chain: Chain) -> bool:
        """Return True if a correction of a limb or a single joint rotates a joint of the chain."""
        ends = {chain.parent, chain.child}
        flipped = any(
            isinstance(limb, Limb)
            and limb.name in self._offsets
            and not ends.isdisjoint((limb.parent, limb.end))
            for limb in self._chains
        )
        return flipped or bool(self._repairs_among(ends))

    def _repairs_among(self, joints: Iterable[int]) -> list[Interval]:
        """Return the single-joint errors whose correction rotates any of the given joints."""
        own, skeleton = set(joints), self._motion.skeleton
        every = self._repairs.intervals
        return [i for i in every if not own.isdisjoint(repaired_joints(skeleton, i))]


class _ClosedForm:
    """The angles of a chain after a correction, computed from the offsets alone.

    A correction rotates the parent about the bone axis by −offset and the child by +offset. So θp
    decreases and θc increases by the offset, and no quaternions are needed. Only a correction of
    the chain above requires them, because it multiplies the parent's rotation from the left. In the
    frames of such a correction, θp is computed from quaternions.
    """

    def __init__(self, analysis: ClipAnalysis, chain: Chain, free: set[str]) -> None:
        self._chain, self._motion = chain, analysis.motion
        self._signals = analysis.signals[chain.name]
        children = analysis.motion.skeleton.children
        self._above = [
            c
            for c in analysis.chains
            if c is not chain and c.name in free and chain.parent in children[c.parent]
        ]
        defined = self._signals.azimuth_reliability > _ZERO
        self._defined = defined & np.roll(defined, 1)

    def angles(self, corrected: Corrected) -> Angles:
        """Return the angles after the corrections of this chain and of the chains above."""
        own = corrected.offset(self._chain.name)
        theta_p = self._signals.theta_p
        for chain in self._above:
            turned = corrected.offset(chain.name)
            at = np.flatnonzero(turned)
            if len(at):
                theta_p = theta_p.copy()
                axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
                ahead = quaternion_from_axis_angle(axis, turned[at])
                parent = self._motion.rotations[at, self._chain.parent]
                theta_p[at] = twist_angle(multiply(ahead, parent), self._chain.axis)
        theta_p = wrap(theta_p - own)
        step = np.diff(own, prepend=own[:1])
        dtheta_c = np.where(self._defined, wrap(self._signals.dtheta_c + step), 0.0)
        dtheta_c[:1] = 0.0
        return Angles(
            theta_p=theta_p,
            theta_c=np.cumsum(dtheta_c),
            dtheta_p=wrap(np.diff(theta_p, prepend=theta_p[:1])),
            dtheta_c=dtheta_c,
        )


def _has_closed_form(analysis: ClipAnalysis, chain: Chain, free: set[str]) -> bool:
    """Return True if a chain's corrected angles follow from the offsets alone.

    This is not the case if the bone axis varies, or if a correction rotates the child about an axis
    other than the child's own bone.
    """
    others = [c for c in analysis.chains if c is not chain and c.name in free]
    below = [c for c in others if c.parent == chain.child]
    return (
        chain.axis.ndim == 1
        and not any(c.parent == chain.parent for c in others)
        and all(_parallel(c.axis, chain.arm) for c in below)
    )


def _parallel(axis: Array, arm: Array) -> bool:
    return axis.ndim == arm.ndim == 1 and bool(abs(axis @ arm) > _SAME_AXIS)
