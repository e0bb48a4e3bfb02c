"""Combine the verdicts of two blind judges: python -m benchmarks.blind_verdicts DIR [--csv FILE].

DIR is a folder made by `python -m benchmarks.atlas FOLDER --blind DIR`. It contains a picture of
every detection, numbered at random and without set, clip, kind or confidence, and `key.csv`, which
the judges must not open. Each judge writes a table with the columns `number,verdict,why`, which is
called `first.csv` or `second.csv`.

A detection on which the judges differ counts as doubtful. The output shows Cohen's kappa over all
detections and over automatic corrections, and the verdicts by kind, by set and for automatic
corrections. It also compares the confidence, in bins, with the share of errors among errors and
alarms, and shows the expected calibration error (ECE). --csv writes a table like
docs/atlas-blind.csv. --figure plots the share of errors against the confidence.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.atlas import COLUMNS, VERDICTS, markdown, precision
from benchmarks.evidence import equal_bins
from twistcore.review.agreement import cohen_kappa
from twistcore.tuning.learned_confidence import Bin, expected_calibration_error

BINS = 5  # number of bins with equal numbers of detections


def agreed(first: str, second: str) -> str:
    """Return the verdict on which both judges agree, or 'doubtful' if they differ."""
    return first if first == second else "doubtful"


def reliability(rows: Iterable[Mapping[str, str]], bins: int = BINS) -> list[Bin]:
    """Return the share of errors among errors and alarms, in bins of similar confidence."""
    own = [r for r in rows if r["confidence"] and r["verdict"] in ("error", "alarm")]
    confidence = np.array([float(r["confidence"]) for r in own])
    return equal_bins(confidence, np.array([r["verdict"] == "error" for r in own]), bins)


def judged(folder: Path) -> list[dict[str, str]]:
    """Return the rows of the key with both verdicts. Raises ValueError for an unknown verdict."""
    key = {row["number"]: row for row in _rows(folder / "key.csv")}
    said = [_verdicts(folder / f"{name}.csv") for name in ("first", "second")]
    both = sorted(set(said[0]) & set(said[1]) & set(key), key=int)
    return [
        key[n]
        | {"first": said[0][n], "second": said[1][n], "verdict": agreed(said[0][n], said[1][n])}
        for n in both
    ]


def _verdicts(path: Path) -> dict[str, str]:
    out = {}
    for row in _rows(path):
        verdict = row["verdict"].strip()
        if verdict not in VERDICTS:
            said = f"{path.name}, number {row['number']}: {verdict!r} is not a verdict"
            raise ValueError(f"{said}; expected one of {', '.join(VERDICTS)}")
        out[str(int(row["number"]))] = verdict
    return out


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def picture(bins: Sequence[Bin], output: Path) -> None:
    """Plot the share of errors, with its 95 % interval, against the confidence."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(4.2, 3.6), dpi=96)
    axes.plot([0, 1], [0, 1], color="#8794a3", lw=1)
    x, y = [b.said for b in bins], [b.was for b in bins]
    spread = [[b.was - b.low for b in bins], [b.high - b.was for b in bins]]
    axes.errorbar(x, y, yerr=spread, fmt="o", color="#1668b3", capsize=3)
    for b in bins:
        axes.annotate(f" {b.count}", (b.said, b.was), fontsize=8, va="top")
    axes.set(xlabel="confidence", ylabel="share of errors", xlim=(0, 1), ylim=(0, 1.02))
    figure.tight_layout()
    figure.savefig(output)
    plt.close(figure)


def main(arguments: Sequence[str] | None = None) -> int:
    """Combine the verdicts of two judges and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args(arguments)
    rows = judged(given.folder)
    for name, own in (("all", rows), ("automatic", [r for r in rows if r["applied"] == "yes"])):
        value = cohen_kappa([r["first"] for r in own], [r["second"] for r in own])
        alike = sum(r["first"] == r["second"] for r in own)
        words = "undefined" if value is None else f"{value:.2f}"
        print(f"{name}: {len(own)} judged by both, {alike} equal, kappa {words}")
    for by in (("kind", "applied"), ("applied", "set"), ("set", "kind")):
        print(f"\n{markdown(precision(rows, *by))}")
    bins = reliability(r for r in rows if r["kind"] == "counter-twist")
    print()
    for b in bins:
        print(f"confidence {b.said:.2f}: {b.was:.2f} errors of {b.count}")
    print(f"ECE {expected_calibration_error(bins):.3f}")
    if given.csv:
        columns = (*COLUMNS, "confidence", "first", "second", "verdict", "why", "picture")
        with given.csv.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, columns, restval="", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)
    if given.figure:
        picture(bins, given.figure)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
