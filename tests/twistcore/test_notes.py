"""Notes of an analysis: every command shows each of them once."""

import json

import pytest

from tests.twistcore.test_first_frames import blended
from twistcore import analyse, read_clip
from twistcore.batch import Manifest
from twistcore.cli import main
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.formats.bvh.compose import write_motion
from twistcore.skeleton.notes import Note


@pytest.fixture(scope="module")
def clip(walk, tmp_path_factory):
    """A file whose first frames are a blend, and the note about it."""
    capture = walk.motion.sliced(count_leading_rest_frames(walk.motion), walk.motion.frames)
    path = tmp_path_factory.mktemp("notes") / "blend.bvh"
    write_motion(blended(capture, 10), path)
    (note,) = analyse(read_clip(path)).notes
    assert (note.kind, note.text.startswith("Frames 0–")) == ("border", True)
    return path, note


def test_a_clip_without_anything_to_know_has_no_notes(walk):
    assert analyse(walk).notes == ()


def test_a_note_is_its_sentence():
    note = Note("border", "Frames 0–9 are no capture.")
    assert (str(note), note.to_json()) == (note.text, {"kind": note.kind, "text": note.text})


@pytest.mark.parametrize("command", ["info", "detect", "refine"])
def test_commands_print_a_note_once(capsys, tmp_path, clip, command):
    path, note = clip
    more = ["-o", str(tmp_path / "out.bvh")] if command == "refine" else []
    assert main([command, str(path), *more]) == 0
    out, err = capsys.readouterr()
    assert (out + err).count(note.text) == 1
    assert main([command, str(path), *more, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    if command == "detect":
        assert document["notes"] == [note.to_json()]
    else:
        (sentence,) = document["warnings" if command == "info" else "notes"]
        assert note.text in sentence


@pytest.mark.usefixtures("batch_here")
def test_a_batch_and_the_report_show_it_once(capsys, tmp_path, clip):
    path, note = clip
    assert main(["batch", str(path), "-o", str(tmp_path / "out"), "--workers", "1"]) == 0
    with Manifest.open(tmp_path / "out") as manifest:
        (record,) = manifest.each_record()
    assert record.result["warnings"] == [note.text]
    report = tmp_path / "report"
    assert main(["refine", str(path), "-o", str(tmp_path / "r.bvh"), "--report", str(report)]) == 0
    (page,) = report.glob("*.html")
    (document,) = report.glob("*.json")
    assert page.read_text("utf-8").count(note.text) == 1
    assert json.loads(document.read_text("utf-8"))["warnings"] == [note.text]
    capsys.readouterr()
