"""What the curves are made of: seams, thinning, spans, proposals."""

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage, QPainter

from inspector.session.opening import analyse_file
from inspector.timeline.curve_values import (
    thin_curve_to_pixels,
    unreliable_spans,
    wrap_degrees_about,
)
from inspector.timeline.regions import Regions
from inspector.widgets.theme import LIGHT
from tests.gui.pictures import INJECTED
from twistcore.analysis.correction.corrected import _has_closed_form
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection.interval import Interval
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Insert, Judged
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import twist_signals

NO_SEAMS = np.zeros(0, dtype=np.int64)


@pytest.fixture(scope="module")
def sample():
    return analyse_file(INJECTED)


def test_signals_after_from_offsets_equal_those_of_the_corrected_motion(open_document):
    document = open_document(INJECTED)
    rng = np.random.default_rng(7)
    for chain in document.data.chains:  # every chain, neighbours above and below included
        for _ in range(3):
            start = int(rng.integers(1, document.frames - 60))
            stop = start + int(rng.integers(1, 50))
            delta = float(rng.uniform(-np.pi, np.pi))
            document.do(Insert(new_constant_offset_interval(chain.name, start, stop, delta)))
    clip = document.data
    whole = refine(clip.motion, clip.chains, document.review.state.chosen(undecided=True))
    for chain in clip.chains:
        assert _has_closed_form(clip.analysis, chain, {c.name for c in clip.chains})
        quick, full = document.corrected.angles(chain), twist_signals(whole, chain)
        sure = (full.swing_reliability > 1e-2) & (full.azimuth_reliability > 1e-2)
        sure &= np.roll(sure, 1)
        for name in ("theta_p", "dtheta_p", "dtheta_c"):
            apart = wrap(getattr(quick, name) - getattr(full, name))[sure]
            np.testing.assert_allclose(apart, 0.0, atol=1e-9, err_msg=f"{chain.name} {name}")
        if sure[1:].all():
            np.testing.assert_allclose(wrap(quick.theta_c - full.theta_c), 0.0, atol=1e-7)


def test_a_full_turn_is_a_seam_and_a_jump_is_not():
    angle = np.radians([170.0, 179.0, -179.0, -60.0])
    y, seams = wrap_degrees_about(angle, 0.0)
    assert seams.tolist() == [1]
    x, out = thin_curve_to_pixels(y, seams, 0, 3, 500)
    assert np.isnan(out).sum() == 1
    assert x[np.isnan(out)] == 1.5
    y, seams = wrap_degrees_about(angle, np.pi)
    assert not len(seams)
    np.testing.assert_allclose(y, [170.0, 179.0, 181.0, 300.0])


def test_thinning_keeps_extremes_and_short_pieces():
    y = np.full(100_000, np.nan)
    y[50_001:50_004] = [1.0, 9.0, -2.0]
    x, out = thin_curve_to_pixels(y, NO_SEAMS, -0.5, 99_999.5, 600)
    assert len(x) < 1300
    assert np.nanmax(out) == 9.0
    assert np.nanmin(out) == -2.0
    rng = np.random.default_rng(1)
    noise = rng.normal(size=10_000)
    _, out = thin_curve_to_pixels(noise, NO_SEAMS, -0.5, 9_999.5, 600)
    assert out.max() == noise.max()
    assert out.min() == noise.min()


def test_unreliable_spans_are_half_open():
    reliability = np.array([0.1, 0.9, 0.1, 0.1, 0.9, 0.0])
    assert unreliable_spans(reliability).tolist() == [[0, 1], [2, 4], [5, 6]]


def test_regions_cover_what_their_intervals_cover() -> None:
    """Each interval's columns are filled, overlapping ones once, gaps left open.

    An interval of one frame is as wide as a mouse can hold.
    """
    spans = [(10, 20), (40, 50), (45, 60), (80, 81)]
    drawn = [*spans[:-1], (76, 85)]
    intervals = [
        Judged(k, Interval("A", start, stop, np.zeros(stop - start)))
        for k, (start, stop) in enumerate(spans)
    ]
    image = QImage(100, 30, QImage.Format.Format_RGB32)
    image.fill(QColor(LIGHT.surface))
    painter = QPainter(image)
    Regions(intervals, None, -0.5, 99.5, 100).paint(painter, LIGHT, 30, None)
    painter.end()
    paper = QColor(LIGHT.surface).rgb()
    filled = [x for x in range(100) if image.pixel(x, 15) != paper]
    inside = {x for start, stop in drawn for x in range(start, stop)}
    borders = {x for span in drawn for x in span}
    assert inside <= set(filled) <= inside | borders
