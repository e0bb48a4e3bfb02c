"""How far a tracked motion is from the truth, and what can be said without one.

Positions are (frames, 24, 3) in millimetres at 25 Hz; joint 0 is the root [Le26 §4.3].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.quamo.topology import ANKLES, TOES
from twistcore.rotation import Array

SLIDE_MM = 20.0
CONTACT_MM = 30.0
METRICS = ("MPJPE", "P-MPJPE", "Accel", "G-MPJPE", "GRE", "G-Accel", "FS")


@dataclass(frozen=True)
class Errors:
    """Metrics against the truth: millimetres, Accel in mm a frame², FS in per cent."""

    mpjpe: float
    p_mpjpe: float
    accel: float
    g_mpjpe: float
    gre: float
    g_accel: float
    fs: float

    def values(self) -> tuple[float, ...]:
        """In the order of METRICS."""
        return (
            self.mpjpe, self.p_mpjpe, self.accel, self.g_mpjpe, self.gre, self.g_accel, self.fs
        )  # fmt: skip


def errors(found: Array, truth: Array, up: int = 1) -> Errors:
    """All metrics of positions (frames, 24, 3) in mm; feet are in contact where the truth's are."""
    here, there = root_aligned(found), root_aligned(truth)
    return Errors(
        mpjpe=_mean_distance(here[:, 1:], there[:, 1:]),
        p_mpjpe=_mean_distance(procrustes(found, truth), truth),
        accel=_mean_distance(second_difference(here)[:, 1:], second_difference(there)[:, 1:]),
        g_mpjpe=_mean_distance(found, truth),
        gre=_mean_distance(found[:, 0], truth[:, 0]),
        g_accel=_mean_distance(second_difference(found), second_difference(truth)),
        fs=foot_slide(found, in_contact(truth, up), up),
    )


def root_aligned(places: Array) -> Array:
    """Places with the root in the origin."""
    aligned: Array = places - places[:, :1]
    return aligned


def second_difference(places: Array) -> Array:
    """x(t−1) − 2x(t) + x(t+1), (frames − 2, …)."""
    difference: Array = places[:-2] - 2.0 * places[1:-1] + places[2:]
    return difference


def procrustes(found: Array, truth: Array) -> Array:
    """`found` turned, scaled and moved onto `truth` frame by frame; never reflected."""
    centre_f, centre_t = found.mean(axis=1, keepdims=True), truth.mean(axis=1, keepdims=True)
    x, y = found - centre_f, truth - centre_t
    u, s, vt = np.linalg.svd(np.einsum("fji,fjk->fik", x, y))
    sign = np.sign(np.linalg.det(u @ vt))
    s[:, -1] *= sign
    u[:, :, -1] *= sign[:, None]
    size = (x**2).sum(axis=(1, 2))
    scale = s.sum(axis=1) / np.where(size > 0.0, size, 1.0)
    placed: Array = scale[:, None, None] * (x @ (u @ vt)) + centre_t
    return placed


def in_contact(places: Array, up: int = 1) -> NDArray[np.bool_]:
    """Feet on the ground, (frames, 2): ankle and toe below a low height of their own + 3 cm.

    That height is the 2nd percentile over the clip, of each foot's ankle and toe apart.
    """
    out = np.ones((len(places), 2), dtype=np.bool_)
    for foot in range(2):
        for joint in (ANKLES[foot], TOES[foot]):
            height = places[:, joint, up]
            out[:, foot] &= height < np.percentile(height, 2.0) + CONTACT_MM
    return out


def foot_slide(places: Array, contact: NDArray[np.bool_], up: int = 1) -> float:
    """Per cent of frame pairs in which a foot on the ground moves ≥ 20 mm level, feet summed."""
    flat = [axis for axis in range(3) if axis != up]
    slides = 0
    for foot in range(2):
        middle = 0.5 * (places[:, ANKLES[foot]] + places[:, TOES[foot]])[:, flat]
        moved = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        slides += int(((moved >= SLIDE_MM) & contact[1:, foot] & contact[:-1, foot]).sum())
    return 100.0 * slides / max(len(places) - 1, 1)


@dataclass(frozen=True)
class Quality:
    """What can be told without a truth; none of it is an error.

    deviation: mean distance from the input, mm, root-aligned, or None for the input itself; jitter:
    mean size of the third difference, mm a frame³; foot_slide: per cent of frame pairs, contact
    taken from the motion itself.
    """

    deviation: float | None
    jitter: float
    foot_slide: float


def quality(places: Array, given: Array | None = None, up: int = 1) -> Quality:
    """Evidence of quality of positions (frames, 24, 3) in mm; given: the input to compare with."""
    third = np.diff(places, n=3, axis=0)
    return Quality(
        None if given is None else _mean_distance(root_aligned(places), root_aligned(given)),
        float(np.linalg.norm(third, axis=-1).mean()) if len(third) else 0.0,
        foot_slide(places, in_contact(places, up), up),
    )


def _mean_distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b, axis=-1).mean()) if len(a) else 0.0
