"""What joints were taken for, what was not examined, and whose chains are shown."""

import pytest
from PySide6.QtWidgets import QDialogButtonBox

from inspector.session.rig_profiles import rig_path
from inspector.session.settings import Settings
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from tests.twistcore.two_people import two_people
from twistcore.rig import read_rig

FINGERS = "LeftFingerPlate"  # a hand whose name is that of a part of one


def opened(qtbot, show_window, tmp_path, data):
    clip = tmp_path / "clip.bvh"
    clip.write_bytes(data)
    window = show_window(Settings(), tmp_path / "settings.json")
    open_clip(qtbot, window, clip)
    return window


@pytest.fixture
def odd(qtbot, show_window, tmp_path):
    """The walk with a left hand of an odd name in a window."""
    data = (ASSETS / "walk.bvh").read_bytes().replace(b"JOINT LeftHand\r", b"JOINT LeftHand\n")
    text = data.decode()
    lines = [FINGERS.join(x.split("LeftHand")) if x.split()[-1:] == ["LeftHand"] else x
             for x in text.split("\n")]  # fmt: skip
    return opened(qtbot, show_window, tmp_path, "\n".join(lines).encode())


def test_what_was_not_examined_is_named_above_the_chains(odd):
    assert odd.chains.unexamined.isVisible()
    assert "forearm" in odd.chains.unexamined.text()
    assert not odd.chains.people.isVisible()


def test_a_hand_is_named_and_its_arm_is_examined(qtbot, odd):
    act(odd, "joint_names")
    dialog = odd.chain_actions.names
    box = dialog.choices[FINGERS]
    assert "forearm" in dialog.told.text()
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


def test_one_person_of_two_is_listed(qtbot, show_window, tmp_path):
    window = opened(qtbot, show_window, tmp_path, two_people())
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


def test_a_clip_that_cannot_be_examined_says_so(qtbot, show_window, tmp_path):
    lines = (ASSETS / "walk.bvh").read_text("utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    short = [*lines[:at], "Frames: 3", lines[at + 1], *lines[at + 2 : at + 5]]
    window = opened(qtbot, show_window, tmp_path, "\n".join(short).encode())
    assert window.document.data.analysis.not_examined
    assert window.chains.unexamined.isVisible()
    assert window.chains.unexamined.text() == window.intervals._hint.text()
