"""Errors that belong together: edges, overlap and series make groups; decisions do not."""

from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
import pytest

import twistcore as tc
from twistcore.analysis.error_groups import drop_weaker_correction_alternatives, error_groups
from twistcore.detection import Interval, Kind

ASSETS = Path(__file__).resolve().parents[2] / "assets"
LEG, KNEE, FOOT = "RightUpLeg-RightFoot", "RightUpLeg", "RightLeg"


@pytest.fixture(scope="module")
def walk():
    clip = tc.read_clip(ASSETS / "walk.bvh")
    return (*tc.find_chains(clip), *tc.find_limbs(clip)), clip.skeleton


def made(chain, start, stop, kind=Kind.COUNTER_TWIST, *, degrees=30.0, joint="", carried=False):
    angle = np.radians(degrees)
    offset = np.full(stop - start, angle if kind.repairable else 0.0)
    left = 0.0 if kind.repairable else float(angle)
    return Interval(chain, start, stop, offset, kind=kind, joint=joint, carried=carried,
                    residual=left)  # fmt: skip


def flip(start, stop, degrees=178.0):
    return made(LEG, start, stop, Kind.LIMB_FLIP, degrees=degrees)


def jump(start, joint="RightFoot", chain=FOOT):
    return made(chain, start, start + 1, Kind.LONE_JUMP, joint=joint)


def groups_of(walk, *intervals):
    return [(set(g.members), g.name) for g in error_groups(intervals, *walk)]


def test_a_flip_goes_with_the_jumps_at_its_edges(walk):
    found = error_groups([jump(20), flip(20, 29), jump(29), jump(40)], *walk)
    assert [group.members for group in found] == [(1, 0, 2)]  # the flip represents it
    assert found[0].name == "Right knee flips and the 2 jumps at its edges"


def test_a_stretch_goes_with_its_jumps(walk):
    stretch = made(FOOT, 20, 90, Kind.STRETCH, joint="RightFoot")
    assert groups_of(walk, jump(19), stretch, jump(60)) == [
        ({0, 1}, "RightFoot stays rotated and the jump at its edge")
    ]


@pytest.mark.parametrize("frames", [40, 560])
def test_a_group_names_an_error_that_is_far_longer_than_the_others(walk, frames):
    flips = [flip(20, 26), flip(40, 46), flip(60, 66)]
    stretch = made(FOOT, 66, 66 + frames, Kind.STRETCH, joint="RightFoot")
    ((members, name),) = groups_of(walk, *flips, jump(66), stretch)
    assert len(members) == 5
    long = "RightFoot stays rotated for 560 frames, and 4 more errors"
    assert (name == long) is (frames == 560)
    (group,) = error_groups((*flips, jump(66), stretch), *walk)
    short = "RightFoot stays rotated" if frames == 560 else "3 times: right knee flips"
    assert group.short == short


@pytest.mark.parametrize("gap", [-2, -1, 0, 1, 2])
def test_edges_touch_if_they_are_at_most_one_frame_apart(walk, gap):
    assert bool(groups_of(walk, flip(20, 30), jump(30 + gap))) == (abs(gap) <= 1)
    assert bool(groups_of(walk, made(KNEE, 20, 30), made(FOOT, 20 + gap, 60))) == (abs(gap) <= 1)


def test_an_error_that_ends_where_another_begins_is_another(walk):
    two = made(KNEE, 20, 30), made(FOOT, 30, 44)
    assert groups_of(walk, *two) == []
    assert [members for members, _ in groups_of(walk, *two, jump(30))] == [{0, 1, 2}]
    assert [members for members, _ in groups_of(walk, jump(30), *two)] == [{0, 1, 2}]


def test_two_flips_of_which_each_has_its_jumps_stay_apart(walk):
    found = groups_of(walk, flip(20, 25), jump(20), jump(25), flip(27, 33), jump(27), jump(33))
    assert [members for members, _ in found] == [{0, 1, 2}, {3, 4, 5}]


@pytest.mark.parametrize(("stop", "together"), [(120, True), (138, True), (140, False)])
def test_a_leg_and_its_foot_in_mostly_the_same_frames_are_together(walk, stop, together):
    found = groups_of(walk, made(KNEE, 20, 116), made(FOOT, 24, stop), made("LeftLeg", 20, 116))
    assert [members for members, _ in found] == ([{0, 1}] if together else [])


def test_other_limbs_and_other_people_stay_apart(walk):
    assert groups_of(walk, flip(20, 29), jump(20, "LeftFoot", "LeftLeg")) == []


def test_a_joint_of_the_trunk_is_of_no_limb(walk):
    """Jumps of the hips are listed under a chain of a leg."""
    hips, back = (jump(20, joint, KNEE) for joint in ("Hips", "LowerBack"))
    assert groups_of(walk, flip(20, 29), hips, back) == [({1, 2}, "Hips jumps, and 1 more error")]


def test_three_of_a_kind_are_a_series_with_the_jumps_of_each(walk):
    three = flip(20, 29), jump(20), flip(60, 66, -175.0), jump(66), flip(90, 94, 150.0)
    assert groups_of(walk, *three[:4]) == [
        ({0, 1}, "Right knee flips and the jump at its edge"),
        ({2, 3}, "Right knee flips and the jump at its edge"),
    ]
    found = error_groups(three, *walk)
    assert [group.members for group in found] == [(0, 1, 2, 3, 4)]
    assert found[0].name == "the same error 3 times: right knee flips, with 2 jumps at the edges"


@pytest.mark.parametrize(
    ("sizes", "count"),
    [
        ((30.0, 34.0, 38.0), 1),
        ((30.0, 34.0, 40.0), 0),  # more than 1.3 times as large
        ((30.0, -30.0, 30.0), 0),  # in another direction
        ((-38.0, -30.0, -34.0), 1),
        ((170.0, 180.0, -170.0), 1),  # half turns
        ((0.0, 0.0, 0.0), 1),
    ],
)
def test_a_series_has_one_direction_and_one_size(walk, sizes, count):
    apart = [made(KNEE, 50 * k, 50 * k + 9, degrees=size) for k, size in enumerate(sizes)]
    assert len(error_groups(apart, *walk)) == count


def test_a_series_is_of_one_joint_and_one_kind(walk):
    spikes = [made(FOOT, 50 * k, 50 * k + 1, Kind.SPIKE, joint="RightFoot") for k in range(2)]
    assert groups_of(walk, *spikes, jump(150)) == []
    toe = made(FOOT, 150, 151, Kind.SPIKE, joint="RightToeBase")
    assert groups_of(walk, *spikes, toe) == []
    third = made(FOOT, 150, 151, Kind.SPIKE, joint="RightFoot")
    assert groups_of(walk, *spikes, third) == [
        ({0, 1, 2}, "the same error 3 times: RightFoot leaves its path")
    ]


def test_flips_that_turn_the_foot_are_another_series(walk):
    turned = [replace(flip(50 * k, 50 * k + 9), carried=k == 1) for k in range(3)]
    assert groups_of(walk, *turned) == []
    assert len(groups_of(walk, *turned, flip(150, 159))) == 1


def test_the_order_of_the_intervals_changes_nothing(walk):
    some = [jump(20), flip(20, 29), jump(29), made(KNEE, 60, 70), made(FOOT, 60, 70)]

    def found(order):
        groups = error_groups([some[k] for k in order], *walk)
        return {(frozenset(order[k] for k in g.members), g.name) for g in groups}

    assert found([3, 1, 4, 0, 2]) == found([0, 1, 2, 3, 4])


def test_the_example_of_flips(walk):
    clip = tc.read_clip(ASSETS / "kick.bvh")
    found = list(tc.detect(clip))
    chains = (*tc.find_chains(clip), *tc.find_limbs(clip))
    groups = error_groups(found, chains, clip.skeleton)
    assert [g.name for g in groups] == [
        "the same error 5 times: right knee flips, and 8 more errors",
        "Right knee flips and the jump at its edge",
    ]
    assert [g.short for g in groups] == ["5 times: right knee flips", "Right knee flips"]


def test_ten_times_as_many_intervals_take_about_ten_times_as_long(walk):
    def seconds(count):
        many = [made((KNEE, FOOT)[k % 2], 9 * k, 9 * k + 20, degrees=k % 90) for k in range(count)]
        times = []
        for _ in range(3):
            begin = process_time()
            error_groups(many, *walk)
            times.append(process_time() - begin)
        return min(times)

    assert seconds(5000) < 30 * seconds(500)


def test_of_two_corrections_of_the_same_frames_a_group_has_the_surer_one(walk):
    roll = replace(made(KNEE, 20, 30, Kind.CARRIED_ROLL), confidence=0.9)
    doubtful = replace(flip(20, 30), confidence=1.0, open=True)
    assert groups_of(walk, roll, doubtful) == []
    ((members, _),) = groups_of(walk, doubtful, roll, jump(30))
    assert members == {1, 2}
    later = replace(flip(30, 40), confidence=1.0)
    ((members, _),) = groups_of(walk, roll, jump(30), later)  # not in the same frames
    assert members == {0, 1, 2}
    ((members, _),) = groups_of(walk, roll, replace(flip(20, 30), confidence=1.0))
    assert members == {0, 1}  # refine corrects both


def test_alternatives_are_not_corrected_together(walk):
    chains, skeleton = walk
    roll = replace(made(KNEE, 20, 30, Kind.CARRIED_ROLL), confidence=0.9)
    doubtful = replace(flip(20, 30), confidence=1.0, open=True)
    other_leg = made("LeftUpLeg", 20, 30)
    every = (doubtful, roll, other_leg)
    assert drop_weaker_correction_alternatives(every, chains, skeleton) == (roll, other_leg)
    assert drop_weaker_correction_alternatives(every, chains, skeleton, chosen=[doubtful]) == (
        doubtful, other_leg,
    )  # fmt: skip
    assert (
        drop_weaker_correction_alternatives(every, chains, skeleton, chosen=[doubtful, roll])
        == every
    )


def test_an_alternative_that_is_left_excludes_nothing_else(walk):
    chains, skeleton = walk
    sure = replace(made(KNEE, 20, 30), confidence=0.9)
    doubtful = replace(flip(25, 45), confidence=0.8, open=True)
    roll = replace(made(KNEE, 40, 50, Kind.CARRIED_ROLL), confidence=0.6, open=True)
    every = (sure, doubtful, roll)
    assert drop_weaker_correction_alternatives(every, chains, skeleton) == (sure, roll)
