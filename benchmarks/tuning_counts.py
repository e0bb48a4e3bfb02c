"""Compare the numbers of the tuning page with ``twistcore detect --tau`` and the verdicts.

    python -m benchmarks.tuning_counts CLIP… [--inject]

Random verdicts are given on some of each clip's intervals. At several τ, the command lists the
intervals, and this script counts listed, automatic and rejected ones independently of the program.
Then it compares these numbers with the page. `--inject` injects errors into the clips first.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Kind
from twistcore.formats.reading import read_clip
from twistcore.review import Decide, Decision, Review
from twistcore.tuning import GRID, prepare_clip_tuning
from twistcore.tuning.listed_intervals import count_counter_twists_at_tau
from twistcore.tuning.verdicts_of import counter_twist_verdicts_of_review

SURE_ENOUGH = 0.5  # the default confidence of automatic corrections according to docs/guide.md
PLACES = (0, 3, 10, 18, 26, 34)  # indices in the grid of τ, from 0.1° to about 20°
Counts = tuple[int, int, int]  # listed, automatic, rejected


def listed_by_command(clip: Path, degrees: float) -> list[dict[str, Any]]:
    """Return the counter-twists that the command lists at a τ in degrees."""
    words = [sys.executable, "-m", "twistcore", "detect", str(clip), "--json", "--tau"]
    done = subprocess.run(
        [*words, repr(degrees)], check=True, capture_output=True, text=True, encoding="utf-8"
    )
    return [i for i in json.loads(done.stdout)["intervals"] if i["kind"] == "counter-twist"]


def recounted(
    rows: Sequence[dict[str, Any]], judged: Sequence[tuple[str, int, int, bool]], chain: str
) -> Counts:
    """Return the numbers of listed, automatic and rejected intervals of a chain.

    `rows` are the listed intervals. `judged` has the chain and the span of each verdict, with True
    for an accepted interval.
    """
    own = [row for row in rows if row["chain"] == chain]
    rejected = 0
    for row in own:
        best = {True: 0, False: 0}
        for name, start, stop, error in judged:
            if name == chain:
                frames = len(set(range(row["start"], row["stop"])) & set(range(start, stop)))
                best[error] = max(best[error], frames)
        rejected += best[False] > best[True]
    automatic = sum(not row["open"] and row["confidence"] >= SURE_ENOUGH for row in own)
    return len(own), automatic, rejected


def differences(path: Path, places: Sequence[int] = PLACES) -> tuple[int, int, list[str]]:
    """Compare the numbers for one clip.

    Returns how many numbers were compared, the number of false alarms, and a sentence for each
    difference.
    """
    clip = read_clip(path)
    analysis = analyse(clip)
    low = float(np.degrees(GRID[places[1]]))
    review = Review.of(analysis.detect(tau_degrees=low))
    rng = np.random.default_rng(sum(map(ord, clip.name)))
    judged = []
    for one in review.state.intervals:
        if one.interval.kind == Kind.COUNTER_TWIST and rng.random() < 0.8:
            error = bool(rng.random() < 0.4)
            decision = Decision.ACCEPTED if error else Decision.REJECTED
            review.do(Decide((one.id,), decision, "a reviewer", "2026-01-01T00:00:00"))
            judged.append((one.interval.chain, one.interval.start, one.interval.stop, error))
    verdicts = counter_twist_verdicts_of_review(review.state)
    measured = prepare_clip_tuning(clip.motion, clip.name, seeds=(), verdicts=verdicts)
    curves = {name: measured.curve(name).counts for name in measured.names}
    detector, compared, alarms, said = analysis.detector(), 0, 0, []
    for place in places:
        tau = float(GRID[place])
        rows = listed_by_command(path, float(np.degrees(tau)))
        for name in measured.names:
            expected = recounted(rows, judged, name)
            now = count_counter_twists_at_tau(detector, name, tau, verdicts, measured.left_out)
            shown = tuple(map(int, vars(now).values()))  # for any τ, not only the grid's
            counts = curves[name]
            drawn = tuple(int(np.asarray(c)[place]) for c in vars(counts).values())
            compared, alarms = compared + 6, alarms + expected[2]
            if not expected == shown == drawn:
                at = f"{path.name} {name} τ {np.degrees(tau):.2f}°"
                said.append(f"{at}: {expected} by the command, {shown} shown, {drawn} drawn")
    return compared, alarms, said


def with_errors(path: Path, folder: Path) -> Path:
    """Return a copy of a clip with injected errors."""
    dirty, truth = folder / path.name, folder / f"{path.stem}.truth.json"
    words = [sys.executable, "-m", "twistcore", "inject", str(path), "-o", str(dirty)]
    words += ["--truth", str(truth), "--seed", "47", "--protocol", "H6"]
    subprocess.run(words, check=True, capture_output=True)
    return dirty


def main() -> int:
    """Compare all clips. Return 1 if a number differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clips", nargs="+", type=Path)
    parser.add_argument("--inject", action="store_true", help="put errors into the clips first")
    arguments = parser.parse_args()
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for path in arguments.clips:
            clip = with_errors(path, Path(folder)) if arguments.inject else path
            compared, alarms, said = differences(clip)
            print(f"{path.name}: {compared} numbers compared, {alarms} false alarms among them")
            for line in said:
                print(f"  differs: {line}")
            wrong += len(said)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
