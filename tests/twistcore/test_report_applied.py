"""A page tells what was taken out of a clip: not what was only decided, and all that was."""

import csv
import json
import re
from collections import Counter

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore import amc_files
from tests.twistcore.reviews import CARRIED, CHAINS, CLIP, LIMBS, flip, flipped, spun
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.export.detection_json import intervals_to_json
from twistcore.formats.amc import read_amc
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.report.changes import detect_remaining_errors
from twistcore.report.clip_page import clip_page_html
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report, report_to_json
from twistcore.report.picture_job import Drawn
from twistcore.review import Decide, Decision, Review, start_review
from twistcore.review.replay import accepted_motion

LIMB = "rfemur-rfoot"
WHEN = "2026-01-02T10:00:00+00:00"


def reviewed(clip, chains, found, accepted, reviewer=""):
    tau = {c.name: 0.1 for c in chains}
    state = start_review("consistency", tau, found, [c.name for c in chains])
    when = WHEN if reviewer else ""
    for one in accepted:
        state = Decide((one,), Decision.ACCEPTED, reviewer, when).apply(state)
    return Report(clip, chains, state, accepted_motion(clip, chains, state))


@pytest.fixture
def foot(tmp_path):
    """A figure whose foot has one channel: of two flips that with the foot kept cannot be out."""
    clip = read_amc(amc_files.written(tmp_path, False))
    found = [flip(LIMB, 20, 30, 170.0, carried=True), flip(LIMB, 60, 68, 172.0)]
    return clip, analyse(clip).chains_and_limbs, found


@pytest.mark.parametrize("reviewer", ["", "Kim"])
def test_what_the_figure_cannot_have_taken_out_is_not_told_as_applied(tmp_path, foot, reviewer):
    report = reviewed(*foot, (1, 2), reviewer)
    page, table, markers, listing = write_clip_report(tmp_path / "out", report)
    document = json.loads(listing.read_bytes())
    done = "accepted" if reviewer else "applied automatically"
    assert [(i["decision"], i["stuck"]) for i in document["intervals"]] == [
        (done, ""), ("not correctable", "rfoot")
    ]  # fmt: skip
    told = {k: n for k, n in document["decisions"].items() if n}
    assert told == {done: 1, "not correctable": 1}
    (why,) = [w for w in document["warnings"] if "rfoot" in w]
    assert why.startswith(f"{LIMB} was not corrected in intervals that keep")
    assert document["changed"]["frames"] == 10
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    assert [row["decision"] for row in rows] == [done, "not correctable"]
    assert markers.read_text("utf-8").count("not correctable") == 1
    text = page.read_text("utf-8")
    assert '<b class="not">1</b> not correctable' in text
    assert why in text
    (line,) = re.findall(r'<tr><th scope="row">.*60–68 .*</tr>', text)
    assert line.count('<td class="n">–</td>') == 2  # nothing is taken out: no change
    assert 'class="not">not correctable: rfoot</td>' in line
    assert str(tmp_path) not in text


def test_there_is_no_picture_after_a_correction_that_there_is_not(foot):
    picture = (b"before", b"after")
    for accepted in ((1, 2), (1,)):
        report = reviewed(*foot, accepted)
        page = clip_page_html(report_to_json(report), report, Drawn((picture, picture)))
        assert page.count("<figcaption>Before<") == 2
        assert page.count("<figcaption>After<") == 1
        assert "If accepted<" not in page
        assert page.count("because rfoot has fewer than three rotation channels.") == 1


def find_panels(report):
    """The paths of 'after' in the worst finds, as many of them as there are strokes."""
    page = clip_page_html(report_to_json(report), report)
    finds = re.findall(r'<article class="find.*?</article>', page, re.DOTALL)
    return [sum(p.count("M") for p in re.findall(r'class="after" d="([^"]*)"', f)) for f in finds]


def test_what_is_applied_beside_a_find_is_drawn_as_applied():
    """Two of the worst near each other: both are drawn after the correction in both panels."""
    found = [
        new_constant_offset_interval("LeftForeArm", 100, 110, 0.9),
        new_constant_offset_interval("LeftForeArm", 130, 140, 0.8),
    ]
    assert find_panels(reviewed(CLIP, CHAINS, found, (1, 2))) == [2, 2]
    assert find_panels(reviewed(CLIP, CHAINS, found, (1,))) == [1, 2]
    assert find_panels(reviewed(CLIP, CHAINS, found, ())) == [1, 1]


def test_what_is_left_of_a_limb_is_told_by_the_limb_and_with_what_became_of_it(tmp_path):
    """As in `detect --json`, whose `chain` is the joint that a limb begins with."""
    write_clip(CLIP, flipped(CLIP.motion, flip(), CARRIED), tmp_path / "flipped.bvh")
    clip = read_clip(tmp_path / "flipped.bvh")
    found = analyse(clip).detect()
    chains, review = found.chains_and_limbs, Review.of(found)
    at = next(j.id for j in review.state.intervals if j.interval.start == CARRIED.start)
    state = Decide((at,), Decision.ACCEPTED).apply(review.state)
    report = Report(clip, chains, state, accepted_motion(clip, chains, state))
    left = intervals_to_json(detect_remaining_errors(report.refined, chains, state))
    names = {(i["chain"], i.get("limb"), i["start"]) for i in left}
    assert ("RightUpLeg", "RightUpLeg-RightFoot", 100) in names
    page = clip_page_html(report_to_json(report), report)
    after = page[page.index("examined again") :]
    row = r'<th scope="row">RightUpLeg-RightFoot</th><td>limb flip.*?>100–108<.*>undecided</td>'
    assert re.search(row, after)


def test_a_lone_jump_is_told_alike_wherever_it_stands(tmp_path):
    """It has no δ: its turn and speed stand beside its kind, before the correction and after."""
    write_clip(CLIP, spun("RightHand", 60, 61, 100.0, CLIP.motion), tmp_path / "spun.bvh")
    clip = read_clip(tmp_path / "spun.bvh")
    found = analyse(clip).detect()
    chains, review = found.chains_and_limbs, Review.of(found)
    review.accept()
    refined = accepted_motion(clip, chains, review.state)
    report = Report(clip, chains, review.state, refined)
    page = clip_page_html(report_to_json(report), report)
    told = r"<td>lone jump of RightHand, ([+-][\d.]+° at [\d,]+°/s)</td>(.*?)</tr>"
    told = re.findall(told, page)
    jumps = [i for i in found if not i.repairable and i.joint == "RightHand"]
    assert len(jumps) > 0
    assert len(told) == 2 * len(jumps)
    turns = Counter(f"{np.degrees(i.residual):+.2f}" for i in jumps)
    assert Counter(words.partition("°")[0] for words, _ in told) == turns + turns
    assert all('<td class="n">–</td>' in cells and "°</td>" not in cells for _, cells in told)


def test_a_jump_of_a_joint_is_listed_with_its_joint_and_its_angle():
    """Its chain is only the place in the list; another joint may have jumped."""
    clip = read_clip(ASSETS / "kick.bvh")
    found = analyse(clip).detect()
    review = Review.of(found)
    review.accept()
    refined = accepted_motion(clip, found.chains_and_limbs, review.state)
    report = Report(clip, found.chains_and_limbs, review.state, refined)
    page = clip_page_html(report_to_json(report), report)
    jumps = [i for i in found if i.kind in (Kind.JOINT_JUMP, Kind.SPIKE)]
    assert len(jumps) > 0
    for i in jumps:
        angle = abs(np.degrees(i.shown))
        assert f"<td>{i.kind} of {i.joint}, {angle:.2f}°</td>" in page
    before, after = page.split("examined again")
    listed = r"<td>(?:joint jump|spike) of \w+, [\d.]+°</td>"
    assert len(re.findall(listed, before)) == len(jumps)
    assert len(re.findall(listed, after)) == len(re.findall(r"<td>(?:joint jump|spike)", after)) > 0


def test_a_find_is_named_by_its_chain_and_the_pictures_say_what_they_show():
    """Right leg is a limb, Right Leg a chain: the name that tells them apart stands beside it."""
    found = [flip(), new_constant_offset_interval("LeftForeArm", 40, 45, 0.9)]
    report = reviewed(CLIP, (*CHAINS, *LIMBS), found, (1, 2))
    drawn = Drawn(((b"before", b"after"),) * 2)
    page = clip_page_html(report_to_json(report), report, drawn)
    assert page.count("The pictures show frame") == 2
    assert "The pictures show" not in clip_page_html(report_to_json(report), report)
    heads = dict(re.findall(r'<h3>([^<]*) <span class="soft small">([^<]*)</span> <span', page))
    assert heads == {"Right leg": "RightUpLeg-RightFoot", "Left ForeArm": "LeftForeArm"}
    after = re.findall(r'alt="The same frame ([^"]*)"', page)
    assert [("stripes" in words, "ForeArm" in words) for words in after] == [
        (False, False), (True, True)
    ]  # fmt: skip


def test_the_legend_of_the_curves_has_every_band():
    found = [new_constant_offset_interval("LeftForeArm", 20 * k, 20 * k + 9, 0.5) for k in range(2)]
    report = reviewed(CLIP, CHAINS, found, (1,))
    page = clip_page_html(report_to_json(report), report)
    legend = page[page.index('id="h-curves"') :].partition("</ul>")[0]
    assert re.findall(r'class="band (\w+)"', legend) == [
        "accepted", "undecided", "rejected", "seen"
    ]  # fmt: skip


def test_of_an_error_that_sets_in_softly_the_page_shows_what_the_window_shows():
    """Its largest angle: the median of a ramp depends on how far its ends are counted in."""
    chain = CHAINS[0]
    ramp = np.radians(np.concatenate([np.linspace(0.0, 40.0, 30), np.linspace(40.0, 0.0, 31)]))
    found = [Interval(chain.name, 40, 101, ramp)]
    report = reviewed(CLIP, CHAINS, found, [])
    page = clip_page_html(report_to_json(report), report)
    assert np.degrees(found[0].delta) == pytest.approx(20.0, abs=1.0)
    assert '<td class="n">+40.00°</td>' in page
