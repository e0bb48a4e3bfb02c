"""Kinds of error: what each announces, and kinds that only a later version knows."""

import copy
import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from tests.twistcore.test_registry import run
from twistcore.detection.finding import finder_of
from twistcore.detection.interval import Interval
from twistcore.detection.kind import Kind, KindInfo
from twistcore.errors import TwistError

WALK = ASSETS / "walk_injected.bvh"
LATER = "Melted {wax}"


def test_a_kind_is_a_file_and_its_word():
    folder = Path(tc.detection.__file__).parent / "kinds"
    assert {kind.name.lower() for kind in Kind} == {p.stem for p in folder.glob("[a-z]*.py")}
    assert [kind.value for kind in Kind] == [
        *("counter-twist", "carried roll", "limb flip", "helper roll"),
        *(
            "lone jump",
            "stretch",
            "turned end",
            "spike",
            "backward bend",
            "joint jump",
            "place jump",
        ),
        "body step",
        *("noise burst", "frozen frames"),
    ]
    assert len(Kind) == 14
    for kind in Kind:
        assert Kind(kind.value.upper().replace(" ", "_")) is kind is getattr(Kind, kind.name)
        assert pickle.loads(pickle.dumps(kind)) is copy.deepcopy(kind) is kind
        assert (json.dumps(kind), f"{kind}") == (f'"{kind.value}"', kind.value)
        assert {kind: 1}[kind.value] == 1
    with pytest.raises(AttributeError):
        _ = Kind.MELTED_WAX


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
        Kind.CARRIED_ROLL: (True, True, False),
        Kind.LIMB_FLIP: (True, True, False),
        Kind.HELPER_ROLL: (True, False, False),
        Kind.LONE_JUMP: (False, False, False),
        Kind.STRETCH: (False, False, True),
        Kind.TURNED_END: (False, False, True),
        Kind.SPIKE: (False, False, True),
        Kind.BACKWARD_BEND: (False, False, True),
        Kind.JOINT_JUMP: (False, False, True),
        Kind.PLACE_JUMP: (False, False, True),
        Kind.BODY_STEP: (False, False, True),
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
    own.KIND = KindInfo("foot slide", "Foot slides", 35, of_capture=True, size="slide_mm")
    monkeypatch.setitem(sys.modules, own.__name__, own)
    import pkgutil

    every = [*pkgutil.iter_modules(tc.detection.kinds.__path__)]
    found = pkgutil.ModuleInfo(None, "foot_slide", False)
    monkeypatch.setattr(pkgutil, "iter_modules", lambda *_: [*every, found])
    known = module._known.__wrapped__()
    assert [*known][3:5] == ["HELPER_ROLL", "FOOT_SLIDE"]
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
    from twistcore.analysis.why_not import why_frame_bounds_no_interval

    state = tc.read_session(session).state
    analysis = tc.analyse(tc.read_clip(WALK))
    intervals = tuple(j.interval for j in state.intervals)
    found = Detection(analysis, "consistency", state.tau, intervals)
    interval = intervals[1]
    reason = why_frame_bounds_no_interval(found, interval.chain, interval.start + 1)
    assert f"{LATER} " in reason.text


# Where kinds and what finds them come from

PACKAGE = """
from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    "foot slide", "Foot slides", 35, of_capture=True, find="foot_slide_finder:find"
)
"""
FINDER = """
import numpy as np
from twistcore.detection import Interval, Kind

def find(search):
    name = search.chosen[0].name
    return {name: [Interval(name, 3, 5, np.zeros(2), open=True, kind=Kind("foot slide"))]}
"""


def site_with_kind(tmp_path, target="foot_slide:KIND", finder=FINDER):
    """As pip would have installed it."""
    site = tmp_path / "site"
    info = site / "foot_slide-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "foot_slide.py").write_text(PACKAGE)
    (site / "foot_slide_finder.py").write_text(finder)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: foot-slide\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[twistcore.kinds]\nfoot-slide = {target}\n")
    return site


def with_site(site, code):
    path = [str(site), str(Path(tc.__file__).parents[1])]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(path)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


LISTED = """
import sys
from twistcore.detection import Kind
print([kind.value for kind in Kind][3:6], Kind("foot slide").known)
assert "numpy" not in sys.modules and "foot_slide_finder" not in sys.modules
"""
DETECTED = f"""
import sys
import twistcore as tc
found = tc.detect(tc.read_clip({str(WALK)!r}), "LeftForeArm")
print([(i.chain, i.start, i.stop) for i in found if i.kind == "foot slide"])
only = tc.detect(tc.read_clip({str(WALK)!r}), kinds="foot slide")
print(len(only), tc.detect(tc.read_clip({str(WALK)!r})).to_rows()[0]["kind"])
"""


def test_a_package_brings_a_kind_and_what_finds_it(tmp_path):
    site = site_with_kind(tmp_path)
    assert with_site(site, LISTED)[0] == "['helper roll', 'foot slide', 'lone jump'] True\n"
    told = with_site(site, DETECTED)[0].splitlines()
    assert told == ["[('LeftForeArm', 3, 5)]", "1 foot slide"]


@pytest.mark.parametrize("target", ["no_such_module:KIND", "foot_slide:KindInfo"])
def test_a_kind_that_cannot_be_loaded_is_left_out_with_a_warning(tmp_path, target):
    out, err = with_site(site_with_kind(tmp_path, target), LISTED)
    assert out == "['helper roll', 'lone jump', 'stretch'] False\n"
    assert "the error kind 'foot-slide'" in err
    assert "is ignored" in err


@parametrize(
    "finder",
    [
        "def find(search): raise ValueError('no feet')",
        FINDER.replace("3, 5", "3, 900"),
        FINDER.replace('"foot slide"', '"frozen frames"'),
        "nothing = 1",
    ],
)
def test_a_finder_that_fails_is_a_note_and_hides_nothing_else(tmp_path, finder):
    code = f"""
import twistcore as tc
found = tc.detect(tc.read_clip({str(WALK)!r}))
assert len([i for i in found if i.kind == "counter-twist"]) == 8
(why,) = [str(note) for note in found.notes if "'foot slide'" in str(note)]
print(why.partition("'foot slide'")[0])
"""
    out, _ = with_site(site_with_kind(tmp_path, finder=finder), code)
    assert out == "the search for the error kind \n"


def test_every_kind_that_is_only_shown_names_what_finds_it():
    for kind in Kind:
        assert bool(kind.info.find) == (not kind.repairable)
        if kind.info.find:
            assert callable(finder_of(kind))


def test_errors_in_the_same_frames_are_always_listed_in_the_same_order(monkeypatch):
    def one_of(self, kind, method=""):
        own = (Interval("LeftArm", 3, 5, np.zeros(2), open=True, kind=kind),)
        return {c.name: own if c.name == "LeftArm" else () for c in self.chains}

    monkeypatch.setattr(tc.ClipAnalysis, "shown", one_of)
    shown = [kind for kind in Kind if kind.info.find]
    found = tc.detect(tc.read_clip(ASSETS / "walk.bvh"), kinds=reversed(shown))
    assert [i.kind for i in found] == shown
