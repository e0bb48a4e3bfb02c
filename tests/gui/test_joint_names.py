"""What joints were taken for, what was not examined, and whose chains are shown."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialogButtonBox, QLabel

from benchmarks._rigs import rigged
from inspector.session.rig_profiles import rig_path
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from tests.twistcore.test_strangers import BY_NAME, UNREAL, WALK
from tests.twistcore.two_people import two_people
from twistcore.formats.bvh.compose import bvh_text
from twistcore.skeleton.rig import read_rig

ONE_WINDOW = True
FINGERS = "LeftFingerPlate"  # a hand whose name is that of a part of one


def opened(qtbot, window_for_clips, tmp_path, data):
    clip = tmp_path / "clip.bvh"
    clip.write_bytes(data)
    window = window_for_clips(Settings())
    open_clip(qtbot, window, clip)
    return window


@pytest.fixture
def odd(qtbot, window_for_clips, tmp_path):
    """The walk with a left hand of an odd name in a window."""
    data = (ASSETS / "walk.bvh").read_bytes().replace(b"JOINT LeftHand\r", b"JOINT LeftHand\n")
    text = data.decode()
    lines = [FINGERS.join(x.split("LeftHand")) if x.split()[-1:] == ["LeftHand"] else x
             for x in text.split("\n")]  # fmt: skip
    return opened(qtbot, window_for_clips, tmp_path, "\n".join(lines).encode())


def test_what_was_not_examined_is_named_above_the_chains(odd):
    assert odd.chains.unexamined.isVisible()
    assert "forearm" in odd.chains.unexamined.text()
    assert not odd.chains.people.isVisible()


@pytest.mark.thorough
def test_a_hand_is_named_and_its_arm_is_examined(qtbot, odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    box = dialog.choices[FINGERS]
    assert "forearm" in dialog.status.text()
    dialog.search.setText("finger")
    shown = [r for r in range(dialog.table.rowCount()) if not dialog.table.isRowHidden(r)]
    names = list(dialog.choices)
    assert FINGERS in [names[r] for r in shown]
    assert "LeftUpLeg" not in [names[r] for r in shown]
    box.setCurrentIndex(box.findData("left hand"))
    assert dialog.names == {FINGERS: "left hand"}
    with qtbot.waitSignal(odd.document.chains_changed, timeout=60_000):
        dialog.buttons.button(QDialogButtonBox.StandardButton.Ok).click()
    data = odd.document.data
    assert "LeftForeArm" in {c.name for c in data.chains}
    assert not odd.chains.unexamined.isVisible()
    assert odd.document.review.state.rig.names == {FINGERS: "left hand"}
    assert read_rig(rig_path(data.motion.skeleton)).names == {FINGERS: "left hand"}
    with qtbot.waitSignal(odd.document.chains_changed, timeout=60_000):
        act(odd, "undo")
    assert odd.chains.unexamined.isVisible()


@pytest.mark.thorough
def test_all_joints_go_back_to_what_was_found(odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    box = dialog.choices["LeftFoot"]
    box.setCurrentIndex(box.findData("other"))
    assert dialog.names == {"LeftFoot": "other"}
    dialog.reset()
    assert dialog.names == {}
    before = odd.document.review.state
    dialog.buttons.button(QDialogButtonBox.StandardButton.Ok).click()
    assert odd.document.review.state is before


@pytest.mark.thorough
def test_one_person_of_two_is_listed(qtbot, window_for_clips, tmp_path):
    window = opened(qtbot, window_for_clips, tmp_path, two_people())
    people = window.document.data.analysis.people
    box = window.chains.people
    assert box.isVisible()
    assert [box.itemData(k) for k in range(box.count())] == ["", *people]
    box.setCurrentIndex(2)
    box.activated.emit(2)
    chains = window.document.data.chains_and_limbs
    assert {c.person for c in chains if c.name not in window.document.hidden} == {people[1]}
    assert window.document.find_chain(window.document.chain).person == people[1]
    box.setCurrentIndex(0)
    box.activated.emit(0)
    assert window.document.hidden == frozenset()


@pytest.mark.thorough
def test_a_clip_that_cannot_be_examined_says_so(qtbot, window_for_clips, tmp_path):
    lines = (ASSETS / "walk.bvh").read_text("utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    short = [*lines[:at], "Frames: 3", lines[at + 1], *lines[at + 2 : at + 5]]
    window = opened(qtbot, window_for_clips, tmp_path, "\n".join(short).encode())
    assert window.document.data.analysis.not_examined
    assert window.chains.unexamined.isVisible()
    said = window.chains.unexamined.text()
    assert "not enough" in said
    assert said == window.intervals._hint.text()
    assert window.detail.says(said)
    assert window.signs.decided.text() == "not examined"
    assert not window.chains._names.isVisible()  # no name of a joint helps
    for action in ("next_interval", "next_faint", "why_not"):
        window.bar.clear()
        act(window, action)
        assert window.bar.label.text() == said, action
    dialog = ExportDialog(window.document, window)
    assert said in [label.text() for label in dialog.findChildren(QLabel)]


@pytest.mark.thorough
def test_what_was_not_examined_is_said_where_all_is_decided(qtbot, odd):
    limb = odd.chains.unexamined.text()
    odd.document.go_to(100)
    odd.document.select_chain("RightArm")
    act(odd, "insert_interval")
    act(odd, "accept")
    assert all(j.decision == "accepted" for j in odd.document.intervals)
    assert odd.bar.label.text().endswith(limb)


def words(dialog, joint):
    """What a joint was taken for, and by what."""
    row = list(dialog.choices).index(joint)
    return tuple(dialog.table.item(row, column).text() for column in (1, 2))


@pytest.mark.thorough
def test_each_joint_says_what_it_was_taken_for_and_by_what(qtbot, odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    assert words(dialog, "RightArm") == ("Right Arm", "its name")
    assert words(dialog, "Spine") == ("trunk", "its name")
    assert words(dialog, FINGERS) == ("head, finger or prop", "its name")
    for said, taken in (("left hand", "Left Hand"), ("unknown", "unknown")):
        box = dialog.choices[FINGERS]
        box.setCurrentIndex(box.findData(said))
        assert words(dialog, FINGERS)[0] == taken
    dialog.reject()


@pytest.mark.thorough
def test_twist_bones_and_pieces_are_called_so(qtbot, window_for_clips, tmp_path):
    clip = tmp_path / "unreal.bvh"
    clip.write_text(bvh_text(UNREAL), "utf-8")
    window = window_for_clips(Settings())
    open_clip(qtbot, window, clip)
    act(window, "joint_names")
    dialog = window.chain_actions.names
    assert words(dialog, "upperarm_twist_01_l") == ("twist bone of Left Arm", "its name")
    assert dialog.status.text().startswith("10 chains, 12 twist bones")
    clip.with_name("human.bvh").write_text(bvh_text(rigged(WALK, BY_NAME["MakeHuman"])), "utf-8")
    open_clip(qtbot, window, clip.with_name("human.bvh"))
    act(window, "joint_names")
    dialog = window.chain_actions.names
    assert words(dialog, "upperarm02.L")[0] == "piece of Left Arm"


@pytest.mark.thorough
def test_the_table_is_gone_through_by_keys(qtbot, odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    assert QTest.qWaitForWindowActive(dialog, 5000)
    qtbot.waitUntil(dialog.search.hasFocus)
    qtbot.keyClicks(dialog.search, "LeftU")
    qtbot.keyClick(dialog.search, Qt.Key.Key_Return)  # to the joint, not out of the form
    assert odd.chain_actions.names is dialog
    assert dialog.focusWidget() is dialog.choices["LeftUpLeg"]
    assert dialog.table.currentRow() == list(dialog.choices).index("LeftUpLeg")
    dialog.search.clear()
    for joint in ("LeftLeg", "LeftFoot"):
        qtbot.keyClick(dialog.focusWidget(), Qt.Key.Key_Tab)
        assert dialog.focusWidget() is dialog.choices[joint]
    last = list(dialog.choices)[-1]
    dialog.choices[last].setFocus()
    shown = dialog.table.viewport().rect()
    row = dialog.table.visualItemRect(dialog.table.item(len(dialog.choices) - 1, 0))
    assert shown.contains(row.center())  # it has been scrolled to


@pytest.mark.thorough
def test_an_undo_is_followed_by_the_open_table(qtbot, odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    box = dialog.choices[FINGERS]
    box.setCurrentIndex(box.findData("left hand"))
    with qtbot.waitSignal(odd.document.chains_changed, timeout=60_000):
        dialog.accept()
    qtbot.waitUntil(lambda: odd.chain_actions.names is None)
    assert odd.bar.label.text()
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    assert dialog.names == {FINGERS: "left hand"}
    with qtbot.waitSignal(odd.document.chains_changed, timeout=60_000):
        act(odd, "undo")
    assert dialog.names == {}
    assert "forearm" in dialog.status.text()
