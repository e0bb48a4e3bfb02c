"""Measure the natural departures from the bridges over every span, in the clip itself.

x and y are the twist increments of a chain's parent P and child C. A twist error does not change
their sum. So β(x + y), the part of x that is proportional to this sum, is natural, and the
remainder u = x − β(x + y) contains the whole error. If P does not twist, β is 0 and u is x. If C
does not twist, β is 1 and u is −y. In all other cases, u is the part of x that x + y does not
explain.
"""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.prediction import FLOOR, Mask
from twistcore.detection.soft_errors.departures import Span
from twistcore.skeleton.medians import quantiles
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

NU = 4.0  # degrees of freedom of Student's t, as in robust_cost
LOCAL_SECONDS = 0.6  # half the window of the local scale, at least one and a half spans
# weights: of the local scale in σ; of the scale of the whole clip in the local scale
OWN, BORROWED = 0.7, 0.15
FEWEST, FEWEST_SHARE = 12, 0.06  # clean positions; with fewer, the previous span's scale is used
GROWTH = 1.7  # growth of σ with the length of a span, if it cannot be measured
SAMPLES, STEPS = 800, 8  # samples and steps of the fit of β
QUIET_SHARE, QUIET = 0.35, 2.2  # quantile of |u| that errors do not affect; ratio of σ to it
BEYOND = 6.0  # σ from which an increment is not natural
ROUNDED = 0.29  # σ of a level that rounding causes, as a share of the step of written angles
CAP = 14.0  # nats; all larger departures are equally unlikely


def cost(z: Array, cap: float = CAP) -> Array:
    """Return the negative log-likelihood of a departure of z σ, limited to `cap`.

    x + y is assumed to be known.
    """
    return np.minimum(0.5 * (NU + 2.0) * np.log1p(z * z / (NU + 1.0)), cap)


@dataclass(frozen=True, eq=False)
class Natural:
    """The scales of natural departures over one span.

    Attributes
    ----------
    beta
        β of each chain, shape (chains,).
    sigma, sigma_sum
        The scales of u and of x + y, radians, shape (probes, chains, positions).
    """

    span: Span
    beta: Array
    sigma: Array
    sigma_sum: Array

    def rest(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return u and x + y, given the departures of x and y, each (probes, chains, positions)."""
        total = x + y
        return x - self.beta[:, None] * total, total

    def spread(self, total: Array) -> Array:
        """Return the scale of u for given values of x + y.

        The scale grows with the magnitude of these values, as in a multivariate t distribution.
        """
        z = total / self.sigma_sum
        return np.asarray(self.sigma * np.sqrt((NU + z * z) / (NU + 1.0)))


def natural_scales(
    x: Array, y: Array, fps: float, spans: tuple[Span, ...], bad: Mask, step: float = 0.0
) -> list[Natural]:
    """Return the natural scales over each span, measured in the frames that are not marked bad.

    Parameters
    ----------
    x, y
        The increments, radians, shape (chains, frames).
    bad
        Mask of the bad frames, in which nothing is measured, shape (chains, frames).
    step
        The rounding step of the angles in the file. No scale is smaller than the noise of that
        rounding.
    """
    frames = x.shape[1]
    level_x, level_y = np.cumsum(x, axis=1), np.cumsum(y, axis=1)
    counts = np.zeros((len(x), frames + 1), dtype=np.int32)
    np.cumsum(bad, axis=1, out=counts[:, 1:])
    found: list[Natural] = []
    for span in spans:
        dx, dy = span.departures(level_x), span.departures(level_y)
        many = dx.shape[-1]
        first = span.step * np.arange(many)
        clean = counts[:, first + span.support] == counts[:, first]
        enough = clean.sum(axis=1) >= np.maximum(FEWEST, FEWEST_SHARE * many)
        total = dx + dy
        middle = len(dx) // 2
        beta = fitted_share(dx[middle], total[middle], clean)
        half = max(LOCAL_SECONDS * fps, 1.5 * span.length)
        window = max(1, round(half / span.step))
        sigma = _scales(dx - beta[:, None] * total, clean, window)
        sigma_sum = _scales(total, clean, window)
        if not enough.all():
            lacking = ~enough
            if found:
                before = found[-1]
                growth = (span.length / before.span.length) ** GROWTH
                middle_of = first + (span.length - before.span.length) // 2
                at = np.minimum(middle_of // before.span.step, before.sigma.shape[-1] - 1)
                beta[lacking] = before.beta[lacking]
                sigma[:, lacking] = growth * before.sigma[:, lacking][..., at]
                sigma_sum[:, lacking] = growth * before.sigma_sum[:, lacking][..., at]
            else:
                everything = np.ones_like(clean)
                sigma[:, lacking] = _scales(dx - beta[:, None] * total, everything, window)[
                    :, lacking
                ]
                sigma_sum[:, lacking] = _scales(total, everything, window)[:, lacking]
        if step:
            least = step * ROUNDED * span.noise()[:, None]
            sigma = np.maximum(sigma, (least * np.hypot(beta, 1.0 - beta))[..., None])
            sigma_sum = np.maximum(sigma_sum, math.sqrt(2.0) * least[..., None])
        found.append(Natural(span, beta, sigma, sigma_sum))
    return found


def fitted_share(x: Array, total: Array, clean: Mask) -> Array:
    """Return the β in 0…1 that minimises Σ|x − β(x + y)| over the clean positions.

    `x`, `total` and `clean` have the shape (chains, n), and β has the shape (chains,). Absolute
    values are summed so that remaining errors have little influence.
    """
    step = max(1, x.shape[1] // SAMPLES)
    x, total = x[:, ::step], total[:, ::step]
    weight = clean[:, ::step].astype(np.float64)
    beta = np.full(len(x), 0.5)
    tiny = FLOOR * FLOOR * 1e-3
    for _ in range(STEPS):
        by = weight * total / np.maximum(np.abs(x - beta[:, None] * total), FLOOR)
        over = np.einsum("cf,cf->c", by, total)
        beta = np.clip((np.einsum("cf,cf->c", by, x) + 0.5 * tiny) / (over + tiny), 0.0, 1.0)
    return beta


def _scales(values: Array, clean: Mask, window: int) -> Array:
    """Return σ = 1.48·(mean √|r|)² over the clean positions nearby, (probes, chains, positions)."""
    root = np.sqrt(np.abs(values))
    root *= clean
    many = clean.sum(axis=1)[:, None]
    overall = root.sum(axis=-1, keepdims=True) / np.maximum(many, 1)
    near = _box_mean_parts(root, clean, window)
    local = (near[0] + BORROWED * overall) / (near[1] + BORROWED)
    mixed = (1.0 - OWN) * overall + OWN * local
    return np.asarray(np.maximum(1.48 * mixed * mixed, FLOOR))


def _box_mean_parts(root: Array, clean: Mask, window: int) -> tuple[Array, Array]:
    """Return the means of `root` and `clean` within ± `window` positions.

    At the ends, the means include fewer positions.
    """
    n = root.shape[-1]
    low = np.maximum(np.arange(n) - window, 0)
    high = np.minimum(np.arange(n) + window + 1, n)
    sums = []
    for values in (root, clean):
        total = np.zeros((*values.shape[:-1], n + 1))
        np.cumsum(values, axis=-1, out=total[..., 1:])
        sums.append((total[..., high] - total[..., low]) / (high - low))
    return sums[0], sums[1]


def unlikely_increments(x: Array, y: Array, fps: float, step: float = 0.0) -> Mask:
    """Return a mask of the frames with conspicuous increments, (chains, frames).

    No natural scale should be measured in these frames. `step` is the rounding step of the angles
    in the file.
    """
    least = max(0.5 * FLOOR, math.sqrt(2.0) * ROUNDED * step)
    everywhere = np.ones(x.shape, dtype=bool)
    total = x + y
    u = x - fitted_share(x, total, everywhere)[:, None] * total
    size, half = np.abs(u), round(LOCAL_SECONDS * fps)
    quiet = QUIET * quantiles(size, QUIET_SHARE)[:, None]
    sigma = np.maximum(quiet, least)
    root = np.sqrt(size)
    for _ in range(3):
        fine = size < BEYOND * sigma
        mean, share = _box_mean_parts(root * fine, fine, half)
        local = (mean + 0.1 * np.sqrt(quiet / 1.48)) / (share + 0.1)
        sigma = np.maximum(1.48 * local * local, least)
    return np.asarray(size > BEYOND * sigma)
