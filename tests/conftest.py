"""What many tests need: the sample clips and small skeletons made in memory."""

import atexit
import os
import shutil
import signal
import sys
import tempfile
import threading
from pathlib import Path

import pytest
from hypothesis import settings

from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.work.processes import map_in_processes

# A machine that is busy with something else is no reason to fail. The examples of properties are
# the same in every run, a quarter of them in the quick one; TWIST_INSPECTOR_EXAMPLES=random takes
# others, and a failure prints its own.
settings.register_profile("quick", deadline=None, derandomize=True, max_examples=25)
settings.register_profile("patient", deadline=None, derandomize=True, max_examples=100)
settings.register_profile("random", deadline=None, derandomize=False, print_blob=True)
_usual = "patient" if os.environ.get("CI") else "quick"
settings.load_profile(os.environ.get("TWIST_INSPECTOR_EXAMPLES", _usual))

# Under nohup programs are deaf to it; tests send it to those that they start.
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# A tool that measures what is run hears of Python's threads by itself, of Qt's not.
if heard := threading.gettrace():
    from inspector.widgets import background

    def run_heard(runner: background._Runner, run=background._Runner.run) -> None:
        sys.settrace(heard)
        run(runner)

    background._Runner.run = run_heard

# A copy: reviews leave sessions and journals beside their clips, and assets/ is not for that.
ASSETS = Path(tempfile.mkdtemp(prefix="twist-assets-"))
shutil.copytree(Path(__file__).parent.parent / "assets", ASSETS, dirs_exist_ok=True)
atexit.register(shutil.rmtree, ASSETS, ignore_errors=True)


@pytest.fixture(scope="session")
def walk() -> Clip:
    return read_bvh(ASSETS / "walk.bvh")


@pytest.fixture(scope="session")
def dirty_walk() -> Clip:
    return read_bvh(ASSETS / "walk_injected.bvh")


@pytest.fixture
def batch_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """`twistcore batch` takes clips in this process, because to start another takes a second."""
    from twistcore.batch.clip_task import run_task

    def in_this_process(tasks, seconds, *, workers):
        return map_in_processes(run_task, tasks, 1)

    monkeypatch.setattr("twistcore.cli.batch_command._in_processes", in_this_process)


@pytest.fixture(scope="session", params=["walk", "dance", "basketball", "walk_injected"])
def sample(request: pytest.FixtureRequest) -> Clip:
    return read_bvh(ASSETS / f"{request.param}.bvh")
