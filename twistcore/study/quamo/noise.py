"""Add synthetic random noise to poses, at the error levels A and B.

The levels match the magnitude and speed of the errors that [Le26 Table 1] reports for pose
estimation from video. They do not simulate any particular estimator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, exponential, multiply

SMOOTH_SECONDS = 0.75
DEPTH_WEIGHTS = np.array([0.25, 0.15, 1.0])  # of x, height and depth; a camera measures depth worst


@dataclass(frozen=True)
class NoiseLevel:
    """The magnitudes of the noise, in degrees per joint and axis, and in metres for the root.

    Attributes
    ----------
    smooth
        Magnitude of a bias that drifts within about a second.
    white
        Magnitude of the noise that is independent in each frame at 25 Hz.
    root_smooth
        Range from which the magnitude of the root's bias is drawn for each clip.
    root_white
        Magnitude of the root's white noise, the same for every clip.
    """

    smooth: float
    white: float
    root_smooth: tuple[float, float]
    root_white: float


LEVELS = {
    "A": NoiseLevel(3.6, 0.5, (0.10, 0.16), 0.0155),
    "B": NoiseLevel(3.0, 0.24, (0.07, 0.11), 0.006),
}


@dataclass(frozen=True)
class Noise:
    """The synthetic noise to add to poses.

    Attributes
    ----------
    level
        The magnitudes.
    systematic
        True if half of the bias's variance is constant within a clip. This part is drawn for each
        clip, so that no method can memorise it. The total magnitude does not change.
    bursts
        Number of occlusions per minute. During each occlusion, the input of a limb freezes.
        Afterwards, it jumps back.
    """

    level: NoiseLevel
    systematic: bool = False
    bursts: float = 0.0


LIMBS = ((1, 4, 7, 10), (2, 5, 8, 11), (16, 18, 20, 22), (17, 19, 21, 23))


def add_pose_noise(
    q: Array,
    r: Array,
    noise: Noise,
    rng: np.random.Generator,
    *,
    unit: float = 1.0,
    dt: float = NETWORK_DT,
) -> tuple[Array, Array]:
    """Return poses and root positions with noise, q̂ = Exp(n) ⊗ q.

    At other frame rates, the bias keeps its time scale and the white noise its magnitude, so that
    samples 1/25 s apart have the same statistics as at 25 Hz.

    Parameters
    ----------
    q
        Poses, shape (frames, 24, 4).
    r
        Root positions, shape (frames, 3).
    noise
        The noise.
    rng
        The random generator.
    unit
        Length unit of `r` in metres.
    dt
        Frame time in seconds.
    """
    frames, joints = q.shape[:2]
    level = noise.level
    share = math.sqrt(0.5) if noise.systematic else 1.0
    smooth, white = np.radians(level.smooth), np.radians(level.white)
    bend = share * smooth * gaussian_smoothed_noise(frames, (joints, 3), rng, dt)
    if noise.systematic:
        bend = bend + share * smooth * rng.standard_normal((joints, 3))
    bend = bend + white * rng.standard_normal((frames, joints, 3))
    q_hat = multiply(exponential(bend), q)
    away = rng.uniform(*level.root_smooth) * gaussian_smoothed_noise(frames, (3,), rng, dt)
    away = away + level.root_white * rng.standard_normal((frames, 3))
    r_hat = r + DEPTH_WEIGHTS * away / unit
    if noise.bursts:
        q_hat = _with_bursts(q_hat, noise.bursts * frames * dt / 60.0, rng, dt)
    return q_hat, r_hat


def gaussian_smoothed_noise(
    frames: int, shape: tuple[int, ...], rng: np.random.Generator, dt: float
) -> Array:
    """Return white noise smoothed by a Gaussian of 0.75 s, with unit variance, (frames, *shape)."""
    sigma = SMOOTH_SECONDS / dt
    margin = math.ceil(4.0 * sigma)
    raw = rng.standard_normal((frames + 2 * margin, *shape))
    kernel = np.zeros(2 * margin + 1)
    kernel[margin] = 1.0
    kernel = gaussian_filter1d(kernel, sigma)
    smooth = gaussian_filter1d(raw, sigma, axis=0)[margin : margin + frames]
    return smooth / math.sqrt(float((kernel**2).sum()))


def _with_bursts(q_hat: Array, expected: float, rng: np.random.Generator, dt: float) -> Array:
    out = q_hat.copy()
    frames = len(q_hat)
    for _ in range(int(rng.poisson(expected))):
        length = int(rng.uniform(0.2, 0.8) / dt)
        start = int(rng.integers(1, max(2, frames - length)))
        limb = list(LIMBS[int(rng.integers(len(LIMBS)))])
        out[start : start + length, limb] = out[start - 1, limb]
    return out
