"""Files of an exercise for a class: which are written, and which are refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from inspector.lessons.classroom import open_for_student, score_answers, write_for_class
from tests.conftest import ASSETS
from twistcore.errors import ClipMismatchError, FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import changed_rotations
from twistcore.study.class_exercise import StudentAnswer, write_student_answer
from twistcore.synthesis.truth import read_truth, write_truth

WALK = ASSETS / "walk.bvh"


def test_every_exercise_has_a_clip_and_a_key_of_its_own(tmp_path):
    for k in (1, 2):
        clip, key = write_for_class(WALK, tmp_path / f"class.{k}.json", k, "judge")
        assert (clip.name, key.name) == (f"class.{k}.bvh", f"class.{k}.key.json")
    for k in (1, 2):
        assert read_truth(tmp_path / f"class.{k}.key.json").seed == k
        (tmp_path / f"opened.{k}").mkdir()
        open_for_student(tmp_path / f"class.{k}.json", tmp_path / f"opened.{k}")


@pytest.mark.parametrize("there", ["class.bvh", "class.key.json"])
def test_nothing_is_replaced_unasked(tmp_path, there):
    (tmp_path / there).write_bytes(b"mine")
    with pytest.raises(FormatError, match=rf"class\.json: .*{there}"):
        write_for_class(WALK, tmp_path / "class.json", 1, "judge")
    assert [path.name for path in tmp_path.iterdir()] == [there]
    assert (tmp_path / there).read_bytes() == b"mine"


@pytest.mark.parametrize("name", ["x.key.json", "x.KEY.json", "x.key"])
def test_an_exercise_is_never_named_as_a_key(tmp_path, name):
    with pytest.raises(FormatError, match=r"key"):
        write_for_class(WALK, tmp_path / name, 1, "judge")
    assert list(tmp_path.iterdir()) == []


def test_what_the_class_gets_does_not_tell_the_errors(tmp_path):
    clip, key = write_for_class(WALK, tmp_path / "class.json", 5, "judge")
    source, written = read_bvh(WALK), read_bvh(clip)
    turns = np.array([layout.rotation for layout in source.channels])
    rows = clip.read_text().splitlines()[-len(source.values) :]
    tokens = np.array([row.split() for row in rows])[:, turns]
    assert len({len(token.partition(".")[2]) for token in tokens.ravel()}) == 1
    moved = np.ptp(source.values[1:, turns], axis=0).all(axis=-1)
    rewritten = changed_rotations(source, written.motion)[1:, moved]
    assert rewritten.mean() > 0.95  # of who compares it with the original, bit for bit
    exercise = json.loads((tmp_path / "class.json").read_text())
    assert len(read_truth(key).errors) < len(exercise["intervals"])


def handed_in(path, name, clip, sha256):
    write_student_answer(path, StudentAnswer(name, 1.0, clip, sha256, ()))
    return path


def test_a_score_is_of_the_very_exercise(tmp_path):
    clip, key = write_for_class(WALK, tmp_path / "class.json", 1, "judge")
    mark = read_bvh(clip).sha256
    good = handed_in(tmp_path / "ada.json", "Ada", clip.name, mark)
    assert score_answers([key, good]).splitlines()[1].startswith("Ada,0,")
    # Another exercise of the same name, of another seed.
    (tmp_path / "other").mkdir()
    other, its_key = write_for_class(WALK, tmp_path / "other" / "class.json", 2, "judge")
    assert other.name == clip.name
    for wrong in ("zzz", read_bvh(other).sha256):
        kim = handed_in(tmp_path / "kim.json", "Kim", clip.name, wrong)
        with pytest.raises(ClipMismatchError, match=r"kim\.json"):
            score_answers([key, good, kim])
    with pytest.raises(ClipMismatchError, match=r"ada\.json"):
        score_answers([its_key, good])
    # A truth file that is no key does not know its clip.
    write_truth(key, replace(read_truth(key), sha256=""))
    assert "sha256" not in json.loads(key.read_text())
    with pytest.raises(FormatError, match="key"):
        score_answers([key, good])
