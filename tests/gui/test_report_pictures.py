"""The pictures of a report, drawn by a process of their own without a display."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from inspector.bundled import FLIPPED, SAMPLE
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import refine
from twistcore.formats.reading import read_clip
from twistcore.report.picture_job import SIZE, draw_figures, make_clip_figure


@pytest.fixture(scope="module")
def drawn():
    """Two clips: a wrung arm and a flipped leg, before and after."""
    figures = []
    for path, kind in ((SAMPLE, "counter-twist"), (FLIPPED, "limb flip")):
        motion, found = read_clip(path).motion, analyse(read_clip(path)).detect()
        worst = max((i for i in found if i.kind == kind), key=lambda i: abs(i.offset).sum())
        after = refine(motion, found.chains_and_limbs, [worst])
        wanted = [(worst.chain, (worst.start + worst.stop) // 2)]
        figures.append(make_clip_figure(motion, after, found.chains_and_limbs, wanted))
    return draw_figures(figures)


def pixels(jpeg):
    return imread(io.BytesIO(jpeg), format="jpeg").astype(float)


def test_before_is_orange_and_after_is_blue_from_the_same_side(drawn):
    assert [d.problem for d in drawn] == ["", ""]
    for (pair,) in (d.pictures for d in drawn):
        before, after = map(pixels, pair)
        assert before.shape == after.shape == (SIZE[1], SIZE[0], 3)
        warm, cold = (p[..., 0] - p[..., 2] for p in (before, after))
        assert (warm > 60).mean() > 0.01  # the limb is a good part of the picture
        assert (cold < -60).mean() > 0.01
        assert (warm < -60).mean() < 1e-3
        assert (cold > 60).mean() < 1e-3
        alike = np.abs(before - after).max(axis=-1) < 30
        assert alike.mean() > 0.8  # all but the limb, and its shadow, stands where it stood


def test_a_page_of_many_stays_small(drawn):
    sizes = [len(picture) for d in drawn for pair in d.pictures for picture in pair]
    assert max(sizes) < 18_000
