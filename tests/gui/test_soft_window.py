"""Errors that set in softly, in the window: shown, gone to, edited, and exported when sure."""

import numpy as np
import pytest

from inspector.panels.detail_card import explanation
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.skeleton.chain import find_chains

ONE_WINDOW = True
RAMP = np.radians(np.concatenate([np.arange(1, 13), np.full(10, 13), np.arange(12, 0, -1)]) * 6.0)


@pytest.fixture
def ramped(qtbot, window_for_clips, tmp_path):
    """The window with the walk, whose right shoulder ramps off and back."""
    clip = read_bvh(ASSETS / "walk.bvh")
    offset = np.zeros(clip.motion.frames)
    offset[80 : 80 + len(RAMP)] = -RAMP
    wrong = remove_twist(clip.motion, find_chains(clip.motion), {"RightShoulder": offset})
    write_clip(clip, wrong, tmp_path / "ramped.bvh")
    window = window_for_clips(Settings(turn_ms=0))
    open_clip(qtbot, window, tmp_path / "ramped.bvh")
    return window


def test_its_card_and_row_tell_the_largest_offset_and_how_it_sets_in(ramped):
    act(ramped, "next_interval")
    document, detail = ramped.document, ramped.detail
    (judged,) = document.intervals
    told = explanation(judged, document.find_chain("RightShoulder"), 0)
    assert "12 frames" in told
    assert "+78.0°" in told
    assert "+78.0°" in detail.title.text()
    assert detail.delta.value() == pytest.approx(78.0, abs=0.01)
    assert "Log odds" in detail.why.toolTip()
    model = ramped.intervals.table.model()
    assert "+78.0°" in [model.index(0, c).data() for c in range(model.columnCount())]
    seen = judged.interval.seen_at
    assert document.frame == seen > judged.interval.start
    assert abs(np.degrees(document.offset("RightShoulder")[seen])) >= 39.0


@pytest.mark.thorough
def test_the_strength_plot_shows_what_tau_acts_on(ramped):
    act(ramped, "next_interval")
    document, timeline = ramped.document, ramped.timeline
    (judged,) = document.intervals
    interval, pane = judged.interval, timeline.panes["strength"]
    size = np.square(pane.values["soft"][0])  # on the root scale
    inside = slice(interval.start, interval.stop)
    np.testing.assert_allclose(size[inside], np.degrees(np.abs(interval.offset)), atol=1e-6)
    assert np.isnan(np.delete(size, np.arange(interval.start, interval.stop))).all()
    title = "".join(text for text, _ in pane.front.title)
    assert "its maximum 78.0° is compared with τ" in title
    # It is listed exactly if τ is at most this maximum, which the strength reaches in one frame.
    largest = abs(interval.largest)
    strength = document.detector.strength("RightShoulder")[inside]
    assert strength.max() == pytest.approx(largest)
    for tau, listed in ((largest * 0.999, 1), (largest * 1.001, 0)):
        assert len(document.detector.intervals("RightShoulder", tau)) == listed
    document.set_tau(largest * 1.001)
    timeline.refresh()
    assert np.isnan(pane.values["soft"][0]).all()


@pytest.mark.thorough
def test_its_delta_stretches_the_course_and_undo_brings_it_back(ramped):
    act(ramped, "next_interval")
    document, detail = ramped.document, ramped.detail
    before = document.intervals[0].interval.offset
    detail.delta.setValue(39.0)
    edited = document.intervals[0]
    np.testing.assert_allclose(edited.interval.offset, 0.5 * before, atol=1e-4)
    assert detail.why.text()
    act(ramped, "undo")
    np.testing.assert_array_equal(document.intervals[0].interval.offset, before)


@pytest.mark.thorough
def test_a_moved_edge_keeps_the_course_between(ramped):
    act(ramped, "next_interval")
    document = ramped.document
    (judged,) = document.intervals
    before = judged.interval
    ramped.detail.start.setValue(before.start + 5)  # frames are counted from 1
    edited = document.intervals[0].interval
    assert edited.stop == before.stop
    np.testing.assert_array_equal(edited.offset, before.offset[edited.start - before.start :])


@pytest.mark.thorough
def test_an_export_of_what_is_undecided_corrects_what_is_sure(ramped):
    unasked = len(ramped.document.review.state.automatic_ids())
    act(ramped, "export_dialog")
    dialog = ramped.findChildren(ExportDialog)[-1]
    text = "Also correct 1 undecided" if unasked else "Also correct 0 of 1 undecided"
    assert dialog.undecided.text().startswith(text)
    assert dialog.undecided.isEnabled() == bool(unasked)
    dialog.reject()
    assert ramped.document.accept_undecided()
    assert len(ramped.document.review.accepted) == unasked
