"""Measure the branch coverage of the tests.

    python -m benchmarks.branch_coverage [--html FOLDER] [WORD …]

The words are passed to `dev.py test` to select tests. Without words, all tests run. Every process
is measured, including workers, programs that are forked or started, and Qt's threads
(tests/conftest.py), but not processes that are killed. The output shows the share of covered
statements and branches, and of branches alone, for each package, and the modules with the most
uncovered ones. --html also shows every line. The exit code is 1 if the coverage of twistcore is
below 95 % or the coverage of inspector is below 88 %. A run takes twice as long as the tests.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
WANTED = {"twistcore": 95.0, "inspector": 88.0}
SHOWN = 25  # number of modules to list
CONFIGURATION = """
[run]
branch = True
parallel = True
source_pkgs = twistcore, inspector
data_file = {folder}/data
patch = subprocess, _exit, fork
concurrency = thread, multiprocessing
disable_warnings = no-data-collected, module-not-measured, module-not-imported, already-imported
[report]
exclude_also =
    if TYPE_CHECKING:
    @overload
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests and print the coverage. Return 0 if both packages reach their minimum."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--html", type=Path)
    given, words = parser.parse_known_args(arguments)
    with tempfile.TemporaryDirectory(prefix="branches-") as folder:
        rc = Path(folder, "coveragerc")
        rc.write_text(CONFIGURATION.format(folder=folder))
        environment = os.environ | {"COVERAGE_PROCESS_START": str(rc)}
        subprocess.run([sys.executable, "dev.py", "test", *words], cwd=ROOT, env=environment)
        told, coverage = Path(folder, "told.json"), [sys.executable, "-m", "coverage"]
        steps = [["combine", "-q"], ["json", "-q", "-i", "-o", str(told)]]
        steps += [["html", "-q", "-i", "-d", str(given.html.absolute())]] if given.html else []
        for step in steps:
            subprocess.run([*coverage, *step, f"--rcfile={rc}"], cwd=ROOT, check=True)
        files = json.loads(told.read_text())["files"]
    return tell({name: entry["summary"] for name, entry in files.items()})


def tell(files: Mapping[str, Mapping[str, int]]) -> int:
    """Print the coverage. Return 1 if a package is below its minimum.

    `files` has the summary that coverage gives for each file, keyed by path.
    """
    sums: dict[str, Counter[str]] = defaultdict(Counter)
    for name, of in files.items():
        sums[Path(name).parts[0]].update(of)
    for name, of in sorted(files.items(), key=lambda item: _gone(item[1]) - _all(item[1]))[:SHOWN]:
        print(f"{name}: {_all(of) - _gone(of)} of {_all(of)} not covered")
    shares = {package: 100 * _gone(of) / _all(of) for package, of in sorted(sums.items())}
    for package, share in shares.items():
        of = sums[package]
        branches = 100 * of["covered_branches"] / of["num_branches"]
        print(f"{package}: {share:.1f} % of {_all(of)}; of its branches {branches:.1f} %")
    return int(any(shares.get(package, 0.0) < wanted for package, wanted in WANTED.items()))


def _all(of: Mapping[str, int]) -> int:
    return of["num_statements"] + of["num_branches"]


def _gone(of: Mapping[str, int]) -> int:
    return of["covered_lines"] + of["covered_branches"]


if __name__ == "__main__":
    sys.exit(main())
