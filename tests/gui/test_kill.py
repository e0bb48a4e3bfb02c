"""kill -9 in the midst of a review: what was done is there again, and no file is half written."""

import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import ASSETS
from twistcore.bvh import read_bvh
from twistcore.review import read_session, recover, session_bytes

REVIEWER = Path(__file__).with_name("scripted_review.py")


def state_on_disk(clip_path, clip):
    """The review as a restart would find it: the journal, else the session."""
    session = clip_path.with_name(clip_path.stem + ".twist.json")
    journal = session.with_name(session.name + ".journal")
    if journal.exists():
        state = recover(journal).review.state
    elif session.exists():
        state = read_session(session).state
    else:
        return None
    return hashlib.sha256(session_bytes(clip, state)).hexdigest()


@pytest.mark.parametrize("seed", range(int(os.environ.get("TWIST_KILLS", "4"))))
def test_killed_at_a_random_moment(tmp_path, seed):
    clip_path = tmp_path / "walk.bvh"
    shutil.copy(ASSETS / "walk_injected.bvh", clip_path)
    clip = read_bvh(clip_path)
    words = [sys.executable, str(REVIEWER), str(clip_path), str(seed)]
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as process:
        told = [process.stdout.readline().strip()]
        commands = random.Random(seed).randint(2, 25)
        while len(told) < commands:
            told.append(process.stdout.readline().strip())
        time.sleep(random.Random(seed + 1000).uniform(0.0, 0.03))
        process.send_signal(signal.SIGKILL)
        told += [line.strip() for line in process.stdout.read().split("\n") if len(line) == 64]
    assert all(len(line) == 64 for line in told)
    found = state_on_disk(clip_path, clip)
    # The command under way when the program died may or may not have reached the disk.
    if found is None:
        assert set(told) == {told[0]}, "decisions were made, but nothing is on disk"
    elif found != told[-1]:
        assert found not in told, "an older state than the last command executed"
    for path in tmp_path.iterdir():
        assert not path.name.endswith(".part") or path.name.startswith(".")
    out = tmp_path / "out.bvh"
    if out.exists():
        assert read_bvh(out).motion.frames == 344
    assert clip_path.read_bytes() == (ASSETS / "walk_injected.bvh").read_bytes()
