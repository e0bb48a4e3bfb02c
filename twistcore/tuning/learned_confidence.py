"""Learn from a person's verdicts how to adjust the detector's confidence.

The detector's confidence estimates whether an injected error was found and corrected. A person may
call fewer or more intervals errors, depending on rig, performer and taste. The map

    learned = 1 / (1 + exp(−(shift + scale · log(c / (1 − c)))))

of the detector's confidence c has two parameters and does not change the order of intervals (scale
is above 0). The parameters are the most likely ones given the verdicts and a prior around the
built-in map (shift 0, scale 1), so that a few verdicts change the map only a little. The form of
the map and the prior were chosen on the first four passes of `benchmarks/learned_confidence.py`,
which reports the results of the remaining passes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from twistcore.detection.prediction import Mask
from twistcore.skeleton.rotation import Array
from twistcore.tuning.verdict_curve import wilson
from twistcore.tuning.verdicts_of import JudgedClip
from twistcore.work.frozen import dataclass

LEAST = 0.01  # values closer to 0 or 1 carry no more information
SHIFT_SPREAD, LOG_SCALE_SPREAD = 2.0, 0.5  # standard deviations of the prior
FOLDS = 5
BINS = 10
ENOUGH = 20  # minimum number of verdicts to learn from


@dataclass(frozen=True)
class LearnedConfidence:
    """The fitted map, with the numbers of accepted and rejected intervals used for the fit."""

    shift: float = 0.0
    scale: float = 1.0
    accepted: int = 0
    rejected: int = 0

    def of(self, confidence: Array) -> Array:
        """Return the learned confidences, 0…1, for the detector's confidences."""
        return _logistic(self.shift + self.scale * _logit(confidence))

    def __call__(self, confidence: float | None) -> float | None:
        """Return the learned confidence of one interval, or None for None."""
        return None if confidence is None else float(self.of(np.array([confidence]))[0])


@dataclass(frozen=True, eq=False)
class Seen:
    """Intervals that a detector listed.

    Three arrays of shape (n,): the confidence of each interval, whether it was accepted, and the
    index of its clip.
    """

    confidence: Array
    accepted: Mask
    clip: Array

    def __len__(self) -> int:
        return len(self.confidence)

    def __getitem__(self, at: Mask) -> Seen:
        """Return the intervals selected by an index or mask."""
        return Seen(self.confidence[at], self.accepted[at], self.clip[at])


@dataclass(frozen=True)
class Bin:
    """Intervals of similar confidence: their number, mean confidence and accepted fraction.

    `low` and `high` are the limits of the 90 % confidence interval of the accepted fraction.
    """

    count: int
    said: float
    was: float
    low: float
    high: float


@dataclass(frozen=True)
class Reliability:
    """The nonempty bins in order of confidence, and the expected calibration error."""

    bins: tuple[Bin, ...]
    error: float


def seen(clips: Iterable[JudgedClip]) -> Seen:
    """Return the verdicts on all intervals that have a confidence."""
    rows = [
        (v.confidence, v.error, k)
        for k, clip in enumerate(clips)
        for v in clip.verdicts
        if v.confidence is not None
    ]
    columns = np.array(rows, dtype=float).reshape(-1, 3).T
    return Seen(columns[0], columns[1] > 0.5, columns[2])


def learned(given: Seen) -> LearnedConfidence:
    """Return the most likely map given the verdicts, or the built-in map without verdicts."""
    if not len(given):
        return LearnedConfidence()
    logit, sign = _logit(given.confidence), 2.0 * given.accepted - 1.0

    def loss(at: Array) -> float:
        score = sign * (at[0] + math.exp(at[1]) * logit)
        prior = (at[0] / SHIFT_SPREAD) ** 2 + (at[1] / LOG_SCALE_SPREAD) ** 2
        return float(np.logaddexp(0.0, -score).sum() + 0.5 * prior)

    from scipy.optimize import minimize  # slow to load; only needed for a fit

    shift, log_scale = minimize(loss, np.zeros(2)).x
    accepted = int(given.accepted.sum())
    return LearnedConfidence(float(shift), math.exp(log_scale), accepted, len(given) - accepted)


def held_out(given: Seen, folds: int = FOLDS, seed: int = 0) -> Array:
    """Return the learned confidence of every interval, from a map fitted without its clip, (n,).

    With fewer clips than folds, each clip is left out in turn; with a single clip, parts of its
    verdicts are left out.
    """
    rng = np.random.default_rng(seed)
    group = given.clip
    if len(np.unique(group)) < 2:
        group = np.arange(len(given), dtype=float)
    names = rng.permutation(np.unique(group))
    out = np.array(given.confidence, dtype=float)
    for fold in range(min(folds, len(names))):
        apart = np.isin(group, names[fold::folds])
        out[apart] = learned(given[~apart]).of(given.confidence[apart])
    return out


def reliability(confidence: Array, accepted: Mask, bins: int = BINS) -> Reliability:
    """Return the accepted fraction of the intervals in bins of similar confidence."""
    of = np.minimum((confidence * bins).astype(int), bins - 1)
    rows: list[Bin] = []
    for b in np.unique(of):
        here = of == b
        n, yes = int(here.sum()), int(accepted[here].sum())
        low, high = wilson(np.array(yes), np.array(n))
        rows.append(Bin(n, float(confidence[here].mean()), yes / n, float(low), float(high)))
    return Reliability(tuple(rows), expected_error(rows))


def expected_error(bins: Sequence[Bin]) -> float:
    """Return the expected calibration error, the mean of |confidence − accepted fraction|."""
    total = sum(b.count for b in bins)
    return sum(b.count * abs(b.said - b.was) for b in bins) / max(total, 1)


def _logit(p: Array) -> Array:
    p = np.clip(np.asarray(p, float), LEAST, 1.0 - LEAST)
    return np.asarray(np.log(p / (1.0 - p)))


def _logistic(x: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-x)))
