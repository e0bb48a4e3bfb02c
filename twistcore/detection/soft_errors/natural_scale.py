"""Measure how far natural motion in a clip departs from smooth courses over spans of each length.

x and y are the twist increments of a chain's parent P and child C. A twist error does not change
their sum, so β(x + y), the part of x that is proportional to the sum, is natural. The remainder u =
x − β(x + y) contains the whole error. If P does not twist naturally, β is 0 and u is x. If C does
not twist naturally, β is 1 and u is −y. The smooth courses are the bridges of `departures`.
"""

from __future__ import annotations

import math

import numpy as np

from twistcore.detection.prediction import FLOOR, Mask
from twistcore.detection.soft_errors.departures import Single, SpanGrid, Values
from twistcore.skeleton.medians import quantiles
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

NU = 4.0  # degrees of freedom of Student's t, as in robust_cost
LOCAL_SECONDS = 0.6  # half the window for the local scale; at least one and a half spans
# The weight of the local scale in σ, and of the scale of the whole clip in the local scale.
OWN, BORROWED = 0.7, 0.15
# Minimum number and share of clean positions; with fewer, the scale of the next shorter spans is
# used.
FEWEST, FEWEST_SHARE = 12, 0.06
GROWTH = 1.7  # exponent of the growth of σ with the length of a span, if it cannot be measured
SAMPLES, STEPS = 800, 8  # maximum number of samples and number of steps in the fit of β
QUIET_SHARE, QUIET = 0.35, 2.2  # quantile of |u| that errors do not affect; ratio of σ to it
BEYOND = 6.0  # an increment of more σ is not natural
ROUNDED = 0.29  # σ of a level due to rounding, in rounding steps of the angles
CAP = 14.0  # nats: the cost of all large departures, which are equally unlikely


def natural_twist_departure_cost(z: Values, cap: float = CAP) -> Values:
    """Return the costs in nats of departures of `z` σ from the natural course, at most `cap`.

    The cost is the negative log-likelihood of u, given x + y, relative to a departure of 0.
    """
    return np.minimum(0.5 * (NU + 2.0) * np.log1p(z * z / (NU + 1.0)), cap)


@dataclass(frozen=True, eq=False)
class Natural:
    """The scales of natural motion's departures over spans of one length.

    Attributes
    ----------
    span
        The spans.
    beta
        β, the natural share of x + y in x, for each chain, shape (chains,).
    sigma, sigma_sum
        The scales of the departures of u and of x + y, radians, (probes, chains, positions), in
        single precision to save memory.
    """

    span: SpanGrid
    beta: Array
    sigma: Single
    sigma_sum: Single

    def rest(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the departures of u = x − β(x + y) and of x + y, given the departures of x and y.

        All arrays have the shape (probes, chains, positions).
        """
        total = x + y
        return x - self.beta[:, None] * total, total

    def spread(self, total: Array) -> Array:
        """Return the scales of the departures of u, given the departures of x + y, in radians.

        The scales grow with the magnitude of the given departures, as in a multivariate t
        distribution.
        """
        z = total / self.sigma_sum
        return np.asarray(self.sigma * np.sqrt((NU + z * z) / (NU + 1.0)))


def natural_twist_departure_scales(
    x: Array, y: Array, fps: float, spans: tuple[SpanGrid, ...], bad: Mask, step: float = 0.0
) -> list[Natural]:
    """Measure the scales of natural motion's departures over the spans of each length.

    Parameters
    ----------
    x, y
        The twist increments, radians, shape (chains, frames).
    fps
        The frame rate.
    spans
        The spans of each length, the shortest first.
    bad
        Mask of the frames to exclude, because they may contain errors, shape (chains, frames).
    step
        The rounding step of the angles in the file, radians. No scale is smaller than the noise due
        to this rounding.

    Returns
    -------
    list of Natural
        One item for each length.
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
        beta = fit_parent_share_of_twist(dx[middle], total[middle], clean)
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
        found.append(Natural(span, beta, sigma.astype(np.float32), sigma_sum.astype(np.float32)))
    return found


def fit_parent_share_of_twist(x: Array, total: Array, clean: Mask) -> Array:
    """Return for each chain the β in 0…1 that minimises Σ|x − β(x + y)|, (chains,).

    `total` contains x + y, and `clean` is the mask of the positions to use. They and `x` have the
    shape (chains, n). The sum of absolute values is used because remaining errors have little
    influence on it.
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
    """Return the local scales σ = 1.48·(mean √|r|)² of values r.

    Each mean is over the clean positions within ± `window`. `values` and the result have the shape
    (probes, chains, positions), and `clean` has the shape (chains, positions).
    """
    root = np.sqrt(np.abs(values))
    root *= clean
    many = clean.sum(axis=1)[:, None]
    overall = root.sum(axis=-1, keepdims=True) / np.maximum(many, 1)
    near = _box_mean_parts(root, clean, window)
    local = (near[0] + BORROWED * overall) / (near[1] + BORROWED)
    mixed = (1.0 - OWN) * overall + OWN * local
    return np.asarray(np.maximum(1.48 * mixed * mixed, FLOOR))


def _box_mean_parts(root: Array, clean: Mask, window: int) -> tuple[Array, Array]:
    """Return the moving averages of `root` and `clean` within ± `window` positions.

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


def unnaturally_large_twist_increments(x: Array, y: Array, fps: float, step: float = 0.0) -> Mask:
    """Return a mask of the frames with unnaturally large increments, (chains, frames).

    Natural scales must not be measured in these frames. `x` and `y` are the twist increments in
    radians, (chains, frames), and `step` is the rounding step of the angles in the file.
    """
    least = max(0.5 * FLOOR, math.sqrt(2.0) * ROUNDED * step)
    everywhere = np.ones(x.shape, dtype=bool)
    total = x + y
    u = x - fit_parent_share_of_twist(x, total, everywhere)[:, None] * total
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
