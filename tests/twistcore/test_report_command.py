"""`twistcore report` of a review: a page with what was decided, and what it refuses."""

import json

import pytest

from tests.twistcore import amc_files
from tests.twistcore.reviews import CLIP
from twistcore.analysis.clip_analysis import analyse
from twistcore.cli import main
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.review import Decide, Decision, Review, write_session


@pytest.fixture
def session(tmp_path):
    """A session whose first interval was accepted, beside its clip."""
    write_clip(CLIP, CLIP.motion, tmp_path / "take.bvh")
    clip = read_clip(tmp_path / "take.bvh")
    state = Review.of(analyse(clip).detect()).state
    first = state.intervals[0].id
    state = Decide((first,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(state)
    write_session(clip, state, tmp_path / "take.twist.json")
    return tmp_path / "take.twist.json"


def report(*words):
    return main(["report", *map(str, words), "--no-pictures"])


def test_the_page_of_a_session_says_what_was_decided(session, tmp_path, capsys):
    assert report(session, "-o", tmp_path / "out") == 0
    assert "take.report.html" in capsys.readouterr().out
    document = json.loads((tmp_path / "out" / "take.report.json").read_bytes())
    assert document["decisions"]["accepted"] == 1
    assert document["changed"]["frames"] > 0
    assert "1 decision by Kim" in (tmp_path / "out" / "take.report.html").read_text("utf-8")


def test_a_clip_that_was_moved_is_named(session, tmp_path, capsys):
    (tmp_path / "take.bvh").rename(tmp_path / "moved.bvh")
    assert report(session, "-o", tmp_path / "out") == 2
    assert "take.bvh" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert report(session, "-o", tmp_path / "out", "--clip", tmp_path / "moved.bvh") == 0
    assert (tmp_path / "out" / "moved.report.html").exists()


@pytest.mark.parametrize("place", ["clip", "file"])
def test_what_cannot_be_is_refused_in_a_line(session, tmp_path, capsys, place):
    """Another clip than that of the session, a file where a folder is to be."""
    (tmp_path / "file").write_text("mine")
    (tmp_path / "other.bvh").write_bytes(CLIP.data + b"\n")
    more = ["-o", tmp_path / "out", "--clip", tmp_path / "other.bvh"]
    assert report(session, *(more if place == "clip" else ["-o", tmp_path / "file"])) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out").exists()
    assert (tmp_path / "file").read_text() == "mine"


def test_the_page_of_another_clip_of_this_stem_is_not_replaced(session, tmp_path, capsys):
    """Another format has a name of its own; where names agree, refine refuses before it writes."""
    amc = amc_files.written(tmp_path, True).rename(tmp_path / "take.amc")
    (tmp_path / "capitals").mkdir()
    bvh = tmp_path / "capitals" / "take.BVH"
    bvh.write_bytes(CLIP.data + b"\n")
    assert report(session, "-o", tmp_path / "out") == 0
    before = {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()}
    capsys.readouterr()
    words = ["refine", bvh, "-o", tmp_path / "r.bvh", "--report", tmp_path / "out"]
    assert main([str(w) for w in words]) == 2
    told = capsys.readouterr().err
    assert "is the report of take.bvh; choose another folder for the report of take.BVH" in told
    assert len(told.splitlines()) == 1
    assert not (tmp_path / "r.bvh").exists()
    assert {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()} == before
    words = ["refine", amc, "-o", tmp_path / "r.amc", "--report", tmp_path / "out"]
    assert main([str(w) for w in words]) == 0
    assert (tmp_path / "out" / "take.amc.report.html").exists()
    assert before.items() <= {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()}.items()


def test_a_new_version_of_a_clip_and_a_renamed_one_replace_their_page(session, tmp_path):
    assert report(session, "-o", tmp_path / "out") == 0
    (tmp_path / "take.bvh").write_bytes(CLIP.data + b"\n")
    clip = read_clip(tmp_path / "take.bvh")
    write_session(clip, Review.of(analyse(clip).detect()).state, tmp_path / "take.twist.json")
    assert report(session, "-o", tmp_path / "out") == 0
    listing = tmp_path / "out" / "take.report.json"
    assert json.loads(listing.read_bytes())["sha256"] == clip.sha256
    (tmp_path / "take.bvh").rename(tmp_path / "take.BVH")
    assert report(session, "-o", tmp_path / "out", "--clip", tmp_path / "take.BVH") == 0
