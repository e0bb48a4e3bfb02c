"""What is told for and against the repair of a counter-twist by all that a chain shows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis import analyse
from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.detection import Interval
from twistcore.detection.chain_analysis import judged
from twistcore.detection.evidence import Find, Witnesses, judgement_of, taken_by, terms_of
from twistcore.rotation import multiply, quaternion_from_axis_angle
from twistcore.twist_removal import applied_unasked, refine

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = {c.name: c for c in find_chains(WALK)}
START, STOP = 150, 160


def twisted(chain, degrees, start=START, stop=STOP, motion=WALK):
    """The motion with P twisted and C turned back; the find that takes it out."""
    offset = np.full(stop - start, -math.radians(degrees))
    wrong = Interval(chain.name, start, stop, offset)
    return refine(motion, [chain], [wrong]), Find(start, stop, -np.degrees(offset))


def judgement(motion, chain, find):
    known = Witnesses.of(motion, chain)
    terms = terms_of(known, find, taken_by(motion.frames, [find]))
    return judgement_of(terms, chain.segment), terms


@pytest.mark.parametrize("name", ["LeftArm", "RightArm", "RightUpLeg"])
@pytest.mark.parametrize("degrees", [-25.0, 12.0, 60.0])
def test_a_true_error_is_more_likely_than_not_and_a_made_up_one_is_not(name, degrees):
    chain = CHAINS[name]
    motion, find = twisted(chain, degrees)
    assert judgement(motion, chain, find)[0].probability > 0.5
    assert judgement(WALK, chain, find)[0].probability < 0.3


def test_a_repair_that_takes_an_exact_hinge_apart_says_so():
    """The knee of the clip is one: its azimuth stands."""
    chain = CHAINS["LeftUpLeg"]
    bent = int(np.argmax(Witnesses.of(WALK, chain).bend))
    found, terms = judgement(WALK, chain, Find(bent - 5, bent + 5, np.full(10, 12.0)))
    assert terms.side_spread < 3.0
    assert terms.off_after - terms.off_before == pytest.approx(12.0, abs=1.0)
    assert found.probability < 0.1
    assert "12°" in found.doubts[0]


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
    assert not terms.same_way
    assert terms.together < 0.3
    rolled = WALK.rotations.copy()
    roll = quaternion_from_axis_angle(chain.axis, np.radians(30.0))
    rolled[START:STOP, chain.parent] = multiply(WALK.rotations[START:STOP, chain.parent], roll)
    turned = WALK.with_rotations(rolled)  # P turns, and C does not turn back
    assert judgement(turned, chain, find)[1].together > 0.8


def test_no_confidence_is_above_what_the_evidence_gives():
    chain = CHAINS["LeftArm"]
    known, none = Witnesses.of(WALK, chain), np.zeros(WALK.frames, dtype=bool)
    made_up = Interval("LeftArm", START, STOP, np.full(10, 0.3), confidence=0.99)
    doubted = judged(made_up, known, none)
    assert doubted.confidence < 0.3
    assert doubted.evidence["doubts"]
    assert applied_unasked([made_up])
    assert not applied_unasked([doubted])
    unsure = replace(made_up, confidence=0.01)
    assert judged(unsure, known, none).confidence == 0.01


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
            find = Find(start, stop, np.full(stop - start, 10.0))
            found, _ = judgement(short, chain, find)
            assert 0.0 <= found.probability <= 1.0
