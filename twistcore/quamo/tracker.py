"""Track a noisy reference frame by frame, without looking at later frames [Le26].

q̂ is the reference of the rotations of all joints, and r̂ is the reference of the root's position.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twistcore.errors import TwistError
from twistcore.quamo.stability import check_stability
from twistcore.quamo.state_space import (
    EXACT,
    AccelerationTerms,
    Gains,
    align_hemisphere,
    angular_acceleration,
    next_quaternion,
    next_translation,
    next_velocity,
    tracker_reference_rotation_step,
)
from twistcore.skeleton.rotation import Array, normalise
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

LOST_AFTER = 5  # number of frames after which a joint far from its reference is reset
LOST_COSINE = np.cos(np.radians(90.0) / 2.0)  # a smaller |q·q̂| means an error above 90°
_TELL_EVERY = 25  # number of frames between reports of the progress
_NAMED, _JOINTS_NAMED = 10, 6  # maximum number of frame ranges and of joints in a sentence


@dataclass(frozen=True, eq=False)
class State:
    """The state of the tracker after a step.

    Attributes
    ----------
    q
        The local rotations, shape (…, joints, 4).
    omega
        The angular velocities ω, rad/s, shape (…, joints, 3).
    r, v
        The position and the velocity of the root, shape (…, 3).
    """

    q: Array
    omega: Array
    r: Array
    v: Array


class Controller(ABC):
    """A source of gains for tracking steps, which are tuned by hand or computed by a network."""

    def start(self, q_hat: Array, r_hat: Array) -> State:
        """Return the initial state, by default the first reference with zero velocity."""
        return State(q_hat, np.zeros((*q_hat.shape[:-1], 3)), r_hat, np.zeros_like(r_hat))

    def both_ways(self, q_two: Array, r_two: Array) -> Controller:
        """Return a controller for a simultaneous forward and backward pass, by default this one.

        The references `q_two`, (frames, 2, …, joints, 4), and `r_two`, (frames, 2, …, 3), are in
        forward and in backward order.
        """
        del q_two, r_two
        return self

    @abstractmethod
    def gains(self, state: State, q_hat: Array, r_hat: Array, dt: float) -> Gains:
        """Return the gains of the step from a state to the next reference.

        The quaternions of the reference are in the hemisphere of the state, and `dt` is the frame
        time in seconds.
        """


class HandGains(Controller):
    """A controller with the same hand-tuned gains in all frames.

    Parameters
    ----------
    gains
        The gains, or None for :meth:`Gains.by_hand` at the clip's frame time.
    causal
        The argument `causal` of :meth:`Gains.by_hand`.
    """

    def __init__(self, gains: Gains | None = None, *, causal: bool = True) -> None:
        self._given, self._causal = gains, causal
        self._used = gains or Gains()
        self._checked = 0.0

    def both_ways(self, q_two: Array, r_two: Array) -> HandGains:
        """Return a controller with the same gains or, if no gains were given, the default gains.

        The default gains are those for tracking forward and backward.
        """
        del q_two, r_two
        return HandGains(self._given, causal=False)

    def gains(self, state: State, q_hat: Array, r_hat: Array, dt: float) -> Gains:
        """Return the constant gains. Raises UnstableGainsError if they diverge at `dt` seconds."""
        del state, q_hat, r_hat
        if dt != self._checked:
            gains = self._given or Gains.by_hand(dt, causal=self._causal)
            check_stability(gains, dt)
            self._used, self._checked = gains, dt
        return self._used


@dataclass(frozen=True, eq=False)
class Step:
    """The result of one step of the tracker.

    Attributes
    ----------
    state
        The state after the step.
    snapped
        True for joints that were far from the reference and were reset to it, shape (…, joints).
    gains, parts
        The gains and the acceleration terms of the step; None in the first frame.
    """

    state: State
    snapped: NDArray[np.bool_]
    gains: Gains | None = None
    parts: AccelerationTerms | None = None


class Stepper:
    """A tracker that is called once per frame with the reference of all joints.

    Parameters
    ----------
    controller
        The source of the gains.
    integration
        The method of integrating rotations, 'exact' or 'first-order'.
    """

    def __init__(self, controller: Controller, *, integration: str = EXACT) -> None:
        self._controller, self._integration = controller, integration
        self._state: State | None = None
        self._before: Array | None = None
        self._delta: Array | None = None
        self._lost: NDArray[np.int64] | None = None

    def step(self, q_hat: ArrayLike, r_hat: ArrayLike, dt: float) -> Step:
        """Track the next reference.

        Parameters
        ----------
        q_hat
            The reference q̂ of the local rotations, shape (…, joints, 4). The length and the sign of
            a quaternion do not matter.
        r_hat
            The reference r̂ of the root's position, shape (…, 3).
        dt
            The time since the previous reference in seconds; ignored in the first call.

        Raises
        ------
        TwistError
            If a number is not finite or a quaternion is zero.
        UnstableGainsError
            If the gains diverge at this frame time.
        """
        q_hat, r_hat = _checked(q_hat, r_hat)
        if self._state is None:
            # Choose one of the two signs, so that −q̂ gives the same bits.
            q_hat = np.where(_leading(q_hat) < 0.0, -q_hat, q_hat)
            self._state = self._controller.start(q_hat, r_hat)
            self._before = q_hat
            self._lost = np.zeros(q_hat.shape[:-1], dtype=np.int64)
            return Step(self._state, np.zeros(q_hat.shape[:-1], dtype=np.bool_))
        assert self._before is not None
        assert self._lost is not None
        state = self._state
        q_hat = align_hemisphere(q_hat, state.q)
        delta = tracker_reference_rotation_step(q_hat, self._before)
        curvature = 0.0 if self._delta is None else delta - self._delta
        gains = self._controller.gains(state, q_hat, r_hat, dt)
        parts = angular_acceleration(state.q, state.omega, q_hat, curvature, gains, dt)
        omega = next_velocity(state.omega, parts, dt, gains.clip)
        q = next_quaternion(state.q, omega, dt, self._integration)
        r, v = next_translation(state.r, state.v, r_hat, gains, dt)
        away = np.abs(np.einsum("...i,...i->...", q_hat, q)) < LOST_COSINE
        self._lost = np.where(away, self._lost + 1, 0)
        snapped = self._lost >= LOST_AFTER
        if snapped.any():
            q = np.where(snapped[..., None], q_hat, q)
            omega = np.where(snapped[..., None], 0.0, omega)
            self._lost = np.where(snapped, 0, self._lost)
        self._state, self._before, self._delta = State(q, omega, r, v), q_hat, delta
        return Step(self._state, snapped, gains, parts)


@dataclass(frozen=True, eq=False)
class TrackResult:
    """The result of tracking a clip.

    Attributes
    ----------
    q
        The tracked local rotations, shape (frames, …, joints, 4).
    r
        The tracked positions of the root, shape (frames, …, 3).
    snapped
        Mask of the joints that were reset to the reference, shape (frames, …, joints).
    steps
        All steps, if requested.
    steps_back
        The steps of the backward pass in the order of the frames, if requested.
    apart
        Mask of the joints whose rotations in the two passes differ by more than 90°, shape (frames,
        …, joints); None for a single pass.
    """

    q: Array
    r: Array
    snapped: NDArray[np.bool_]
    steps: tuple[Step, ...] = ()
    steps_back: tuple[Step, ...] = ()
    apart: NDArray[np.bool_] | None = None


def track(
    q_hat: Array,
    r_hat: Array,
    dt: float,
    controller: Controller,
    *,
    integration: str = EXACT,
    keep_steps: bool = False,
    tell: Tell | None = None,
) -> TrackResult:
    """Track a whole clip causally, which gives the same result as a :class:`Stepper`.

    Parameters
    ----------
    q_hat
        The references of the local rotations, shape (frames, …, joints, 4).
    r_hat
        The references of the root's position, shape (frames, …, 3).
    dt
        The frame time in seconds.
    controller
        The source of the gains.
    integration
        The method of integrating rotations, 'exact' or 'first-order'.
    keep_steps
        If True, the result contains all steps.
    tell
        Function that is called with the progress, from 0 to 1. If it raises an exception, the
        tracking ends.
    """
    tell = tell or ignore_progress
    stepper = Stepper(controller, integration=integration)
    q, r = np.empty(q_hat.shape), np.empty(r_hat.shape)
    snapped = np.zeros(q_hat.shape[:-1], dtype=np.bool_)
    steps: list[Step] = []
    for frame in range(len(q_hat)):
        step = stepper.step(q_hat[frame], r_hat[frame], dt)
        q[frame], r[frame], snapped[frame] = step.state.q, step.state.r, step.snapped
        if keep_steps:
            steps.append(step)
        if frame % _TELL_EVERY == 0:
            tell(frame / len(q_hat))
    return TrackResult(q, r, snapped, tuple(steps))


def describe_joint_resets(
    snapped: NDArray[np.bool_], names: Sequence[str], *, causal: bool = True
) -> tuple[str, ...]:
    """Return a sentence for each joint that was reset to its reference.

    `snapped` is the mask of these joints, (frames, joints), and `names` contains the names of the
    joints. `causal` is False if the joints were reset in one of two passes.
    """
    lost, was = ("", "") if causal else (" in a pass", " there")
    return tuple(
        f"{name} was more than 90° away from the input{lost} and was reset to it{was} at {places}"
        for name, places in _where(snapped, names)
    )


def describe_diverging_tracker_passes(apart: NDArray[np.bool_], names: Sequence[str]) -> str:
    """Return a sentence about joints whose rotations in the two passes differ by over 90°, or ''.

    `apart` is the mask of these joints, (frames, joints), and `names` contains the names of the
    joints.
    """
    found = [f"{name} at {places}" for name, places in _where(apart, names)]
    if not found:
        return ""
    if len(found) > _JOINTS_NAMED:
        found[_JOINTS_NAMED:] = [f"{len(found) - _JOINTS_NAMED} more joints"]
    return (
        f"the two passes are more than 90° apart ({'; '.join(found)}): the motion is faster than "
        "the tracker can follow, and the result there may be far from the input"
    )


def describe_frames(there: NDArray[np.bool_]) -> str:
    """Describe a set of frames in words, such as 'frame 7' or 'frames 7, 12–15' (15 is excluded).

    `there` is the mask of the frames, shape (frames,), with at least one True. At most ten ranges
    are listed.
    """
    at = [f"{a}" if b == a + 1 else f"{a}–{b}" for a, b in runs_of_true(there)]
    some = ", ".join(at[:_NAMED]) + (" …" if len(at) > _NAMED else "")
    return f"frame{'' if there.sum() == 1 else 's'} {some}"


def _where(there: NDArray[np.bool_], names: Sequence[str]) -> list[tuple[str, str]]:
    """Return the name of each joint that is True in any frame, and the description of these frames.

    `there` is a mask, (frames, joints). The frames are described by :func:`describe_frames`.
    """
    joints = np.flatnonzero(there.any(axis=0)).tolist()
    return [(names[joint], describe_frames(there[:, joint])) for joint in joints]


def _checked(q_hat: ArrayLike, r_hat: ArrayLike) -> tuple[Array, Array]:
    q = np.asarray(q_hat, dtype=np.float64)
    r = np.asarray(r_hat, dtype=np.float64)
    if not (np.isfinite(q).all() and np.isfinite(r).all()):
        raise TwistError("expected finite rotations and positions to track, found NaN or infinity")
    if not np.einsum("...i,...i->...", q, q).all():
        raise TwistError("expected unit quaternions to track, found one of length 0")
    return normalise(q), r


def _leading(q: Array) -> Array:
    """Return the first nonzero component of quaternions, (…, 4) → (…, 1)."""
    first = np.argmax(q != 0.0, axis=-1)[..., None]
    return np.take_along_axis(q, first, axis=-1)
