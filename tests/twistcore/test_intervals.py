"""Intervals, the paper's detector, events of a clip's own and lone jumps, each by itself."""

import json
import math
import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples
from tests.twistcore import reviews
from tests.twistcore.counters import counter_of
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Interval, Kind
from twistcore.detection import lone_jumps as lone_jumps_module
from twistcore.detection.detectors.paper import PaperDetector
from twistcore.detection.lone_jumps import largest_natural_turn, lone_jumps
from twistcore.detection.natural_events import (
    NaturalEvent,
    chain_flip_events,
    chains_and_limbs_with_events,
    limb_flip_events,
    natural_events,
)
from twistcore.detection.paper import (
    intervals_of_offset,
    paper_detector_error_increments,
    paper_detector_running_offset,
)
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.angles import circular_median
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import (
    conjugate,
    multiply,
    quaternion_from_axis_angle,
    twist_angle,
    wrap,
)

FILE = read_bvh(ASSETS / "walk.bvh").motion
WALK = FILE.sliced(1, 80)
CHAINS = find_chains(WALK)
LIMBS = find_limbs(WALK, CHAINS)
DEGREE = math.pi / 180.0


def interval(degrees, start=10, **more):
    offset = np.radians(np.asarray(degrees, dtype=float))
    return Interval("Arm", start, start + len(offset), offset, **more)


# Intervals


@pytest.mark.parametrize(
    ("degrees", "soft", "shown", "seen_at"),
    [
        ([30.0, 30.0, 20.0], False, 30.0, 10),
        ([7.4, 20.0, 30.0, 30.0], True, 30.0, 12),
        ([7.6, 26.9, 27.1, 30.0], False, 27.0, 12),
        ([30.0, 30.0, 20.0, 7.4], True, 30.0, 10),
        ([-3.0, -10.0, -40.0, -19.0, -30.0], True, -40.0, 12),
        ([0.0, 14.9, 15.0, 30.0], True, 30.0, 13),
        ([0.0], False, 0.0, 10),
        ([], False, 0.0, 10),
    ],
)
def test_a_soft_interval_is_shown_by_its_largest_offset(degrees, soft, shown, seen_at):
    one = interval(degrees)
    assert one.soft_ended is soft
    assert math.degrees(one.shown) == pytest.approx(shown)
    assert one.seen_at == seen_at
    assert one.frames == len(degrees)
    if len(degrees):
        assert abs(one.largest) == np.abs(one.offset).max()
    assert not replace(one, kind=Kind.LIMB_FLIP).soft_ended


def test_a_lone_jump_is_as_large_as_its_turn_and_nothing_of_it_is_repairable():
    jump = interval([0.0, 0.0], kind=Kind.LONE_JUMP, residual=2.0)
    assert (jump.size, jump.shown, jump.repairable) == (2.0, 2.0, False)
    assert interval([30.0], residual=2.0).size == pytest.approx(30.0 * DEGREE)
    assert interval([30.0]).repairable
    assert replace(jump, kind=Kind.LIMB_FLIP).repairable


def test_an_interval_says_in_a_line_what_it_is():
    one = interval([30.0, 30.0])
    assert repr(one) == "<Interval Arm 10–12: +30.0°>"
    flip = replace(one, confidence=0.876, open=True, kind=Kind.LIMB_FLIP)
    assert repr(flip) == "<Interval Arm 10–12: +30.0°, confidence 0.88, open, limb flip>"


def test_other_offsets_bring_their_frames():
    moved = interval([30.0, 30.0], confidence=0.5).with_offset(4, np.zeros(5))
    assert (moved.start, moved.stop, moved.confidence) == (4, 9, 0.5)


def test_evidence_is_asked_for_once_it_is_needed_and_goes_along():
    asked = []
    one = interval([30.0], explain=lambda: asked.append(1) or {"gain": 3.0})
    assert asked == []
    assert one.evidence == {"gain": 3.0}
    same = pickle.loads(pickle.dumps(one))
    assert same.evidence == {"gain": 3.0}
    assert same.offset.tolist() == one.offset.tolist()
    none = interval([30.0])
    assert none.evidence is None
    assert (none.open, none.residual, none.carried, none.joint) == (False, 0.0, False, "")
    assert (none.kind, none.followed, none.confidence) == (Kind.COUNTER_TWIST, 1.0, None)
    assert pickle.loads(pickle.dumps(none)).evidence is None


@given(st.lists(st.floats(-60.0, 60.0), min_size=1, max_size=9), st.floats(-3.1, 3.1))
def test_the_circular_median_turns_with_the_angles(degrees, turn):
    angles = np.radians(degrees)
    found = circular_median(wrap(angles + turn))
    assert abs(float(wrap(found - turn - np.median(angles)))) < 1e-6


# The paper's detector


def plain_intervals(offset, tau):
    """(start, stop, offsets, residual) of the running sum's intervals."""
    found, start, base, before = [], None, 0.0, 0.0
    for t, level in enumerate(offset):
        if level != before:
            left = float(wrap(level - base))
            if start is None:
                start, base = t, before
            elif abs(left) < tau:
                found.append((start, t, wrap(offset[start:t] - base), left))
                start, base = None, level
        before = level
    if start is not None:
        rest = wrap(offset[start:] - base)
        found.append((start, len(offset), rest, float(rest[-1])))
    return found


steps = st.one_of(st.just(0.0), st.just(0.0), st.sampled_from([50.0, -50.0, 20.0, -49.0, 180.0]))


@given(st.lists(steps, min_size=1, max_size=20), st.sampled_from([0.0, 10.0]))
def test_the_running_sum_is_cut_where_it_comes_back(jumps, carried):
    offset = np.cumsum(np.radians([carried, *jumps]))
    found = intervals_of_offset("c", offset, math.radians(5.0))
    wanted = plain_intervals(offset, math.radians(5.0))
    assert [(i.start, i.stop) for i in found] == [w[:2] for w in wanted]
    for i, (_, _, offsets, left) in zip(found, wanted, strict=True):
        np.testing.assert_allclose(i.offset, offsets)
        assert i.residual == pytest.approx(left)
        assert i.chain == "c"


def test_an_error_has_the_sign_of_p_and_the_size_of_m_from_tau_on():
    turns, strength = np.array([0.3, -0.3, 0.3, 0.0]), np.array([0.2, 0.1, 0.09, 0.3])
    np.testing.assert_array_equal(
        paper_detector_error_increments(turns, strength, 0.1), [0.2, -0.1, 0.0, 0.0]
    )


def test_the_papers_threshold_is_five_degrees_and_its_curve_is_m():
    told: list[float] = []
    analysis = PaperDetector().analyse(WALK, CHAINS, told.append)
    assert told == [k / len(CHAINS) for k in range(len(CHAINS))]
    assert analysis.automatic_tau(CHAINS[0].name) == 5.0 * DEGREE
    for chain in CHAINS:
        signals = analysis.signals[chain.name]
        assert analysis.strength(chain.name) is signals.strength
        offset = paper_detector_running_offset(signals, 0.01)
        found, wanted = (
            [(i.chain, i.start, i.stop, i.residual) for i in some]
            for some in (
                analysis.intervals(chain.name, 0.01),
                intervals_of_offset(chain.name, offset, 0.01),
            )
        )
        assert found == wanted
    assert {name: d.info.name for name, d in DETECTORS.items()} == {
        n: n for n in ("consistency", "paper")
    }
    assert DEFAULT_METHOD == "consistency"


# Events of a clip's own


def test_flips_are_turns_of_one_joint_alone_that_no_limb_makes():
    counter = counter_of(1, chains=1, frames=60, jumps=0.0)
    rx, ry, event = (np.zeros((1, 60)) for _ in range(3))
    sigma = np.full((1, 60), 2.0 * DEGREE)
    sigma[0, 40:] = 7.0 * DEGREE
    for t, degrees in ((5, 61.0), (6, -61.0), (7, 59.0), (45, 69.0), (46, 71.0), (50, 90.0)):
        rx[0, t] = degrees * DEGREE
    ry[0, 8] = -150.1239 * DEGREE
    event[0, 50] = 1.0
    rx[0, [0, 20, 59]] = ry[0, 30] = rx[0, [1, 21, 58]] = 2.0
    c = replace(counter, rx=rx, ry=ry, sigma_x=sigma, sigma_y=sigma, event=event > 0.0)
    tables = (SimpleNamespace(low=0, high=20), SimpleNamespace(low=20, high=59))
    chain = SimpleNamespace(name="Arm", parent=3, child=4)
    found = list(chain_flip_events(chain, SimpleNamespace(limb=c, row=0, tables=tables)))
    assert [(e.start, e.stop, e.joint) for e in found] == [
        (1, 2, 3), (5, 6, 3), (6, 7, 3), (21, 22, 3), (46, 47, 3), (58, 59, 3),
        (8, 9, 4), (30, 31, 4),
    ]  # fmt: skip
    assert [e.degrees for e in found[1:3]] == [61.0, -61.0]
    assert [found[k].degrees for k in (4, 6)] == [71.0, -150.124]
    assert {(e.chain, e.kind) for e in found} == {("Arm", "flip")}
    assert found[1].to_json() == {
        "chain": "Arm", "kind": "flip", "start": 5, "stop": 6, "degrees": 61.0
    }  # fmt: skip


def test_what_a_detector_finds_at_its_own_threshold_is_an_event_an_open_one_too():
    class Finds:
        def automatic_tau(self, chain):
            return 0.1 * (1 + len(chain))

        def intervals(self, chain, tau):
            assert tau == self.automatic_tau(chain)
            return (
                Interval(chain, 4, 9, np.full(5, 0.5)),
                Interval(chain, 20, 22, np.full(2, -0.25), open=True),
            )

    chains = [SimpleNamespace(name=n, parent=k, child=9) for k, n in enumerate(("Arm", "Leg1"))]
    wanted = [
        NaturalEvent(c.name, kind, start, stop, degrees, c.parent)
        for c in chains
        for kind, start, stop, degrees in (
            ("interval", 4, 9, 28.648), ("open", 20, 22, -14.324)
        )
    ]  # fmt: skip
    assert natural_events(chains, Finds()) == wanted


def test_flips_are_told_beside_the_intervals_of_their_chain():
    motion = spun(CHAINS[3].parent, 30, 50, 170.0)
    analysis = DETECTORS["consistency"].analyse(motion, CHAINS)
    events = natural_events(CHAINS, analysis)
    alone = [e for c in CHAINS for e in chain_flip_events(c, analysis.chains[c.name])]
    assert [e for e in events if e.kind == "flip"] == alone
    assert {(e.chain, e.start) for e in alone} >= {(CHAINS[3].name, 30), (CHAINS[3].name, 50)}
    paper = PaperDetector().analyse(motion, CHAINS)
    assert all(e.kind == "interval" for e in natural_events(CHAINS, paper))


def test_flips_of_limbs_are_events_and_what_else_is_found_there_is_none():
    limb = LIMBS[0]
    flip = Interval(limb.name, 4, 9, np.full(5, 2.0), kind=Kind.LIMB_FLIP)
    (event,) = limb_flip_events(LIMBS, [replace(flip, kind=Kind.LONE_JUMP), flip])
    degrees = round(math.degrees(2.0), 3)
    assert event == NaturalEvent(limb.name, "limb flip", 4, 9, degrees, limb.parent)


def test_an_event_of_a_limb_counts_for_the_chains_that_share_its_ends_and_back():
    def audited(*names):
        events = [NaturalEvent(n, "interval", 0, 1, 9.0, 0) for n in names]
        return chains_and_limbs_with_events(WALK.skeleton, CHAINS, LIMBS, events)

    assert audited() == frozenset()
    for limb in LIMBS:
        ends = {limb.parent, limb.end}
        near = {c.name for c in CHAINS if ends & set(c.changed_joints(WALK.skeleton))}
        assert near
        assert audited(limb.name) == near | {limb.name}
        for chain in CHAINS:
            assert (limb.name in audited(chain.name)) is (chain.name in near)


# Lone jumps


def spun(joint, start, stop, degrees, motion=WALK):
    """A joint turned about its own bone in frames [start, stop), its children with it."""
    return reviews.spun(motion.skeleton.names[joint], start, stop, degrees, motion)


def plain_jumps(motion, chains):
    """(chain, joint, start, stop, turn) of every jump."""
    least = 120.0 if motion.fps < 50.0 else max(60.0, 7500.0 / motion.fps)
    room, names, found = forward_kinematics(motion)[0], motion.skeleton.names, []
    for joint in {j for c in chains for j in (c.parent, c.child)}:
        own = next((c for c in chains if c.parent == joint), None)
        own = own or next(c for c in chains if c.child == joint)
        axis = own_bone_axis(motion.skeleton, joint)
        both = [
            np.degrees(twist_angle(multiply(conjugate(q[:-1, joint]), q[1:, joint]), axis)).tolist()
            for q in (room, motion.rotations)
        ]
        for t, turns in enumerate(zip(*both, strict=True), start=1):
            if abs(turns[0]) > least and abs(turns[1]) > 0.5 * least:
                last = found[-1] if found else None
                if last and last[:2] == [own.name, names[joint]] and last[3] == t:
                    last[3] = t + 1
                    last[4] = max(last[4], turns[0], key=abs)
                else:
                    found.append([own.name, names[joint], t, t + 1, turns[0]])
    return sorted(map(tuple, found))


@settings(max_examples=examples(12))
@given(
    st.sampled_from([30.0, 49.0, 51.0, 120.0, 240.0]),
    st.lists(
        st.tuples(
            st.integers(0, len(CHAINS) - 1), st.booleans(), st.integers(0, 70),
            st.integers(1, 9), st.floats(20.0, 340.0),
        ),
        max_size=3,
    ),
)  # fmt: skip
def test_lone_jumps_are_told_joint_by_joint(fps, turned):
    motion = replace(WALK, frame_time=1.0 / fps)
    for k, of_child, start, length, degrees in turned:
        joint = CHAINS[k].child if of_child else CHAINS[k].parent
        motion = spun(joint, start, start + length, degrees, motion)
    found = lone_jumps(motion, CHAINS)
    assert list(found) == [c.name for c in CHAINS]
    told = sorted(
        (i.chain, i.joint, i.start, i.stop, pytest.approx(math.degrees(i.residual), abs=1e-6))
        for i in (i for own in found.values() for i in own)
    )
    assert plain_jumps(motion, CHAINS) == told
    for own in found.values():
        assert [i.start for i in own] == sorted(i.start for i in own)
        for i in own:
            assert (i.kind, i.open, i.confidence) == (Kind.LONE_JUMP, True, None)
            np.testing.assert_array_equal(i.offset, np.zeros(i.frames))
            evidence = json.loads(json.dumps(i.evidence))
            assert evidence == {
                "joint": i.joint,
                "turn_deg": pytest.approx(math.degrees(i.residual)),
                "speed_deg_s": pytest.approx(abs(math.degrees(i.residual)) * motion.fps),
                "limit_deg_s": pytest.approx(
                    math.degrees(largest_natural_turn(motion.fps)) * motion.fps
                ),
            }


@pytest.mark.parametrize(
    ("fps", "degrees"),
    [(24.0, 120.0), (49.9, 120.0), (50.0, 150.0), (100.0, 75.0), (125.0, 60.0), (240.0, 60.0)],
)
def test_the_limit_is_a_speed_between_noise_and_what_a_slow_camera_proves(fps, degrees):
    assert math.degrees(largest_natural_turn(fps)) == pytest.approx(degrees)


def test_frames_that_follow_one_another_are_one_jump_as_fast_as_its_fastest():
    chain = CHAINS[0]
    motion = spun(chain.parent, 20, 79, 100.0)
    motion = spun(chain.parent, 21, 79, 130.0, motion)
    motion = spun(chain.parent, 22, 79, 90.0, spun(chain.parent, 24, 79, -110.0, motion))
    found = lone_jumps(motion, CHAINS[:1])[chain.name]
    frames = [(i.start, i.stop) for i in found if i.joint == WALK.skeleton.names[chain.parent]]
    assert frames == [(20, 23), (24, 25)]
    assert math.degrees(found[0].residual) == pytest.approx(130.0, abs=15.0)


@pytest.mark.parametrize(("of_parent", "own", "joints"), [
    (100.0, 40.0, []), (100.0, 70.0, ["c"]), (70.0, 70.0, ["c"]), (0.0, 130.0, ["c"]),
    (125.0, 10.0, ["b"]), (125.0, -125.0, ["b"]),
])  # fmt: skip
def test_a_joint_that_only_goes_along_does_not_jump(of_parent, own, joints):
    parents = np.array([-1, 0, 1, 2])
    straight = np.array([[0.0, 1.0, 0.0]] * 4)
    skeleton = Skeleton(("a", "b", "c", "d"), parents, straight, ((3, (0.0, 1.0, 0.0)),))
    q = np.zeros((12, 4, 4))
    q[..., 0] = 1.0
    for joint, degrees in ((1, of_parent), (2, own)):
        q[5:, joint] = quaternion_from_axis_angle(np.eye(3)[1], degrees * DEGREE)
    motion = Motion(skeleton, q, (), np.zeros((12, 0, 3)), 1.0 / 30.0)
    chain = SimpleNamespace(name="b", parent=1, child=2)
    assert [i.joint for i in lone_jumps(motion, [chain])["b"]] == joints


def test_a_joint_without_an_axis_hides_no_other(monkeypatch):
    first = CHAINS[0].child
    axis = lone_jumps_module.own_bone_axis
    motion = spun(CHAINS[3].parent, 20, 79, 150.0)
    usual = lone_jumps(motion, CHAINS)[CHAINS[3].name]
    monkeypatch.setattr(
        lone_jumps_module, "own_bone_axis", lambda s, j: None if j == first else axis(s, j)
    )
    found = lone_jumps(motion, CHAINS)[CHAINS[3].name]
    assert [(i.joint, i.start) for i in found] == [(i.joint, i.start) for i in usual]
    assert found


def test_no_chains_and_no_second_frame_have_no_jumps():
    assert lone_jumps(WALK, []) == {}
    assert lone_jumps(WALK.sliced(0, 1), CHAINS[:2]) == {c.name: () for c in CHAINS[:2]}
    two = spun(CHAINS[0].parent, 1, 2, 170.0, WALK.sliced(0, 2))
    assert [i.start for i in lone_jumps(two, CHAINS[:1])[CHAINS[0].name]] == [1]


def test_a_joints_own_axis_is_that_of_its_longest_bone_or_of_a_joint_in_its_place():
    names = ("a", "b", "c", "d", "e", "f")
    parents = np.array([-1, 0, 0, 2, 3, 2])
    offsets = np.array([[0, 9, 0], [3, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 2], [0, 0, 0]], float)
    skeleton = Skeleton(names, parents, offsets, ((4, (0.0, -5.0, 0.0)), (0, (0.0, 0.0, 4.0))))
    axes = [own_bone_axis(skeleton, j) for j in range(6)]
    assert axes[1] is axes[5] is None
    wanted = {0: [0, 0, 1], 2: [0, 0, 1], 3: [0, 0, 1], 4: [0, -1, 0]}
    for joint, axis in wanted.items():
        np.testing.assert_array_equal(axes[joint], axis)


def test_an_offset_that_goes_both_ways_shows_where_it_is_largest():
    offset = np.radians(np.r_[np.full(10, 5.0), np.full(9, -6.0)])
    one = Interval("LeftArm", 10, 29, offset)
    assert math.degrees(replace(one, offset=offset - np.radians(0.2)).shown) == pytest.approx(4.8)
    wavering = np.radians(np.r_[np.full(9, 5.0), 0.1, np.full(9, -6.0)])
    assert math.degrees(replace(one, offset=wavering).shown) == pytest.approx(-6.0)
