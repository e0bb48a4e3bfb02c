"""Synthetic noise, levels A and B: seeded, calibrated to error levels, no estimator's errors.

The levels imitate how large and how fast errors of video pose estimators are said to be
[Le26 Table 1], nothing else of any estimator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array, exponential, multiply

SMOOTH_SECONDS = 0.75
DEPTH_WEIGHTS = np.array([0.25, 0.15, 1.0])  # x, up, depth: a camera sees depth worst


@dataclass(frozen=True)
class NoiseLevel:
    """Sizes of the noise: degrees per joint and axis, metres of the root.

    smooth: a bias that wanders over about a second; white: new in every frame, at 25 Hz;
    root_smooth: range that a clip's size is drawn from; root_white: likewise constant.
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
    """What to add: a level, and whether half of the wandering bias' variance stands still.

    The systematic part is drawn anew for every clip, so nothing can learn it by heart; the level's
    size is the same with and without. bursts: occlusions a minute, in each of which a limb loses
    its input (it freezes, then jumps back).
    """

    level: NoiseLevel
    systematic: bool = False
    bursts: float = 0.0


LIMBS = ((1, 4, 7, 10), (2, 5, 8, 11), (16, 18, 20, 22), (17, 19, 21, 23))


def noisy(
    q: Array,
    r: Array,
    noise: Noise,
    rng: np.random.Generator,
    *,
    unit: float = 1.0,
    dt: float = NETWORK_DT,
) -> tuple[Array, Array]:
    """Poses (frames, 24, 4) and root places (frames, 3) with noise put on, q̂ = Exp(n) ⊗ q.

    unit: metres in one unit of r. At another rate the wandering part keeps its time scale and the
    white part its size, so that every 25th of a second looks as at 25 Hz.
    """
    frames, joints = q.shape[:2]
    level = noise.level
    share = math.sqrt(0.5) if noise.systematic else 1.0
    smooth, white = np.radians(level.smooth), np.radians(level.white)
    bend = share * smooth * wandering(frames, (joints, 3), rng, dt)
    if noise.systematic:
        bend = bend + share * smooth * rng.standard_normal((joints, 3))
    bend = bend + white * rng.standard_normal((frames, joints, 3))
    q_hat = multiply(exponential(bend), q)
    away = rng.uniform(*level.root_smooth) * wandering(frames, (3,), rng, dt)
    away = away + level.root_white * rng.standard_normal((frames, 3))
    r_hat = r + DEPTH_WEIGHTS * away / unit
    if noise.bursts:
        q_hat = _with_bursts(q_hat, noise.bursts * frames * dt / 60.0, rng, dt)
    return q_hat, r_hat


def wandering(frames: int, shape: tuple[int, ...], rng: np.random.Generator, dt: float) -> Array:
    """White noise under a Gaussian kernel of 0.75 s, of unit variance, (frames, *shape)."""
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
