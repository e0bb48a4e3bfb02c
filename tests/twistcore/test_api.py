"""The names of `twistcore` as a user of scipy or MNE would try them, and their documentation."""

import doctest
import inspect
import json
import re
import subprocess
import sys
from dataclasses import replace
from enum import Enum
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.tiers import parametrize
from twistcore.cli import main
from twistcore.skeleton.chain import chain_named

ROOT = Path(__file__).parents[2]
NAMES = [name for name in tc.__all__ if name != "__version__"]
# Sections of a docstring in numpydoc's form and order; these a function has at least.
SECTIONS = ("Parameters", "Attributes", "Returns", "Raises", "See Also", "Notes", "Examples")
UNDERLINED = re.compile(r"^(\w[\w ]*)\n-+$", re.MULTILINE)


@pytest.fixture(scope="module")
def clip():
    return tc.read_clip(ASSETS / "walk_injected.bvh")


@pytest.fixture(scope="module")
def found(clip):
    return tc.detect(clip)


def places(intervals):
    return [(i.chain, i.start, i.stop) for i in intervals]


# -- names of chains -------------------------------------------------------------------------------


@parametrize(
    ("name", "chain"),
    [
        ("LeftForeArm", "LeftForeArm"),
        ("leftforearm", "LeftForeArm"),
        ("leftleg", "LeftLeg"),  # the chain, though a limb is called 'Left leg'
        ("Left ForeArm", "LeftForeArm"),
        ("LEFT FOREARM", "LeftForeArm"),
        ("LeftUpLeg-LeftFoot", "LeftUpLeg-LeftFoot"),
        ("leftupleg-leftfoot", "LeftUpLeg-LeftFoot"),
        ("Left leg", "LeftUpLeg-LeftFoot"),  # the limb …
        ("Left Leg", "LeftLeg"),  # … and the chain, whose labels differ in case alone
        ("Left leg · limb", "LeftUpLeg-LeftFoot"),
        ("left arm", "LeftArm"),  # the chain, before the limb that it begins
    ],
    quick=2,
)
def test_chains_go_by_the_names_and_labels_that_info_prints(clip, found, name, chain):
    assert found.analysis.chain(name).name == chain
    assert chain in {c.name for c in tc.analyse(clip, name).chains_and_limbs}
    assert places(tc.detect(clip, name)) == places(tc.detect(clip, [chain]))


def test_one_chain_needs_no_list(clip, found):
    chain = found.analysis.chain("LeftForeArm")
    same = [tc.detect(clip, what) for what in ("LeftForeArm", chain, ["LeftForeArm"], [chain])]
    assert {len(one) for one in same} == {3}
    assert {tuple(places(one)) for one in same} == {tuple(places(found["LeftForeArm"]))}


def test_the_command_line_takes_the_same_names(capsys):
    shown = []
    for name in ("LeftForeArm", "left forearm"):
        assert main(["detect", str(ASSETS / "walk_injected.bvh"), "--chain", name]) == 0
        shown.append(capsys.readouterr().out)
    assert shown[0] == shown[1]
    assert main(["detect", str(ASSETS / "walk_injected.bvh"), "--chain", "LeftForArm"]) == 2
    assert names_in_one_line(capsys.readouterr().err, "'LeftForArm'", "LeftForeArm")


def test_an_unknown_name_is_answered_by_those_that_are_near(clip):
    with pytest.raises(tc.TwistError, match=r"'LeftAm'.* LeftArm( or .*)?\?$"):
        tc.detect(clip, "LeftAm")
    with pytest.raises(tc.TwistError, match=r"'Tail'.* LeftArm, "):
        tc.detect(clip, "Tail")
    with pytest.raises(tc.TwistError, match=r"'left leg'.* LeftLeg or LeftUpLeg-LeftFoot"):
        tc.detect(clip, "left leg")


def test_a_name_as_written_goes_before_all_that_are_alike(found):
    arm = found.analysis.chain("LeftArm")
    chains = [replace(arm, name="leftarm", parent=1), replace(arm, name="LeftArm", parent=2)]
    assert [chain_named(chains, n, "here").parent for n in ("leftarm", "LeftArm")] == [1, 2]
    with refused(tc.TwistError, "here:", "'LEFTARM'", "leftarm or LeftArm"):
        chain_named(chains, "LEFTARM", "here")


def test_people_need_no_list(clip):
    with refused(tc.TwistError, "'Kim'"):
        tc.analyse(clip, people="Kim")


# -- clips and motions -----------------------------------------------------------------------------


def test_every_verb_takes_a_clip_or_a_motion(clip, found):
    motion = clip.motion
    error = tc.InjectedError("LeftArm", 20, 30, np.full(10, 1.0))
    for verb in (
        lambda what: places(tc.detect(what)),
        lambda what: [len(tc.analyse(what).chains), len(tc.analyse(what).limbs)],
        lambda what: [c.name for c in tc.find_chains(what)],
        lambda what: [c.name for c in tc.find_limbs(what)],
        lambda what: tc.twist_signals(what, found.chains[0]).theta_p.tolist(),
        lambda what: tc.twist_signals(what, "left shoulder").theta_p.tolist(),
        lambda what: tc.refine(what, found).rotations.tolist(),
        lambda what: tc.refine(what, found.chains, found).rotations.tolist(),
        lambda what: tc.inject(what, [error]).rotations.tolist(),
    ):
        assert verb(clip) == verb(motion)
        assert verb(clip)
    for wrong in ("walk.bvh", None, 3):
        for verb in (tc.detect, tc.analyse, tc.find_chains, tc.find_limbs):
            with refused(TypeError, type(wrong).__name__):
                verb(wrong)
        with refused(TypeError, type(wrong).__name__):
            tc.refine(wrong, found)


def test_limbs_are_those_of_the_clips_chains(clip):
    chains = tc.find_chains(clip)
    assert [x.name for x in tc.find_limbs(clip)] == [x.name for x in tc.find_limbs(clip, chains)]
    assert tc.find_limbs(clip, []) == ()


def test_a_clip_has_its_rate_and_its_length(clip):
    assert clip.fps == clip.motion.fps == pytest.approx(120.0, abs=1e-3)
    assert clip.duration == clip.motion.duration == clip.frames * clip.frame_time
    slow = tc.read_clip(clip.path, fps=30.0)
    assert (slow.fps, slow.duration) == (pytest.approx(30.0), pytest.approx(344 / 30.0))


def test_progress_is_reported_on_request(clip):
    shares = []
    assert places(tc.detect(clip, tell=shares.append)) == places(tc.detect(clip, tell=None))
    assert shares
    assert shares == sorted(shares)
    assert all(0.0 <= share <= 1.0 for share in shares)
    for name in NAMES:
        thing = getattr(tc, name)
        if inspect.isfunction(thing) and "tell" in (known := inspect.signature(thing).parameters):
            assert known["tell"].default is None, name


# -- what was found --------------------------------------------------------------------------------


def test_a_detection_is_asked_by_chain(found):
    arm = found["left forearm"]
    assert places(arm) == [p for p in places(found) if p[0] == "LeftForeArm"]
    assert (dict(arm.tau), arm.method) == ({"LeftForeArm": found.tau["LeftForeArm"]}, found.method)
    assert len(found["LeftArm"]) == 0
    assert len(found["RightUpLeg"]) == 5
    assert len(found["RightUpLeg-RightFoot"]) == 0
    assert found[-2:] == found.intervals[-2:]
    with pytest.raises(tc.TwistError, match="'LeftWrist'"):
        found["LeftWrist"]


def test_rows_are_those_of_the_command(found, capsys):
    command = ["detect", str(ASSETS / "walk_injected.bvh"), "--json"]
    assert main(command) == 0
    assert found.to_rows() == json.loads(capsys.readouterr().out)["intervals"]
    assert main([*command, "--explain"]) == 0
    explained = json.loads(capsys.readouterr().out)["intervals"]
    assert json.loads(json.dumps(found.to_rows(explain=True))) == explained


def test_a_table_has_a_row_an_interval_and_columns_without_any(found, monkeypatch):
    frames = []
    pandas = SimpleNamespace(DataFrame=lambda rows, columns: frames.append((rows, columns)))
    monkeypatch.setitem(sys.modules, "pandas", pandas)
    found.to_dataframe()
    found["LeftArm"].to_dataframe()
    assert frames[0] == (found.to_rows(), None)
    assert frames[1] == ([], tuple(found.to_rows()[0]))


def test_a_real_table(found):
    pandas = pytest.importorskip("pandas")
    table = found.to_dataframe()
    assert isinstance(table, pandas.DataFrame)
    assert table["start"].tolist() == [i.start for i in found]


def test_without_pandas_one_sentence_says_so(found, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(tc.TwistError, match="pip install pandas"):
        found.to_dataframe()


def test_what_was_found_is_removed_in_one_step(clip, found):
    before = clip.motion.rotations.copy()
    assert len(tc.detect(found.refined())) == 0
    np.testing.assert_array_equal(tc.refine(clip, found).rotations, found.refined().rotations)
    np.testing.assert_array_equal(clip.motion.rotations, before)
    sure = found.refined(at_least=0.9999)
    left = [i for i in found if i.confidence < 0.9999]
    assert left
    assert len(tc.detect(sure)) >= len(left)


def test_open_intervals_stay_unless_asked_for(clip, found):
    doubted = replace(found, intervals=tuple(replace(i, open=True) for i in found))
    assert (doubted.refined().rotations == clip.motion.rotations).all()
    np.testing.assert_array_equal(
        doubted.refined(include_open=True).rotations, found.refined().rotations
    )


def test_intervals_are_removed_as_given(clip, found):
    one = tc.refine(clip, found[0])
    np.testing.assert_array_equal(tc.refine(clip, [found[0]]).rotations, one.rotations)
    assert places(tc.detect(one)) == places(found[1:])
    assert places(tc.detect(tc.refine(clip, found["RightUpLeg"]))) == places(found["LeftForeArm"])
    assert (tc.refine(clip, []).rotations == clip.motion.rotations).all()
    for wrong in (found.chains, 3, "LeftArm", [found[0], 3]):
        with refused(TypeError):
            tc.refine(clip, wrong)
    short = clip.motion.sliced(0, 100)
    with refused(tc.TwistError, "100 frames", "<Interval LeftForeArm 122"):
        tc.refine(short, found)


@pytest.mark.parametrize(
    "word", ["counter-twist", "counter_twist", "Counter Twist", "COUNTER-twist"]
)
def test_kinds_are_taken_in_both_spellings(clip, found, word):
    assert tc.Kind(word) is tc.Kind.COUNTER_TWIST
    assert places(tc.detect(clip, kinds=word)) == places(tc.detect(clip, kinds=[word, "limb_flip"]))
    assert places(tc.detect(clip, kinds=word)) == places(found)


def test_words_that_are_no_kinds_are_refused(clip):
    assert not tc.Kind("twist").known
    for word in ("", " ", None, 3):
        with refused(ValueError, repr(word)):
            tc.Kind(word)
    with refused(tc.TwistError, "'flip'", "counter-twist"):
        tc.detect(clip, kinds=["limb flip", "flip"])


# -- reviews ---------------------------------------------------------------------------------------


def test_a_review_begins_with_what_was_found(clip, found):
    for what in (found, found.analysis, tc.Review.of(found).state):
        review = tc.Review(what)
        assert places(j.interval for j in review.state.intervals) == places(found)
        assert review.saved
    assert review.accept() == 8
    # Under review offsets are rounded to nine decimals, as files have them.
    np.testing.assert_allclose(
        tc.refine(clip, review).rotations, found.refined().rotations, atol=1e-9
    )
    assert (tc.refine(clip, tc.Review(found)).rotations == clip.motion.rotations).all()
    for wrong in (clip, None, list(found)):
        with refused(TypeError, "detect"):
            tc.Review(wrong)


def test_a_session_is_written_as_a_clip_is(clip, found, tmp_path):
    review = tc.Review(found)
    review.accept()
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    tc.write_session(clip, review, str(new))
    tc.write_session(old, clip, review.state)  # the order of earlier versions
    assert old.read_bytes() == new.read_bytes()
    session = tc.read_session(str(new))
    np.testing.assert_allclose(
        tc.refine(clip, session).rotations, found.refined().rotations, atol=1e-9
    )
    for wrong in ((clip, new, review), (clip.motion, review, new), (clip, found, new)):
        with refused(TypeError):
            tc.write_session(*wrong)


# -- rotations and known errors --------------------------------------------------------------------


def test_errors_are_put_in_by_the_names_of_the_clips_chains():
    clip = tc.read_clip(ASSETS / "walk.bvh")
    error = tc.InjectedError("left forearm", 120, 140, np.full(20, 1.0))
    dirty = tc.inject(clip, [error])
    named = replace(error, chain="LeftForeArm")
    same = tc.inject(clip.motion, tc.find_chains(clip), [named])
    np.testing.assert_array_equal(dirty.rotations, same.rotations)
    assert places(tc.detect(dirty, "LeftForeArm")) == [("LeftForeArm", 120, 140)]
    flip = tc.InjectedError("Left leg", 50, 60, np.full(10, 2.0), kind=tc.Kind.LIMB_FLIP)
    assert places(tc.detect(tc.inject(clip, [flip]), "Left leg")) == [
        ("LeftUpLeg-LeftFoot", 50, 60)
    ]
    with pytest.raises(tc.TwistError, match="LeftForeArm"):
        tc.inject(clip, [replace(error, chain="LeftForArm")])
    with refused(tc.TwistError, "130 frames", "left forearm"):
        tc.inject(clip.motion.sliced(0, 130), tc.find_chains(clip), [error])


def test_a_survey_reports_its_progress(tmp_path):
    for k in range(2):
        (tmp_path / f"{k}.bvh").write_bytes(b"HIERARCHY")
    shares = []
    assert len(tc.survey_folder(tmp_path, tell=shares.append)) == 2
    assert shares == [0.5, 1.0]


# -- documentation ---------------------------------------------------------------------------------


def test_names_are_listed_once_in_the_order_of_the_data():
    assert len(set(tc.__all__)) == len(tc.__all__) < 40
    verbs = ["read_clip", "find_chains", "find_limbs", "twist_signals", "analyse", "detect"]
    verbs += ["Review", "write_session", "refine", "write_clip", "inject", "survey_folder"]
    assert [name for name in tc.__all__ if name in verbs] == verbs
    assert all(hasattr(tc, name) for name in tc.__all__)
    assert tc.write_bvh is tc.write_clip  # its name before there were other formats


def test_the_page_of_the_api_lists_every_name():
    page = (ROOT / "docs" / "api" / "index.md").read_text("utf-8")
    listed = re.findall(r"^ +~twistcore\.[\w.]+\.(\w+)$", page, re.MULTILINE)
    assert listed == NAMES


def issubclass_of(thing, *kinds):
    return inspect.isclass(thing) and issubclass(thing, kinds)


def missing_sections(thing):
    """What the docstring lacks: sections, parameters; and what is out of order."""
    doc = inspect.getdoc(thing) or ""
    there = [name for name in UNDERLINED.findall(doc) if name in SECTIONS]
    wanted = {"Examples"} if issubclass_of(thing, Exception) else {"Parameters", "Examples"}
    parameters = (
        () if issubclass_of(thing, Enum, Exception) else inspect.signature(thing).parameters
    )
    if inspect.isfunction(thing):
        wanted |= {"Raises"}
        if thing.__annotations__["return"] != "None":
            wanted |= {"Returns"}
    wrong = sorted(wanted - set(there))
    if there != sorted(there, key=SECTIONS.index):
        wrong.append("order")
    named = {
        n.strip(" *")
        for line in re.findall(r"^([\w, *]+?)(?: : .+)?\n    ", doc, re.M)
        for n in line.split(",")
    }
    return wrong + sorted(set(parameters) - named)


@pytest.mark.parametrize("name", NAMES)
def test_every_name_is_documented_in_numpydocs_form(name):
    assert missing_sections(getattr(tc, name)) == []


def test_the_check_of_docstrings_finds_what_is_missing():
    def bare(clip, more=3) -> int:
        """Do it.

        Parameters
        ----------
        clip : Clip
            What to do it to.
        """

    bare.__annotations__["return"] = "int"
    assert missing_sections(bare) == ["Examples", "Raises", "Returns", "more"]


def test_numpydoc_finds_no_section_wrong():
    """Where numpydoc is installed; the check above needs nothing."""
    validate = pytest.importorskip("numpydoc.validate").validate
    # No docstring, unknown or misplaced sections, parameters that are missing or unknown, Returns.
    wanted = {"GL06", "GL07", "GL08", "PR01", "PR02", "PR03", "PR10", "RT01", "SS01"}
    # Whose parameters numpydoc cannot read: made by calls of their own, or called in two ways.
    names = set(NAMES) - {"Kind", "Decision", "refine"}
    found = {name: validate(f"twistcore.{name}")["errors"] for name in sorted(names)}
    assert {
        n: e for n, errors in found.items() if (e := [x for x in errors if x[0] in wanted])
    } == {}


METHODS = [("Detection", name) for name in ("refined", "to_rows")]


@parametrize("path", [*((n,) for n in NAMES), *METHODS], ids=".".join, quick=8)
def test_examples_do_what_they_show(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    thing = tc
    for name in path:
        thing = getattr(thing, name)
    (test,) = doctest.DocTestFinder(recurse=False).find(thing, ".".join(path), globs={})
    assert test.examples
    report = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=report.append)
    assert result.failed == 0, "".join(report)


def test_the_package_is_loaded_without_numpy():
    program = "import sys, twistcore; print([m for m in ('numpy', 'scipy') if m in sys.modules])"
    found = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"
