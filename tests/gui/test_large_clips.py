"""Large clips, as large as a test bears, worked on in the window: nothing goes wrong."""

import pytest

from benchmarks.alive import heard
from benchmarks.large_clips import long_clip, many_joints, measure
from tests.tiers import parametrize
from twistcore.review import Decision

pytestmark = pytest.mark.thorough

STEPS = 12


@parametrize(("make", "size", "least"), [(long_clip, (6_000,), 100), (many_joints, (100, 900), 10)])
def test_a_large_clip_is_opened_scrubbed_dragged_and_judged(
    qapp, show_window, tmp_path, make, size, least
):
    make(tmp_path / "large.bvh", *size)
    window = show_window()
    with heard() as said:
        found = measure(qapp, window, tmp_path / "large.bvh", STEPS)
    assert said.wrong == []
    intervals = window.document.intervals
    assert len(intervals) >= least
    accepted = sum(judged.decision == Decision.ACCEPTED for judged in intervals)
    assert accepted == STEPS // 3 - STEPS // 6, "of those judged, all but those undone"
    assert {what: len(times) for what, times in found.steps.items()} == {
        "the playhead anywhere": STEPS,
        "the next frame": STEPS,
        "zoom to the interval": 1,
        "a border dragged": STEPS,
        "zoom to all": 1,
        "τ dragged": STEPS,
        "undone": 1 + STEPS // 6,
        "to the next interval": STEPS // 3,
        "judged": STEPS // 3,
    }
