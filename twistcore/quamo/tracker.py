"""Follow a noisy reference frame by frame, without looking at later frames."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twistcore.detection.runs import runs
from twistcore.errors import TwistError
from twistcore.quamo.stability import check_stability
from twistcore.quamo.state_space import (
    EXACT,
    AccelerationTerms,
    Gains,
    aligned,
    angular_acceleration,
    increment,
    next_quaternion,
    next_translation,
    next_velocity,
)
from twistcore.skeleton.rotation import Array, normalise
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, nobody

LOST_AFTER = 5  # frames
LOST_COSINE = np.cos(np.radians(90.0) / 2.0)  # a smaller |q·q̂| means an error above 90°
_TELL_EVERY = 25  # frames
_NAMED, _JOINTS_NAMED = 10, 6  # maximum number of frame runs and of joints in a sentence


@dataclass(frozen=True, eq=False)
class State:
    """The tracker's state: rotations q, angular velocities ω, position r and velocity v.

    q has the shape (…, joints, 4), ω has the shape (…, joints, 3) in rad/s, and r and v have the
    shape (…, 3).
    """

    q: Array
    omega: Array
    r: Array
    v: Array


class Controller(ABC):
    """The source of each step's gains, tuned by hand or computed by a network."""

    def start(self, q_hat: Array, r_hat: Array) -> State:
        """Return the state at the first reference, by default at rest there."""
        return State(q_hat, np.zeros((*q_hat.shape[:-1], 3)), r_hat, np.zeros_like(r_hat))

    def both_ways(self, q_two: Array, r_two: Array) -> Controller:
        """Return a controller that runs forward and backward at once, by default this one.

        The references q_two (frames, 2, …, joints, 4) and r_two (frames, 2, …, 3) are in forward
        and in backward order.
        """
        del q_two, r_two
        return self

    @abstractmethod
    def gains(self, state: State, q_hat: Array, r_hat: Array, dt: float) -> Gains:
        """Return the gains of the step to this reference, which is in the state's hemisphere."""


class HandGains(Controller):
    """Hand-tuned gains for all frames. They must be stable at the clip's frame time.

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
        """Return a controller for a forward and backward pass, with the given or default gains."""
        del q_two, r_two
        return HandGains(self._given, causal=False)

    def gains(self, state: State, q_hat: Array, r_hat: Array, dt: float) -> Gains:
        """Return the constant gains. Raises UnstableGainsError if they diverge at frame time dt."""
        del state, q_hat, r_hat
        if dt != self._checked:
            gains = self._given or Gains.by_hand(dt, causal=self._causal)
            check_stability(gains, dt)
            self._used, self._checked = gains, dt
        return self._used


@dataclass(frozen=True, eq=False)
class Step:
    """The result of one frame.

    Attributes
    ----------
    state
        The state after the step.
    snapped
        True for joints that lost the reference and were reset to it, shape (…, joints).
    gains, parts
        Gains and acceleration terms of the step, None in the first frame, where tracking starts.
    """

    state: State
    snapped: NDArray[np.bool_]
    gains: Gains | None = None
    parts: AccelerationTerms | None = None


class Stepper:
    """The tracker's steps and their state, called once per frame with all joints.

    `integration` is 'exact' or 'first-order'.
    """

    def __init__(self, controller: Controller, *, integration: str = EXACT) -> None:
        self._controller, self._integration = controller, integration
        self._state: State | None = None
        self._before: Array | None = None
        self._delta: Array | None = None
        self._lost: NDArray[np.int64] | None = None

    def step(self, q_hat: ArrayLike, r_hat: ArrayLike, dt: float) -> Step:
        """Return the pose after the reference q̂ (…, joints, 4), r̂ (…, 3), dt seconds later.

        The first call starts at the reference and ignores dt. q̂ is normalised, and its sign does
        not matter. Raises TwistError if a number is not finite or a quaternion is zero.
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
        q_hat = aligned(q_hat, state.q)
        delta = increment(q_hat, self._before)
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
    """A tracked clip: rotations q, positions r, and a mask of the joints that lost their reference.

    q has the shape (frames, …, joints, 4), r has the shape (frames, …, 3), and `snapped` has the
    shape (frames, …, joints).

    Attributes
    ----------
    steps
        If requested, every step with its gains and acceleration terms.
    steps_back
        The steps of the backward pass, if there was one, in the order of the frames.
    apart
        True where the two passes differ by more than 90°, with the shape of snapped, or None for a
        single pass.
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
    """Track a whole clip, with the same result as one call of :class:`Stepper` per frame.

    `tell` is called repeatedly with the completed share. If it raises an exception, the tracking
    ends.
    """
    tell = tell or nobody
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


def snap_sentences(
    snapped: NDArray[np.bool_], names: Sequence[str], *, causal: bool = True
) -> tuple[str, ...]:
    """Return a sentence with the frames for each joint that was reset to its reference.

    `causal` is False if this happened in one of two passes, so that the result lies halfway between
    them.
    """
    lost, was = ("", "") if causal else (" in a pass", " there")
    return tuple(
        f"{name} was more than 90° away from the input{lost} and was reset to it{was} at {places}"
        for name, places in _where(snapped, names)
    )


def apart_sentence(apart: NDArray[np.bool_], names: Sequence[str]) -> str:
    """Return a sentence about joints that differ by over 90° between the passes, or ''."""
    found = [f"{name} at {places}" for name, places in _where(apart, names)]
    if not found:
        return ""
    if len(found) > _JOINTS_NAMED:
        found[_JOINTS_NAMED:] = [f"{len(found) - _JOINTS_NAMED} more joints"]
    return (
        f"the two passes are more than 90° apart ({'; '.join(found)}): the motion is faster than "
        "the tracker can follow, and the result there may be far from the input"
    )


def frames_listed(there: NDArray[np.bool_]) -> str:
    """List frames as text, such as 'frame 7' or 'frames 7, 12–15' (15 excluded), at most ten runs.

    `there` is the mask of the frames to list, shape (frames,); at least one value is True.
    """
    at = [f"{a}" if b == a + 1 else f"{a}–{b}" for a, b in runs(there)]
    some = ", ".join(at[:_NAMED]) + (" …" if len(at) > _NAMED else "")
    return f"frame{'' if there.sum() == 1 else 's'} {some}"


def _where(there: NDArray[np.bool_], names: Sequence[str]) -> list[tuple[str, str]]:
    """Return the joint names with their frames in words, from a mask (frames, joints)."""
    joints = np.flatnonzero(there.any(axis=0)).tolist()
    return [(names[joint], frames_listed(there[:, joint])) for joint in joints]


def _checked(q_hat: ArrayLike, r_hat: ArrayLike) -> tuple[Array, Array]:
    q = np.asarray(q_hat, dtype=np.float64)
    r = np.asarray(r_hat, dtype=np.float64)
    if not (np.isfinite(q).all() and np.isfinite(r).all()):
        raise TwistError("expected finite rotations and positions to track, found NaN or infinity")
    if not np.einsum("...i,...i->...", q, q).all():
        raise TwistError("expected unit quaternions to track, found one of length 0")
    return normalise(q), r


def _leading(q: Array) -> Array:
    """Return the first nonzero component, whose sign gives the hemisphere, (…, 4) → (…, 1)."""
    first = np.argmax(q != 0.0, axis=-1)[..., None]
    return np.take_along_axis(q, first, axis=-1)
