"""Chains that a person adds and removes: by mouse and keys, undone, killed, kept for a skeleton."""

import json
import shutil

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialogButtonBox

from inspector.language import use_language
from inspector.session.export_files import ExportChoice
from inspector.session.opening import analyse_file
from inspector.session.rig_profiles import rig_path
from inspector.session.session_files import journals, session_path
from inspector.session.settings import Settings
from tests.conftest import ASSETS
from tests.gui.windows import act, export, open_clip
from twistcore.cli import main
from twistcore.review import Decision, read_session
from twistcore.skeleton.rig import OwnChain, Rig, read_rig

ONE_WINDOW = True
SPINE = OwnChain(("Spine", "Spine1", "Neck1"))
Key = Qt.Key


@pytest.fixture
def reviewed(qtbot, window_for_clips, clip):
    """A copy of the walk with errors in a window with default settings."""
    window = window_for_clips(Settings())
    open_clip(qtbot, window, clip)
    return window


def add_by_keys(qtbot, window, *joints):
    """The dialog from its key to Enter: names typed, Tab between."""
    qtbot.keyClick(
        window, Key.Key_C, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    )
    dialog = window.chain_actions.dialog
    assert QTest.qWaitForWindowActive(dialog, 60_000)
    for box, name in zip(dialog.joints, joints, strict=False):
        box.setFocus()
        box.lineEdit().selectAll()
        qtbot.keyClicks(box.lineEdit(), name)
        if (popup := box.completer().popup()).isVisible():  # it has the keyboard
            qtbot.keyClick(popup, Key.Key_Escape)
    return dialog


def confirm(qtbot, window, dialog):
    with qtbot.waitSignal(window.document.chains_changed, timeout=10_000):
        qtbot.keyClick(dialog, Key.Key_Return)


def change(qtbot, window, name):
    with qtbot.waitSignal(window.document.chains_changed, timeout=10_000):
        act(window, name)


def names(window):
    return [c.name for c in window.document.data.chains]


def shown(window):
    model = window.chains.table.model()
    return [thing.chain for thing in model.things]


@pytest.mark.thorough
def test_a_chain_of_the_spine_is_added_by_keys(qtbot, reviewed):
    window, document = reviewed, reviewed.document
    dialog = add_by_keys(qtbot, window, "Spine", "Spine1", "Neck1")
    assert "Spine → Spine1 → Neck1" in dialog.status.text()
    confirm(qtbot, window, dialog)
    assert names(window)[-1] == "Spine"
    assert "Spine" in shown(window)
    assert document.chain == "Spine"
    assert "Spine" in document.review.undo_text
    assert window.docks["chains"].windowTitle() == "Chains (1 added)"
    assert len(document.detector.strength("Spine")) == document.frames
    assert window.chain_actions.dialog is None
    act(window, "undo")
    assert "Spine" not in names(window)
    assert document.chain != "Spine"
    act(window, "redo")
    assert names(window)[-1] == "Spine"


@pytest.mark.thorough
def test_the_dialog_starts_with_joints_that_make_a_chain(qtbot, reviewed):
    dialog = add_by_keys(qtbot, reviewed)
    assert "LHipJoint: LHipJoint → LeftUpLeg → LeftLeg" in dialog.status.text()
    dialog.reject()


def test_a_limb_is_added_and_another_one_removed(qtbot, reviewed):
    window, document = reviewed, reviewed.document
    dialog = add_by_keys(qtbot, window, "Spine1")
    box = dialog.limb
    qtbot.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))
    assert dialog.limb.isChecked()
    dialog.joints[1].setCurrentText("LeftArm")
    dialog.joints[2].setCurrentText("LeftHand")
    assert "Spine1-LeftHand: Spine1 → LeftArm → LeftHand" in dialog.status.text()
    confirm(qtbot, window, dialog)
    assert document.chain == "Spine1-LeftHand"
    assert document.limb is not None
    document.select_chain("RightArm-RightHand")
    change(qtbot, window, "remove_chain")
    assert {"Spine1-LeftHand", "RightArm"} <= set(shown(window))
    assert "RightArm-RightHand" not in shown(window)
    act(window, "undo")
    assert document.chain == "RightArm-RightHand"


@pytest.mark.thorough
def test_what_is_wrong_is_said_in_the_dialog(qtbot, reviewed):
    dialog = add_by_keys(qtbot, reviewed, "LeftArm")
    ok = dialog.buttons.button(QDialogButtonBox.StandardButton.Ok)
    assert "already" in dialog.status.text()
    assert not ok.isEnabled()
    dialog.joints[0].setCurrentText("Spine9")
    assert "'Spine9'" in dialog.status.text()
    dialog.joints[0].setCurrentText("Spine")
    assert [box.currentText() for box in dialog.joints] == ["Spine", "Spine1", "Neck1"]
    assert ok.isEnabled()  # the neck lies in the place of the upper spine
    dialog.joints[1].setCurrentText("Head")
    assert "Spine" in dialog.status.text()
    qtbot.keyClick(dialog, Key.Key_Escape)
    assert reviewed.chain_actions.dialog is None
    assert reviewed.document.review.position == 0


@pytest.mark.thorough
def test_the_right_button_removes_a_chain_and_undo_brings_its_decisions_back(qtbot, reviewed):
    window, document = reviewed, reviewed.document
    own = [j.id for j in document.intervals if j.interval.chain == "LeftForeArm"]
    document.select_interval(own[0])
    act(window, "accept")
    before = document.review.state
    table = window.chains.table
    row = shown(window).index("LeftForeArm")
    place = table.visualRect(table.model().index(row, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    remove = window.actions_by_id["remove_chain"]
    assert remove in table.actions()
    with qtbot.waitSignal(document.chains_changed, timeout=10_000):
        remove.trigger()
    assert "LeftForeArm" not in names(window)
    assert not [j for j in document.intervals if j.interval.chain == "LeftForeArm"]
    assert window.bar.label.text()
    act(window, "undo")
    use_language("de")
    try:
        with qtbot.waitSignal(document.chains_changed, timeout=10_000):
            remove.trigger()
        assert document.review.undo_text == "Kette Unterarm links entfernen"
        act(window, "undo")
    finally:
        use_language("en")
    assert document.review.state is before
    assert "LeftForeArm" in shown(window)
    assert document.review.state.find(own[0]).decision == Decision.ACCEPTED


@pytest.mark.thorough
def test_all_views_show_a_chain_that_was_added(qtbot, reviewed, tmp_path):
    """Curves, both detectors, teaching, tuning, a hand-made interval, and the figure."""
    window, document = reviewed, reviewed.document
    confirm(qtbot, window, add_by_keys(qtbot, window, "Neck", "Neck1", "Head"))
    for name in ("show_teaching", "show_tuning", "both_detectors", "skin", "focus_chain"):
        act(window, name)
        qtbot.wait(30)
    assert "Neck" in [line.chain for line in window.tuning.profiles.model.things]
    document.go_to(100)
    act(window, "insert_interval")
    assert document.interval.interval.chain == "Neck"
    act(window, "accept")
    assert np.abs(document.offset("Neck")).max() > 0.0
    document.use_method("paper")
    qtbot.waitUntil(lambda: document.method == "paper", timeout=10_000)
    change(qtbot, window, "restore_chains")
    assert document.method == "paper"
    act(window, "undo")
    act(window, "undo")
    assert document.review.state.method == "consistency"
    assert document.chain == "Neck"


@pytest.mark.thorough
def test_the_export_of_own_chains_is_what_apply_makes(qtbot, reviewed, clip, tmp_path):
    window, document = reviewed, reviewed.document
    confirm(qtbot, window, add_by_keys(qtbot, window, "Spine", "Spine1", "Neck1"))
    change_to = [j.id for j in document.intervals if j.interval.chain == "LeftForeArm"]
    document.go_to(120)
    act(window, "insert_interval")
    act(window, "accept")
    document.select_chain("RightLeg")
    change(qtbot, window, "remove_chain")
    document.decide(Decision.ACCEPTED, change_to)
    out = clip.with_name("out.bvh")
    export(window, ExportChoice(out))
    replayed = tmp_path / "replayed.bvh"
    replay = out.with_suffix(".replay.json")
    assert json.loads(replay.read_bytes())["rig"] == {
        "add": [{"joints": ["Spine", "Spine1", "Neck1"]}],
        "remove": ["RightLeg"],
    }
    assert main(["apply", str(replay), str(clip), "-o", str(replayed)]) == 0
    assert out.read_bytes() == replayed.read_bytes() != clip.read_bytes()
    window.files.save_session()
    assert read_session(session_path(clip)).state.rig == Rig((SPINE,), ("RightLeg",))
    again = analyse_file(clip)
    assert again.analysis.rig == document.review.state.rig
    assert [c.name for c in again.chains] == names(window)


@pytest.mark.thorough
def test_a_rig_profile_is_for_other_clips_of_the_skeleton(qtbot, reviewed, clip):
    window = reviewed
    confirm(qtbot, window, add_by_keys(qtbot, window, "Spine", "Spine1", "Neck1"))
    act(window, "keep_rig")
    kept = rig_path(window.document.data.motion.skeleton)
    assert read_rig(kept) == Rig((SPINE,))
    other = shutil.copy(ASSETS / "walk.bvh", clip.with_name("other.bvh"))
    window.document.review.mark_saved()
    open_clip(qtbot, window, other)
    assert names(window)[-1] == "Spine"
    assert window.document.review.saved
    change(qtbot, window, "restore_chains")
    act(window, "use_rig")
    qtbot.waitUntil(lambda: "Spine" in names(window), timeout=10_000)
    act(window, "undo")
    act(window, "keep_rig")
    assert not kept.exists()


def test_a_damaged_rig_profile_is_set_aside(clip):
    place = rig_path(analyse_file(clip).motion.skeleton)
    place.parent.mkdir(parents=True)
    for text in ("[[chain", '[[chain]]\njoints = ["Spine", "Tail"]\n', "remove = 3\n"):
        place.write_text(text, "utf-8")
        found = analyse_file(clip)
        assert not found.analysis.rig
        assert "was renamed to" in found.notes[0]
        assert not place.exists()
    assert len(list(place.parent.iterdir())) == 3


@pytest.mark.thorough
def test_a_clip_that_changed_on_disk_keeps_the_chains_of_its_session(qtbot, reviewed, clip):
    """So that what was decided in them can be carried over."""
    window = reviewed
    confirm(qtbot, window, add_by_keys(qtbot, window, "Spine", "Spine1", "Neck1"))
    window.document.go_to(120)
    act(window, "insert_interval")
    act(window, "accept")
    window.files.save_session()
    data = clip.read_bytes()
    clip.write_bytes(data[: data.rindex(b".")] + b".5\n")
    open_clip(qtbot, window, clip)
    assert window.document.data.earlier
    assert "Spine" in names(window)
    (carry,) = [b for b in window.bar.buttons() if b.text() == "Carry over decisions"]
    carry.click()
    (own,) = window.document.review.state.of_chain("Spine")
    assert own.decision == Decision.ACCEPTED


@pytest.mark.thorough
def test_own_chains_survive_kill_9(start, clip):
    program = start(clip)
    program.tell("add Spine Spine1 Neck1", "remove LeftForeArm", "accept 0", "undo", "accept 0")
    assert program.answer["chains"][-1] == "Spine"
    assert "LeftForeArm" not in program.answer["chains"]
    found = program.answer
    program.kill()
    assert journals(session_path(clip))
    again = start(clip)
    assert "LeftForeArm" in again.answer["chains"]
    again.tell("press Restore", "wait_for_chains")
    for key in ("chains", "decisions"):
        assert again.answer[key] == found[key]
    again.tell("undo", "undo", "wait_for_chains")
    assert "LeftForeArm" in again.answer["chains"]
    again.kill()
    third = start(clip)
    third.tell("press Restore", "wait_for_chains")
    assert third.answer["chains"][-1] == "Spine"
    assert "LeftForeArm" in third.answer["chains"]
    third.kill()
