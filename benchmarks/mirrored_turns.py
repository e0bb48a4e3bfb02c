"""Find limbs whose upper and lower parts rotate against each other, in world coordinates.

The joints of a limb are called P, C and E: shoulder, elbow and wrist, or hip, knee and ankle. The
benchmark :mod:`benchmarks.real_flips` uses this module, which does not use the detectors' signals.

- A mirrored transition is a window of 0.13 s in which P and C rotate about P's bone by at least 10°
  each, in opposite directions, and the angles differ by at most 35 % of the larger one. Overlapping
  windows count once.
- A limb is bent if the angle between the bones of C and P is more than 30°, and straight if it is
  less than 18°.
- A frame is changed if the correction rotated P about its bone by more than 2°.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

WINDOW = 0.13  # seconds
LEAST, OPEN = 10.0, 0.35  # minimum angle in degrees; share of the larger angle
BENT, STRAIGHT = 30.0, 18.0  # degrees
CHANGED = 2.0  # degrees


@dataclass(frozen=True)
class Straightness:
    """Numbers of frames with a bent and with a straight limb, and how many of them changed.

    Attributes
    ----------
    bent, straight
        Numbers of frames with a bent and with a straight limb.
    bent_changed, straight_changed
        How many of these frames the correction changed.
    """

    bent: int = 0
    bent_changed: int = 0
    straight: int = 0
    straight_changed: int = 0

    def __add__(self, other: Straightness) -> Straightness:
        return Straightness(
            *(a + b for a, b in zip(vars(self).values(), vars(other).values(), strict=True))
        )


def twist(turned: Array, bone: Array) -> Array:
    """Return the angle of rotations about unit directions, in degrees, shape (frames,).

    `turned` are rotation matrices, (frames, 3, 3), and `bone` are the directions, (frames, 3).
    """
    q = Rotation.from_matrix(turned).as_quat()
    along = (q[:, :3] * bone).sum(axis=1)
    return (np.degrees(2.0 * np.arctan2(along, q[:, 3])) + 180.0) % 360.0 - 180.0


def mirrored(above: Array, p: Array, c: Array, bone: Array, fps: float) -> list[tuple[int, float]]:
    """Return the first frame of each mirrored transition, and the angle in degrees of P in it.

    Parameters
    ----------
    above, p, c : array, shape (frames, 3, 3)
        The global orientations of P's parent, P and C.
    bone : array, shape (frames, 3)
        The unit direction of P's bone in P's coordinates.
    fps
        Frames per second.
    """
    own, below = (np.einsum("fji,fjk->fik", a, b) for a, b in ((above, p), (p, c)))
    x = twist(np.einsum("fji,fjk->fik", own[:-1], own[1:]), bone[1:])
    y = twist(np.einsum("fij,fkj->fik", below[1:], below[:-1]), bone[1:])
    window = max(1, round(WINDOW * fps))
    if len(x) < window:
        return []
    turns, answers = (np.convolve(v, np.ones(window), "valid") for v in (x, y))
    sizes = np.abs(turns), np.abs(answers)
    hit = (np.minimum(*sizes) >= LEAST) & (turns * answers < 0.0)
    hit &= np.abs(turns + answers) <= OPEN * np.maximum(*sizes)
    found: list[tuple[int, float]] = []
    last = -window
    for t in np.flatnonzero(hit).tolist():
        if t - last >= window:
            found.append((t + 1, round(float(turns[t]), 1)))
        last = t
    return found


def bends(p: Array, c: Array, e: Array) -> Array:
    """Return the angle between the bones P-C and C-E in degrees, shape (frames,).

    `p`, `c` and `e` are positions, (frames, 3).
    """
    upper, lower = c - p, e - c
    away = np.linalg.norm(np.cross(upper, lower), axis=1)
    return np.degrees(np.arctan2(away, (upper * lower).sum(axis=1)))


def straightness(bend: Array, before: Array, after: Array, bone: Array) -> Straightness:
    """Count the frames with a bent and with a straight limb, and how many of them changed.

    Parameters
    ----------
    bend : array, shape (frames,)
        The angle between the bones in degrees.
    before, after : array, shape (frames, 3, 3)
        The global orientations of P before and after the correction.
    bone : array, shape (frames, 3)
        The unit direction of P's bone in P's coordinates.
    """
    changed = np.abs(twist(np.einsum("fji,fjk->fik", before, after), bone)) > CHANGED
    bent, straight = bend > BENT, bend < STRAIGHT
    counts = (m.sum() for m in (bent, bent & changed, straight, straight & changed))
    return Straightness(*(int(n) for n in counts))
