"""A joint that rotates through ±180°, and five tracking filters that follow it.

The filters differ in their representation of the rotation, such as quaternions or Euler angles.
"""

from __future__ import annotations

import numpy as np

from twistcore.quamo import Gains, HandGains, track
from twistcore.quamo.state_space import EXACT, FIRST_ORDER
from twistcore.skeleton.rotation import Array, geodesic_angle, quaternion_from_axis_angle
from twistcore.study.quamo.representations import (
    REPRESENTATIONS,
    Representation,
    rotation_coordinates,
    track_coordinates,
)

AXIS = np.array([0.36, 0.48, 0.8])
DT = 0.04  # seconds between frames: 25 Hz
FRAMES = 101
_TRACKED = ("axis-angle, raw", "Euler XYZ, raw", "Euler XYZ, wrapped")


def fixed_axis_rotations(speed: float) -> Array:
    """Return the rotations of a joint about a fixed axis as quaternions, (FRAMES, 4).

    `speed` is in turns per second. The rotation starts slowly.
    """
    time = np.arange(FRAMES) * DT
    eased = np.where(time < 1.0, 0.5 * time**2, time - 0.5)
    return quaternion_from_axis_angle(AXIS, 2.0 * np.pi * speed * eased)


def tracker_errors(q_hat: Array) -> dict[str, Array]:
    """Return the error of each tracking filter in degrees, (frames,), keyed by the filter's name.

    The error is the angle between the output of the filter and the input `q_hat`, quaternions
    (frames, 4). All filters use the same gains.
    """
    gains = Gains()
    by_name = {r.name: r for r in REPRESENTATIONS}
    tracked = {
        "Quaternion": _quaternion(q_hat, gains, EXACT),
        **{name: track_coordinates(q_hat, DT, by_name[name], gains) for name in _TRACKED},
        "Quaternion, first-order": _quaternion(q_hat, gains, FIRST_ORDER),
    }
    return {name: np.degrees(geodesic_angle(q, q_hat)) for name, q in tracked.items()}


def euler_angles(q_hat: Array) -> Array:
    """Return the input quaternions as Euler angles XYZ in degrees, (frames, 3), not unwrapped."""
    return np.degrees(rotation_coordinates(q_hat, Representation("", "XYZ")))


def _quaternion(q_hat: Array, gains: Gains, integration: str) -> Array:
    rest = np.zeros((len(q_hat), 3))
    one = track(q_hat[:, None], rest, DT, HandGains(gains), integration=integration)
    return one.q[:, 0]
