"""The command that tries mutants, on a module of four lines."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mutmut", reason="the extra dev brings it")
pytest.importorskip("resource", reason="mutants are tried in forked processes")

ROOT = Path(__file__).parent.parent
MODULE = """
LIMIT = 3

@property
def never_run(x):
    return x + 1

def below(n):
    if n < 0:
        raise ValueError("a number below nothing")
    while n >= LIMIT:
        n -= 2
    return n
"""
TESTS = """
import small

def test_below():
    assert small.below(3) == 1
    assert small.below(2) == 2

def test_nothing():
    pass
"""


def mutation(folder, *options):
    (folder / "small.py").write_text(MODULE)
    (folder / "test_small.py").write_text(TESTS)
    path = os.pathsep.join([str(ROOT), *sys.path[1:], str(folder)])
    return subprocess.run(
        [
            sys.executable,
            *["-m", "benchmarks.mutation", "small.py", "--tests", "test_small.py"],
            *options,
        ],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=600,
    )


@pytest.mark.thorough
def test_what_no_test_sees_is_listed_and_the_rest_counted(tmp_path):
    done = mutation(tmp_path, "--least", "100")
    survivors = [line for line in done.stdout.splitlines() if line.startswith("small.py:")]
    assert "small.py:6: x + 1  →  x - 1" in survivors, done.stderr
    assert any(line.startswith("small.py:9: ") and "<= 0" in line for line in survivors)
    assert not any(line.startswith(("small.py:2:", "small.py:11:")) for line in survivors)
    assert "XXa number" not in done.stdout  # a sentence
    assert done.returncode == 1  # fewer than all were killed
    name, made, tried, killed, timeout, survived, *_ = done.stdout.splitlines()[-1].split()
    assert (name, made, tried) == ("small.py", tried, made)
    assert int(timeout) >= 1  # n += 2 never ends
    assert int(killed) + int(timeout) + int(survived) == int(tried)
    assert int(survived) == len(survivors)


@pytest.mark.thorough
def test_tests_that_fail_anyway_are_told(tmp_path):
    (tmp_path / "conftest.py").write_text("import nothing_that_exists\n")
    done = mutation(tmp_path)
    assert done.returncode == 2
    assert "nothing_that_exists" in done.stderr
    assert "test_small.py" in done.stderr
    assert not done.stdout
