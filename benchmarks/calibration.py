"""Test the calibration of the confidence.

    python -m benchmarks.calibration FOLDER [--seed N] [--step N]

FOLDER contains clips named SUBJECT_TRIAL.bvh. Errors of eleven protocols are injected into one
chain at a time. The candidates are the intervals found at 0.3 τ. A candidate is right if its IoU
with an injected interval is ≥ 0.5 and ≥ 80 % of that interval's frames are corrected by ≥ 80 %.

The logistic map from features to confidence is fitted again on one subject, and its weights are
printed for comparison with twistcore.detection.consistency.confidence. The tables evaluate the map
of the program on all *other* subjects, first as injected, and then with a tenth of the errors: nine
chains without errors for each chain with errors. They show the area under the ROC curve (AUC), the
expected calibration error over ten bins (ECE), and the share of right candidates in each bin.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from twistcore.detection import Interval
from twistcore.detection.consistency import confidence
from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.detectors.consistency import ConsistencyDetector
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import wrap
from twistcore.synthesis import (
    InjectedError,
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)

PROTOCOLS = (
    "P0", "H6", "H3-4", "H4", "rich", "rich+H6", "rich+H3-4", "rich+H1", "rich+H4", "rich+H6+H1",
    "rich+H5",
)  # fmt: skip
LOWEST = 0.3  # share of τ at which candidates are found
CLEAN_FOR_EACH = 9  # chains without errors for each chain with errors, in the second table
BINS = 10


def right(interval: Interval, errors: Sequence[InjectedError]) -> bool:
    """Return True if an interval matches one of the injected errors and corrects it."""
    for e in errors:
        if e.chain != interval.chain:
            continue
        common = min(e.stop, interval.stop) - max(e.start, interval.start)
        union = max(e.stop, interval.stop) - min(e.start, interval.start)
        if common < 0.5 * union:
            continue
        taken = np.zeros(e.stop - e.start)
        low, high = max(e.start, interval.start), min(e.stop, interval.stop)
        taken[low - e.start : high - e.start] = interval.offset[
            low - interval.start : high - interval.start
        ]
        left = np.abs(wrap(e.offset - taken))
        return bool((left <= 0.2 * np.abs(wrap(e.offset))).mean() >= 0.8)
    return False


def features(interval: Interval, tau: float) -> tuple[float, ...]:
    """Return the features of an interval from which its confidence is computed.

    They are the gain, the closing residual in σ, the margin of the weaker edge, the number of
    frames, and whether τ is reached.
    """
    evidence = interval.evidence or {}
    weakest = np.radians(min(abs(e["jump_deg"]) for e in evidence["edges"]))
    margin = min(abs(e["jump_deg"]) / e["sigma_deg"] for e in evidence["edges"])
    closing = abs(evidence["closing_residual_deg"]) / evidence["closing_sigma_deg"]
    return evidence["gain"], closing, float(np.log(margin)), float(interval.frames), weakest >= tau


def candidates(
    analysis: ConsistencyAnalysis, chains: Sequence[Chain]
) -> list[tuple[Interval, float]]:
    """Return the intervals of all chains between two jumps of at least 0.3 τ, each with its τ."""
    return [
        (i, tau)
        for c in chains
        for tau in [analysis.automatic_tau(c.name)]
        for i in analysis.intervals(c.name, LOWEST * tau)
        if not i.open and "edges" in (i.evidence or {})
    ]


class Sample:
    """Candidates with their features, the program's confidence, and whether they are right.

    Attributes
    ----------
    x
        The features of each candidate.
    p
        The confidence of each candidate.
    y
        True for each candidate that is right.
    clean
        True for each candidate from a clip without injected errors.
    """

    def __init__(self) -> None:
        self.x: list[tuple[float, ...]] = []
        self.p: list[float] = []
        self.y: list[bool] = []
        self.clean: list[bool] = []

    def add(
        self,
        found: Sequence[tuple[Interval, float]],
        errors: Sequence[InjectedError],
        clean: bool,
    ) -> None:
        """Add the candidates found in one clip, which is `clean` or has the given errors."""
        self.x += [features(i, tau) for i, tau in found]
        self.p += [i.confidence or 0.0 for i, _ in found]
        self.y += [right(i, errors) for i, _ in found]
        self.clean += [clean] * len(found)


def collect(paths: Sequence[Path], seed: int) -> Sample:
    """Collect the candidates from all clips, without errors and with errors of every protocol.

    The errors are injected into one chain at a time.
    """
    sample, detector = Sample(), ConsistencyDetector()
    for path in paths:
        captured = read_bvh(path).motion
        chains = find_chains(captured)
        for n, name in enumerate(PROTOCOLS):
            protocol = parse_protocol(name)
            motion: Motion = prepare_clean_motion_for_injection(captured, chains, protocol)
            sample.add(candidates(detector.analyse(motion, chains), chains), (), clean=True)
            for k, chain in enumerate(chains):
                limb = [c for c in chains if c.side == chain.side and _arm(c) == _arm(chain)]
                rng = clip_random_generator(seed, path.name, n, k)
                errors = draw_errors(motion, [chain], rng, protocol)
                analysis = detector.analyse(inject(motion, chains, errors), limb)
                sample.add(candidates(analysis, limb), errors, clean=False)
    return sample


def _arm(chain: Chain) -> bool:
    return chain.segment in ("Shoulder", "Arm", "ForeArm")


def fitted(sample: Sample) -> np.ndarray:
    """Return the weights of the logistic map, intercept first, as in consistency.confidence."""
    gain, closing, margin, frames, beyond = np.array(sample.x, dtype=float).T
    columns = np.stack(
        [
            np.ones(len(gain)),
            np.log(np.maximum(gain, 0.5)),
            np.minimum(closing, confidence.MOST_CLOSING),
            np.minimum(margin, confidence.MOST_MARGIN),
            np.log1p(frames / confidence.LENGTH_FRAMES),
            beyond,
        ],
        axis=1,
    )
    use = ~np.array(sample.clean)
    columns, sign = columns[use], 2.0 * np.array(sample.y)[use] - 1.0

    def loss(weights: np.ndarray) -> float:
        # Few candidates are long, and one natural event that occurs with every error is among
        # them. The weight of the length must not become large because of this event.
        penalty = 0.5 * float((weights[1:] ** 2).sum()) + 100.0 * (weights[4] + 0.13) ** 2
        return float(np.logaddexp(0.0, -sign * (columns @ weights)).sum()) + penalty

    return np.asarray(minimize(loss, np.zeros(6)).x)


def area(p: np.ndarray, y: np.ndarray, weight: np.ndarray) -> float:
    """Return the area under the ROC curve. Pairs with equal confidences count half.

    `p` are the confidences, `y` is a mask of the right candidates, and `weight` has their weights.
    """
    levels, of = np.unique(p, return_inverse=True)
    good = np.bincount(of, weight * y, len(levels))
    bad = np.bincount(of, weight * ~y, len(levels))
    below = np.cumsum(bad) - bad
    return float((good * (below + 0.5 * bad)).sum() / (good.sum() * bad.sum()))


def report(title: str, sample: Sample, clean_weight: float) -> None:
    """Print a table of the calibration.

    `clean_weight` is the weight of candidates from clips without errors.
    """
    p, y, clean = np.array(sample.p), np.array(sample.y), np.array(sample.clean)
    # Each clip is searched once without errors, and once for each chain with errors.
    weight = np.where(clean, clean_weight, 1.0)
    p, y, weight = p[weight > 0], y[weight > 0], weight[weight > 0]
    bins = np.minimum((p * BINS).astype(int), BINS - 1)
    total, error, rows = weight.sum(), 0.0, []
    for b in range(BINS):
        w = weight * (bins == b)
        if not w.any():
            continue
        said, was = (w * p).sum() / w.sum(), (w * y).sum() / w.sum()
        error += w.sum() / total * abs(said - was)
        rows.append(f"  {b / BINS:.1f}-{(b + 1) / BINS:.1f}  {w.sum():9.0f}  {said:.3f}  {was:.3f}")
    print(
        f"\n{title}: {total:.0f} candidates, prevalence {(weight * y).sum() / total:.4f}, "
        f"AUC {area(p, y, weight):.4f}, ECE {error:.4f}"
    )
    print("  said       count   mean  right", *rows, sep="\n")


def main() -> None:
    """Fit the map on one subject and evaluate it on the others."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=6)
    parser.add_argument("--step", type=int, default=1, help="every step-th clip")
    parser.add_argument("--fit", default="05", help="the subject used for fitting")
    arguments = parser.parse_args()
    paths = clip_paths_in_folder(arguments.folder, suffixes=BVH)
    own = [p for p in paths if p.stem.split("_")[0] == arguments.fit][:: arguments.step]
    others = [p for p in paths if p.stem.split("_")[0] != arguments.fit][:: arguments.step]
    if not own or not others:
        parser.error(f"{arguments.folder}: expected clips of subject {arguments.fit} and of others")
    fit = collect(own, arguments.seed)
    print("fitted weights", np.round(fitted(fit), 4).tolist())
    shipped = [getattr(confidence, n) for n in ("INTERCEPT", "PER_LOG_GAIN", "PER_CLOSING")]
    print(
        "shipped       ",
        [*shipped, confidence.PER_MARGIN, confidence.PER_LENGTH, confidence.PER_BEYOND_TAU],
    )
    test = collect(others, arguments.seed + 1)
    report(f"fitted subject {arguments.fit}, as injected", fit, 0.0)
    report("other subjects, as injected", test, 0.0)
    report("other subjects, a tenth of the errors", test, float(CLEAN_FOR_EACH))


if __name__ == "__main__":
    main()
