"""What is told for and against the repair of a counter-twist by all that a chain shows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.evidence import Judged, calibration_error, fitted
from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import Interval
from twistcore.detection.consistency.chain_analysis import (
    halve_low_log_odds,
    judge_interval_by_evidence,
)
from twistcore.detection.evidence import (
    Background,
    ChainSignals,
    SuspectedError,
    judgement_of,
    measure_evidence,
)
from twistcore.detection.evidence.chain_signals import ALONG
from twistcore.detection.evidence.judgement import WEIGHTS, unweighted_evidence_scores
from twistcore.detection.evidence.terms import Terms
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import exponential, multiply, quaternion_from_axis_angle

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = {c.name: c for c in find_chains(WALK)}
START, STOP = 150, 160


def twisted(chain, degrees, start=START, stop=STOP, motion=WALK):
    """The motion with P twisted and C turned back; the find that takes it out."""
    offset = np.full(stop - start, -math.radians(degrees))
    wrong = Interval(chain.name, start, stop, offset)
    return refine(motion, [chain], [wrong]), SuspectedError(start, stop, -np.degrees(offset))


def judgement(motion, chain, find):
    known = ChainSignals.of(motion, chain)
    terms = measure_evidence(Background.of(known, [find]), find)
    return judgement_of(terms, chain.segment), terms


@pytest.mark.parametrize("name", ["LeftArm", "RightArm", "RightUpLeg"])
@pytest.mark.parametrize("degrees", [-25.0, 12.0, 60.0])
def test_a_true_error_is_more_likely_than_not_and_a_made_up_one_is_not(name, degrees):
    chain = CHAINS[name]
    motion, find = twisted(chain, degrees)
    assert judgement(motion, chain, find)[0].probability > 0.5
    assert judgement(WALK, chain, find)[0].probability < 0.3


def test_what_a_silent_joint_tells_may_last_longer():
    chain = CHAINS["LeftForeArm"]
    drift = np.radians(30.0) * np.sin(np.linspace(0.0, math.pi, 150)) ** 2
    motion = refine(WALK, [chain], [Interval(chain.name, 100, 250, -drift)])
    find = SuspectedError(100, 250, np.degrees(drift))
    lively, silent = (judgement(motion, chain, replace(find, silent=s))[0] for s in (False, True))
    assert lively.terms["long"] < 0.0 == silent.terms["long"]
    assert lively.terms["silent_joint"] < silent.terms["silent_joint"]


def test_a_repair_that_takes_an_exact_hinge_apart_says_so():
    """The knee of the clip is one: its azimuth stands."""
    chain = CHAINS["LeftUpLeg"]
    bent = int(np.argmax(ChainSignals.of(WALK, chain).bend))
    found, terms = judgement(WALK, chain, SuspectedError(bent - 5, bent + 5, np.full(10, 12.0)))
    assert terms.side_spread < 3.0
    assert terms.off_after - terms.off_before == pytest.approx(12.0, abs=1.0)
    assert found.probability < 0.1
    assert "12°" in found.doubts[0]
    assert sum("12°" in doubt for doubt in found.doubts) == 1


def test_the_azimuth_is_no_witness_where_nothing_hangs_on_the_child():
    _, terms = judgement(*_hand(replace(CHAINS["LeftForeArm"], grandchild=-1)))
    assert not terms.hinged
    assert terms.rougher == terms.for_azimuth == terms.for_side == 0.0


def _hand(chain):
    motion, find = twisted(chain, 20.0)
    return motion, chain, find


def test_a_twist_error_leaves_what_both_bones_turn_together():
    chain = CHAINS["LeftArm"]
    motion, find = twisted(chain, 30.0)
    _, terms = judgement(motion, chain, find)
    assert terms.together < 0.3
    rolled = WALK.rotations.copy()
    roll = quaternion_from_axis_angle(chain.axis, np.radians(30.0))
    rolled[START:STOP, chain.parent] = multiply(WALK.rotations[START:STOP, chain.parent], roll)
    turned = WALK.with_rotations(rolled)  # P turns, and C does not turn back
    assert judgement(turned, chain, find)[1].together > 0.8


def test_no_confidence_is_above_what_the_evidence_gives():
    chain = CHAINS["LeftArm"]
    known = ChainSignals.of(WALK, chain)
    made_up = Interval("LeftArm", START, STOP, np.full(10, 0.3), confidence=0.99)
    find = SuspectedError(START, STOP, np.degrees(made_up.offset))
    terms = measure_evidence(Background.of(known, []), find)
    doubted, _ = judge_interval_by_evidence(made_up, terms, known.segment)
    assert doubted.confidence < 0.3
    assert doubted.evidence["doubts"]
    assert automatic_corrections([made_up])
    assert not automatic_corrections([doubted])
    unsure = replace(made_up, confidence=0.01)
    assert judge_interval_by_evidence(unsure, terms, known.segment)[
        0
    ].confidence == halve_low_log_odds(0.01)


def test_the_same_interval_is_judged_once_at_every_tau():
    motion, _ = twisted(CHAINS["LeftArm"], 40.0)
    detector = analyse(motion).by()
    (one,) = detector.intervals("LeftArm", math.radians(5.0))
    (other,) = detector.intervals("LeftArm", math.radians(6.0))
    assert one is other
    assert one.confidence > 0.5


@pytest.mark.parametrize("frames", [2, 3, 5, 9, 30])
def test_short_clips_have_evidence_too(frames):
    short = replace(WALK, rotations=WALK.rotations[:frames], positions=WALK.positions[:frames])
    for chain in find_chains(short):
        for start, stop in ((0, 1), (frames - 1, frames), (0, frames)):
            find = SuspectedError(start, stop, np.full(stop - start, 10.0))
            found, _ = judgement(short, chain, find)
            assert 0.0 <= found.probability <= 1.0


def test_noise_and_the_hinge_are_told_first_and_also_where_the_score_is_low_without_them():
    chain = CHAINS["LeftUpLeg"]
    bent = int(np.argmax(ChainSignals.of(WALK, chain).bend))
    _, terms = judgement(WALK, chain, SuspectedError(bent - 5, bent + 5, np.full(10, 50.0)))
    noisy = replace(terms, noise=9.0, rate=20.0, together=20.0)
    found = judgement_of(noisy, chain.segment)
    assert sum(found.terms[name] for name in WEIGHTS) < -3.0
    assert "9°" in found.doubts[0]
    assert "hinge" in found.doubts[1]


# Evidence that is neither for nor against a correction.
PLAIN = Terms(
    hinged=True, for_x=0.0, for_y=0.0, for_azimuth=0.0, rougher=0.0, edge_bend=1.0,
    off_before=0.0, off_after=0.0, side_spread=math.nan, for_side=0.0, least_bend=40.0,
    together=2.0, rate=0.3, natural=10.0, step=25.0, seconds=0.7, quiet=1.0, silent=False,
    noise=0.0,
)  # fmt: skip
E = math.e


@pytest.mark.parametrize(
    ("term", "changes"),
    [
        ("azimuth_rougher", {0.0: {"rougher": -9.0}, -1.0: {"rougher": 10.0}}),
        ("azimuth_rougher", {-3.0: {"rougher": 40.0}}),
        ("azimuth_rougher", {0.0: {"rougher": 10.0, "for_azimuth": 0.7}}),
        ("azimuth_rougher", {0.0: {"rougher": 10.0, "for_side": 0.7}}),
        ("azimuth_rougher", {0.0: {"rougher": 10.0, "edge_bend": 0.0}}),
        ("azimuth_stays", {-1.0: {"for_azimuth": -1.2}, -3.0: {"for_azimuth": -9.0}}),
        ("off_its_side", {-1.0: {"off_after": E - 1.0}, -1.7: {"off_after": 90.0}}),
        ("back_to_its_side", {0.0: {"off_before": 0.4}, 1.0: {"off_before": E**1.4 - 1.0}}),
        ("back_to_its_side", {1.6: {"off_before": 90.0}, 0.0: {"off_before": math.nan}}),
        ("straight", {0.5: {"least_bend": 20.0}, 0.0: {"least_bend": 90.0}}),
        ("no_azimuth", {-1.0: {"hinged": False}, 0.0: {"hinged": True}}),
        ("both_turn_more", {-1.0: {"together": 2.0 * E}, -2.5: {"together": 99.0}}),
        ("both_turn_less", {1.0: {"together": 2.0 / E}, 3.0: {"together": 0.0}}),
        ("both_joints", {1.0: {"for_x": 5.0, "for_y": 9.0}, 1.5: {"for_x": 20.0, "for_y": 20.0}}),
        ("both_joints", {-0.5: {"for_x": 9.0, "for_y": -9.0}}),
        ("silent_joint", {0.5: {"for_x": 15.0}, 1.5: {"for_y": 99.0}, 1.0: {"silent": True}}),
        ("often", {-1.0: {"rate": 0.3 * E}, -2.0: {"rate": 9.0}, 0.0: {"rate": None}}),
        ("natural_size", {-1.0: {"step": 25.0 / E}, -1.6: {"step": 0.0}, 1.0: {"step": 90.0}}),
        ("natural_size", {0.0: {"step": 25.0 / E, "natural": None}}),
        ("natural_size", {0.5: {"step": 25.0 * E**0.5, "natural": None}}),
        ("long", {-1.0: {"seconds": 0.7 * E}, -2.5: {"seconds": 60.0}}),
        ("long", {-1.0: {"seconds": 2.0 * E, "silent": True}}),
    ],
)  # fmt: skip
def test_each_term_grows_with_its_evidence_up_to_a_limit(term, changes):
    assert unweighted_evidence_scores(PLAIN) == pytest.approx(
        {**dict.fromkeys(WEIGHTS, 0.0), "base": 1.0}
    )
    for expected, change in changes.items():
        assert unweighted_evidence_scores(replace(PLAIN, **change))[term] == pytest.approx(expected)


@pytest.mark.parametrize("segment", ["Arm", ""])
def test_each_kind_of_evidence_against_a_correction_has_words_of_its_own(segment):
    against = {
        "azimuth_rougher": {"rougher": 40.0},
        "azimuth_stays": {"for_azimuth": -9.0},
        "off_its_side": {"off_after": 90.0},
        "no_azimuth": {"hinged": False},
        "both_turn_more": {"together": 99.0},
        "often": {"rate": 9.0},
        "natural_size": {"step": 10.0, "natural": 90.0},
        "long": {"seconds": 60.0},
        "noise": {"noise": 9.0},
        "small": {"step": 2.0, "natural": 0.1},
        "off_its_hinge": {"side_spread": 1.0, "off_after": 5.0},
    }
    said = {t: judgement_of(replace(PLAIN, **c), segment).doubts[0] for t, c in against.items()}
    assert len(set(said.values())) == len(against)
    for term, number in (("both_turn_more", "99"), ("often", "9.0"), ("natural_size", "90°")):
        assert number in said[term]


def test_the_strongest_doubt_is_the_first():
    for rate, seconds, first in ((9.0, 1.3, "a second"), (0.6, 60.0, "lasts")):
        against = replace(PLAIN, rate=rate, seconds=seconds, together=4.0)
        doubts = judgement_of(against, "Arm").doubts
        assert len(doubts) == 3
        assert first in doubts[0]


def test_between_the_pieces_of_a_bone_no_joint_is_named():
    chain = replace(CHAINS["LeftArm"], ends=False, grandchild=-1)
    motion, find = twisted(CHAINS["LeftArm"], 20.0)
    known = ChainSignals.of(motion, chain)
    terms = replace(measure_evidence(Background.of(known, [find]), find), rate=20.0)
    assert not any("elbow" in d for d in judgement_of(terms, known.segment).doubts)


def test_the_azimuth_counts_where_the_limb_is_bent_on_both_sides_of_a_turn():
    """Turn t leads from frame t - 1 to frame t."""
    known = ChainSignals.of(WALK, CHAINS["LeftArm"])
    bent = known.sine > ALONG
    for width in (1, 4):
        own = known.bent(width)
        for t in range(1, WALK.frames - width):
            assert own[t] == (bent[t - 1] and bent[t + width - 1])


def test_weights_are_fitted_with_the_signs_of_physics():
    rng = np.random.default_rng(2)
    judged_finds = [
        Judged(
            name, rng.normal(0.5 if right else -0.5, 1.0, len(WEIGHTS)), verdict, True, False, 0.5
        )
        for name in ("one", "other")
        for right, verdict in ((True, "error"), (False, "alarm"))
        for _ in range(60)
    ]
    weights = fitted(judged_finds, [])
    assert (weights[1:] >= 0.0).all()
    scores = np.array([j.parts @ weights for j in judged_finds])
    errors = np.array([j.verdict == "error" for j in judged_finds])
    assert scores[errors].mean() > scores[~errors].mean() + 1.0
    assert calibration_error(1.0 / (1.0 + np.exp(-scores)), errors.astype(float)) < 0.15


def test_motion_is_what_the_terms_alone_say_twenty_to_one():
    chain = CHAINS["LeftArm"]
    motion, find = twisted(chain, 40.0)
    _, terms = judgement(motion, chain, find)
    assert not judgement_of(terms).motion
    assert not judgement_of(replace(terms, noise=8.0)).motion  # no motion: noise
    unlikely = replace(terms, for_x=0.0, for_y=0.0, rate=5.0, natural=120.0, together=20.0)
    assert judgement_of(unlikely).motion


def test_a_hinge_that_the_rig_makes_counts_of_a_limb_that_is_nearly_straight():
    """As in the last frames of some exports: the elbow keeps its hinge, only its angle is small."""
    chain = CHAINS["LeftUpLeg"]
    hinge = np.cross(chain.axis, [0.0, 0.0, 1.0])
    angle = np.radians(6.0 + 3.0 * np.sin(np.arange(WALK.frames) / 9.0))
    rotations = WALK.rotations.copy()
    across = np.cross(chain.arm, chain.axis)
    size = np.linalg.norm(across)
    aligned = exponential(across / max(size, 1e-12) * np.arctan2(size, chain.arm @ chain.axis))
    bent = quaternion_from_axis_angle(hinge / np.linalg.norm(hinge), angle)
    rotations[:, chain.child] = multiply(bent, aligned)
    straight = WALK.with_rotations(rotations)
    last = SuspectedError(WALK.frames - 1, WALK.frames, np.full(1, 15.0))
    found, terms = judgement(straight, chain, last)
    assert terms.off_after - terms.off_before == pytest.approx(15.0, abs=1.0)
    assert found.probability < 0.1


def test_what_lasts_is_mostly_motion_unless_the_azimuth_or_a_silent_joint_shows_it():
    motion, find = twisted(CHAINS["LeftArm"], 40.0)
    _, terms = judgement(motion, CHAINS["LeftArm"], find)
    dim = replace(terms, for_azimuth=1.0, for_x=6.0, for_y=6.0, off_before=math.nan)
    brief, lasting = (judgement_of(replace(dim, seconds=s)) for s in (0.1, 4.0))
    assert brief.probability > lasting.probability + 0.2
    assert any("4.0 s" in doubt for doubt in judgement_of(replace(dim, seconds=4.0)).doubts)
    for clear in (replace(dim, for_azimuth=9.0), replace(dim, for_x=25.0)):
        assert judgement_of(replace(clear, seconds=4.0)).terms["long"] == 0.0


def test_what_turns_by_little_is_left_unless_it_is_clear():
    motion, find = twisted(CHAINS["LeftArm"], 40.0)
    _, terms = judgement(motion, CHAINS["LeftArm"], find)
    dim = replace(terms, step=2.4, natural=0.2, for_x=9.0, for_y=9.0, for_azimuth=1.0)
    assert judgement_of(dim).small
    assert "2.4°" in judgement_of(dim).doubts[0]
    clear = (replace(dim, for_azimuth=5.0), replace(dim, for_x=30.0), replace(dim, silent=True))
    for other in (replace(dim, step=3.1), *clear):
        assert not judgement_of(other).small
    made_up = Interval("LeftArm", START, STOP, np.full(10, 0.04), confidence=0.99)
    for own, left in ((dim, True), (clear[0], False)):
        found, _ = judge_interval_by_evidence(made_up, own, "Arm")
        assert (found.open, len(automatic_corrections([found]))) == (left, 1 - left)
        assert found.confidence > 0.5


def test_on_a_straight_limb_both_bones_must_turn_at_the_ends():
    motion, find = twisted(CHAINS["LeftArm"], 40.0)
    _, terms = judgement(motion, CHAINS["LeftArm"], find)
    against = replace(terms, for_x=-6.0, quiet=1.0)
    assert judgement_of(against).probability > judgement_of(against, straight=True).probability
    assert judgement_of(against, straight=True).probability < 0.05
    quiet = replace(against, quiet=0.03)  # one bone never turns elsewhere
    for answered in (quiet, replace(terms, quiet=1.0)):
        assert "unanswered" not in judgement_of(answered, straight=True).terms


def test_doubts_overlap_so_that_below_even_odds_they_count_half():
    for probability in (0.0, 0.5, 0.8, 1.0):
        assert halve_low_log_odds(probability) == probability
    odds = [0.001, 0.01, 0.1, 0.3, 0.49]
    found = [halve_low_log_odds(p) for p in odds]
    assert found == sorted(found)
    assert max(found) < 0.5
    for before, after in zip(odds, found, strict=True):
        assert math.log(after / (1 - after)) == pytest.approx(0.5 * math.log(before / (1 - before)))
