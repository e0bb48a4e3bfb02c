"""What a person meets who imports twistcore in a notebook."""

import re
import shutil
import threading
import time
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import twistcore as tc
import twistcore.analysis.clip_analysis as core
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.twistcore.reviews import CARRIED, find_flips, flip
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.export.compare import compare_motions

README = Path(__file__).parents[2] / "README.md"


@pytest.fixture(scope="module")
def clip():
    return tc.read_bvh(ASSETS / "walk_injected.bvh")


@pytest.fixture(scope="module")
def found(clip):
    return tc.detect(clip)


def test_the_scripts_of_the_readme_run(tmp_path, monkeypatch, capsys):
    scripts = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len(scripts) == 2
    work = [line for line in scripts[0].splitlines() if line and not line.startswith("import")]
    assert len(work) == 6
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "walk.bvh")
    (tmp_path / "captures").mkdir()
    shutil.copy(ASSETS / "walk.bvh", tmp_path / "captures" / "clean.bvh")
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "captures" / "wrong.bvh")
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    names = {}
    for script in scripts:
        exec(script, names)
    assert len(names["review"].accepted) == 8
    clean = tc.read_bvh(ASSETS / "walk.bvh").motion
    refined = tc.read_bvh(tmp_path / "walk_refined.bvh").motion
    assert compare_motions(clean, refined).max_position_of_height < 1e-4
    assert max((j.max_degrees for j in compare_motions(clean, refined).joints), default=0.0) < 0.5
    told = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in told[-2:]] == ["wrong.bvh", "clean.bvh"]


def test_everything_shows_itself_in_one_line(clip, found):
    review = tc.Review.of(found)
    things = [
        clip, clip.motion, clip.motion.skeleton, found, found.analysis, found[0], found.chains[0],
        found.analysis.signals["LeftArm"], review, review.state,
    ]  # fmt: skip
    for thing in things:
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 120, repr(thing)
    assert names_in_one_line(repr(found), "walk_injected.bvh", "8 intervals", "consistency")


def test_tau_has_its_unit_in_its_name(clip):
    degrees = tc.detect(clip, tau_degrees=20.0)
    assert {degrees.tau[c.name] for c in degrees.chains} == {np.radians(20.0)}
    same = tc.detect(clip, tau_radians=float(np.radians(20.0)))
    assert [(i.chain, i.start, i.stop) for i in degrees] == [
        (i.chain, i.start, i.stop) for i in same
    ]
    one = tc.detect(clip, tau_degrees={"LeftArm": 3.0})
    assert one.tau["LeftArm"] == np.radians(3.0) != one.tau["RightArm"]
    with pytest.raises(TypeError):
        tc.detect(clip, tau=5.0)
    with refused(tc.TwistError, "τ"):
        tc.detect(clip, tau_degrees=5.0, tau_radians=0.1)
    with refused(tc.TwistError, "'LeftWing'", "LeftArm"):
        tc.detect(clip, tau_degrees={"LeftWing": 3.0})


def test_errors_say_what_came_and_what_was_expected(clip, found):
    with refused(tc.TwistError, "'median'", "consistency"):
        tc.detect(clip, method="median")
    with refused(tc.TwistError, "'LeftWing'", "LeftArm"):
        tc.detect(clip, ["LeftWing"])
    with pytest.raises(tc.TwistError, match="'LeftWing'"):
        found.analysis.chain("LeftWing")
    with pytest.raises(TypeError, match=r"str 'walk\.bvh'"):
        tc.detect("walk.bvh")
    with pytest.raises(TypeError, match=r"Motion.*<Clip .*\.motion"):
        tc.write_clip(clip, clip, "out.bvh")


def test_chains_are_chosen_by_name_and_in_the_clips_order(clip):
    few = tc.detect(clip, ["RightLeg", "LeftArm"])
    assert [c.name for c in few.chains] == ["LeftArm", "RightLeg"]
    assert [limb.name for limb in few.limbs] == ["LeftArm-LeftHand"]
    assert list(few.tau) == ["LeftArm", "RightLeg", "LeftArm-LeftHand"]
    alone = tc.analyse(clip, ["RightUpLeg-RightFoot"])
    assert [c.name for c in alone.chains_and_limbs] == ["RightUpLeg-RightFoot"]
    with pytest.raises(tc.TwistError, match=r"'RightUpLeg-Foot'.* RightUpLeg-RightFoot"):
        tc.analyse(clip, ["RightUpLeg-Foot"])


def test_kinds_of_errors_are_looked_for_as_asked(clip, monkeypatch):
    made = find_flips(monkeypatch, flip(), CARRIED)
    analysis = tc.analyse(clip)
    twists = analysis.detect(kinds={tc.Kind.COUNTER_TWIST})
    assert made == []  # nothing that was not asked for is made
    assert (len(twists), twists.limbs, set(twists.tau)) == (8, (), {c.name for c in twists.chains})
    every = analysis.detect()
    assert made == [[limb.name for limb in analysis.limbs]]
    assert [i.chain for i in every[8:]] == ["LeftUpLeg-LeftFoot", "RightUpLeg-RightFoot"]
    assert list(every.tau) == [c.name for c in every.chains_and_limbs]
    assert [j.interval.chain for j in tc.Review.of(every).state.intervals] == [
        i.chain for i in every
    ]
    fresh = tc.analyse(clip)
    assert len(fresh.detect(kinds=[tc.Kind.LIMB_FLIP])) == 2
    assert fresh.kept("consistency") is None
    assert fresh.detect(kinds=[tc.Kind.LONE_JUMP]).limbs == fresh.detect(kinds=()).chains == ()
    assert len(fresh.detect(kinds="limb flip")) == len(fresh.detect(kinds=["limb flip"])) == 2
    with refused(tc.TwistError, "'twist'", "counter-twist"):
        fresh.detect(kinds=["twist"])
    assert len(fresh.detect()) == 10
    assert len(made) == 2
    only_chains = tc.ClipAnalysis(clip.motion, analysis.chains)
    assert (len(only_chains.detect()), len(made)) == (8, 2)


def test_tau_of_all_chains_is_none_of_a_limb(clip, monkeypatch):
    find_flips(monkeypatch, flip(degrees=170.0))
    found = tc.detect(clip, tau_degrees=175.0)
    assert [i.kind for i in found] == [tc.Kind.LIMB_FLIP]
    assert found.tau["RightUpLeg-RightFoot"] == 0.5
    assert not tc.detect(clip, tau_degrees={"RightUpLeg-RightFoot": 175.0})[8:]
    twists = tc.detect(
        clip, kinds=[tc.Kind.COUNTER_TWIST], tau_degrees={"RightUpLeg-RightFoot": 1.0}
    )
    assert "RightUpLeg-RightFoot" not in twists.tau


def test_a_detector_answers_for_chains_and_limbs_by_name(clip, monkeypatch):
    made = find_flips(monkeypatch, flip())
    analysis = tc.analyse(clip)
    detector, limb = analysis.detector("paper"), "RightUpLeg-RightFoot"
    assert (made, analysis.kept("paper")) == ([], None)
    assert detector.automatic_tau(limb) == 0.5
    assert detector.strength(limb)[0] == 0.25
    assert len(detector.intervals(limb, 0.5)) == 1
    assert analysis.kept("paper") is not None  # whose twists may say that a flip is none
    own = analysis.by("paper")
    assert detector.automatic_tau("RightUpLeg") == own.automatic_tau("RightUpLeg")
    assert detector.strength("RightUpLeg") is own.strength("RightUpLeg")
    assert len(detector.intervals("LeftForeArm", 0.1)) == len(own.intervals("LeftForeArm", 0.1))
    with pytest.raises(tc.TwistError, match="'Tail'"):
        detector.strength("Tail")
    with pytest.raises(tc.TwistError, match="'median'"):
        analysis.detector("median")


def test_flips_are_looked_for_once_by_whoever_comes_first(clip, monkeypatch):
    made = find_flips(monkeypatch)
    quick = core.analyse_limbs
    monkeypatch.setattr(core, "analyse_limbs", lambda *given: time.sleep(0.05) or quick(*given))
    analysis, together, got = tc.analyse(clip), threading.Barrier(8), []

    def ask():
        together.wait()
        got.append(analysis.flips)

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1
    assert all(one is got[0] for one in got)


def test_a_detector_is_asked_once(clip):
    analysis = tc.analyse(clip)
    assert analysis.kept("paper") is None
    assert analysis.by("paper") is analysis.by("paper") is analysis.kept("paper")
    assert analysis.detect("paper", tau_degrees=4.0).analysis is analysis


def test_what_a_detector_knows_already_waits_for_no_other(clip):
    """The window asks in its own thread, while another detector is at work in a second one."""
    analysis = tc.analyse(clip)
    kept, told = analysis.by("paper"), []
    with analysis._making:
        asker = threading.Thread(target=lambda: told.append(analysis.by("paper")), daemon=True)
        asker.start()
        asker.join(10.0)
        assert told == [kept]


@pytest.mark.parametrize(("at_least", "left"), [(0.0, 0), (0.9, 0), (1.01, 8)])
def test_a_review_accepts_by_confidence_in_one_step(found, at_least, left):
    review = tc.Review.of(found)
    assert review.accept(at_least) == 8 - left == len(review.accepted)
    review.undo()
    assert review.accepted == ()


def test_a_confidence_of_a_half_is_asked_for_where_nobody_names_one(found):
    low, high = (replace(found[0], confidence=c) for c in (0.49, 0.5))
    assert automatic_corrections([low, high]) == (high,)
    assert automatic_corrections([low, high], 0.0) == (low, high)
    assert automatic_corrections([low, high], 0.6) == ()
    assert automatic_corrections([replace(high, open=True)]) == ()
    assert automatic_corrections([replace(high, open=True)], include_open=True) != ()


def test_without_a_confidence_none_is_relied_on(clip):
    """The paper's detector knows none: a wish for any leaves its intervals to a person."""
    paper = tc.detect(clip, method="paper")
    assert automatic_corrections(paper) == automatic_corrections(paper, 0.0) == paper.intervals
    review = tc.Review.of(paper)
    assert review.accept(0.01) == 0
    assert review.accept() == len(review.state.intervals) > 0


def test_a_folder_tells_its_worst_clip_first_and_what_it_could_not_read(tmp_path):
    shutil.copy(ASSETS / "walk.bvh", tmp_path / "a.bvh")
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "b.BVH")
    (tmp_path / "c.bvh").write_text("nothing", encoding="utf-8")
    surveys = tc.survey_folder(tmp_path)
    assert [s.path.name for s in surveys] == ["b.BVH", "a.bvh", "c.bvh"]
    assert [s.intervals for s in surveys] == [8, 0, 0]
    assert "HIERARCHY" in surveys[-1].problem
    assert not surveys[0].problem
