"""The program killed at a random moment, and what is on the disk then: for a test and a number."""

import contextlib
import hashlib
import os
import random
import shutil
import signal
import time
from pathlib import Path

from inspector.session.session_files import journals, session_path
from tests.conftest import ASSETS
from tests.gui import forked
from tests.gui.programs import Program
from tests.processes import children_of, is_alive, until
from twistcore.cli import main
from twistcore.formats.bvh import read_bvh
from twistcore.review import read_session, replay_journal, session_bytes
from twistcore.review.interrupted_export import interrupted_export_sentence, interrupted_exports

REVIEWER = Path(__file__).with_name("scripted_review.py")
OPENER = Path(__file__).with_name("opened_folder.py")
COMMANDS = 12
_PARTS = (".part", ".part.mp4")
_EXPORTED = ("bvh", "replay.json", "report.html", "intervals.csv", "markers.py", "report.json")


# -- in the midst of decisions ----------------------------------------------------------------


@contextlib.contextmanager
def reviewer(clip, seed, state_home, parent):
    words = [REVIEWER, clip, str(seed), str(COMMANDS)]
    process = forked.start(words, {**os.environ, "XDG_STATE_HOME": str(state_home)}, parent)
    try:
        yield process
        process.wait(60)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait(60)
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
        state = replay_journal(left[0]).review.state
    elif session.exists():
        state = read_session(session).state
    else:
        return None
    return hashlib.sha256(session_bytes(clip, state)).hexdigest()


def killed_twice_among_decisions(place, seed):
    """Twice in a row: the second run restores what the first one left."""
    folder = place / "clips"
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


# -- in the midst of an export ----------------------------------------------------------------


def killed_in_an_export(place, seed):
    """Each file of it is whole or not there; the next export leaves nothing half written.

    Every other seed's export replaces an earlier one, of fewer corrections.
    """
    folder = place / "clips"
    folder.mkdir()
    clip = Path(shutil.copy(ASSETS / "walk_injected.bvh", folder / "walk.bvh"))
    moment, earlier = random.Random(seed), seed % 2 == 1
    out, replay, *_ = written = [folder / f"walk_refined.{end}" for end in _EXPORTED]
    program = Program(clip, place / "state")
    try:
        program.tell("accept", "accept", *["export replace"] * earlier, "accept")
        program.process.stdin.write("export replace\n")
        program.process.stdin.flush()
        if moment.random() < 0.8:  # the files come within milliseconds of one another
            awaited = moment.choice(written)
            before = _number(awaited)
            until(lambda: _number(awaited) != before, 30.0, every_s=0.0)
            time.sleep(moment.uniform(0.0, 0.0005))
        else:
            time.sleep(moment.uniform(0.0, 0.3))
    finally:
        program.kill()
    if out.exists():
        assert read_bvh(out).motion.frames == read_bvh(clip).motion.frames
    if replay.exists():
        assert out.exists()
        accepted = len(read_session(replay).state.chosen())
        assert accepted in ((2, 3) if earlier else (3,))
        again = place / "again.bvh"
        assert main(["apply", str(replay), str(clip), "-o", str(again)]) == 0
        # The clip is written first: beside a new one may be what an earlier one was made by.
        assert again.read_bytes() == out.read_bytes() or (earlier and accepted == 2)
        if again.read_bytes() != out.read_bytes():
            assert interrupted_exports(clip) == [replay.name]
            assert "interrupted" in interrupted_export_sentence(replay)
    for path in folder.iterdir():
        if path.name.endswith(_PARTS):  # begun: it may have nothing in it yet
            assert path.name.startswith(".")
        else:
            assert path.stat().st_size, f"{path.name} is empty"
    program = Program(clip, place / "state")
    try:
        # An export ends with the session saved: one that came to its end left nothing to restore.
        if program.accepted < 3:
            program.tell("press Restore")
        assert program.accepted == 3
        program.tell("export replace", "export replace")
        assert "joints changed" in program.answer["says"], program.answer["says"]
        assert not interrupted_exports(clip)
        program.tell("save", "close")
        program.end()
    finally:
        program.kill()
    left = [path.name for path in folder.iterdir() if path.name.endswith(_PARTS)]
    assert not left, left


def _number(path):
    """Which file is there: another once it was replaced."""
    with contextlib.suppress(FileNotFoundError):
        return path.stat().st_ino
    return None


def equal_exports(place, seed, count=15):
    """Exports after seeded steps, each of the bytes that `twistcore apply` makes of its session."""
    folder = place / "clips"
    folder.mkdir()
    clip = Path(shutil.copy(ASSETS / "walk_injected.bvh", folder / "walk.bvh"))
    out, replay = (folder / f"walk_refined.{end}" for end in ("bvh", "replay.json"))
    again, step = place / "again.bvh", random.Random(seed)
    program = Program(clip, place / "state")
    try:
        for _ in range(count):
            left = program.answer["decisions"].count("undecided")
            wanted = ["undo", *["accept"] * 3] if left > 1 else ["undo"]
            program.tell(*step.choices(wanted, k=step.randint(1, 2 if left > 1 else 5)))
            out.unlink(missing_ok=True)
            program.tell("export replace")
            assert main(["apply", str(replay), str(clip), "-o", str(again), "-q"]) == 0
            assert again.read_bytes() == out.read_bytes()
    finally:
        program.kill()
    return count


# -- in the midst of a folder's analysis ------------------------------------------------------


def killed_with_a_folder(place, seed, clips=6, patience_s=120.0):
    """No process stays behind; how many there were."""
    folder = place / "clips"
    folder.mkdir()
    for k in range(clips):
        shutil.copy(ASSETS / "dance.bvh", folder / f"{k}.bvh")
    moment = random.Random(seed)
    environment = {**os.environ, "XDG_STATE_HOME": str(place / "state")}
    process = forked.start([OPENER, folder], environment)
    try:
        assert process.stdout.readline().strip() == "at work"
        time.sleep(moment.uniform(0.0, 1.5))
        children = children_of(process.pid)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait(60)
        process.close()
    until(lambda: not any(map(is_alive, children)), patience_s)
    return len(children)
