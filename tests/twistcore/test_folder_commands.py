"""Commands that take folders: which files they take, and that a bad one stops no other."""

import json
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.tiers import parametrize
from tests.twistcore.reviews import CLIP, fresh
from tests.twistcore.test_cli import run
from twistcore.batch import survey_folder
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.formats.clip_files import (
    BVH,
    clip_paths_in_folder,
    clips_by_name,
    format_names_from_suffixes,
)
from twistcore.review import Decide, Decision, write_session
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence_folder

WALK = ASSETS / "walk.bvh"


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """A piece of the walk that takes little time."""
    path = tmp_path_factory.mktemp("cut") / "walk.bvh"
    write_motion(read_bvh(WALK).motion.sliced(0, 60), path)
    return path


@pytest.fixture
def odd(tmp_path, cut):
    """A folder with two good clips and all that a folder may have beside them."""
    folder = tmp_path / "odd"
    folder.mkdir()
    shutil.copy(cut, folder / "01_good.bvh")
    shutil.copy(cut, folder / "05_UPPER.BVH")
    (folder / "bad.bvh").write_bytes(b"PK\x03\x04 no BVH")
    (folder / "empty.bvh").touch()
    (folder / "astray.bvh").symlink_to("nowhere")
    (folder / "folder.bvh").mkdir()
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe.bvh")  # who reads it waits for good
    (folder / "notes.txt").touch()
    return folder


BAD = ("astray.bvh", "bad.bvh", "empty.bvh")
ALL = ("01_good.bvh", "05_UPPER.BVH", *BAD)


def test_the_clips_of_a_folder(odd):
    assert [path.name for path in clip_paths_in_folder(odd)] == list(ALL)
    shutil.move(odd / "05_UPPER.BVH", odd / "folder.bvh")
    assert len(clip_paths_in_folder(odd)) == len(ALL) - 1
    assert list(clips_by_name(odd)) == ["01_good.bvh", *BAD, "folder.bvh/05_UPPER.BVH"]
    assert clip_paths_in_folder(odd / "nowhere") == clip_paths_in_folder(odd / "bad.bvh") == []
    (odd / "folder.bvh" / "x.npz").touch()
    assert len(clip_paths_in_folder(odd / "folder.bvh", suffixes=BVH)) == 1
    assert len(clip_paths_in_folder(odd / "folder.bvh", suffixes=(".npz", ".amc"))) == 1
    with pytest.raises(TwistError, match="BVH or NPZ"):
        clips_by_name(odd / "bad.bvh", suffixes=(".bvh", ".npz"))


def listed(err):
    """The names of clips in sentences on standard error that say why not."""
    lines = [line for line in err.splitlines() if "expected" in line or "cannot be read" in line]
    return sorted({name for line in lines for name in ALL if name in line})


@parametrize(
    "words",
    [
        ("benchmark", "{}", "--seeds", "1", "--workers", "1", "--methods", "paper"),
        ("tune", "{}", "-o", "{}/../profile.toml", "--seeds", "1", "--workers", "1"),
    ],
    ids=lambda words: words[0],
)
def test_a_bad_file_stops_no_command(capsys, odd, words):
    code, _, err = run(capsys, *(word.format(odd) for word in words))
    assert (code, listed(err)) == (1, sorted(BAD)), err


def test_a_bad_file_stops_no_survey_and_no_study(odd):
    surveys = {s.path.name: s.problem for s in survey_folder(odd)}
    assert [name for name in ALL if surveys[name]] == list(BAD)
    sequences, problems = read_cmu_bvh_sequence_folder(odd)
    assert [s.subject for s in sequences] == ["01", "05"]
    assert listed("\n".join(problems)) == sorted(BAD)


# --- diff ------------------------------------------------------------------------------------


def test_two_folders_are_compared_clip_by_clip(capsys, tmp_path, odd, cut):
    a, b = odd, tmp_path / "b"
    (a / "sub").mkdir()
    (b / "sub").mkdir(parents=True)
    shutil.copy(cut, b / "01_good.bvh")
    (b / "05_UPPER.BVH").write_bytes(cut.read_bytes().replace(b"\n", b"\r\n"))
    motion = read_bvh(cut).motion
    shutil.copy(cut, a / "sub" / "walk.bvh")
    turned = motion.rotations.copy()
    turned[10:20, 5] = turned[0, 5]
    write_motion(replace(motion, rotations=turned), b / "sub" / "walk.bvh")
    shutil.copy(cut, b / "bad.bvh")
    (b / "empty.bvh").touch()
    shutil.copy(cut, b / "new.bvh")
    write_motion(motion.sliced(0, 30), a / "short.bvh")
    shutil.copy(cut, b / "short.bvh")
    code, out, err = run(capsys, "diff", a, b, "--json", "--workers", "1")
    found = json.loads(out)
    assert (code, found["schema"]) == (1, "twistcore.folder_diff/1")
    assert (found["only_a"], found["only_b"]) == (["astray.bvh"], ["new.bvh"])
    assert found["identical"] == ["01_good.bvh", "empty.bvh"]
    assert found["same_motion"] == ["05_UPPER.BVH"]
    (changed,) = found["different"]
    assert (changed["clip"], changed["frames"]) == ("sub/walk.bvh", 10)
    (joint,) = changed["joints"]
    assert (joint["joint"], joint["frames"]) == (motion.skeleton.names[5], 10)
    assert joint["max_deg"] == changed["max_deg"] > 0
    reasons = {entry["clip"]: entry["reason"] for entry in found["failed"]}
    fifo = ["pipe.bvh"] if hasattr(os, "mkfifo") else []
    assert list(reasons) == ["bad.bvh", *fifo, "short.bvh"]
    assert numbers(reasons["short.bvh"]) == [30, 60]
    assert all(reason in err for reason in reasons.values())
    code, out, _ = run(capsys, "diff", a, b, "--workers", "1")
    assert code == 1
    assert "sub/walk.bvh: 1 joint in 10 frames" in out
    assert numbers(out.splitlines()[-1])[:5] == [4, 2, 1, 1, 1]


def test_equal_folders_and_a_folder_beside_a_file(capsys, tmp_path, cut):
    code, out, _ = run(capsys, "diff", cut.parent, cut.parent, "--json", "--workers", "1")
    found = json.loads(out)
    assert (code, found["identical"], found["failed"]) == (0, ["walk.bvh"], [])
    code, _, err = run(capsys, "diff", cut.parent, cut)
    assert code == 2
    assert names_in_one_line(err, str(cut))
    code, _, err = run(capsys, "diff", cut.parent, tmp_path)
    assert code == 2
    assert names_in_one_line(err, f"{tmp_path}: ", format_names_from_suffixes())


# --- apply -----------------------------------------------------------------------------------


def judged(decide=True):
    review = fresh()
    for judged in review.state.intervals[:4]:
        if decide:
            review.do(Decide((judged.id,), Decision.ACCEPTED))
    return review.state


@pytest.fixture
def delivery(tmp_path):
    """Clips in folders, their sessions in another, and one of each that has no partner."""
    clips, sessions = tmp_path / "clips", tmp_path / "sessions"
    for k, name in enumerate(("one/walk.bvh", "two/WALK.BVH", "alone.bvh")):
        (clips / name).parent.mkdir(parents=True, exist_ok=True)
        data = CLIP.data if name != "alone.bvh" else WALK.read_bytes()
        (clips / name).write_bytes(data + b"\n" * k)  # bytes of its own
        if name != "alone.bvh":
            session = sessions / name
            session.parent.mkdir(parents=True)
            write_session(read_bvh(clips / name), judged(), session.with_suffix(".twist.json"))
    (sessions / "broken.twist.json").write_text("{")
    (sessions / "truth.json").write_text("{}")
    return clips, sessions, tmp_path / "out"


def apply(capsys, clips, sessions, out):
    return run(capsys, "apply", sessions, clips, "-o", out, "--workers", "1")


def files_of(folder):
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def test_sessions_of_a_folder_give_the_bytes_of_each_alone(capsys, delivery, tmp_path):
    clips, sessions, out = delivery
    code, said, err = apply(capsys, clips, sessions, out)
    assert code == 1
    assert [line for line in err.splitlines() if "broken" in line]
    assert numbers(said.splitlines()[-1]) == [8, 2, 1]
    assert files_of(out) == {"applied.jsonl", "one/walk.bvh", "two/WALK.BVH"}
    for name in ("one/walk.bvh", "two/WALK.BVH"):
        session = (sessions / name).with_suffix(".twist.json")
        assert run(capsys, "apply", session, clips / name, "-o", tmp_path / "single.bvh")[0] == 0
        assert (out / name).read_bytes() == (tmp_path / "single.bvh").read_bytes()
        assert (out / name).read_bytes() != (clips / name).read_bytes()


def test_a_session_is_replayed_on_the_source_though_its_export_has_the_same_bytes(capsys, delivery):
    clips, sessions, out = delivery
    (sessions / "broken.twist.json").unlink()
    source = (clips / "one" / "walk.bvh").rename(clips / "one" / "take.bvh")
    source.with_name("take_refined.bvh").write_bytes(source.read_bytes())  # nothing accepted
    code, said, _ = apply(capsys, clips, sessions, out)
    assert code == 0
    assert numbers(said.splitlines()[-1])[1:] == [2, 1]  # an export has no session
    assert files_of(out) == {"applied.jsonl", "one/take.bvh", "two/WALK.BVH"}


def test_what_is_there_is_replaced_only_where_the_command_wrote_it(capsys, delivery):
    clips, sessions, out = delivery
    (sessions / "broken.twist.json").unlink()
    (out / "two").mkdir(parents=True)
    (out / "two" / "WALK.BVH").write_bytes(b"of somebody")
    code, _, err = apply(capsys, clips, sessions, out)
    assert code == 1
    path = out / "two" / "WALK.BVH"
    assert str(path) in err
    assert path.read_bytes() == b"of somebody"
    path.unlink()
    assert apply(capsys, clips, sessions, out)[0] == 0
    times = {name: (out / name).stat().st_mtime_ns for name in files_of(out)}
    code, said, _ = apply(capsys, clips, sessions, out)
    assert (code, said.count("already there")) == (0, 2)
    assert times == {name: (out / name).stat().st_mtime_ns for name in files_of(out)}
    ours, session = out / "one" / "walk.bvh", sessions / "one" / "walk.twist.json"
    write_session(read_bvh(clips / "one" / "walk.bvh"), judged(decide=False), session)
    assert apply(capsys, clips, sessions, out)[0] == 0  # decided otherwise since
    assert ours.read_bytes() == (clips / "one" / "walk.bvh").read_bytes()
    ours.write_bytes(b"changed by hand")
    assert apply(capsys, clips, sessions, out)[0] == 1
    assert ours.read_bytes() == b"changed by hand"


def test_a_session_finds_its_clip_by_name_and_bytes(capsys, delivery):
    clips, sessions, out = delivery
    (sessions / "broken.twist.json").unlink()
    session = sessions / "two" / "WALK.twist.json"
    later = session.with_name("later.json")
    shutil.move(session, later)
    write_session(read_bvh(clips / "two" / "WALK.BVH"), judged(decide=False), session)
    os.utime(session, (1e9, 1e9))
    (clips / "two" / "WALK.BVH").rename(clips / "renamed.bvh")
    code, _, err = apply(capsys, clips, sessions, out)
    assert (code, f"{session}: note: " in err) == (0, True)
    assert (out / "renamed.bvh").read_bytes() != (clips / "renamed.bvh").read_bytes()
    later.unlink()
    shutil.copy(clips / "renamed.bvh", clips / "again.bvh")
    shutil.rmtree(out)
    code, _, err = apply(capsys, clips, sessions, out)
    assert (code, files_of(out)) == (1, {"applied.jsonl", "one/walk.bvh"})
    assert "identical to the clip of this session: again.bvh and renamed.bvh" in err
    (clips / "two").mkdir(exist_ok=True)
    shutil.copy(clips / "again.bvh", clips / "two" / "again.bvh")  # as the session lies
    assert apply(capsys, clips, sessions, out)[0] == 0
    assert "two/again.bvh" in files_of(out)


def test_another_version_of_a_clip_is_listed(capsys, delivery):
    clips, sessions, out = delivery
    shutil.copy(WALK, clips / "one" / "walk.bvh")
    (clips / "two" / "WALK.BVH").unlink()
    code, _, err = apply(capsys, clips, sessions, out)
    assert (code, files_of(out)) == (2, set())  # nothing could be done
    first, second, third = err.splitlines()[-3:]
    assert "broken.twist.json" in first
    assert names_in_one_line(second, "one/walk.bvh", "SHA-256")
    assert names_in_one_line(third, "'WALK.BVH'")


def test_folders_that_cannot_be_applied_are_refused(capsys, delivery, tmp_path):
    clips, sessions, out = delivery
    session = sessions / "one" / "walk.twist.json"
    for words, wrong in (
        ((clips, sessions, clips), clips),
        ((clips, session, out), session),
        ((clips / "alone.bvh", sessions, out), clips / "alone.bvh"),
        ((clips, clips, out), clips),
        ((clips, sessions, session), session),
    ):
        code, _, err = apply(capsys, *words)
        assert code == 2
        assert names_in_one_line(err, str(wrong))
    assert not out.exists()


def test_a_folder_in_that_of_the_clips_is_written_into_again_and_again(capsys, delivery):
    clips, sessions, _ = delivery
    (sessions / "broken.twist.json").unlink()
    for session in sessions.rglob("*.twist.json"):  # beside their clips
        shutil.move(session, clips / session.relative_to(sessions))
    for _ in range(2):
        code, said, _ = apply(capsys, clips, clips, clips / "out")
        assert (code, numbers(said.splitlines()[-1])[1:]) == (0, [2, 1])
    assert files_of(clips / "out") == {"applied.jsonl", "one/walk.bvh", "two/WALK.BVH"}


def test_a_record_of_another_program_is_not_taken_for_ours(capsys, delivery):
    clips, sessions, out = delivery
    out.mkdir()
    (out / "applied.jsonl").write_text('{"schema": "other/1"}\n')
    code, _, err = apply(capsys, clips, sessions, out)
    assert code == 2
    assert names_in_one_line(err, "applied.jsonl: ", "'twistcore.applied/1'")
    assert files_of(out) == {"applied.jsonl"}


def test_an_npz_of_other_data_is_no_clip(tmp_path):
    np.savez(tmp_path / "shape.npz", betas=np.zeros(16))
    with (tmp_path / "walk.NPZ").open("wb") as file:
        np.savez(file, poses=np.zeros((2, 66)))
    (tmp_path / "damaged.npz").write_bytes(b"PK\x03\x04")
    assert [path.name for path in clip_paths_in_folder(tmp_path)] == ["damaged.npz", "walk.NPZ"]
