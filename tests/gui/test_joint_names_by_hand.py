"""Names of joints and a twist bone as a person has them: real keys and mouse, to the export."""

import re

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import needs_real_screen, watched
from tests.twistcore.test_strangers import UNREAL, rolled
from twistcore.formats.bvh import read_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.skeleton.rotation import geodesic_angle

pytestmark = [pytest.mark.thorough, needs_real_screen]
NAMED = {"reviewer": "Ada"}
DIALOG = "window.chain_actions.names"
HELPER = "upperarm_twist_01_l"
ODD = {  # the left arm says nothing and its hand is a finger, the right arm is something carried
    "LeftShoulder": "Qurbo", "LeftArm": "Zimta", "LeftForeArm": "Wexel", "LeftHand": "FingerPlate",
    "RightShoulder": "Da_prop", "RightArm": "Mu_prop", "RightForeArm": "Jo_prop",
    "RightHand": "He_prop",
}  # fmt: skip


def test_a_hand_is_named_and_its_arm_is_examined(screen, tmp_path):
    text = (ASSETS / "walk_injected.bvh").read_text("utf-8")
    text = re.sub(r"\b(?:Left|Right)(?:Shoulder|Arm|ForeArm|Hand)\b", lambda m: ODD[m[0]], text)
    clip = tmp_path / "odd.bvh"
    clip.write_text(text, "utf-8")
    with watched(screen, tmp_path, clip, settings=NAMED) as p:
        assert p.ask("window.chains.unexamined.text()").count("not examined") == 1
        screen.click(p.rect("window.chains._names"))
        screen.shown("Joint names")
        for joint, said in (("He_prop", "right hand"), ("FingerPlate", "left hand")):
            screen.click(p.rect(f"{DIALOG}.search"))
            screen.key("ctrl+a")
            screen.type(joint)
            screen.key("Return")  # to the joint, not out of the table
            choice = f"{DIALOG}.choices[{joint!r}]"
            p.until(f"{choice}.hasFocus()")
            screen.key("alt+Down")
            p.until("app.activePopupWidget() is not None")
            screen.type(said)
            screen.key("Return")
            p.until(f"{choice}.currentText() == {said!r}")
        p.until(f"{DIALOG}.status.text().startswith('10 chains')")
        screen.click(p.rect(f"{DIALOG}._use"))
        p.until("len(window.document.data.chains) == 10", 60.0)
        p.until("not window.chains.unexamined.isVisible()")
        # An arm that was found by its shape alone had its errors at the wrong joint.
        chains = p.ask("[j.interval.chain for j in window.document.intervals]")
        assert set(chains) == {"Wexel", "RightUpLeg"}
        p.until("'these names' in window.bar.label.text()")
        screen.key("ctrl+z")
        p.until("window.chains.unexamined.isVisible()")


def test_the_roll_of_a_twist_bone_is_reviewed_to_the_end(screen, tmp_path):
    degrees = np.zeros(UNREAL.frames)
    degrees[150:165] = 90.0
    clip = tmp_path / "popped.bvh"
    clip.write_text(bvh_text(rolled(UNREAL, HELPER, degrees)), "utf-8")
    with watched(screen, tmp_path, clip, settings=NAMED) as p:
        screen.key("n")
        p.until(f"window.document.chain == {HELPER!r}")
        p.until("window.viewport.scene.circled and window.viewport.sees_chain()")
        screen.key("a")
        p.until("'Ctrl+E' in window.bar.label.text()")
        assert p.decisions() == ["accepted"]
        screen.key("ctrl+shift+e")
        path = str(tmp_path / "popped_refined.bvh")
        p.until(f"__import__('os').path.isfile({path!r})", 60.0)
        p.until("'popped_refined' in window.bar.label.text()", 60.0)
    written, j = read_bvh(tmp_path / "popped_refined.bvh").motion, UNREAL.skeleton.index(HELPER)
    assert np.degrees(geodesic_angle(written.rotations, UNREAL.rotations)[:, j].max()) < 4.0
