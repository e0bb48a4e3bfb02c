"""How large an error is, and in how many frames: one number in the batch and on every page."""

import math

import numpy as np
import pytest

from tests.twistcore.reviews import CHAINS, CLIP
from twistcore.analysis import ClipAnalysis
from twistcore.batch.clip_result import processed
from twistcore.batch.parameters import Parameters
from twistcore.detection import Interval
from twistcore.report.clip_page import clip_page
from twistcore.report.report_document import Report, report_to_json
from twistcore.review import start_review
from twistcore.rotation import largest_and_rms


def test_an_angle_beyond_a_half_turn_counts_by_the_shorter_way():
    largest, rms = largest_and_rms(np.radians([243.0, -30.0]))
    assert largest == pytest.approx(117.0)
    assert rms == pytest.approx(math.sqrt((117.0**2 + 30.0**2) / 2.0))
    assert largest_and_rms([]) == (0.0, 0.0)


def test_a_batch_and_a_page_say_the_same_of_it(monkeypatch):
    found = Interval("LeftForeArm", 10, 12, np.radians([243.0, -30.0]), 0.9)
    real = ClipAnalysis.detect

    def detect(self, *words, **more):
        detection = real(self, *words, **more)
        object.__setattr__(detection, "intervals", (found,))
        return detection

    monkeypatch.setattr(ClipAnalysis, "detect", detect)
    _, document, _ = processed(CLIP.path, Parameters())
    assert document["degrees"]["max"] == pytest.approx(117.0)
    assert document["degrees"]["rms"] == pytest.approx(85.408, abs=1e-3)
    state = start_review("consistency", {c.name: 0.1 for c in CHAINS}, [found], [])
    report = Report(CLIP, CHAINS, state, CLIP.motion)
    page = clip_page(report_to_json(report), report)
    assert '<td class="n">117.00°</td><td class="n">85.41°</td>' in page
