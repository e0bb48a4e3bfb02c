"""Going about the clip: what a loop plays, and what M finds that the review has not."""

import numpy as np
import pytest

from inspector.session.player import Player
from inspector.window.review_actions import faint_intervals
from tests.gui.pictures import INJECTED
from twistcore.bvh import read_bvh, write_bvh
from twistcore.chain import find_chains
from twistcore.refinement import remove_twist


def test_a_loop_plays_the_selected_interval_and_half_a_second_round_it(open_document):
    document = open_document(INJECTED)
    player = Player(document)
    frames, around = document.frames, round(0.5 * document.data.motion.fps)
    document.select_interval(None)
    player.set_loop(True)
    assert player.span() == (0, frames)  # nothing is selected
    spans = []
    for judged in document.review.state.intervals:
        document.select_interval(judged.id)
        i = judged.interval
        assert player.span() == (max(0, i.start - around), min(frames, i.stop + around))
        spans.append(player.span())
    assert any(first > 0 and stop < frames for first, stop in spans)
    player.set_loop(False)
    assert player.span() == (0, frames)


@pytest.fixture
def faint_walk(open_document, tmp_path):
    """The walk with an error between half of τ and τ, and one above τ, in one chain."""
    clip = read_bvh(INJECTED.parent / "walk.bvh")
    offsets = {"LeftForeArm": np.zeros(clip.motion.frames)}
    offsets["LeftForeArm"][100:130] = np.radians(3.0)
    offsets["LeftForeArm"][200:230] = np.radians(30.0)
    path = tmp_path / "faint" / "faint.bvh"
    path.parent.mkdir()
    write_bvh(clip, remove_twist(clip.motion, find_chains(clip.motion), offsets), path)
    document = open_document(path)
    document.set_tau(np.radians(4.0), "LeftForeArm")
    return document


def test_suspicious_moments_lie_between_half_of_tau_and_tau(faint_walk):
    document = faint_walk
    (known,) = document.review.state.intervals
    assert (known.interval.start, known.interval.stop) == (200, 230)

    def faint_ones():
        return faint_intervals(document.data.analysis, document.review.state)

    (faint,) = faint_ones()
    assert (faint.chain, faint.start, faint.stop) == ("LeftForeArm", 100, 130)
    document.set_tau(np.radians(6.5), "LeftForeArm")
    assert faint_ones() == []  # 3° is less than half of it
    document.set_tau(np.radians(2.0), "LeftForeArm")
    assert faint_ones() == []  # and found where τ is below it
