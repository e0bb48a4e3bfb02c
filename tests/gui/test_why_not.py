"""Go → Why is nothing found here?, the card at a peak, and M past τ."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt

from inspector.session.why_here import reasons_at_unexplained_peaks
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip, press
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.analysis.why_not import Why
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import normalise

ARM, FRAME = "LeftArm", 200
SENTENCE = "at frame 200 is above τ = 1.5°, but only LeftArm turns there"
NOTHING = "Press N to go to the next interval."


@pytest.fixture
def alone(qtbot, window, lone_turn):
    """The walk in which a joint turns alone, in the window."""
    open_clip(qtbot, window, lone_turn)
    window.document.select_chain(ARM)
    window.document.select_interval(None)
    return window


@pytest.mark.thorough
def test_the_reason_is_told_at_the_playhead_or_at_the_peak_next_to_it(qtbot, alone):
    document = alone.document
    for frame in (FRAME - 3, FRAME, FRAME + 2):
        document.go_to(frame)
        act(alone, "why_not")
        assert alone.detail.why.text().startswith("Left Arm: ")
        assert SENTENCE in alone.detail.why.text()
        assert not alone.bar.isVisible()  # said once
    act(alone, "show_tuning")
    act(alone, "why_not")
    assert SENTENCE in alone.bar.label.text()
    document.go_to(FRAME + 40)
    assert not alone.bar.isVisible()  # it was about another frame
    press(qtbot, alone, Qt.Key.Key_Y)
    assert "τ = 1.5°" in alone.bar.label.text()
    assert document.frame == FRAME + 40


@pytest.mark.thorough
def test_in_an_interval_the_answer_is_about_it_and_not_about_a_peak_beside(opened):
    document, card = opened.document, opened.detail
    act(opened, "next_interval")
    own, number = document.interval.interval, document.interval_id
    boxes = (card.start, card.stop, card.delta)
    frame = own.stop - 1
    document.go_to(frame)
    act(opened, "why_not")
    said = f"Frame {frame} is in an interval: counter-twist {own.start}–{own.stop} ("
    assert said in opened.bar.label.text()
    document.select_interval(None)
    assert said in card.why.text()
    assert [box.text().strip() for box in boxes] == ["", "", ""]  # numbers of no interval
    assert document.interval is None
    document.select_interval(number)
    assert [box.value() for box in boxes[:2]] == [own.start, own.stop]
    assert "" not in [box.text().strip() for box in boxes]


def test_nothing_is_asked_without_a_clip(window):
    for name in ("why_not", "next_faint"):
        assert not window.actions_by_id[name].isEnabled()


def test_the_card_says_it_where_no_interval_is_selected(alone):
    document, card = alone.document, alone.detail
    document.go_to(FRAME + 40)
    assert card.why.text() == NOTHING
    document.go_to(FRAME + 1)
    assert SENTENCE in card.why.text()
    document.select_chain("RightArm")
    assert card.why.text() == NOTHING
    document.select_chain(ARM)
    assert SENTENCE in card.why.text()
    document.set_first_frame(1)
    assert "frame 201" in card.why.text()
    document.set_tau(np.radians(90.0), ARM)
    assert card.why.text() == NOTHING  # below τ: no peak


@pytest.mark.thorough
def test_a_selected_interval_is_what_the_card_is_about(opened):
    document = opened.document
    act(opened, "next_interval")
    assert document.interval is not None
    said = opened.detail.why.text()
    for frame in range(0, document.frames, 7):
        document.go_to(frame)
        assert opened.detail.why.text() == said


@pytest.mark.thorough
def test_nothing_suspicious_is_said_together_with_what_is_past_tau(alone):
    past = list(reasons_at_unexplained_peaks(alone.document))
    assert past
    assert not any(r.suspicious for r in past)
    assert {r.why for r in past} == {Why.ONE_JOINT}
    act(alone, "next_faint")
    assert alone.bar.label.text() == (
        "No suspicious moments were found down to half of τ. "
        f"{len(past)} peaks above τ are explained: at {len(past)} peaks, only one joint turns. "
        "For details choose Go → Why is nothing found here?"
    )


@pytest.mark.thorough
def test_m_goes_to_every_peak_past_tau_that_is_suspicious(qtbot, window, tmp_path):
    clip = read_bvh(ASSETS / "walk.bvh")
    steps = {"LeftArm": 120, "RightArm": 150, "LeftUpLeg": 180, "RightUpLeg": 180, "LeftLeg": 210}
    offsets = {
        name: np.where(np.arange(clip.motion.frames) < t, 0.0, np.radians(14.0))
        for name, t in steps.items()
    }  # each for good: nothing takes it back
    motion = remove_twist(clip.motion, find_chains(clip.motion), offsets)
    rng = np.random.default_rng(0)
    q = motion.rotations + rng.normal(scale=0.006, size=motion.rotations.shape)
    write_clip(clip, replace(motion, rotations=normalise(q)), tmp_path / "shaken.bvh")
    open_clip(qtbot, window, tmp_path / "shaken.bvh")
    document = window.document
    wanted = {(r.chain, r.frame) for r in reasons_at_unexplained_peaks(document) if r.suspicious}
    assert len(wanted) >= 3
    document.go_to(0)
    reached = {}
    for _ in range(500):
        act(window, "next_faint")
        here = document.chain, document.frame
        if here in reached:
            break
        reached[here] = window.bar.label.text()
    assert wanted <= set(reached)
    for chain, frame in wanted:
        assert f"at frame {frame} is above τ" in reached[chain, frame]
        assert document.find_chain(chain).label in reached[chain, frame]
