"""Learn from a person's verdicts how to adjust the detector's confidence.

The detector's confidence is the estimated probability that an interval is an error, calibrated on
injected errors. For other rigs, performers or reviewers, the accepted fraction may be different.
The learned confidence is

    learned = 1 / (1 + exp(−(shift + scale · log(c / (1 − c)))))

where c is the detector's confidence. Since scale is positive, intervals keep their order of
confidence. The two parameters, shift and scale, are the most likely ones given the verdicts and a
prior around the built-in values (shift 0, scale 1), so a few verdicts change the confidence only a
little. The formula and the prior were chosen on the first four passes of
`benchmarks/learned_confidence.py`, which reports the results of the remaining passes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from twistcore.detection.prediction import Mask
from twistcore.skeleton.rotation import Array
from twistcore.tuning.verdict_curve import wilson_bounds
from twistcore.tuning.verdicts_of import JudgedClip
from twistcore.work.frozen import dataclass

LEAST = 0.01  # confidences are limited to LEAST … 1 − LEAST, so that logarithms stay finite
SHIFT_SPREAD, LOG_SCALE_SPREAD = 2.0, 0.5  # standard deviations of the prior
FOLDS = 5
BINS = 10
ENOUGH = 20  # minimum number of verdicts to learn from


@dataclass(frozen=True)
class LearnedConfidence:
    """The parameters of the learned confidence, and the number of verdicts used for the fit.

    Parameters
    ----------
    shift, scale
        The parameters of the formula in the module's docstring.
    accepted, rejected
        Number of accepted and number of rejected intervals used for the fit.
    """

    shift: float = 0.0
    scale: float = 1.0
    accepted: int = 0
    rejected: int = 0

    def of(self, confidence: Array) -> Array:
        """Return the learned confidences, 0…1, for an array of the detector's confidences."""
        return _logistic(self.shift + self.scale * _logit(confidence))

    def __call__(self, confidence: float | None) -> float | None:
        """Return the learned confidence of an interval, or None if `confidence` is None."""
        return None if confidence is None else float(self.of(np.array([confidence]))[0])


@dataclass(frozen=True, eq=False)
class ConfidenceVerdicts:
    """The verdicts on n detected intervals.

    Parameters
    ----------
    confidence
        The detector's confidence in each interval, shape (n,).
    accepted
        Mask of the accepted intervals, shape (n,).
    clip
        Index of each interval's clip, shape (n,).
    """

    confidence: Array
    accepted: Mask
    clip: Array

    def __len__(self) -> int:
        return len(self.confidence)

    def __getitem__(self, at: Mask) -> ConfidenceVerdicts:
        """Return the verdicts selected by the mask `at`."""
        return ConfidenceVerdicts(self.confidence[at], self.accepted[at], self.clip[at])


@dataclass(frozen=True)
class Bin:
    """A bin of intervals with similar confidence.

    Parameters
    ----------
    count
        Number of intervals.
    said
        Mean confidence.
    was
        Accepted fraction.
    low, high
        Limits of the 90 % confidence interval of the accepted fraction.
    """

    count: int
    said: float
    was: float
    low: float
    high: float


@dataclass(frozen=True)
class Reliability:
    """The accepted fraction in bins of similar confidence.

    Parameters
    ----------
    bins
        The bins that contain intervals, in order of confidence.
    error
        The expected calibration error.
    """

    bins: tuple[Bin, ...]
    error: float


def verdicts_with_confidence(clips: Iterable[JudgedClip]) -> ConfidenceVerdicts:
    """Return the verdicts on all intervals for which the detector gives a confidence."""
    rows = [
        (v.confidence, v.error, k)
        for k, clip in enumerate(clips)
        for v in clip.verdicts
        if v.confidence is not None
    ]
    columns = np.array(rows, dtype=float).reshape(-1, 3).T
    return ConfidenceVerdicts(columns[0], columns[1] > 0.5, columns[2])


def fit_confidence_to_verdicts(given: ConfidenceVerdicts) -> LearnedConfidence:
    """Return the learned confidence that is most likely given the verdicts.

    Without verdicts, the built-in parameters are returned.
    """
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


def cross_validated_confidence(given: ConfidenceVerdicts) -> Array:
    """Return the learned confidence of each interval, fitted without the verdicts on its clip.

    The result has the shape (n,). The clips are held out in FOLDS random groups, or one by one if
    there are fewer clips. With a single clip, groups of verdicts are held out.
    """
    rng = np.random.default_rng(0)
    group = given.clip
    if len(np.unique(group)) < 2:
        group = np.arange(len(given), dtype=float)
    names = rng.permutation(np.unique(group))
    out = np.array(given.confidence, dtype=float)
    for fold in range(min(FOLDS, len(names))):
        apart = np.isin(group, names[fold::FOLDS])
        out[apart] = fit_confidence_to_verdicts(given[~apart]).of(given.confidence[apart])
    return out


def confidence_reliability_by_bin(confidence: Array, accepted: Mask) -> Reliability:
    """Return the fraction of accepted intervals in bins of similar confidence.

    `confidence` and the mask `accepted` have the shape (n,).
    """
    of = np.minimum((confidence * BINS).astype(int), BINS - 1)
    rows: list[Bin] = []
    for b in np.unique(of):
        here = of == b
        n, yes = int(here.sum()), int(accepted[here].sum())
        low, high = wilson_bounds(np.array(yes), np.array(n))
        rows.append(Bin(n, float(confidence[here].mean()), yes / n, float(low), float(high)))
    return Reliability(tuple(rows), expected_calibration_error(rows))


def expected_calibration_error(bins: Sequence[Bin]) -> float:
    """Return the expected calibration error: the mean |confidence − accepted fraction|."""
    total = sum(b.count for b in bins)
    return sum(b.count * abs(b.said - b.was) for b in bins) / max(total, 1)


def _logit(p: Array) -> Array:
    p = np.clip(np.asarray(p, float), LEAST, 1.0 - LEAST)
    return np.asarray(np.log(p / (1.0 - p)))


def _logistic(x: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-x)))
