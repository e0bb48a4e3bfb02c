"""Fit the weights of the evidence to judged detections and to injected errors.

    python -m benchmarks.evidence VERDICTS.csv FOLDER [--inject PROTOCOL ...] [--seed N]

VERDICTS.csv has the columns of docs/atlas-verdicts.csv. FOLDER contains a folder of clips for every
set in it. The output shows how many automatic corrections are errors, alarms and doubtful, both
with the program's weights and with weights fitted to all other sets. It also shows the calibration
error of the probabilities (ECE), and the weights fitted to all sets.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from benchmarks.atlas import wilson
from benchmarks.real_corrections import clips_of
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Kind
from twistcore.detection.evidence import (
    Background,
    ChainSignals,
    SuspectedError,
    Terms,
    measure_evidence,
)
from twistcore.detection.evidence.judgement import WEIGHTS, unweighted_evidence_scores
from twistcore.detection.straight_limbs import STRAIGHT
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.synthesis import (
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)
from twistcore.tuning.learned_confidence import Bin, expected_calibration_error

# The prior of the weights, suggested by physics. It matters for weights that few detections affect.
PRIOR: Mapping[str, float] = {
    "base": -0.2,
    "azimuth_rougher": 1.5,
    "azimuth_stays": 0.8,
    "off_its_side": 0.8,
    "back_to_its_side": 1.0,
    "straight": 0.4,
    "no_azimuth": 1.5,
    "both_turn_more": 1.2,
    "both_turn_less": 1.0,
    "both_joints": 0.5,
    "silent_joint": 0.8,
    "often": 0.7,
    "natural_size": 1.0,
    "long": 1.0,
}
PULL = 1.0  # strength of the prior, in nats for a squared distance of 1
INJECTED = 40.0  # weight of all injected errors together, as a number of judged detections
ALIKE = 0.6  # minimum IoU of a detection and a judged interval that are the same
BINS = 5


@dataclass(frozen=True, eq=False)
class Judged:
    """A counter-twist in a clip.

    Attributes
    ----------
    set_name
        Name of the set.
    parts
        The terms of the score before weighting, in the order of the weights.
    verdict
        'error', 'alarm', 'doubtful', or '' if there is none.
    applied
        True if the counter-twist is corrected automatically.
    straight
        True if the limb is straight, so that another kind of evidence was used.
    probability
        The confidence of the counter-twist.
    """

    set_name: str
    parts: np.ndarray
    verdict: str
    applied: bool
    straight: bool
    probability: float


def parts_of(terms: Terms) -> np.ndarray:
    """Return the terms of a score before weighting, in the order of the weights."""
    own = unweighted_evidence_scores(terms)
    return np.array([own[name] for name in WEIGHTS])


def finds_in(motion: Motion, set_name: str, rows: Sequence[Mapping[str, str]]) -> Iterator[Judged]:
    """Yield the counter-twists found in a motion, each with its verdict.

    `rows` are the verdicts on this clip.
    """
    found = analyse(motion).detect(kinds={Kind.COUNTER_TWIST})
    applied = set(map(id, automatic_corrections(found)))
    for chain in found.chains:
        own = [i for i in found if i.chain == chain.name]
        finds = [SuspectedError.of(i) for i in own]
        background = Background.of(ChainSignals.of(motion, chain), finds)
        for interval, find in zip(own, finds, strict=True):
            verdicts = (
                row["verdict"]
                for row in rows
                if row["chain"] == chain.name and _alike(find, int(row["start"]), int(row["stop"]))
            )
            yield Judged(
                set_name,
                parts_of(measure_evidence(background, find)),
                next(verdicts, ""),
                id(interval) in applied,
                (interval.evidence or {}).get("follows") == STRAIGHT,
                interval.confidence or 0.0,
            )


def _alike(find: SuspectedError, start: int, stop: int) -> bool:
    shared = min(find.stop, stop) - max(find.start, start)
    return shared >= ALIKE * (max(find.stop, stop) - min(find.start, start))


def injected(motion: Motion, protocol: str, seed: int, name: str) -> Iterator[np.ndarray]:
    """Yield the terms of detections that match errors injected into a motion.

    `name` and `seed` seed the errors, which `protocol` describes.
    """
    rules = parse_protocol(protocol)
    chains = find_chains(motion)
    motion = prepare_clean_motion_for_injection(motion, chains, rules)
    for k, segments in enumerate((("Arm", "UpLeg"), ("ForeArm", "Leg"))):
        targets = [c for c in chains if c.segment in segments]
        errors = draw_errors(motion, targets, clip_random_generator(seed, name, k), rules)
        if not errors:
            continue
        bad = inject(motion, chains, errors)
        found = analyse(bad).detect(kinds={Kind.COUNTER_TWIST})
        for chain in targets:
            own = [i for i in found if i.chain == chain.name]
            finds = [SuspectedError.of(i) for i in own]
            background = Background.of(ChainSignals.of(bad, chain), finds)
            for interval, find in zip(own, finds, strict=True):
                true = any(e.chain == chain.name and _alike(find, e.start, e.stop) for e in errors)
                if true and (interval.evidence or {}).get("follows") != STRAIGHT:
                    yield parts_of(measure_evidence(background, find))


def fitted(judged: Sequence[Judged], errors: Sequence[np.ndarray]) -> np.ndarray:
    """Fit the weights to verdicts and to the terms of injected errors, and return them.

    Only the first weight, the base, may be negative, since the signs of the others follow from
    physics.
    """
    prior = np.array([PRIOR[name] for name in WEIGHTS])
    told = [j for j in judged if j.verdict in ("error", "alarm") and not j.straight]
    x = np.array([*(j.parts for j in told), *errors])
    y = np.array([1.0 if j.verdict == "error" else -1.0 for j in told] + [1.0] * len(errors))
    w = np.array([1.0] * len(told) + [INJECTED / max(len(errors), 1)] * len(errors))

    def loss(b: np.ndarray) -> float:
        far = ((b[1:] - prior[1:]) ** 2).sum()
        return float((w * np.logaddexp(0.0, -y * (x @ b))).sum() + PULL * far)

    bounds = [(None, None), *[(0.0, None)] * (len(prior) - 1)]
    return np.asarray(minimize(loss, prior, bounds=bounds, method="L-BFGS-B").x)


def _counts(judged: Sequence[Judged], sure: Sequence[bool]) -> str:
    count = Counter(j.verdict for j, s in zip(judged, sure, strict=True) if j.verdict and s)
    right = 100.0 * count["error"] / max(count["error"] + count["alarm"], 1)
    told = f"{count['error']} errors, {count['alarm']} alarms, {count['doubtful']} doubtful"
    return f"{told}: {right:.1f} % are errors"


def calibration_error(probabilities: np.ndarray, right: np.ndarray) -> float:
    """Return the expected calibration error, over bins with equal numbers of detections."""
    return expected_calibration_error(equal_bins(probabilities, right))


def equal_bins(probabilities: np.ndarray, right: np.ndarray, bins: int = BINS) -> list[Bin]:
    """Sort detections by probability, and return bins with equal numbers of detections.

    Each bin has the 95 % interval of its share of errors. `right` is 1 for each detection that is
    an error.
    """
    out = []
    for at in np.array_split(np.argsort(probabilities, kind="stable"), bins):
        if len(at):
            low, high = wilson(int(right[at].sum()), len(at))
            said, was = float(probabilities[at].mean()), float(right[at].mean())
            out.append(Bin(len(at), said, was, low, high))
    return out


def main() -> None:
    """Collect the detections, fit the weights, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("verdicts", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--inject", nargs="*", default=["P0", "H6", "F10"])
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rows: dict[tuple[str, str], list[Mapping[str, str]]] = defaultdict(list)
    with given.verdicts.open(newline="") as file:
        for row in csv.DictReader(file):
            if row["kind"] == Kind.COUNTER_TWIST:
                rows[row["set"], row["clip"]].append(row)
    judged: list[Judged] = []
    errors: dict[str, list[np.ndarray]] = defaultdict(list)
    for folder in sorted(p for p in given.folder.iterdir() if p.is_dir()):
        for path in clips_of(folder):
            own = rows.get((folder.name, path.name), [])
            if not own:
                continue
            try:
                motion = read_clip(path).motion
                judged += finds_in(motion, folder.name, own)
                for protocol in given.inject:
                    errors[folder.name] += injected(motion, protocol, given.seed, path.name)
            except TwistError as error:
                print(f"left out: {error}")
        print(f"{folder.name}: {len(judged)} finds, {sum(map(len, errors.values()))} injected")
    print("by the program:", _counts(judged, [j.applied for j in judged]))
    without = {
        name: fitted(
            [j for j in judged if j.set_name != name],
            [e for other, own in errors.items() if other != name for e in own],
        )
        for name in {j.set_name for j in judged}
    }
    scores = np.array([10.0 if j.straight else j.parts @ without[j.set_name] for j in judged])
    sure = [bool(j.applied and s >= 0.0) for j, s in zip(judged, scores, strict=True)]
    print("one set left out:", _counts(judged, sure))
    told = [k for k, j in enumerate(judged) if j.verdict in ("error", "alarm")]
    right = np.array([judged[k].verdict == "error" for k in told], dtype=float)
    for name, values in (
        ("the program's", np.array([judged[k].probability for k in told])),
        ("one set left out", 1.0 / (1.0 + np.exp(-scores[told]))),
    ):
        print(f"ECE, {name}: {calibration_error(values, right):.3f} over {len(told)} finds")
    every = fitted(judged, [e for own in errors.values() for e in own])
    for name, weight in zip(WEIGHTS, every, strict=True):
        print(f'    "{name}": {weight:.2f},')


if __name__ == "__main__":
    main()
