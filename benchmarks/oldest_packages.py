"""Compare answers with the oldest and the newest packages that pyproject.toml allows.

python -m benchmarks.oldest_packages [--python VERSION] [TEST…]

Two environments with the core's packages are created in a temporary folder. In both, errors are
detected and corrected in the clips of assets/. If TESTs are given, they run with the oldest
packages. The exit code is 1 if a number differs by more than 1e-9, if a corrected file differs, or
if a test fails.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
DEPENDENCIES = ROOT / "pyproject.toml"
RESOLUTIONS = ("lowest-direct", "highest")
UNKNOWN_SETTING = "ignore:Unknown config option:pytest.PytestConfigWarning"
CLOSE = 1e-9  # rounding differs from release to release; answers have far fewer digits


def main() -> int:
    """Compare both environments, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", default="3.11", help="Python of both (default: %(default)s)")
    parser.add_argument("tests", nargs="*", metavar="TEST", help="a file of tests of the core")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for resolution in RESOLUTIONS:
            install(folder / resolution, resolution, arguments.python)
            answer(folder / resolution)
        wrong = list(differences(*(folder / resolution / "answers" for resolution in RESOLUTIONS)))
        print(*(wrong or ["The answers are the same."]), sep="\n")
        failed = run_tests(folder / RESOLUTIONS[0], arguments.tests) if arguments.tests else 0
    return 1 if wrong or failed else 0


def install(folder: Path, resolution: str, python: str) -> None:
    """Create an environment with the core's packages, and list their versions."""
    uv = [sys.executable, "-m", "uv"]
    subprocess.run([*uv, "venv", "--quiet", "--python", python, str(folder)], check=True)
    pip = [*uv, "pip", "install", "--quiet", "--python", str(folder), "--only-binary", ":all:"]
    subprocess.run(
        [*pip, "--resolution", resolution, "--requirement", str(DEPENDENCIES)], check=True
    )
    freeze = [*uv, "pip", "freeze", "--quiet", "--python", str(folder)]
    versions = subprocess.run(freeze, check=True, capture_output=True, text=True).stdout.split()
    print(f"{resolution}:", *versions, flush=True)
    subprocess.run([*pip, "pytest", "hypothesis"], check=True)


def answer(environment: Path) -> None:
    """Write the detections in each clip, and the corrected clip, to the folder `answers`."""
    (environment / "answers").mkdir()
    for clip in sorted((ROOT / "assets").glob("*.bvh")):
        to = environment / "answers" / clip.name
        detected = run(environment, "-m", "twistcore", "detect", str(clip), "--json")
        to.with_suffix(".json").write_bytes(detected)
        run(environment, "-m", "twistcore", "refine", str(clip), "-o", str(to))


def run(environment: Path, *words: str) -> bytes:
    """Run the environment's Python with the checkout's packages, and return its output."""
    python = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [str(python), *words]
    return subprocess.run(command, check=True, env=env, cwd=ROOT, stdout=subprocess.PIPE).stdout


def differences(old: Path, new: Path) -> Iterator[str]:
    """Yield a sentence for each file that differs between two folders."""
    for file in sorted(old.iterdir()):
        if file.suffix != ".json":
            if file.read_bytes() != (new / file.name).read_bytes():
                yield f"{file.name}: the corrected clip differs"
            continue
        one, other = (json.loads((place / file.name).read_bytes()) for place in (old, new))
        if (size := distance(one, other)) > CLOSE:
            yield f"{file.name}: the answers differ by {size:g}"


def distance(a: object, b: object) -> float:
    """Return the largest difference between numbers, or inf if the documents differ elsewhere."""
    if isinstance(a, dict) and isinstance(b, dict) and a.keys() == b.keys():
        return max((distance(a[key], b[key]) for key in a), default=0.0)
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return max(map(distance, a, b), default=0.0)
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b)
    return 0.0 if a == b else float("inf")


def run_tests(environment: Path, tests: list[str]) -> int:
    """Run tests of the core and return the exit status.

    The warnings about settings of pytest-qt are ignored, because pytest-qt is not installed.
    """
    words = ["-q", "-p", "no:cacheprovider", "-o", "addopts=", "-W", UNKNOWN_SETTING, *tests]
    try:
        print(run(environment, "-m", "pytest", *words).decode())
    except subprocess.CalledProcessError as error:
        print(error.stdout.decode())
        return error.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main())
