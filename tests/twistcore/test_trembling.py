"""A figure that trembles is told from one that moves fast."""

import numpy as np
import pytest

from benchmarks.noise_bursts import at_rate
from benchmarks.quamo_other_rigs import HEIGHT_MM, made_noisy
from tests.conftest import ASSETS
from twistcore.analysis.quality.figure import measure_body_motion_quality
from twistcore.analysis.quality.trembling import CAPTURED, TIMES, jitter_if_trembling
from twistcore.formats.bvh import read_bvh

CLIPS = ("walk", "dance", "basketball", "kick", "walk_injected")


@pytest.mark.parametrize("name", CLIPS)
def test_captures_do_not_tremble_at_any_pace(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion
    for faster in (1.0, 1.5, 2.0):
        quick = at_rate(motion, motion.fps / faster)
        assert (
            jitter_if_trembling(type(motion)(**vars(quick) | {"frame_time": motion.frame_time}))
            is None
        )


@pytest.mark.parametrize("name", ["walk", "dance", "basketball"])
def test_noise_is_trembling_and_its_size_is_the_figures_jitter(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion.sliced(1, 400)
    noisy = made_noisy(motion, "A", 1, name, HEIGHT_MM / motion.skeleton.height)
    jitter = jitter_if_trembling(noisy)
    assert jitter == pytest.approx(measure_body_motion_quality(noisy).jitter)
    assert jitter > TIMES * CAPTURED


def test_a_clip_of_less_than_a_second_is_not_judged():
    motion = read_bvh(ASSETS / "walk.bvh").motion.sliced(1, 100)
    noise = np.random.default_rng(0).normal(0.0, 0.1, motion.rotations.shape)
    assert jitter_if_trembling(motion.with_rotations(motion.rotations + noise)) is None
