"""Detectors that announce themselves by a file, a package or a program, and faults in them."""

import csv
import io
import json
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers, refused
from twistcore.cli import main
from twistcore.detection import DETECTORS, DetectorInfo, Interval, register
from twistcore.detection.registry import FILE_VARIABLE, built_in_detector_names
from twistcore.errors import TwistError
from twistcore.review.journal import command_from_json, review_command_to_json
from twistcore.skeleton.rig import Rig

EXAMPLE = Path(__file__).parents[2] / "docs" / "example_detector"
STEPS = f"{EXAMPLE / 'steps_detector.py'}:StepsDetector"
WALK = ASSETS / "walk_injected.bvh"
KICK = ASSETS / "kick.bvh"
FRAMES = tc.read_clip(KICK).motion.frames


@pytest.fixture(autouse=True)
def nobody_else(monkeypatch):
    """What a test registers is gone after it."""
    monkeypatch.setattr(DETECTORS, "_given", {})


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The example as pip would have installed it."""
    site = tmp_path / "site"
    site.mkdir()
    shutil.copy(EXAMPLE / "steps_detector.py", site)
    announce(site, "steps = steps_detector:StepsDetector")
    monkeypatch.syspath_prepend(site)
    yield site
    sys.modules.pop("steps_detector", None)


def announce(site, *lines):
    info = site / "twist_steps-0.1.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: twist-steps\nVersion: 0.1\n")
    (info / "entry_points.txt").write_text("\n".join(["[twistcore.detectors]", *lines, ""]))


def run(*words):
    """Exit code, standard output and standard error of a command."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = end.code
    return code, out.getvalue(), err.getvalue()


class Plain:
    """A detector of a program's own, which a test may spoil."""

    info = DetectorInfo("plain", "the plain detector", "Nothing much.")

    def __init__(self, **spoilt):
        self.spoilt = spoilt

    def analyse(self, motion, chains, tell=None):
        self.frames, self.tell = motion.frames, tell
        self.spoilt.get("analyse", lambda: None)()
        return self.spoilt.get("analysis", self)

    def automatic_tau(self, chain):
        return self.spoilt.get("tau", 0.1)

    def strength(self, chain):
        return self.spoilt.get("strength", np.zeros(self.frames))

    def intervals(self, chain, tau):
        found = self.spoilt.get("found", lambda c, t: [Interval(c, 5, 9, np.full(4, t))])
        return found(chain, tau)


# Where detectors come from


def test_the_programs_own_are_the_files_of_the_folder():
    folder = Path(tc.detection.__file__).parent / "detectors"
    names = {path.stem for path in folder.glob("[a-z]*.py")}
    assert set(built_in_detector_names()) == names
    assert built_in_detector_names()[0] == "consistency"
    assert {DETECTORS[name].info.name for name in names} == names


def test_names_are_known_without_numpy():
    code = """
import sys
from twistcore.detection import DETECTORS
assert list(DETECTORS) == ["consistency", "paper"], list(DETECTORS)
assert "paper" in DETECTORS and "numpy" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_name_that_is_built_in_asks_no_package():
    code = """
import sys
from twistcore.cli.parser import make_parser
make_parser().parse_args(["detect", "a.bvh", "--method", "paper"])
assert "importlib.metadata" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_package_announces_a_detector(package):
    assert list(DETECTORS) == ["consistency", "paper", "steps"]
    assert [info.column for info in DETECTORS.infos()] == ["Our", "Paper's", "Steps"]
    assert DETECTORS.version("steps") == "steps_detector:StepsDetector 0.1"
    code, out, _ = run("detect", WALK, "--method", "steps", "--kinds", "counter-twist", "--json")
    assert (code, json.loads(out)["method"]) == (0, "steps")
    assert "{consistency,paper,steps}" in run("detect", "--help")[1]


def test_the_example_is_announced_as_its_project_file_says():
    tomllib = pytest.importorskip("tomllib")
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text("utf-8"))
    points = project["project"]["entry-points"]["twistcore.detectors"]
    assert points == {"steps": "steps_detector:StepsDetector"}


def test_a_package_that_cannot_be_loaded_is_one_sentence_and_stops_nothing(package):
    announce(package, "steps = no_such_module:Steps", "odd = steps_detector:StepsDetector")
    sys.path_importer_cache.clear()
    sys.path.append(str(package / "again"))  # another path: packages are looked for again
    try:
        assert set(DETECTORS) >= {"steps", "odd"}
        assert DETECTORS.ready() == ("consistency", "paper")
        code, _, err = run("detect", WALK, "--method", "steps")
        assert code == 2
        assert names_in_one_line(err, "'steps'", "twist-steps")
        with pytest.raises(TwistError, match="'steps'"):
            DETECTORS["odd"]
    finally:
        sys.path.pop()


def test_a_program_registers_a_detector_or_hands_it_over():
    clip = tc.read_clip(KICK)
    found = tc.detect(clip, method=Plain(), kinds="counter-twist")
    assert {(i.start, i.stop) for i in found} == {(5, 9)}
    assert found.method == "plain"
    assert len(tc.detect(clip, method="plain", kinds="counter-twist")) == len(found)


def test_a_detector_registered_again_is_another_one():
    analysis = tc.analyse(tc.read_clip(KICK))
    before = analysis.detect(Plain(), kinds="counter-twist")
    found = {"found": lambda c, t: [Interval(c, 6, 9, np.full(3, t))]}
    after = analysis.detect(Plain(**found), kinds="counter-twist")
    assert ({i.start for i in before}, {i.start for i in after}) == ({5}, {6})


def test_the_programs_own_cannot_be_replaced():
    class Another(Plain):
        info = DetectorInfo("paper", "another", "Nothing.")

    with pytest.raises(TwistError, match="'paper'"):
        register(Another())
    assert DETECTORS.register(DETECTORS["paper"]) is DETECTORS["paper"]


def test_what_is_not_there_has_words_all_the_same():
    info = DETECTORS.info("gone")
    assert (info.name, info.column) == ("gone", "gone")
    assert "'gone'" in info.label
    assert DETECTORS.usable("gone") == "consistency"
    with refused(TwistError, "'gone'", "consistency, paper"):
        tc.detect(tc.read_clip(KICK), method="gone")


# A detector of a file, through the commands


def test_a_file_goes_through_detect_and_refine(tmp_path):
    words = "--detector", STEPS, "--kinds", "counter-twist"
    code, out, err = run("detect", WALK, *words, "--json")
    found = json.loads(out)
    assert (code, err, found["method"]) == (0, "", "steps")
    own = [(i["chain"], i["start"], i["stop"]) for i in found["intervals"]]
    assert ("LeftForeArm", 206, 213) in own
    assert all(i["confidence"] is None for i in found["intervals"])
    again = tc.detect(tc.read_clip(WALK), method="steps", kinds="counter-twist")
    assert [(i.chain, i.start, i.stop) for i in again] == own
    code, out, _ = run("refine", WALK, *words, "-o", tmp_path / "out.bvh", "--json")
    assert (code, json.loads(out)["method"]) == (0, "steps")
    left = tc.detect(tc.read_clip(tmp_path / "out.bvh"), method="steps", kinds="counter-twist")
    assert len(left) < len(own)


def test_signals_have_the_strength_of_a_detector_that_is_named(tmp_path):
    table = tmp_path / "signals.csv"
    chain = "--chain", "LeftForeArm"
    assert run("signals", WALK, "--csv", table, *chain, "--detector", STEPS)[0] == 0
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[-1] == "strength_deg"
    step, strength = ([float(row[k]) for row in rows] for k in ("dtheta_p_deg", "strength_deg"))
    assert np.allclose(np.abs(step), strength)
    assert max(strength) > 10.0
    code, out, _ = run("signals", WALK, "--json", *chain, "--method", "consistency")
    (of_chain,) = json.loads(out)["clips"][0]["chains"]
    wanted = tc.analyse(tc.read_clip(WALK)).by("consistency").strength("LeftForeArm")
    assert code == 0
    assert np.allclose(np.radians(of_chain["strength_deg"]), wanted)
    run("signals", WALK, "--csv", table, *chain)
    assert "strength_deg" not in table.read_text("utf-8").splitlines()[0]


@pytest.mark.thorough
def test_a_file_goes_through_tune_and_benchmark_in_processes(tmp_path):
    shutil.copy(KICK, tmp_path)
    profile = tmp_path / "steps.toml"
    code, out, _ = run(
        *("tune", tmp_path, "-o", profile, "--detector", STEPS),
        *("--both", "--seeds", 1, "--workers", 2),
    )
    assert code == 0
    heads = out.splitlines()[0]
    assert all(info.label in heads for info in DETECTORS.infos())
    assert 'detector = "steps"' in profile.read_text("utf-8")
    json_file = tmp_path / "bench.json"
    words = "--methods", "paper", "--seeds", 1, "--workers", 1, "--json", json_file
    assert run("benchmark", tmp_path, "--detector", STEPS, *words)[0] == 0
    methods = {m["name"]: m for m in json.loads(json_file.read_text("utf-8"))["methods"]}
    assert set(methods) == {"paper", "steps"}
    assert methods["steps"]["detector"]
    assert methods["steps"]["text"] == "Jumps of the parent's twist, and the jump back"


@pytest.mark.thorough
def test_a_batch_by_a_file_is_done_again_once_the_file_has_changed(tmp_path):
    (tmp_path / "in").mkdir()
    shutil.copy(KICK, tmp_path / "in")
    file = tmp_path / "own.py"
    shutil.copy(EXAMPLE / "steps_detector.py", file)
    words = "batch", tmp_path / "in", "-o", tmp_path / "out", "--workers", 1
    words = *words, "--detector", f"{file}:StepsDetector"
    assert numbers(run(*words)[1])[:2] == [1, 0]
    assert numbers(run(*words)[1])[:2] == [0, 1]
    file.write_text(file.read_text("utf-8").replace("radians(10.0)", "radians(20.0)"), "utf-8")
    DETECTORS._given.clear()  # as in another run of the program
    assert numbers(run(*words)[1])[:2] == [1, 0]


def test_nothing_of_a_file_is_left_after_a_command(monkeypatch):
    monkeypatch.delenv(FILE_VARIABLE, raising=False)
    run("detect", KICK, "--detector", STEPS)
    assert FILE_VARIABLE not in os.environ


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        (None, "Python"),
        ("", "Own"),
        ("class Own(", "SyntaxError"),
        ("import no_such_thing", "ModuleNotFoundError"),
        ("class Own: pass", "`info`"),
        ("class Own:\n def __init__(self): 1 / 0", "ZeroDivisionError"),
        (
            "from twistcore.detection import DetectorInfo\n"
            "class Own:\n info = DetectorInfo('own', '', '')",
            "analyse",
        ),
        (
            "from twistcore.detection import DetectorInfo\n"
            "class Own:\n info = DetectorInfo('My own', '', '')\n def analyse(self): pass",
            "'My own'",
        ),
    ],
)
def test_a_file_that_is_no_detector_is_one_sentence(tmp_path, text, fact):
    file = tmp_path / "own.py"
    if text is not None:
        file.write_text(text, "utf-8")
    code, out, err = run("detect", KICK, "--detector", f"{file}:Own")
    assert (code, out) == (2, "")
    assert names_in_one_line(err, f"{file}: ", fact)


@pytest.mark.parametrize("words", [["x.txt:A"], ["x.py"], ["x.py:A", "--method", "paper"]])
def test_words_that_name_no_class_of_a_file_are_refused(words):
    code, _, err = run("detect", KICK, "--detector", *words)
    assert (code, err.count("\n")) == (2, 1)


# What goes wrong in a detector


def error(*_):
    raise ValueError("of its own\nin two lines")


@pytest.mark.parametrize(
    ("spoilt", "fact"),
    [
        ({"found": error}, "failed on LeftShoulder (ValueError: of its own in two lines)"),
        ({"analysis": object()}, "expected an analysis with a method automatic_tau"),
        ({"tau": 0.0}, "on LeftShoulder: expected an automatic τ above 0 and up to π, found 0"),
        ({"tau": float("nan")}, "expected an automatic τ above 0"),
        ({"tau": "much"}, "failed on LeftShoulder (ValueError"),
        ({"strength": np.zeros(3)}, "numbers for the strength, found (3,)"),
        ({"strength": None}, "numbers for the strength, found ()"),
        ({"strength": np.full(FRAMES, -1.0)}, "on LeftShoulder: expected a strength of 0 or more"),
        ({"strength": np.full(FRAMES, np.nan)}, "expected a strength of 0 or more"),
        ({"analyse": error}, "failed (ValueError: of its own in two lines)"),
        ({"found": lambda *_: [1]}, "expected intervals, found 1"),
        ({"found": lambda *_: None}, "failed on LeftShoulder (TypeError"),
        (
            {"found": lambda *_: [Interval("Tail", 0, 1, np.zeros(1))]},
            "'Tail'",
        ),
        (
            {"found": lambda c, _: [Interval(c, 4, 99999, np.zeros(99995))]},
            "4–99999",
        ),
        (
            {"found": lambda c, _: [Interval(c, 4, 6, np.zeros(3))]},
            "offset",
        ),
    ],
)
def test_what_goes_wrong_in_a_detector_names_it(spoilt, fact):
    with refused(TwistError, "'plain'", fact):
        tc.detect(tc.read_clip(KICK), method=Plain(**spoilt))


def test_a_whole_clip_and_the_largest_tau_are_no_fault_of_a_detector():
    def whole(chain, _tau):
        return [Interval(chain, 0, FRAMES, np.ones(FRAMES))]

    detector = Plain(found=whole, tau=np.pi)
    found = tc.detect(tc.read_clip(KICK), method=detector, kinds="counter-twist")
    assert {(i.start, i.stop) for i in found} == {(0, FRAMES)}


def test_a_detector_can_report_its_progress_and_have_other_methods():
    clip, detector = tc.read_clip(KICK), Plain(strength=np.ones(FRAMES, dtype=int))
    analysis = DETECTORS.register(detector).analyse(clip.motion, tc.find_chains(clip), print)
    assert detector.tell is print
    assert analysis.strength("LeftArm").dtype == np.float64
    assert analysis.frames == FRAMES  # which no analysis needs


def test_want_of_memory_is_no_fault_of_a_detector():
    def too_much(*_):
        raise MemoryError

    with pytest.raises(MemoryError):
        tc.detect(tc.read_clip(KICK), method=Plain(found=too_much))


def test_a_reason_that_fails_is_said_and_an_interval_stays_the_same():
    kept = {}

    def found(chain, _tau):
        one = Interval(chain, 5, 9, np.ones(4), explain=error)
        return [kept.setdefault(chain, one)]

    analysis = DETECTORS.register(Plain(found=found)).analyse(
        (clip := tc.read_clip(KICK)).motion, tc.find_chains(clip)
    )
    first, again = (analysis.intervals("LeftArm", 0.1)[0] for _ in range(2))
    assert first is again
    assert names_in_one_line(first.evidence["error"], "'plain'", "ValueError")


# A review by a detector that is not there


@pytest.fixture
def foreign(tmp_path):
    """A session by a detector that nobody has, with one accepted interval."""
    clip = tc.read_clip(WALK)
    review = tc.Review(tc.detect(clip))
    review.accept()
    session = tmp_path / "walk.twist.json"
    tc.write_session(clip, review, session)
    document = json.loads(session.read_text("utf-8"))
    document["method"] = "somebody-elses"
    session.write_text(json.dumps(document), "utf-8")
    return session


def test_a_review_by_a_detector_that_is_not_there_is_applied_and_reported(foreign, tmp_path):
    clip, out = WALK, tmp_path / "out.bvh"
    assert run("apply", foreign, clip, "-o", out)[0] == 0
    assert out.read_bytes() != clip.read_bytes()
    code, _, err = run("report", foreign, "-o", tmp_path / "pages", "--clip", clip, "--no-pictures")
    assert (code, err) == (0, "")
    (page,) = (tmp_path / "pages").glob("*.html")
    told = "The review&#39;s detector, &#39;somebody-elses&#39;, is not installed here"
    assert told in page.read_text("utf-8")
    assert tc.read_session(foreign).state.method == "somebody-elses"


def test_a_review_by_a_detector_that_fails_on_the_clip_is_reported(foreign, tmp_path):
    class Failing(Plain):
        info = DetectorInfo("somebody-elses", "a detector", "Nothing.")

    DETECTORS.register(Failing(strength=None))
    words = "--clip", WALK, "--no-pictures"
    code, _, err = run("report", foreign, "-o", tmp_path / "pages", *words)
    assert (code, err) == (0, "")
    (page,) = (tmp_path / "pages").glob("*.html")
    assert "&#39;somebody-elses&#39;, fails on the clip (the detector" in page.read_text("utf-8")


def test_a_detector_that_fails_is_used_again_once_it_is_another():
    analysis = tc.analyse(tc.read_clip(KICK))
    chosen = tc.analyse(tc.read_clip(KICK), "LeftArm")
    DETECTORS.register(Plain(strength=None))
    for one in (analysis, chosen):
        assert (one.usable("plain"), one.failure("plain")) == ("plain", "")
        with pytest.raises(TwistError):
            one.by("plain")
        assert one.usable("plain") == "consistency"
        assert "numbers for the strength" in one.failure("plain")
        other = one.with_rig(Rig((), ("RightArm",)))
        assert other.usable("plain") == "consistency"
    DETECTORS.register(Plain())
    assert (analysis.usable("plain"), analysis.failure("plain")) == ("plain", "")


def test_its_journal_is_read_with_the_detector_that_it_names():
    redetect = command_from_json(
        {"do": "Redetect", "tau_deg": {"LeftArm": 3.0}, "found": [], "drag": 0, "method": "gone"}
    )
    assert redetect.method == "gone"
    assert review_command_to_json(redetect)["method"] == "gone"


def test_the_page_shows_the_example_as_it_is():
    page = (EXAMPLE.parent / "detectors.md").read_text("utf-8")
    for name in ("steps_detector.py", "pyproject.toml"):
        assert (EXAMPLE / name).read_text("utf-8") in page
