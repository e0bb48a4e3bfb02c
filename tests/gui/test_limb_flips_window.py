"""Flips of limbs in the window: listed, drawn, judged, kept, written, as twists are."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt

from inspector.panels import detail_card
from inspector.session.export_files import ExportChoice
from inspector.session.session_files import journals, session_path
from inspector.tuning.tuning_panel import Scope
from inspector.widgets.axes import degrees_to_root_scale
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.test_plots import drag, spot
from tests.gui.windows import act, export, open_clip, press
from tests.messages import numbers
from twistcore.analysis import clip_analysis as core
from twistcore.analysis.correction.twist_removal import refine
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.review import (
    Decide,
    Decision,
    Insert,
    Journal,
    Review,
    read_session,
    replay_journal,
    write_session,
)
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import limb_middle_and_end_positions
from twistcore.skeleton.rotation import wrap
from twistcore.tuning import Profile

ONE_WINDOW = True

LEG, CHAIN = "RightUpLeg-RightFoot", "RightUpLeg"
JUMPS = [14, 31, 34, 174]  # of the foot
FLIPS = [(14, 31), (34, 37), (38, 42), (45, 52), (73, 76), (174, 177)]


@pytest.fixture
def kick(tmp_path):
    """A copy of the clip of a dancer whose knee flips six times."""
    folder = tmp_path / "clips"
    folder.mkdir()
    return Path(shutil.copy(ASSETS / "kick.bvh", folder))


@pytest.fixture
def opened(qtbot, window, kick):
    """It in the window, with the settings that a first start has, the first flip selected."""
    open_clip(qtbot, window, kick)
    window.document.select_interval(flips(window)[0].id, jump=True)
    return window


def flips(window):
    return [j for j in window.document.intervals if j.interval.kind == Kind.LIMB_FLIP]


def cell(window, row, head):
    model = window.intervals.table.model()
    heads = [model.headerData(k, Qt.Orientation.Horizontal) for k in range(model.columnCount())]
    return model.index(row, heads.index(head)).data()


def values(window, key, name):
    return window.timeline.panes[key].values[name][0]


def test_flips_are_listed_beside_twists(qtbot, opened):
    document = opened.document
    assert [(j.interval.start, j.interval.stop) for j in flips(opened)] == FLIPS
    assert document.chain == LEG
    act(opened, "group_errors")  # off: each interval has a row of its own
    rows = range(opened.intervals.table.model().rowCount())
    listed = [(cell(opened, row, "Kind"), cell(opened, row, "Chain")) for row in rows]
    assert [row for row in listed if row[0] in ("lone jump", "limb flip")] == [
        *[("lone jump", "Right Leg")] * 4,
        *[("limb flip", "Right leg · limb")] * 6,
    ]
    chains = opened.chains.table.model()
    assert [chains.index(row, 0).data() for row in (8, 10, 13)] == [
        "Right UpLeg", "Left arm · limb", "Right leg · limb"
    ]  # fmt: skip
    tip = chains.index(13, 4).data(Qt.ItemDataRole.ToolTipRole)
    assert "RightUpLeg → RightLeg → RightFoot" in tip
    assert [chains.index(13, column).data() for column in (1, 2, 3, 4)] == [
        "0/6", "179.7°", "55.0°", "16 %"
    ]  # fmt: skip
    for wanted, count in (
        ("Limb flips", 6), ("Lone jumps", 4), ("Counter-twists", 0), ("All", len(listed))
    ):  # fmt: skip
        opened.intervals.filter.setCurrentText(wanted)
        assert len(opened.intervals.shown_ids()) == count


@pytest.mark.thorough
def test_curves_of_a_limb_follow_its_decisions(opened):
    document, panes = opened.document, opened.timeline.panes
    opened.timeline.refresh()
    assert opened.timeline.grid.shown == ["theta", "height", "strength", "offset"]
    swivel = document.limb.swivel
    was, now = values(opened, "theta", "p_before"), values(opened, "theta", "p_after")
    for start, stop in FLIPS:
        assert np.abs(wrap(np.radians(was[start:stop]) - swivel.angle[start:stop])).max() < 1e-9
    assert np.isnan(was[100:150]).all()
    assert np.abs(np.diff(now[1:])).max() < 45.0  # straight through, nothing at ±180°
    seams = panes["theta"].values["p_before"][1]
    assert not np.isin(seams, [13, 30, 33, 36]).any()  # real jumps are drawn
    refined = refine(
        document.data.motion,
        document.data.chains_and_limbs,
        document.review.state.chosen(undecided=True),
    )
    bent = swivel.height > 0.01
    again = swivel.angle_at(*limb_middle_and_end_positions(refined, document.find_chain(LEG)))
    assert np.abs(wrap(again - np.radians(now)))[bent].max() < 1e-9
    assert np.allclose(values(opened, "height", "height"), 100.0 * swivel.height)
    jumps = degrees_to_root_scale(np.degrees(np.abs(document.limb.departures)))
    assert np.allclose(values(opened, "strength", "strength"), jumps)
    assert np.nanmax(values(opened, "strength", "after")) < degrees_to_root_scale(20.0)
    document.decide(Decision.REJECTED, tuple(j.id for j in document.intervals))
    opened.timeline.refresh()
    assert np.allclose(wrap(np.radians(values(opened, "theta", "p_after")) - swivel.angle), 0.0)
    assert not values(opened, "offset", "offset").any()
    title = opened.timeline.panes["height"].front.title
    assert "Knee distance " in [text for text, _ in title]
    document.select_chain(CHAIN)
    opened.timeline.refresh()
    assert opened.timeline.grid.shown == ["theta", "delta", "strength", "offset"]
    assert not len(values(opened, "strength", "after"))
    document.select_chain("LeftArm-LeftHand")  # nearly straight at times: shaded
    opened.timeline.refresh()
    spans = opened.timeline.scenery.unreliable
    low = np.flatnonzero(document.limb.swivel.height < 0.03)
    assert sum(stop - start for start, stop in spans) == len(low) > 0


@pytest.mark.thorough
def test_tau_of_a_limb_is_dragged_in_one_step(qtbot, opened):
    document, timeline = opened.document, opened.timeline
    timeline.refresh()
    state, pane = document.review.state, timeline.panes["strength"]
    low, high = pane.view.viewRange()[1]
    share = (high - timeline.tau_line.value()) / (high - low)
    there = spot(timeline, "strength", 120, share), spot(timeline, "strength", 120, 0.0)
    drag(qtbot, timeline, "strength", *there)
    assert np.degrees(document.review.state.tau[LEG]) > 150.0
    assert len(flips(opened)) < 6
    press(qtbot, opened, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert document.review.state is state


def test_a_slow_edge_of_a_flip_is_not_told_as_a_jump_in_one_frame():
    edge = {"start": 865, "stop": 871, "jump_deg": 109.65}
    assert detail_card._jump(edge, 1) == "by +110° within 6 frames from frame 866"


def test_judged_by_keys_and_taken_back(qtbot, opened):
    document = opened.document
    state = document.review.state
    assert document.frame == 14
    press(qtbot, opened, Qt.Key.Key_A)
    press(qtbot, opened, Qt.Key.Key_R)
    assert [j.decision for j in flips(opened)[:3]] == [
        Decision.ACCEPTED, Decision.REJECTED, Decision.UNDECIDED
    ]  # fmt: skip
    title, why = opened.detail.title.text(), opened.detail.why.text()
    assert title == "<b>Right leg</b> · limb flip · 4 frames, varying δ"
    assert why.startswith("The right leg is flipped for 4 frames: the knee points ")
    assert "The knee jumps by +179° at frame 38 and back by −180° at frame 42." in why
    assert "Log odds" in opened.detail.why.toolTip()
    assert (opened.detail.end.name.text(), opened.detail.end.shown) == ("Foot:", "carried along")
    moved = document.corrected.pose(40)[0]
    press(qtbot, opened, Qt.Key.Key_C)
    assert not document.interval.interval.carried
    assert document.interval.edited
    assert opened.detail.end.shown == "kept"
    assert opened.detail.end.choices[False].isChecked()
    opened.detail.end.choices[False].click()  # it is already
    assert not document.interval.interval.carried
    foot = document.find_chain(LEG).end
    assert not np.allclose(document.corrected.pose(40)[0][foot], moved[foot])
    opened.detail.end.choices[True].click()
    assert document.interval.interval.carried
    for _ in range(4):
        press(qtbot, opened, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert document.review.state is state


@pytest.mark.thorough
def test_edited_and_made_by_hand_they_stay_flips(qtbot, opened):
    document, detail = opened.document, opened.detail
    detail.stop.setValue(33)
    detail.delta.setValue(170.0)
    edited = document.interval.interval
    assert (edited.kind, edited.carried, edited.stop) == (Kind.LIMB_FLIP, True, 33)
    assert np.degrees(edited.delta) == pytest.approx(170.0)
    act(opened, "make_level")
    assert np.ptp(document.interval.interval.offset) == 0.0
    act(opened, "make_following")
    after = np.degrees(document.corrected.swivel(document.find_chain(LEG))[13:34])
    assert np.abs(np.diff(after, n=2)).max() < 1e-6
    ids = tuple(j.id for j in document.intervals)
    document.decide(Decision.REJECTED, ids)
    document.select_chain(LEG)
    document.go_to(46)
    act(opened, "insert_interval")
    made = document.interval
    assert (made.interval.kind, made.by_hand) == (Kind.LIMB_FLIP, True)
    assert (made.interval.start, made.interval.stop, made.interval.carried) == (45, 52, True)
    assert abs(np.degrees(made.interval.delta)) > 170.0
    document.select_chain(CHAIN)
    act(opened, "insert_interval")
    assert document.interval.interval.kind == Kind.COUNTER_TWIST
    act(opened, "turn_end")
    assert "Only for these can the joints below keep their rotation" in opened.bar.label.text()
    assert opened.detail.end.isHidden()


@pytest.mark.thorough
def test_no_second_interval_is_inserted_on_the_same_frames(opened):
    """Both accepted would undo the correction; where the first is rejected there is room."""
    document = opened.document
    there = next(j for j in flips(opened) if (j.interval.start, j.interval.stop) == (45, 52))
    state = document.review.state
    document.select_chain(LEG)
    document.select_interval(None)
    document.go_to(46)
    act(opened, "insert_interval")
    assert (
        opened.bar.label.text()
        == "There is already an interval at frames 45–52. It is now selected."
    )
    assert document.review.state is state
    assert document.interval_id == there.id
    document.set_first_frame(1)
    act(opened, "insert_interval")
    assert (
        opened.bar.label.text()
        == "There is already an interval at frames 46–53. It is now selected."
    )
    document.decide(Decision.REJECTED, (there.id,))
    document.select_chain(LEG)
    document.go_to(46)
    act(opened, "insert_interval")
    assert document.interval.by_hand
    assert len(document.intervals) == len(state.intervals) + 1


@pytest.mark.thorough
def test_export_and_session_are_those_of_the_command_line(qtbot, opened, kick, tmp_path, capsys):
    press(qtbot, opened, Qt.Key.Key_C)
    opened.document.decide(Decision.ACCEPTED, [judged.id for judged in flips(opened)[:-1]])
    act(opened, "save_session")
    out = tmp_path / "out.bvh"
    export(opened, ExportChoice(out))
    message = opened.bar.label.text()
    assert (
        "joints moved (as a share of the figure's height): "
        "RightLeg by up to 20.5 % and RightToeBase by" in message
    )
    assert "No other joint moved. All other bytes" in message
    assert main(["apply", str(session_path(kick)), str(kick), "-o", str(tmp_path / "a.bvh")]) == 0
    assert out.read_bytes() == (tmp_path / "a.bvh").read_bytes()
    assert out.read_bytes() != kick.read_bytes()
    capsys.readouterr()
    document = json.loads(session_path(kick).read_bytes())
    assert document["schema"] == "twistcore.session/3"
    written = [i for i in document["intervals"] if i["kind"] == "limb flip"]
    assert [i["carried"] for i in written] == [False, *[True] * 4, False]
    state = opened.document.review.state
    open_clip(qtbot, opened, ASSETS / "walk.bvh")
    open_clip(qtbot, opened, kick)
    now = opened.document.review.state
    assert [(j.decision, j.interval.carried) for j in now.intervals] == [
        (j.decision, j.interval.carried) for j in state.intervals
    ]
    assert opened.document.review.saved
    assert opened.bar.label.text() == "Continuing your review from kick.twist.json."


def reviewed_before(kick):
    """A clip, and a review of its chains alone in which a hand-made twist is accepted."""
    clip = read_bvh(kick)
    review = Review.of(core.detect(clip, find_chains(clip.motion), kinds="counter-twist"))
    review.do(Insert(new_constant_offset_interval(CHAIN, 100, 120, 0.5)))
    review.do(Decide((1,), Decision.ACCEPTED))
    return clip, review.state


@pytest.mark.thorough
def test_a_session_from_before_gets_the_flips_and_loses_nothing(qtbot, window, kick):
    write_session(*reviewed_before(kick), session_path(kick))
    assert json.loads(session_path(kick).read_bytes())["schema"] == "twistcore.session/1"
    document = window.document
    open_clip(qtbot, window, kick)
    assert window.bar.label.text().endswith(" found, undecided.")
    (first,) = (j for j in document.intervals if j.by_hand)
    others = [j for j in document.intervals if not j.by_hand]
    assert (first.decision, first.interval.chain, first.by_hand) == (
        Decision.ACCEPTED, CHAIN, True
    )  # fmt: skip
    assert [(j.interval.start, j.interval.stop) for j in flips(window)] == FLIPS
    assert {j.decision for j in others} == {Decision.UNDECIDED}
    assert np.degrees(document.review.state.tau[LEG]) == pytest.approx(55.0)
    assert document.review.saved
    act(window, "save_session")
    assert len(read_session(session_path(kick)).state.intervals) == 1 + len(others)


@pytest.mark.thorough
def test_a_journal_from_before_is_restored_with_the_flips(kick, start):
    clip, state = reviewed_before(kick)
    Journal(Path(f"{session_path(kick)}.journal"), clip, state, 2).close()
    first = start(kick)
    found = first.answer["decisions"]
    assert set(found) == {"undecided"}
    first.tell("press Restore")
    restored = first.answer["decisions"]
    assert sorted(restored) == sorted(["accepted", *found])
    at = restored.index("undecided", restored.index("accepted"))
    first.tell(f"accept {at}")
    (left,) = journals(session_path(kick))
    first.kill()
    assert replay_journal(left).review.state.tau.keys() > state.tau.keys()
    second = start(kick)
    second.tell("press Restore")
    assert second.answer["decisions"] == [*restored[:at], "accepted", *restored[at + 1 :]]
    second.tell("undo", "save")
    assert second.accepted == 1
    second.end()
    assert not journals(session_path(kick))


@pytest.mark.thorough
def test_killed_with_a_flip_decided(kick, start):
    first = start(kick)
    kinds = [i.kind for i in core.analyse(read_bvh(kick)).detect()]
    flip = kinds.index(Kind.LIMB_FLIP)
    first.tell(f"accept {flip}", f"accept {flip + 1}")
    first.kill()
    second = start(kick)
    assert second.accepted == 0
    second.tell("press Restore")
    assert second.accepted == 2
    second.tell("save")
    second.end()
    state = read_session(session_path(kick)).state
    assert [j.interval.kind for j in state.intervals if j.decision == Decision.ACCEPTED] == [
        Kind.LIMB_FLIP
    ] * 2


@pytest.mark.thorough
def test_another_detector_or_profile_leaves_limbs_their_own_tau(qtbot, opened):
    document = opened.document
    document.use_profile(Profile({LEG: float(np.radians(100.0)), CHAIN: 0.1}, "consistency"))
    assert np.degrees(document.review.state.tau[LEG]) == pytest.approx(100.0)
    with qtbot.waitSignal(document.method_changed, timeout=20_000):
        act(opened, "use_paper")
    assert np.degrees(document.review.state.tau[LEG]) == pytest.approx(100.0)
    assert [(j.interval.start, j.interval.stop) for j in flips(opened)] == FLIPS
    act(opened, "undo")
    act(opened, "undo")
    assert np.degrees(document.review.state.tau[LEG]) == pytest.approx(55.0)


@pytest.mark.thorough
def test_a_limb_can_be_selected_on_every_tab(qtbot, opened):
    document = opened.document
    for tab in ("show_tuning", "show_teaching", "show_quality"):
        act(opened, tab)
        qtbot.wait(50)
        for chain in (CHAIN, LEG, "LeftArm-LeftHand", LEG):
            document.select_chain(chain)
            document.go_to(40)
            qtbot.wait(20)
    act(opened, "show_tuning")
    opened.tuning.refresh()
    assert "measured for chains" in opened.tuning.curves.cost_words.text()
    assert not opened.actions_by_id["suggest_tau"].isEnabled()
    opened.tuning.set_scope(Scope.ALL)
    assert opened.tuning.chains_in_scope() == tuple(
        limb.name for limb in document.data.analysis.limbs
    )
    opened.tuning.box.setValue(150.0)
    assert np.degrees(document.review.state.tau["LeftUpLeg-LeftFoot"]) == pytest.approx(150.0)
    act(opened, "both_detectors")
    assert "one detector" in opened.bar.label.text()
    assert "other" not in opened.timeline.grid.shown
    act(opened, "both_detectors")
    act(opened, "next_faint")


@pytest.mark.thorough
def test_other_flips_come_with_another_tau_of_the_same_review(opened):
    """What a person decided stays, whatever τ finds."""
    document = opened.document
    document.decide(Decision.ACCEPTED, (flips(opened)[0].id,))
    document.set_tau(float(np.radians(179.9)), LEG)
    (kept,) = flips(opened)
    assert (kept.interval.start, kept.supported) == (14, False)


@pytest.mark.thorough
def test_a_clip_without_flips_has_limbs_and_nothing_to_decide(qtbot, window, tmp_path):
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk.bvh", tmp_path))
    assert not flips(window)
    window.document.select_chain(LEG)
    window.timeline.refresh()
    assert not values(window, "offset", "offset").any()


@pytest.mark.thorough
def test_lone_jumps_are_listed_and_not_edited(opened):
    document, detail = opened.document, opened.detail
    jumps = [j for j in document.intervals if j.interval.kind == Kind.LONE_JUMP]
    assert [j.interval.start for j in jumps] == JUMPS
    document.select_interval(jumps[0].id, jump=True)
    assert detail.title.text() == "<b>Right Leg</b> · lone jump · 1 frame"
    assert detail.why.text().startswith(
        "At frame 14, RightFoot turns −66° about its own axis in a single frame. At 120 frames"
    )
    assert not detail.delta.isEnabled()
    assert detail.delta.value() == pytest.approx(-66.1, abs=0.01)
    state = document.review.state
    act(opened, "make_following")
    assert "detections of this kind are not corrected" in opened.bar.label.text()
    assert document.review.state is state
    act(opened, "accept")
    assert not document.offset("RightLeg").any()


@pytest.mark.thorough
def test_seen_lone_jumps_are_not_counted_as_corrected(opened, tmp_path):
    """Nor does an export of what is undecided decide about them."""
    document = opened.document

    def counted():
        act(opened, "export_dialog")
        dialog = opened.findChildren(ExportDialog)[-1]
        told = dialog.count.text(), dialog.undecided.text()
        dialog.reject()
        return told

    every = len(document.intervals)
    assert [numbers(text)[:3] for text in counted()] == [[0, 0, every], [6, every]]
    jumps = [j for j in document.intervals if j.interval.kind == Kind.LONE_JUMP]
    document.decide(Decision.ACCEPTED, [jumps[0].id])
    out = tmp_path / "out.bvh"
    export(opened, ExportChoice(out))
    assert "copy of the source clip. No correction was accepted." in opened.bar.label.text()
    document.decide(Decision.ACCEPTED, [flips(opened)[0].id])
    document.decide(Decision.REJECTED, [flips(opened)[1].id])
    assert [numbers(text)[:4] for text in counted()] == [[1, 1, 1, every - 3], [4, every - 3]]
    assert document.accept_undecided()
    assert numbers(counted()[0]) == [1, 1, 4, 1, every - 7]
