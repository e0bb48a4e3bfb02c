"""What corrections made worse, in a clip's report: sums in the table, rows by name."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.reviews import CHAINS, CLIP, LIMBS
from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.correction.protected_measures import ENDS, NAMES, ROLL
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Interval
from twistcore.formats.bvh import read_bvh
from twistcore.report.changes import sum_correction_effects_on_measures
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review import Decide, Decision, Review

EVERY = (*CHAINS, *LIMBS)


@pytest.fixture(scope="module")
def found():
    return detect(CLIP)


def test_sums_count_what_got_better_and_name_what_got_worse(found):
    right = [i for i in found if i.repairable and not i.open]
    sums = {s.name: s for s in sum_correction_effects_on_measures(CLIP.motion, EVERY, right, right)}
    assert set(sums) <= set(NAMES)
    assert not any(s.worse or s.rows for s in sums.values())
    assert sums[ROLL].measured == sums[ROLL].better == len(right)
    assert sums[ROLL].most == 0.0
    assert (sums[ENDS].measured, sums[ENDS].better) == (len(right), 0)
    wrong = replace(right[0], offset=-right[0].offset)  # twice the error instead of none
    worse = {
        s.name: s
        for s in sum_correction_effects_on_measures(CLIP.motion, EVERY, [wrong, *right[1:]], right)
    }
    (row,) = worse[ROLL].rows
    assert (row.chain, row.start, row.stop) == (wrong.chain, wrong.start, wrong.stop)
    assert worse[ROLL].most == pytest.approx(row.after - row.before)
    assert worse[ROLL].better == len(right) - 1


def test_corrections_are_measured_with_the_others_done():
    """A step of 60° and, right behind it, one of 110° more: each alone leaves the other's edge."""
    clean = read_bvh(ASSETS / "walk.bvh").motion
    both = [
        Interval("RightArm", start, start + 20, np.full(20, math.radians(degrees)))
        for start, degrees in ((100, 60.0), (120, 110.0))
    ]
    wrong = refine(clean, CHAINS, [i.with_offset(i.start, -i.offset) for i in both])
    assert not any(s.worse for s in sum_correction_effects_on_measures(wrong, CHAINS, both, both))
    assert any(s.worse for s in sum_correction_effects_on_measures(wrong, CHAINS, both[:1], both))


def test_the_report_has_the_table_and_the_rows_that_got_worse(found, tmp_path):
    review = Review.of(found)
    ids = tuple(j.id for j in review.state.intervals if j.interval.repairable)
    state = Decide(ids, Decision.ACCEPTED).apply(review.state)
    first = state.intervals[0]
    wrong = replace(first, interval=replace(first.interval, offset=-first.interval.offset))
    state = replace(state, intervals=(wrong, *state.intervals[1:]))
    chosen = [j.interval for j in state.intervals]
    refined = refine(CLIP.motion, EVERY, chosen)
    page, *_, listing = write_clip_report(tmp_path, Report(CLIP, EVERY, state, refined))
    listed = json.loads(listing.read_text("utf-8"))["protected"]
    roll = next(m for m in listed if m["name"] == ROLL)
    assert [r["chain"] for r in roll["rows"]] == [wrong.interval.chain]
    assert math.isfinite(roll["most"])
    text = page.read_text("utf-8")
    assert "must not make worse" in text
    assert f"Worse ({ROLL}): {wrong.interval.chain} {wrong.interval.start}" in text.replace(
        "&#39;", "'"
    )


def test_a_report_without_corrections_has_no_such_table(found, tmp_path):
    page, *_, listing = write_clip_report(
        tmp_path, Report(CLIP, EVERY, Review.of(found).state, CLIP.motion)
    )
    assert json.loads(listing.read_text("utf-8"))["protected"] == []
    assert "must not make worse" not in page.read_text("utf-8")
