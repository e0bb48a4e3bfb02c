"""Measure whether the tests detect changes to the program.

    python -m benchmarks.mutation MODULE… [--sample N]

Each MODULE is a Python file or a folder of files, relative to the root of the checkout. Its mutants
(made with mutmut's operators: a sign changed, a number increased by one, an argument left out, …)
are tried one by one: a mutant is killed if a test fails, and survives if none does. A mutant that
slows a test to 3 s and four times its usual time also counts as detected ("timeout"). Survivors are
listed with their lines; the option --again tries listed mutants again with more tests.

Tests are chosen by coverage from the test files that TESTS, or --tests, names for the module. This
needs mutmut (the extra "dev") and a system that supports fork.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = (
    "1"  # set before numpy is imported; each mutant has one process and needs no threads
)

import argparse
import random
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks._mutant_tests import learn, outcomes
from benchmarks._mutants import Mutant, files_of, mutants_of

FOLDER = Path("tests/twistcore")
# The names of the tests for each file or folder; the longest matching path is used.
TESTS: dict[str, tuple[str, ...]] = {
    "twistcore/skeleton/rotation.py": ("rotation",),
    "twistcore/skeleton/chain.py": ("chain", "bone_directions", "limb"),
    "twistcore/skeleton/limb.py": ("limb",),
    "twistcore/analysis/correction/twist_removal.py": ("twist_removal",),
    "twistcore/analysis/correction": ("refinement", "proposal", "corrected"),
    "twistcore/analysis/correction/joint_repairs.py": ("joint_repairs", "turned_ends"),
    "twistcore/analysis/correction/protected_measures.py": ("protected_measures",),
    "twistcore/analysis/clip_severity.py": ("how_large", "batch", "all_joints", "unexamined"),
    "twistcore/batch/manifest.py": (
        "batch_inputs",
        "batch_run",
        "damaged_manifest",
        "merge",
        "stored_rows",
        "unexamined",
    ),
    "twistcore/batch/merging.py": ("merge",),
    "twistcore/batch/run.py": ("batch_run",),
    "twistcore/cli/clean_command.py": ("clean",),
    "twistcore/files/kinds.py": ("file_kinds",),
    "twistcore/formats/blender": ("convert",),
    "twistcore/formats/bvh": ("bvh_patch", "bvh", "bvh_numbers", "bvh_writing", "bvh_branch"),
    "twistcore/formats/bvh/patch.py": ("bvh_patch",),
    "twistcore/formats/bvh/rewriting.py": ("clean",),
    "twistcore/formats/bvh/header_places.py": ("clean",),
    "twistcore/formats/bvh/plain_numbers.py": ("plain_numbers", "bvh_numbers"),
    "twistcore/analysis/clip_analysis.py": ("analysis",),
    "twistcore/skeleton/signals.py": ("analysis", "detection"),
    "twistcore/analysis/decomposition": ("decomposition", "frame_correction"),
    "twistcore/detection/all_joints": ("all_joints", "strangers", "quantities"),
    "twistcore/detection/bends.py": ("plain_cuts",),
    "twistcore/detection/counter_twist/best_runs.py": ("best_runs",),
    "twistcore/detection/consistency/chain_analysis.py": ("chain_analysis", "lines_of_chains"),
    "twistcore/detection/consistency/confidence.py": ("chain_analysis",),
    "twistcore/detection/consistency/detector.py": (
        "lines_of_chains",
        "partly_compensated",
        "soft_intervals",
        "straight_limbs",
        "sureness",
    ),
    "twistcore/detection/counter_twist/counter_rotation.py": ("counter_rotation",),
    "twistcore/detection/counter_twist/coupling.py": ("coupling",),
    "twistcore/detection/cuts.py": ("plain_cuts", "cuts", "first_frames"),
    "twistcore/detection/counter_twist/edges.py": ("edges",),
    "twistcore/detection/evidence": ("evidence", "backward_bends"),
    "twistcore/detection/helper_rolls.py": ("carried_rolls", "quantities", "protected_finds"),
    "twistcore/detection/interval.py": ("intervals", "detection"),
    "twistcore/detection/leading_blend.py": ("plain_cuts", "first_frames"),
    "twistcore/detection/limbs.py": ("lines_of_chains",),
    "twistcore/detection/limb_flips": ("limb_jumps", "flip_runs", "limb_flips"),
    "twistcore/detection/lone_jumps.py": ("lone_jumps", "stretches", "quantities"),
    "twistcore/detection/natural_events.py": ("intervals",),
    "twistcore/detection/counter_twist/offsets.py": ("offsets",),
    "twistcore/detection/counter_twist/pairing.py": ("pairing", "clip_ends"),
    "twistcore/detection/noise_bursts.py": ("noise_bursts", "capture_faults", "quantities"),
    "twistcore/detection/paper.py": ("intervals",),
    "twistcore/detection/quantities": ("quantities", "turned_ends"),
    "twistcore/detection/registry.py": ("registry",),
    "twistcore/detection/guarded.py": ("registry",),
    "twistcore/detection/prediction.py": ("prediction",),
    "twistcore/detection/robust_cost.py": ("edges",),
    "twistcore/detection/soft_errors": (  # test_soft_errors.py takes minutes
        "one_soft_error",
        "silent_joints",
        "silent_errors",
        "explanations",
        "soft_search",
        "soft_doubts",
        "softened_level",
        "surprise",
        "departures",
        "stretch",
    ),
    "twistcore/detection/stretches.py": ("stretches", "joint_repairs", "quantities"),
    "twistcore/detection/straight_limbs": (
        "straight_spells",
        "straight_claims",
        "straight_jumps",
        "straight_limbs",
    ),
    "twistcore/skeleton/twist_increments.py": ("lines_of_chains",),
    "twistcore/export/compare.py": ("compare", "clean", "report_difference"),
    "twistcore/review": (
        "review_model",
        "review_steps",
        "found_again",
        "left_out",
        "journal",
        "review",
    ),
    "twistcore/review/agreement.py": ("agreement",),
    "twistcore/review/commands.py": (
        "review_model",
        "review_steps",
        "review_changes",
        "found_again",
    ),
    "twistcore/review/decisions.py": ("review_model", "review_steps", "review"),
    "twistcore/review/history.py": ("review_steps", "found_again"),
    "twistcore/review/journal.py": ("journal_entries", "journal"),
    "twistcore/review/left_out.py": ("review_steps", "left_out"),
    "twistcore/review/model.py": (
        "review_model",
        "review_steps",
        "review_changes",
        "found_again",
    ),
    "twistcore/review/other_chains.py": ("other_chains", "rig"),
    "twistcore/review/proposal.py": ("proposal",),
    "twistcore/review/reasons.py": ("found_again",),
    "twistcore/review/session.py": ("session_document", "journal_entries"),
    "twistcore/detection/soft_onset.py": ("soft_intervals",),
    "twistcore/tuning/verdict_counts.py": ("kind_verdicts",),
}
CHANGES = ("killed", "timeout", "survived")


def tests_of(path: Path) -> list[str]:
    """Return the test files for a module: those in TESTS, or those named like the module or folder.

    Raises ValueError if there are none.
    """
    fitting = [name for name in TESTS if path.as_posix().startswith(name)]
    if fitting:
        return [f"{FOLDER}/test_{name}.py" for name in TESTS[max(fitting, key=len)]]
    named = [FOLDER / f"test_{name}.py" for name in (path.stem, path.parent.name)]
    found = [str(p) for p in named if p.exists()]
    if not found:
        raise ValueError(f"{path}: name its tests with --tests")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the mutants, and return 0 on success.

    Returns 1 if fewer than --least per cent are killed, and 2 if none could be tried.
    """
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.mutation",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("modules", nargs="+", metavar="MODULE")
    parser.add_argument("--sample", type=int, help="number of random mutants (default: all)")
    parser.add_argument(
        "--together", action="store_true", help="one sample over all modules, not one of each"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample (0)")
    parser.add_argument("--tests", nargs="+", default=[], help="test files instead of TESTS")
    parser.add_argument(
        "--slowest", type=float, default=1.0, help="longer tests are left out (1 s)"
    )
    parser.add_argument(
        "--again", type=Path, help="an earlier run's output: only mutants listed there"
    )
    parser.add_argument("--jobs", type=int, default=1, help="mutants tried at once (1)")
    parser.add_argument("--least", type=float, default=0.0, help="per cent that must be killed (0)")
    options = parser.parse_args(arguments)
    try:
        made = {path: mutants_of(path) for path in files_of(options.modules)}
        tried = _sampled(made, options.sample, options.seed, options.together)
        if options.again:
            listed = set(options.again.read_text(encoding="utf-8").splitlines())
            tried = {path: [m for m in ms if str(m) in listed] for path, ms in tried.items()}
        rows = {}
        for path, mutants in tried.items():
            if mutants:
                tests = learn(path, options.tests or tests_of(path), options.slowest)
                rows[path] = _count(outcomes(mutants, tests, options.jobs), len(mutants))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    heads = f"{'mutants':>8} {'tried':>6} {'killed':>7} {'timeout':>8} {'survived':>9}   share"
    print(f"\n{'module':40} {heads}")
    total: Counter[str] = Counter()
    for path, counts in rows.items():
        total += counts
        print(_row(str(path), len(made[path]), counts))
    if len(rows) > 1:
        print(_row("all", sum(map(len, made.values())), total))
    return 0 if _share(total) >= options.least else 1


def _sampled(
    made: dict[Path, list[Mutant]], size: int | None, seed: int, together: bool
) -> dict[Path, list[Mutant]]:
    if size is None:
        return made
    pools = [[m for mutants in made.values() for m in mutants]] if together else made.values()
    rng = random.Random(seed)
    chosen = [m for pool in pools for m in rng.sample(pool, min(size, len(pool)))]
    return {path: [m for m in chosen if m.path == path] for path in made}


def _count(ended: Iterable[tuple[Mutant, str]], tried: int) -> Counter[str]:
    counts = Counter[str]()
    for mutant, outcome in ended:
        counts[outcome] += 1  # tqdm is not used, because its thread and lock would be forked
        if sys.stderr.isatty():
            print(f"\r{mutant.path}: {counts.total()} of {tried}", end="\r", file=sys.stderr)
        if outcome == "survived":
            print(mutant, flush=True)
    return counts


def _share(counts: Counter[str]) -> float:
    return 100.0 * (1.0 - counts["survived"] / max(counts.total(), 1))


def _row(name: str, mutants: int, counts: Counter[str]) -> str:
    killed, timeout, survived = (counts[c] for c in CHANGES)
    return (
        f"{name:40} {mutants:8} {counts.total():6} {killed:7} {timeout:8} {survived:9}"
        f"  {_share(counts):5.1f} %"
    )


if __name__ == "__main__":
    sys.exit(main())
