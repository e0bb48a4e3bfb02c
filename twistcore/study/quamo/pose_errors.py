"""Measure the errors of a tracked motion against the true motion [Le26 §4.3].

Positions have the shape (frames, 24, 3) and are in millimetres at 25 Hz. Joint 0 is the root.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.analysis.quality.figure import (
    foot_contact_mask,
    foot_slide,
    mean_distance_between_positions,
    positions_relative_to_root,
)
from twistcore.skeleton.rotation import Array

METRICS = ("MPJPE", "P-MPJPE", "Accel", "G-MPJPE", "GRE", "G-Accel", "FS")


@dataclass(frozen=True)
class Errors:
    """The error metrics in mm, except Accel and G-Accel (mm per frame²) and FS (per cent)."""

    mpjpe: float
    p_mpjpe: float
    accel: float
    g_mpjpe: float
    gre: float
    g_accel: float
    fs: float

    def values(self) -> tuple[float, ...]:
        """Return the metrics in the order of METRICS."""
        return tuple(vars(self).values())


def pose_metrics(found: Array, truth: Array) -> Errors:
    """Return all error metrics of positions, shape (frames, 24, 3), in mm.

    Foot contacts are determined from `truth`.
    """
    here, there = positions_relative_to_root(found), positions_relative_to_root(truth)
    return Errors(
        mpjpe=mean_distance_between_positions(here[:, 1:], there[:, 1:]),
        p_mpjpe=mean_distance_between_positions(procrustes(found, truth), truth),
        accel=mean_distance_between_positions(
            second_difference(here)[:, 1:], second_difference(there)[:, 1:]
        ),
        g_mpjpe=mean_distance_between_positions(found, truth),
        gre=mean_distance_between_positions(found[:, 0], truth[:, 0]),
        g_accel=mean_distance_between_positions(second_difference(found), second_difference(truth)),
        fs=foot_slide(found, foot_contact_mask(truth)),
    )


def second_difference(places: Array) -> Array:
    """Return the second difference x(t−1) − 2x(t) + x(t+1), (frames − 2, …)."""
    return places[:-2] - 2.0 * places[1:-1] + places[2:]


def lag_numerator_and_denominator(found: Array, truth: Array, dt: float) -> tuple[float, float]:
    """Return the numerator and the denominator of the lag of positions.

    With the true positions x* and velocities v*, these are −Σ (x − x*)·v* and Σ v*·v*. Their
    quotient is, to first order, the delay in seconds that makes x* most similar to x. For several
    clips, sum the numerators and the denominators before dividing.

    Parameters
    ----------
    found, truth
        Positions x and x*, shape (frames, …, 3).
    dt
        Frame time in seconds.
    """
    velocity = np.gradient(truth, dt, axis=0)
    return -float(((found - truth) * velocity).sum()), float((velocity**2).sum())


def procrustes(found: Array, truth: Array) -> Array:
    """Rotate, scale and shift `found` onto `truth` in each frame, without reflection."""
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
