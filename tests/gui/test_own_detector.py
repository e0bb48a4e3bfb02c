"""A detector of somebody else's in the window: with its package, and without it."""

import json
import multiprocessing
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt

from inspector import __main__, app
from inspector.session.document import Document
from inspector.session.opening import analyse_file, analyse_session
from inspector.tuning.cost_worker import Capture, Request, measure_cost_curves
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, decisions, open_clip
from twistcore import Review, detect, read_clip, read_session, write_session
from twistcore.detection import DETECTORS, DetectorInfo
from twistcore.detection.registry import FILE_VARIABLE
from twistcore.review import Redetect
from twistcore.skeleton.rig import Rig
from twistcore.tuning import Profile, Verdicts

EXAMPLE = Path(__file__).parents[2] / "docs" / "example_detector"

# A process of its own: the menus are made when the window's modules are loaded.
PROGRAM = """
import json, sys, time
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from PySide6.QtWidgets import QApplication
app = QApplication([])
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
window = MainWindow(Settings(turn_ms=0, group_errors=False), None)
window.show()
document, timeline, told = window.document, window.timeline, {}

def wait(until):
    end = time.monotonic() + 120
    while not until():
        app.processEvents()
        assert time.monotonic() < end
        time.sleep(0.01)

window.open_path(Path(sys.argv[2]))
wait(lambda: document.data is not None)
row = window.actions_by_id["use_steps"]
told["row"] = [row.text(), row.statusTip(), row.isChecked()]
window.actions_by_id["both_detectors"].trigger()
row.trigger()
wait(lambda: document.method == "steps")
told["checked"] = [a.objectName() for a in row.actionGroup().actions() if a.isChecked()]
told["before"] = timeline.panes["other"].method
window.actions_by_id["use_paper"].trigger()
wait(lambda: document.method == "paper")
timeline.refresh()
wait(lambda: bool(timeline.panes["other"].intervals))
told["other"] = [timeline.panes["other"].method, timeline.panes["other"]._name]
row.trigger()
wait(lambda: document.method == "steps")
document.set_tau(0.4)
window.actions_by_id["show_tuning"].trigger()
window.actions_by_id["both_costs"].trigger()
model = window.tuning.profiles.detectors
wait(lambda: len(window.tuning.costs.by("steps")) == 10)
told["heads"] = [model.heads[k] for k in range(1, len(model.heads), 3)]
told["cost"] = [model.index(0, c).data() for c in (7, 8)]
window.tuning.confidence.refresh()
told["confidence"] = window.tuning.confidence.hint.text()
window.tuning.curves.show_chain()
window.tuning.curves.show_words(10.0)
told["curves"] = window.tuning.curves.strength_words.text().replace("&nbsp;", " ")
for name in ("next_interval", "accept"):
    window.actions_by_id[name].trigger()
window.files.save_session()
document.review.mark_saved()
window.close()
print(json.dumps(told))
"""


@pytest.fixture
def clip(tmp_path):
    return Path(shutil.copy(INJECTED, tmp_path / "walk.bvh"))


@pytest.mark.thorough
def test_a_package_is_in_menus_columns_and_plots(clip, tmp_path):
    site = tmp_path / "site"
    info = site / "twist_steps-0.1.dist-info"
    info.mkdir(parents=True)
    shutil.copy(EXAMPLE / "steps_detector.py", site)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: twist-steps\nVersion: 0.1\n")
    points = "[twistcore.detectors]\nsteps = steps_detector:StepsDetector\n"
    (info / "entry_points.txt").write_text(points)
    found = subprocess.run(
        [sys.executable, "-c", PROGRAM, site, clip], text=True, capture_output=True, check=False
    )
    assert found.returncode == 0, found.stderr
    printed = json.loads(found.stdout.splitlines()[-1])
    measures = "Jumps of the parent's twist, and the jump back."
    assert printed["row"] == ["Detect with the detector of steps", measures, False]
    assert printed["checked"] == ["use_steps"]
    assert printed["before"] == "consistency"
    assert printed["other"] == ["steps", "The detector of steps"]
    assert printed["heads"] == ["Our\nτ", "Paper's\nτ", "Steps\nτ"]
    assert printed["cost"][0].endswith("°")
    assert printed["confidence"] == (
        "The detector of steps has no confidence, so there is nothing to learn."
    )
    assert "the paper's m(t)" in printed["curves"]
    assert "automatic τ 10.00°" in printed["curves"]
    state = read_session(clip.with_name("walk.twist.json")).state
    assert state.method == "steps"
    assert sum(j.decision == "accepted" for j in state.intervals) == 1


@pytest.fixture
def session(clip):
    """A review by a detector that is not here; its first interval is accepted."""
    read = read_clip(clip)
    review = Review(detect(read))
    review.accept(0.99)
    path = clip.with_name("walk.twist.json")
    write_session(read, replace(review.state, method="gone"), path)
    return path


def test_a_review_by_a_detector_that_is_not_here_is_gone_on_with(qtbot, window, session):
    document, messages = window.document, []
    document.message.connect(lambda *told: messages.append(told[0]))
    open_clip(qtbot, window, session)
    told = [text for text in messages if "'gone', which is not installed" in text]
    assert len(told) == 1
    before = document.review.state
    assert (before.method, document.method) == ("gone", "consistency")
    names = ("use_consistency", "use_paper")
    assert [window.actions_by_id[name].isChecked() for name in names] == [False, False]
    # Its τ stays, whatever is tried; decisions are made.
    document.set_tau(0.5)
    assert document.review.state is before
    assert "'gone', which is not installed" in messages[-1]
    act(window, "why_not")
    act(window, "next_faint")
    act(window, "both_detectors")
    for name in ("show_tuning", "both_costs"):
        act(window, name)
    act(window, "next_interval")
    act(window, "reject")
    qtbot.waitUntil(lambda: not window.tuning.costs.running)
    assert document.review.state.tau == before.tau
    window.files.save_session()
    assert json.loads(session.read_text("utf-8"))["method"] == "gone"
    # Another detector is a choice, which is taken back as any.
    act(window, "use_consistency")
    qtbot.waitUntil(lambda: document.review.state.method == "consistency")
    assert window.actions_by_id["use_consistency"].isChecked()
    document.undo()
    assert document.review.state.method == "gone"
    assert not window.actions_by_id["use_consistency"].isChecked()
    document.redo()
    document.set_tau(0.5)
    assert document.review.state.tau[document.chain] == 0.5


@pytest.mark.thorough
def test_its_steps_of_an_earlier_run_are_taken_up(qtbot, show_window, clip):
    first = show_window()
    open_clip(qtbot, first, clip)
    first.document.do(Redetect({"LeftArm": 0.2}, (), method="gone"))
    act(first, "next_interval")
    act(first, "reject")
    journal = clip.with_name("walk.twist.json.journal")
    kept, wanted = journal.read_bytes(), decisions(first)
    close_window(qtbot, first)
    journal.write_bytes(kept)  # as a killed program leaves it
    again = show_window()
    open_clip(qtbot, again, clip)
    assert "2 steps were kept" in again.bar.label.text()
    restore = next(b for b in again.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert decisions(again) == wanted
    assert again.document.review.state.method == "gone"


class Fails:
    """Works until τ is moved."""

    info = DetectorInfo("fails", "the detector that fails", "Nothing.")

    def analyse(self, motion, chains, tell=None):
        self.frames = motion.frames
        return self

    def automatic_tau(self, chain):
        return 0.1

    def strength(self, chain):
        return np.zeros(self.frames)

    def intervals(self, chain, tau):
        if tau != 0.1:
            raise ValueError("of its own")
        return ()


def test_a_detector_that_fails_is_a_message(qtbot, open_document, clip, monkeypatch):
    monkeypatch.setattr(DETECTORS, "_given", {})
    DETECTORS.register(Fails())
    document = open_document(INJECTED)
    with qtbot.waitSignal(document.method_changed):
        document.use_method("fails")
    with qtbot.waitSignal(document.message) as told:
        document.set_tau(0.3)
    sentence = f"the detector 'fails' failed on {document.chain} (ValueError: of its own)"
    assert told.args == [sentence, True]
    assert document.review.state.tau[document.chain] == 0.1


def test_a_clip_that_was_searched_by_a_detector_that_is_not_here_is_opened(clip, session):
    found = analyse_session(session)
    assert found.analysis.kept("consistency") is not None
    assert [j.decision for j in found.review.state.intervals].count("accepted") > 0


class Raises(Fails):
    """Does not work on the clip at all."""

    info = DetectorInfo("gone", "the detector that raises", "Nothing.")

    def strength(self, chain):
        raise ValueError("of its own")


class RaisesAtTau(Fails):
    """Works at its own τ, not at the review's."""

    info = DetectorInfo("gone", "the detector that raises", "Nothing.")


@pytest.mark.parametrize("detector", [Raises, RaisesAtTau])
def test_a_review_by_a_detector_that_raises_on_the_clip_is_gone_on_with(
    qtbot, clip, session, monkeypatch, detector
):
    monkeypatch.setattr(DETECTORS, "_given", {})
    DETECTORS.register(detector())
    document, messages = Document(), []
    document.message.connect(lambda *message: messages.append(message[0]))
    document.show_clip(analyse_session(session))
    (message,) = [text for text in messages if "fails on this clip" in text]
    assert "the detector 'gone' failed on LeftShoulder (ValueError: of its own)" in message
    before = document.review.state
    assert (before.method, document.method) == ("gone", "consistency")
    assert sum(j.decision == "accepted" for j in before.intervals) > 0
    document.set_tau(0.5)
    assert document.review.state is before
    assert "fails on this clip" in messages[-1]
    # Other chains leave it as it is, and another detector is a choice.
    fewer = Rig((), ("RightLeg",))
    document.change_chains(fewer, "Remove")
    qtbot.waitUntil(lambda: document.review.state.rig == fewer)
    assert (document.review.state.method, document.method) == ("gone", "consistency")
    document.use_method("consistency")
    qtbot.waitUntil(lambda: document.review.state.method == "consistency")
    document.undo()
    assert (document.review.state.method, document.method) == ("gone", "consistency")
    document.close_clip()


def test_a_clip_to_be_searched_by_a_detector_that_raises_is_searched_by_another(clip, monkeypatch):
    monkeypatch.setattr(DETECTORS, "_given", {})
    DETECTORS.register(Raises())
    found = analyse_file(clip, Profile({}, "gone"))
    assert found.review.state.method == "consistency"
    (told,) = found.notes
    assert "default detector" in told
    assert "the detector 'gone' failed on LeftShoulder (ValueError: of its own)" in told


def test_what_a_detector_of_a_file_costs_is_measured_by_the_process(clip, monkeypatch):
    monkeypatch.setattr(DETECTORS, "_given", {})
    place = f"{EXAMPLE / 'steps_detector.py'}:StepsDetector"
    DETECTORS.load(place)
    request = Request(
        clip, read_clip(clip).sha256, "steps", Verdicts(), ("LeftArm",), Rig(), (), 1,
        detector=DETECTORS.place("steps"),
    )  # fmt: skip
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=measure_cost_curves, args=(theirs, request))
    process.start()
    theirs.close()
    answers = list(iter(ours.recv, None))
    process.join()
    process.close()
    ours.close()
    capture, (name, curve) = answers
    assert isinstance(capture, Capture)
    assert (name, len(curve.tau) > 1) == ("LeftArm", True)


def test_the_window_takes_the_detector_of_a_file(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(DETECTORS, "_given", {})
    monkeypatch.setattr(__main__, "_missing_for_window", lambda: "")
    monkeypatch.setattr(
        app, "run_inspector", lambda _: seen.append((*DETECTORS, os.environ[FILE_VARIABLE]))
    )
    place = f"{EXAMPLE / 'steps_detector.py'}:StepsDetector"
    monkeypatch.chdir(EXAMPLE)
    __main__.main(["--detector", "steps_detector.py:StepsDetector"])
    assert seen == [("consistency", "paper", "steps", place)]
    assert FILE_VARIABLE not in os.environ


def test_a_file_without_a_detector_opens_no_window(capsys, monkeypatch):
    monkeypatch.setattr(__main__, "_missing_for_window", lambda: "")
    assert __main__.main(["--detector", "none.py:Own"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("twist-inspector: none.py: expected a Python file")
    assert said.count("\n") == 1
