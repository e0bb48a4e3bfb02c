"""How large an error is, and in how many frames: one number in the batch and on every page."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.twistcore import amc_files
from tests.twistcore.batch_records import done, interval
from tests.twistcore.reviews import CHAINS, CLIP, flip
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.clip_severity import percent_of_frames_with_error
from twistcore.batch.clip_result import process_clip
from twistcore.batch.parameters import Parameters
from twistcore.batch.result_files import clip_result_row
from twistcore.detection import Interval
from twistcore.report.clip_page import clip_page_html
from twistcore.report.document import Report, report_to_json
from twistcore.report.folder_numbers import FolderNumbers
from twistcore.review import start_review
from twistcore.skeleton.rotation import largest_and_rms_angle_degrees


def test_an_angle_beyond_a_half_turn_counts_by_the_shorter_way():
    largest, rms = largest_and_rms_angle_degrees(np.radians([243.0, -30.0]))
    assert largest == pytest.approx(117.0)
    assert rms == pytest.approx(math.sqrt((117.0**2 + 30.0**2) / 2.0))
    assert largest_and_rms_angle_degrees([]) == (0.0, 0.0)


def finding(monkeypatch, *found):
    """Let every analysis find these intervals."""
    real = ClipAnalysis.detect

    def detect(self, *words, **more):
        return replace(real(self, *words, **more), intervals=found)

    monkeypatch.setattr(ClipAnalysis, "detect", detect)


def test_a_batch_and_a_page_say_the_same_of_it(monkeypatch):
    found = Interval("LeftForeArm", 10, 12, np.radians([243.0, -30.0]), 0.9)
    finding(monkeypatch, found)
    _, document, _ = process_clip(CLIP.path, Parameters())
    assert document["degrees"]["max"] == pytest.approx(117.0)
    assert document["degrees"]["rms"] == pytest.approx(85.408, abs=1e-3)
    state = start_review("consistency", {c.name: 0.1 for c in CHAINS}, [found], [])
    report = Report(CLIP, CHAINS, state, CLIP.motion)
    page = clip_page_html(report_to_json(report), report)
    assert '<td class="n">117.00°</td><td class="n">85.41°</td>' in page


def test_a_batch_counts_as_applied_what_was(monkeypatch, tmp_path):
    """Of two flips of a limb whose end has one channel that with the end carried is taken out."""
    limb = "rfemur-rfoot"
    carried = flip(limb, 20, 30, 170.0, carried=True)
    finding(monkeypatch, carried, flip(limb, 60, 68, 172.0))
    path = amc_files.written(tmp_path, False)
    clip, document, corrected = process_clip(path, Parameters(refine=True))
    assert corrected != clip.data
    assert document["applied"] == 1
    (told,) = [w for w in document["warnings"] if "not corrected" in w]
    assert told.startswith(limb)
    assert told.endswith("rfoot")


def test_the_share_of_frames_is_of_frames_and_of_none_it_is_none():
    assert percent_of_frames_with_error(10, 40) == 25.0
    assert percent_of_frames_with_error(0, 0) == 0.0


def test_the_table_and_the_page_have_the_same_share():
    walk = done("a.bvh", interval())
    numbers = FolderNumbers()
    row = numbers.add(walk)
    share = percent_of_frames_with_error(walk.result["affected_frames"], walk.result["frames"])
    assert 0.0 < share < 100.0
    assert clip_result_row(walk)["affected_percent"] == row.share == numbers.share == share
    numbers.add(done("b.bvh"))
    assert numbers.share == share / 2
