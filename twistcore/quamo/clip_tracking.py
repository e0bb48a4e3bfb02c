"""Track the joints chosen in a review with QuaMo, after the twist correction."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.files.document_values import shorten_foreign_message
from twistcore.formats.smpl.skeleton import find_network_joints, metres_per_unit
from twistcore.quamo.clip_smoothing import check_smoothing_fits_motion, smoothed_motion
from twistcore.quamo.network import Network, read_network
from twistcore.quamo.stability import check_stability
from twistcore.quamo.state_space import Gains
from twistcore.quamo.track_clip import (
    TrackedMotion,
    check_position_trackable,
    select_network_joints,
    select_writable_joints,
    track_with_hand_gains,
    track_with_network,
)
from twistcore.quamo.tracker import Step
from twistcore.quamo.tracking_settings import Tracking
from twistcore.quamo.weights import default_gain_network_path
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, vector_lengths
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

WARNING = (
    "Tracking blurs sudden offsets without removing them, so it may hide twist errors. "
    "Decide on the intervals first: tracking is applied after their correction."
)
# Measured by benchmarks/quamo_before_detection.py. The table is in docs/quamo.md.
DEMONSTRATION = (
    "In a test with 820 errors injected into 40 clips, the program found all errors before "
    "tracking. After tracking, it found only 6 % with the correct start and stop; it missed the "
    "others or found them with a wrong start or stop."
)


@dataclass(frozen=True, eq=False)
class Traces:
    """The internal values of the tracker at each of n steps.

    If there was a forward and a backward pass, gains and parts are the means of both passes.

    Attributes
    ----------
    frames
        Time of each step in frames of the clip, shape (n,).
    gains
        κP, κD, κA, means over the three axes, shape (n, joints, 3).
    parts
        Magnitudes of the proportional, derivative, bias and acceleration terms, rad/s², shape (n,
        joints, 4).
    names
        The joints' names.
    """

    frames: Array
    gains: Array
    parts: Array
    names: tuple[str, ...]


@cache
def network_weights_identifier() -> str:
    """Return the identifier of the built-in networks, which sessions store.

    The identifier consists of 16 digits of their SHA-256.
    """
    return hashlib.sha256(default_gain_network_path().read_bytes()).hexdigest()[:16]


@cache
def _network() -> Network:
    return read_network(default_gain_network_path())


def supports_learned_tracking(motion: Motion) -> bool:
    """Return True if the built-in networks can track a motion.

    This requires a supported skeleton, a known length unit, and position channels of the root.
    """
    try:
        topology = find_network_joints(motion.skeleton)
        metres_per_unit(motion.skeleton)
    except TwistError:
        return False
    return bool(motion.positioned and motion.positioned[0] == topology.joints[0])


def check_tracking_fits_motion(motion: Motion, tracking: Tracking) -> None:
    """Raise TwistError if a motion cannot be tracked with these settings."""
    joints = _joints(motion, tracking)
    if tracking.place:
        check_position_trackable(motion, learned=tracking.learned)
    if tracking.spline:
        check_smoothing_fits_motion(motion, tracking)
        return
    if not tracking.learned:
        check_stability(_gains(tracking, motion.frame_time), motion.frame_time)
        return
    select_network_joints(motion.skeleton, joints, strict=True)
    metres_per_unit(motion.skeleton)
    if tracking.weights != network_weights_identifier():
        named = shorten_foreign_message(tracking.weights) or "–"
        raise TwistError(
            f"expected the networks {named}, found {network_weights_identifier()}: the session's "
            "gains were "
            "learned with another version of the program"
        )


def tracked_motion(motion: Motion, tracking: Tracking, tell: Tell | None = None) -> Motion:
    """Return the motion after tracking. T-pose frames at the start are not tracked.

    `tell` is called with the completed share, 0…1. Raises TwistError as in
    :func:`check_tracking_fits_motion`.
    """
    return _tracked(motion, tracking, tell or ignore_progress, keep_steps=False).motion


def track_motion_with_internal_values(
    motion: Motion, tracking: Tracking, tell: Tell | None = None
) -> tuple[Motion, Traces]:
    """Return the tracked motion, and the internal values of the tracker at every step.

    Parameters and errors are as in :func:`tracked_motion`.
    """
    found = _tracked(motion, tracking, tell or ignore_progress, keep_steps=True)
    joints = _joints(motion, tracking)
    own = found.joints.tolist()
    columns = np.array([own.index(j) for j in joints.tolist()], dtype=np.intp)
    names = tuple(motion.skeleton.names[j] for j in joints)
    rows = [_rows(steps, columns) for steps in found.passes or ((),)]  # a spline has no steps
    gains, parts, seen = (np.sum(x, axis=0) for x in zip(*rows, strict=True))
    there = seen > 0  # the first frame of a pass is not a step
    share = seen[there, None, None]
    return found.motion, Traces(found.at[there], gains[there] / share, parts[there] / share, names)


def _tracked(motion: Motion, tracking: Tracking, tell: Tell, *, keep_steps: bool) -> TrackedMotion:
    check_tracking_fits_motion(motion, tracking)
    joints = _joints(motion, tracking)
    if tracking.spline:
        return smoothed_motion(motion, joints, tracking)
    gains = _gains(tracking, motion.frame_time)
    track = (
        partial(track_with_network, network=_network())
        if tracking.learned
        else (partial(track_with_hand_gains, gains=gains))
    )
    return track(
        motion,
        joints,
        causal=tracking.causal,
        place=tracking.place,
        first=count_leading_rest_frames(motion),
        keep_steps=keep_steps,
        tell=tell,
    )


def _joints(motion: Motion, tracking: Tracking) -> NDArray[np.int64]:
    if not tracking.joints:  # only the position is tracked
        return np.zeros(0, dtype=np.int64)
    return select_writable_joints(motion.skeleton, tracking.joints)


def _gains(tracking: Tracking, dt: float) -> Gains:
    """Return the gains that the settings specify. The gains for the position depend on `dt`.

    `dt` is the frame time in seconds. If no joint is tracked, the gains for joints have no effect.
    """
    usual = Gains.by_hand(dt, causal=tracking.causal)
    if not tracking.joints:
        return usual
    return replace(usual, kp=tracking.kp, kd=tracking.kd, ka=tracking.ka)


def _rows(steps: Sequence[Step], shown: NDArray[np.intp]) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return the gains and terms of one pass, as in Traces, and a mask of the rows with a step.

    The mask contains 0 and 1. The first row of a pass has no step, and its gains and terms are 0.
    `shown` are the indices of the joints.
    """
    gains = np.zeros((len(steps), len(shown), 3))
    parts = np.zeros((len(steps), len(shown), 4))
    seen = np.zeros(len(steps), dtype=np.int64)
    for row, step in enumerate(steps):
        if step.gains is None or step.parts is None:
            continue
        seen[row] = 1
        for column, gain in enumerate((step.gains.kp, step.gains.kd, step.gains.ka)):
            every = np.broadcast_to(gain, step.state.omega.shape)
            gains[row, :, column] = every[shown].mean(axis=-1)
        for column, vector in enumerate(vars(step.parts).values()):
            parts[row, :, column] = vector_lengths(vector[shown])
    return gains, parts, seen
