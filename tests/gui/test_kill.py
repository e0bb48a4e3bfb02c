"""kill -9 in the midst of a review: what was done is there again, and no file is half written."""

import contextlib
import hashlib
import os
import random
import shutil
import signal
import time
from pathlib import Path

import pytest

from inspector.session.session_files import journals, session_path
from tests.conftest import ASSETS
from tests.gui import forked
from twistcore.bvh import read_bvh
from twistcore.review import read_session, recover, session_bytes

REVIEWER = Path(__file__).with_name("scripted_review.py")
COMMANDS = 27


@contextlib.contextmanager
def reviewer(clip, seed, state_home, parent):
    words = [REVIEWER, clip, str(seed), str(COMMANDS)]
    process = forked.start(words, {**os.environ, "XDG_STATE_HOME": str(state_home)}, parent)
    try:
        yield process
        process.wait(30)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait(30)
        process.close()


def whole_run(clip, seed, folder):
    """Hashes of all states that a run makes; the folder is afterwards as it was."""
    kept = folder.with_name("kept")
    shutil.copytree(folder, kept)
    with reviewer(clip, seed, folder, parent=0) as process:
        told = process.stdout.read().split()
    assert process.returncode == 0
    shutil.rmtree(folder)
    kept.rename(folder)
    return told


def killed_run(clip, seed, folder, moment):
    """Hashes told by a run that was killed at a random moment."""
    with reviewer(clip, seed, folder, parent=1) as process:
        told = [process.stdout.readline().strip()]
        commands = moment.randint(2, COMMANDS - 2)
        while len(told) < commands:
            told.append(process.stdout.readline().strip())
        time.sleep(moment.uniform(0.0, 0.03))
        process.send_signal(signal.SIGKILL)
        told += [line.strip() for line in process.stdout.read().split("\n") if len(line) == 64]
    return told


def state_on_disk(clip):
    """The review as a restart would find it: the journal, else the session, else untouched."""
    session = session_path(clip.path)
    left = journals(session)
    assert len(left) <= 1  # the second run went on in the first one's
    # One that died before its first line was whole holds nothing: a restart takes it away.
    if left and b"\n" in left[0].read_bytes():
        state = recover(left[0]).review.state
    elif session.exists():
        state = read_session(session).state
    else:
        return None
    return hashlib.sha256(session_bytes(clip, state)).hexdigest()


@pytest.mark.parametrize("seed", range(int(os.environ.get("TWIST_KILLS", "3"))))
def test_killed_at_random_moments(tmp_path, seed):
    """Twice in a row: the second run restores what the first one left."""
    folder = tmp_path / "clips"
    folder.mkdir()
    source = ASSETS / ("kick.bvh" if seed % 2 else "walk_injected.bvh")
    clip_path = Path(shutil.copy(source, folder / "walk.bvh"))
    clip = read_bvh(clip_path)
    moment = random.Random(seed + 1000)
    found = None
    for turn in range(2):
        states = whole_run(clip_path, 2 * seed + turn, folder)
        assert len(states) == COMMANDS + 1
        assert found in (None, states[0]), "the restart found another state than the disk has"
        told = killed_run(clip_path, 2 * seed + turn, folder, moment)
        assert told == states[: len(told)]
        found = state_on_disk(clip)
        # The command under way when the program died may or may not have reached the disk: the
        # state is the last one told or the next one, and no other.
        if found is None:
            assert set(told) == {states[0]}, "decisions were made, but nothing is on disk"
        else:
            assert found in states[len(told) - 1 : len(told) + 1]
        for path in folder.iterdir():
            assert not path.name.endswith(".part") or path.name.startswith(".")
        if (out := folder / "out.bvh").exists():
            assert read_bvh(out).motion.frames == clip.motion.frames
        assert clip_path.read_bytes() == source.read_bytes()
