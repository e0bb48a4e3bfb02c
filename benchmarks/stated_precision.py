"""Measure the stated precision of automatic corrections: python -m benchmarks.stated_precision.

Folders of an unknown rig are simulated by samples of the automatic corrections that two blind
judges rated (docs/atlas-blind.csv). In each folder, the verdicts on 30 corrections are used, chosen
in the informative order or with the worst first. The precision of the other corrections is then
estimated and compared with their verdicts. A doubtful verdict counts as an error in half of the
folders.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from twistcore.tuning.stated_precision import (
    ENOUGH_STATED,
    AutomaticCorrection,
    estimate_unjudged_precision,
    representative_judging_order,
)

VERDICTS = Path(__file__).resolve().parent.parent / "docs" / "atlas-blind.csv"
SIZES, DRAWS = (60, 100, 136), 400


def judged(path: Path) -> tuple[list[AutomaticCorrection], np.ndarray, list[str]]:
    """Return the rated corrections, how bad each is (degrees · √frames), and the verdicts."""
    rows = [r for r in csv.DictReader(path.open()) if r["applied"] == "yes" and r["confidence"]]
    found = [
        AutomaticCorrection(r["chain"], int(r["start"]), int(r["stop"]), float(r["confidence"]))
        for r in rows
    ]
    lengths = np.array([one.stop - one.start for one in found])
    bad = np.abs([float(r["degrees"]) for r in rows]) * np.sqrt(lengths)
    return found, bad, [r["verdict"] for r in rows]


def main() -> None:
    """Print the error of the estimates, and how often their range contains the true precision."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    rng = np.random.default_rng(parser.parse_args().seed)
    found, bad, said = judged(VERDICTS)
    for size in SIZES:
        errors: dict[str, list[float]] = {"informative": [], "worst first": []}
        inside: dict[str, list[bool]] = {name: [] for name in errors}
        for _ in range(DRAWS):
            at = rng.choice(len(found), size=size, replace=False)
            confidence = np.array([found[k].confidence for k in at])
            real = [
                said[k] == "error" or (said[k] == "doubtful" and rng.random() < 0.5) for k in at
            ]
            orders = representative_judging_order(confidence), np.argsort(-bad[at]).tolist()
            for name, order in zip(errors, orders, strict=True):
                asked = set(order[:ENOUGH_STATED])
                verdicts = [real[k] if k in asked else None for k in range(size)]
                stated = estimate_unjudged_precision(confidence, verdicts)
                assert stated is not None
                rest = float(np.mean([real[k] for k in range(size) if k not in asked]))
                errors[name].append(stated.share - rest)
                inside[name].append(stated.low <= rest <= stated.high)
        print(f"{size} corrections, {ENOUGH_STATED} verdicts, {DRAWS} folders:")
        for name, own in errors.items():
            print(
                f"  {name:<12} error {np.abs(own).mean():.3f}, bias {np.mean(own):+.3f}, "
                f"inside the 90 % range {np.mean(inside[name]):.0%}"
            )


if __name__ == "__main__":
    main()
