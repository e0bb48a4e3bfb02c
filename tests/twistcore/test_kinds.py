"""Kinds of error: what each announces, and kinds that only a later version knows."""

import copy
import json
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.test_registry import run
from twistcore.detection.kind import Kind, KindInfo
from twistcore.errors import TwistError

WALK = ASSETS / "walk_injected.bvh"
LATER = "Carried {roll}"


def test_a_kind_is_a_file_and_its_word():
    folder = Path(tc.detection.__file__).parent / "kinds"
    assert {kind.name.lower() for kind in Kind} == {p.stem for p in folder.glob("[a-z]*.py")}
    assert [kind.value for kind in Kind] == [
        *("counter-twist", "limb flip", "helper roll"),
        *("lone jump", "noise burst", "frozen frames"),
    ]
    assert len(Kind) == 6
    for kind in Kind:
        assert Kind(kind.value.upper().replace(" ", "_")) is kind is getattr(Kind, kind.name)
        assert pickle.loads(pickle.dumps(kind)) is copy.deepcopy(kind) is kind
        assert (json.dumps(kind), f"{kind}") == (f'"{kind.value}"', kind.value)
        assert {kind: 1}[kind.value] == 1
    with pytest.raises(AttributeError):
        _ = Kind.CARRIED_ROLL


def test_kinds_are_known_without_numpy():
    code = """
import sys
from twistcore.detection import Kind
assert Kind.FROZEN.of_capture and not Kind.FROZEN.repairable
assert "numpy" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_may_be_done_about_a_kind():
    kinds = {kind: (kind.repairable, kind.info.automatic, kind.of_capture) for kind in Kind}
    assert kinds == {
        Kind.COUNTER_TWIST: (True, True, False),
        Kind.LIMB_FLIP: (True, True, False),
        Kind.HELPER_ROLL: (True, False, False),
        Kind.LONE_JUMP: (False, False, False),
        Kind.NOISE_BURST: (False, False, True),
        Kind.FROZEN: (False, False, True),
    }


def test_a_word_of_no_kind_is_one_that_is_shown():
    kind = Kind(LATER)
    assert (kind.known, kind.repairable, kind.of_capture, kind.value) == (
        False,
        False,
        False,
        LATER,
    )
    assert kind not in set(Kind)
    assert kind is Kind(LATER) is pickle.loads(pickle.dumps(kind))
    assert repr(kind) == f"<Kind: {LATER!r}>"
    assert kind.info.here.format(frames="1–2", size="", joint="") == f"{LATER} 1–2"
    with pytest.raises(TwistError, match=LATER):
        tc.detect(tc.read_clip(WALK), kinds=LATER)


def test_another_kind_is_one_file(monkeypatch):
    """As a file beside the others would have it, in its place among them."""
    from types import ModuleType

    from twistcore.detection import kind as module

    own = ModuleType("twistcore.detection.kinds.foot_slide")
    own.KIND = KindInfo("foot slide", "Foot slides", "slide", 35, of_capture=True, size="slide_mm")
    monkeypatch.setitem(sys.modules, own.__name__, own)
    import pkgutil

    every = [*pkgutil.iter_modules(tc.detection.kinds.__path__)]
    found = pkgutil.ModuleInfo(None, "foot_slide", False)
    monkeypatch.setattr(pkgutil, "iter_modules", lambda *_: [*every, found])
    known = module._known.__wrapped__()
    assert [*known][2:4] == ["HELPER_ROLL", "FOOT_SLIDE"]
    assert known["FOOT_SLIDE"].of_capture
    assert known["FOOT_SLIDE"].name == "FOOT_SLIDE"


# In a session of a later version


@pytest.fixture
def session(tmp_path):
    """Eight accepted intervals, of which the second is of a kind that nobody knows yet."""
    clip = tc.read_clip(WALK)
    review = tc.Review(tc.detect(clip))
    review.accept()
    path = tmp_path / "walk.twist.json"
    tc.write_session(clip, review, path)
    document = json.loads(path.read_text("utf-8"))
    document["schema"] = "twistcore.session/3"
    for entry in document["intervals"]:
        entry |= {"kind": "counter-twist", "carried": False, "joint": ""}
    document["intervals"][1] |= {"kind": LATER, "joint": "Hips"}
    path.write_text(json.dumps(document), "utf-8")
    return path


def test_it_is_kept_as_it_is_when_the_session_is_written_again(session, tmp_path):
    before = json.loads(session.read_text("utf-8"))["intervals"][1]
    read = tc.read_session(session)
    again = tmp_path / "again.twist.json"
    tc.write_session(tc.read_clip(WALK), read.state, again)
    assert json.loads(again.read_text("utf-8"))["intervals"][1] == before
    assert len(read.state.chosen()) == 7


def test_it_is_never_repaired_and_the_commands_say_so(session, tmp_path):
    out = tmp_path / "out.bvh"
    code, _, err = run("apply", session, WALK, "-o", out)
    assert code == 1
    assert names_in_one_line(err, f"{WALK}: ", LATER)
    interval = tc.read_session(session).state.intervals[1].interval
    clip, after = tc.read_clip(WALK), tc.read_clip(out)
    own = next(c for c in tc.find_chains(clip) if c.name == interval.chain)
    frames = slice(interval.start, interval.stop)
    same = (clip.motion.rotations == after.motion.rotations)[frames][:, [own.parent, own.child]]
    assert same.all()
    code, _, err = run("report", session, "-o", tmp_path / "pages", "--clip", WALK, "--no-pictures")
    assert (code, err) == (0, "")
    (page,) = (tmp_path / "pages").glob("*.html")
    assert LATER in page.read_text("utf-8")
    code, out, _ = run("apply", session, WALK, "-o", tmp_path / "o.bvh", "--json")
    assert json.loads(out)["intervals"][1]["kind"] == LATER


def test_why_not_speaks_of_it(session):
    from twistcore.analysis.clip_analysis import Detection
    from twistcore.analysis.why_not import why_not

    state = tc.read_session(session).state
    analysis = tc.analyse(tc.read_clip(WALK))
    intervals = tuple(j.interval for j in state.intervals)
    found = Detection(analysis, "consistency", state.tau, intervals)
    interval = intervals[1]
    reason = why_not(found, interval.chain, interval.start + 1)
    assert f"{LATER} " in reason.text
