"""Bounds beside QuaMo's bars: fitted on others only, causal where they say so, oracles exact."""

import numpy as np

from benchmarks.quamo_fits import LeaveOneOut, PathFilter, foot_steps, known_way
from tests.conftest import ASSETS
from twistcore.analysis.quality.figure import foot_contact_mask
from twistcore.study.quamo.noise import LEVELS, SMOOTH_SECONDS, Noise
from twistcore.study.quamo.pose_errors import pose_metrics
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence
from twistcore.study.quamo.tables import noisy_clip

NOISE = Noise(LEVELS["A"])
CLIPS = [read_cmu_bvh_sequence(ASSETS / f"{name}.bvh") for name in ("walk", "dance", "basketball")]


def test_a_fit_never_sees_the_subject_it_is_measured_on() -> None:
    rng = np.random.default_rng(0)
    right = rng.standard_normal((4, 1))
    fit = LeaveOneOut(0.0)
    for subject in ("a", "b", "held out"):
        x = rng.standard_normal((50, 4))
        fit.add(subject, x, x @ (right if subject != "held out" else -right))
    np.testing.assert_allclose(fit.weights("held out"), right, atol=1e-9)
    np.testing.assert_allclose(fit.weights("held out", own=True), -right, atol=1e-9)


def test_the_best_filter_is_smoother_and_waits_only_as_long_as_it_says() -> None:
    clip = CLIPS[0]
    truth = clip.places_mm(clip.q, clip.r)
    given = clip.places_mm(*noisy_clip(clip, NOISE, 0))
    later = given.copy()
    later[60:] += 50.0
    for ahead in (0, 2):
        path = PathFilter(CLIPS, NOISE, ahead)
        taps = path.taps(clip.subject, 3.0)
        found, other = path.filtered(given, taps), path.filtered(later, taps)
        np.testing.assert_array_equal(found[: 60 - ahead], other[: 60 - ahead])
        assert np.abs(found[60 - ahead] - other[60 - ahead]).max() > 0.1
        assert pose_metrics(found, truth).accel < 0.7 * pose_metrics(given, truth).accel


def test_the_known_way_is_the_generalised_mean_of_what_was_seen() -> None:
    clip = CLIPS[0]
    q_hat, r_hat = noisy_clip(clip, NOISE, 0)
    at = 40
    _, found = known_way(NOISE)(clip, q_hat[:, None], r_hat[:, None])
    times = 0.04 * np.arange(at + 1)
    level = NOISE.level
    covariance = np.mean(level.root_smooth) ** 2 * np.exp(
        -(((times[:, None] - times) / (2.0 * SMOOTH_SECONDS)) ** 2)
    ) + level.root_white**2 * np.eye(at + 1)
    share = np.linalg.solve(covariance, np.ones(at + 1))
    mean = share @ (r_hat - clip.r)[: at + 1] / share.sum()
    np.testing.assert_allclose(found[at, 0], clip.r[at] + mean, atol=1e-6)


def test_feet_on_the_ground_tell_most_of_the_way_in_a_walk() -> None:
    clip = CLIPS[0]
    contact = foot_contact_mask(clip.places_mm(clip.q, clip.r))
    stood = (contact[1:] & contact[:-1]).any(axis=1)
    told = np.diff(foot_steps(True, True)(clip, clip.q, clip.r), axis=0)[stood]
    gone = np.diff(clip.r, axis=0)[stood]
    assert np.linalg.norm(told - gone, axis=1).mean() < 0.3 * np.linalg.norm(gone, axis=1).mean()
