"""Bends, cuts and blends, beside ones that are told joint by joint and frame by frame."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from twistcore.detection.bends import bend_steps
from twistcore.detection.cuts import (
    _jumps,
    count_leading_rest_frames,
    find_cuts,
    ignored_frames_notes,
)
from twistcore.detection.leading_blend import (
    LENGTHS,
    count_held_frames,
    leading_blend_end,
    trailing_rest_frames_of_rotations,
)
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.rotation import (
    conjugate,
    exponential,
    geodesic_angle,
    logarithm,
    multiply,
    normalise,
    quaternion_from_euler,
    rotate,
)

WALK = read_bvh(ASSETS / "walk.bvh").motion
CAPTURE = WALK.sliced(1, WALK.frames)


def tree(seed, joints=14, frames=12):
    """A skeleton of two roots, joints in one place, End Sites, and positions that vary."""
    rng = np.random.default_rng(seed)
    parents = np.array([-1, *(rng.integers(max(0, k - 3), k) for k in range(1, joints))])
    parents[5] = -1
    offsets = rng.normal(size=(joints, 3)) * rng.uniform(0.5, 9.0, (joints, 1))
    offsets[rng.random(joints) < 0.35] = 0.0
    leaves = [k for k in range(joints) if k not in parents]
    ends = tuple((k, tuple(rng.normal(size=3) * (k % 2))) for k in leaves)
    skeleton = Skeleton(tuple(f"J{k}" for k in range(joints)), parents, offsets, ends)
    q = normalise(rng.standard_normal((frames, joints, 4)))
    moved = tuple(k for k in (1, 4) if offsets[k].any())
    positions = offsets[list(moved)] + 0.4 * rng.standard_normal((frames, len(moved), 3))
    return Motion(skeleton, q, moved, positions.reshape(frames, -1, 3), 1 / 60)


def plain_bends(motion):
    """Changes of every bend and turn, each a row."""
    rotations, places = forward_kinematics(motion)
    parents, rows = motion.skeleton.parents.tolist(), []
    least = 1e-6 * motion.skeleton.height
    into = {}  # the bone that ends at a joint, in the room
    for j, p in enumerate(parents):
        if p < 0:
            rows.append(geodesic_angle(rotations[1:, j], rotations[:-1, j]))
        else:
            into[j] = places[:, j] - places[:, p]
    long = {j: np.linalg.norm(b, axis=1).min() > least for j, b in into.items()}
    for j, p in enumerate(parents):
        if p < 0:
            continue
        below = [c for c in motion.skeleton.children[j] if long[c]]
        end = motion.skeleton.end_offsets.get(j, np.zeros(3))
        if below:
            own = into[max(below, key=lambda c: np.linalg.norm(into[c], axis=1).mean())]
        elif np.linalg.norm(end) > least:
            own = rotate(rotations[:, j], np.asarray(end))
        else:
            continue
        top, root = j, p
        while not long[top] and parents[parents[top]] >= 0:
            top = parents[top]
            root = parents[top]
        own = normalise(own)
        if long[top]:
            bend = np.einsum("ti,ti->t", own, normalise(into[top])).clip(-1.0, 1.0)
            rows.append(np.abs(np.diff(np.arccos(bend))))
        else:
            inside = rotate(conjugate(rotations[:, root]), own)
            turn = np.einsum("ti,ti->t", inside[1:], inside[:-1]).clip(-1.0, 1.0)
            rows.append(np.arccos(turn))
    return np.array(rows)


@pytest.mark.parametrize("seed", range(12))
def test_bends_are_angles_between_bones_in_the_room(seed):
    motion = tree(seed)
    found, wanted = bend_steps(motion), plain_bends(motion)
    assert found.shape == wanted.shape
    order, by = (np.argsort(v.sum(axis=1)) for v in (found, wanted))
    np.testing.assert_allclose(found[order], wanted[by], atol=1e-6)


def test_bones_folded_back_upon_one_another_have_a_bend_that_does_not_change():
    directions = np.random.default_rng(0).standard_normal((60, 3))
    offsets = np.concatenate([[[0.0, 1.0, 0.0]], np.repeat(directions, 2, axis=0)])
    offsets[2::2] *= -0.3
    parents = np.array([-1, *(p for k in range(60) for p in (0, 2 * k + 1))])
    skeleton = Skeleton(tuple(f"J{k}" for k in range(121)), parents, offsets)
    q = normalise(np.random.default_rng(1).standard_normal((9, 121, 4)))
    q[:, 1::2] = [1.0, 0.0, 0.0, 0.0]
    found = bend_steps(Motion(skeleton, q, (), np.zeros((9, 0, 3)), 1 / 60))
    assert len(found) == 61
    assert np.isfinite(found).all()
    assert found[1:].max() < 1e-6


def plain_cuts(motion):
    """Frames that most joints jump into."""
    frames, fps = motion.frames, motion.fps
    block, cut = max(8, round(0.13 * fps)), np.zeros(frames, dtype=bool)
    if frames < 2 * block:
        return cut
    every = bend_steps(motion)
    turns = [turn for turn in every if turn.max() > np.radians(0.5)]
    if not turns:
        return cut
    votes = np.zeros(frames)
    for turn in turns:
        whole = (frames - 1) // block
        pace = [np.median(turn[k * block : (k + 1) * block]) for k in range(whole)]
        for t in range(frames - 1):
            k = min(t // block, whole - 1)
            beside = min(pace[max(k - 1, 0)], pace[min(k + 1, whole - 1)])
            least = max(5.0 * max(beside, pace[k]), np.radians(0.5))
            votes[t + 1] += turn[t] > min(least, np.pi)
    share = votes / max(len(turns), len(every) / 3.0)
    groups = []
    for t in np.flatnonzero(share > 0.3).tolist():
        if groups and t - groups[-1][-1] <= 3:
            groups[-1].append(t)
        else:
            groups.append([t])
    for group in groups:
        cut[group[0] : group[-1] + 1] = max(share[group]) > 0.55
    return cut


def jumping(seed, fps, moving=1.0, frames=120):
    """Joints that sway, of which more or fewer jump in some frames."""
    rng = np.random.default_rng(seed)
    motion = tree(seed, 20, frames)
    rate, phase = rng.uniform(0.5, 3.0, (20, 3)), rng.uniform(0.0, 6.0, (20, 3))
    angles = 0.3 * np.sin(rate * np.arange(frames)[:, None, None] / fps + phase)
    angles *= (rng.random(20) < moving)[:, None]
    for t in rng.integers(5, frames - 5, 7):
        for t_, share in ((t, rng.uniform(0.2, 0.9)), (t + int(rng.integers(1, 5)), 0.4)):
            angles[min(t_, frames - 1) :, rng.random(20) < share] += rng.normal(0.0, 0.2, 3)
    angles[:, rng.random(20) > 2.0 * moving] = 0.0
    rotations = quaternion_from_euler("ZYX", angles)
    return replace(motion, rotations=rotations, frame_time=1.0 / fps)


@pytest.mark.parametrize("fps", [24.0, 60.0, 120.0])
@pytest.mark.parametrize("moving", [0.2, 1.0])
def test_cuts_are_where_most_joints_jump(fps, moving):
    found = 0
    for seed in range(5):
        motion = jumping(seed, fps, moving)
        np.testing.assert_array_equal(_jumps(motion), plain_cuts(motion))
        found += int(plain_cuts(motion).sum())
    assert moving < 1.0 or found > 1


@pytest.mark.parametrize("frames", [1, 15, 16, 17, 25])
def test_short_clips_have_cuts_like_long_ones_from_two_blocks_on(frames):
    motion = jumping(2, 30.0).sliced(0, frames)
    np.testing.assert_array_equal(_jumps(motion), plain_cuts(motion))


# Blends


def plain_blend_end(q, fps, from_rest=False):
    """The first frame behind a blend out of frame 0; (frames, joints, 4)."""
    longest = max(8, round(0.27 * fps))
    q = q[: 2 * longest + 1]
    frames, joints, _ = q.shape
    if frames < 8:
        return 0
    rest = np.abs(q[0, :, 1:]).max(axis=1) < 1e-9
    sign = np.where(np.einsum("tjc,jc->tj", q, q[0]) < 0.0, -1.0, 1.0)
    way = q * sign[..., None] - q[0]
    turning = np.abs(way).max(axis=(0, 2)) > np.sin(np.radians(0.5))
    if turning.sum() < joints / 3.0:
        return 0
    resting = rest[turning].sum() >= 0.4 * turning.sum()
    if from_rest and not resting:
        return 0
    least, share = (0.6, 0.45) if resting else (0.2, 0.7)
    way, best = way[:, turning], 0
    for length in (2, 3, 5, 8, 12, 18, 25, 32, 45, 64):
        if length > longest or length > frames - 6:
            break
        left = plain_left(way, length)
        if left is None:
            continue
        median = sorted(left)[len(left) // 2]
        if median < least and sum(v < 0.5 for v in left) >= share * way.shape[1]:
            best, least = length, median
    return plain_end(way, best) if best else 0


def joints_on_course(way, length, stop):
    """Ways of joints that go far, in units of it, its direction, and the share s(t) of most."""
    ways, to = [], []
    for k in range(way.shape[1]):
        far = np.linalg.norm(way[length, k])
        if far > np.sin(np.radians(1.0)):
            ways.append(way[:stop, k] / far)
            to.append(way[length, k] / far)
    shares = sorted_middle([w @ v for w, v in zip(ways, to, strict=True)]) if ways else None
    return ways, to, shares


def sorted_middle(rows):
    return np.sort(np.array(rows), axis=0)[len(rows) // 2]


def bends_of(values, lag):
    return np.array(
        [
            values[t + lag] - 2.0 * values[t] + values[t - lag]
            for t in range(lag + 1, len(values) - lag)
        ]
    )


def plain_left(way, length):
    lag = 1 + length // 8
    ways, to, s = joints_on_course(way, length, length + 1 + 2 * lag)
    if not ways or 2 * len(ways) < way.shape[1]:
        return None
    begun, nearly = int((s > 0.1).argmax()), int((s > 0.9).argmax())
    if s.min() <= -0.1 or s.max() >= 1.3 or begun < 1 or nearly <= 1 or nearly < 3 * begun - 2:
        return None
    bend, left = bends_of(s, lag), []
    for w, v in zip(ways, to, strict=True):
        own = bends_of(w, lag)
        rest = own - bend[:, None] * v
        given, still = ((bend**2 * (a**2).sum(axis=1)).sum() for a in (own, rest))
        left.append(still / max(given, 1e-30))
    return left


def plain_end(way, length):
    lag = 1 + length // 8
    ways, to, s = joints_on_course(way, length, 2 * length + 6)
    bend, keeping = bends_of(s, lag), []
    for w, v in zip(ways, to, strict=True):
        own = bends_of(w, lag)
        rest = own - bend[:, None] * v
        keeping.append((rest**2).sum(axis=1) < 0.5 * (own**2).sum(axis=1))
    at = np.flatnonzero(np.mean(keeping, axis=0) >= 0.4)
    return int(at[-1]) + 1 + lag if len(at) else length


def out_of(pose, q, length, eased, seed=0, spoilt=0.0):
    """Frames of a capture blended out of a pose; some joints jump instead."""
    s = np.arange(length) / length
    s = s * s * (3.0 - 2.0 * s) if eased else s
    way = multiply(conjugate(pose)[None], q[:length])
    way = np.where(way[..., :1] < 0.0, -way, way)
    start = multiply(pose[None], exponential(s[:, None, None] * logarithm(way)))
    jump = np.random.default_rng(seed).random(q.shape[1]) < spoilt
    start[1:, jump] = q[1:length, jump]
    return np.concatenate([start, q[length:]])


REST = np.tile([1.0, 0.0, 0.0, 0.0], (WALK.rotations.shape[1], 1))


@parametrize("fps", [30.0, 120.0])
@parametrize("eased", [False, True])
def test_blends_end_where_they_do_joint_by_joint(fps, eased):
    q = CAPTURE.rotations[:: round(120.0 / fps)]
    found = set()
    poses = {"rest": REST, "last": q[-1], "another": q[40]}
    for k, length in enumerate((0, 1, 2, 3, 4, 6, 9, 13, 19, 26, 33, 40)):
        for name, spoilt in (("rest", 0.0), ("last", 0.0), ("rest", 0.6), ("another", 0.3)):
            clip = out_of(poses[name], q, length, eased, length, spoilt) if length else q
            whole = (clip, clip[:, :9], clip[: length + 7])[k % 3 if spoilt else 0]
            for from_rest in (False, True)[: 1 + (name == "rest")]:
                end = leading_blend_end(whole, fps, from_rest=from_rest)
                assert end == plain_blend_end(whole, fps, from_rest), (length, name, spoilt)
                found.add(end)
    assert len(found) > 4


@pytest.mark.parametrize("still", [0.4, 0.6, 0.7, 0.8])
def test_joints_that_stand_still_or_go_nowhere_far_do_not_vote(still):
    q = CAPTURE.rotations
    rng = np.random.default_rng(round(10.0 * still))
    found = set()
    for length in (3, 9, 19, 26):
        for pose in (REST, q[40]):
            clip = out_of(pose, q, length, eased=True)[:70]
            held = rng.random(q.shape[1]) < still
            clip[:, held] = clip[:1, held]
            near = rng.random(q.shape[1]) < still  # these go back to where they began
            for whole in (clip, np.where(near[:, None] & (np.arange(70) >= length)[:, None, None],
                                         clip[:1], clip)):  # fmt: skip
                for from_rest in (False, True):
                    end = leading_blend_end(whole, 120.0, from_rest=from_rest)
                    assert end == plain_blend_end(whole, 120.0, from_rest)
                    found.add(end)
    assert len(found) > (still < 0.5)


@pytest.mark.parametrize(("fps", "seen"), [(30.0, 16), (120.0, 64)])
def test_joints_count_that_turn_within_twice_the_longest_blend(fps, seen):
    """Fewer than a third of all are blended; one more that turns later makes them enough."""
    pose = CAPTURE.rotations[40]
    far = np.argsort(pose[:, 0] ** 2)  # those that are turned farthest from rest
    joints = len(far)
    blended, one = far[: -(-joints // 3) - 1], far[-1]
    still = np.repeat(pose[None], seen + 9, axis=0)
    clip = np.tile(REST, (seen + 9, 1, 1))
    clip[:, blended] = out_of(REST, still, 5 if fps == 30.0 else 18, eased=True)[:, blended]
    for first in (seen - 1, seen, seen + 1):
        whole = clip.copy()
        whole[first:, one] = np.cos(0.1), np.sin(0.1), 0.0, 0.0
        end = leading_blend_end(whole, fps)
        assert end == plain_blend_end(whole, fps)
        assert (end > 0) == (first <= seen)


@pytest.mark.parametrize("component", [1, 2, 3])
def test_a_joint_that_is_turned_about_any_axis_is_at_no_rest(component):
    pose = REST.copy()
    pose[:, [0, component]] = np.cos(0.02), np.sin(0.02)
    clip = out_of(pose, CAPTURE.rotations, 19, eased=True)
    assert leading_blend_end(clip, 120.0, from_rest=True) == 0
    assert (
        leading_blend_end(out_of(REST, CAPTURE.rotations, 19, eased=True), 120.0, from_rest=True)
        > 9
    )


def test_the_lengths_that_are_looked_for():
    assert LENGTHS == (2, 3, 5, 8, 12, 18, 25, 32, 45, 64)
    assert [leading_blend_end(CAPTURE.rotations[:n], 120.0) for n in range(1, 9)] == [0] * 8


def test_a_pose_is_held_as_long_as_nothing_moves_at_all():
    q = CAPTURE.rotations
    for held in (0, 1, 5):
        clip = np.concatenate([np.repeat(q[:1], held, axis=0), q])
        assert count_held_frames(clip) == held
    assert count_held_frames(q[:1]) == 0
    assert count_held_frames(np.repeat(q[:1], 4, axis=0)) == 3
    one = np.repeat(q[:1], 4, axis=0)
    one[2, 3, 1] += 1e-12
    assert count_held_frames(one) == 1


def test_a_rest_pose_at_the_end_is_told_only_behind_a_blend():
    q = CAPTURE.rotations
    blended = out_of(REST, q[::-1], 12, eased=True)[::-1]
    length = trailing_rest_frames_of_rotations(blended, 120.0)
    assert 10 <= length <= 14
    held = np.concatenate([blended, np.repeat(blended[-1:], 7, axis=0)])
    assert trailing_rest_frames_of_rotations(held, 120.0) == length + 7
    still = np.concatenate([q, np.repeat(q[-1:], 7, axis=0)])
    assert trailing_rest_frames_of_rotations(still, 120.0) == 0
    elsewhere = out_of(q[40], q, 12, eased=True)
    assert leading_blend_end(elsewhere, 120.0) > 9
    assert trailing_rest_frames_of_rotations(elsewhere[::-1], 120.0) == 0
    motion = replace(CAPTURE, rotations=held, positions=CAPTURE.positions[[0] * len(held)])
    cut = np.flatnonzero(find_cuts(motion)).tolist()
    assert cut == list(range(len(held) - length - 7, len(held)))
    (note,) = ignored_frames_notes(motion)
    assert names_in_one_line(note, f" {len(held) - length - 7}–{len(held) - 1} ")


def test_what_is_left_out_at_the_start_is_all_up_to_the_end_of_the_blend():
    q = CAPTURE.rotations
    for held in (0, 4):
        blended = out_of(REST, q, 12, eased=True)
        clip = np.concatenate([np.repeat(REST[None], held, axis=0), blended])
        motion = replace(CAPTURE, rotations=clip, positions=CAPTURE.positions[[0] * len(clip)])
        end = held + leading_blend_end(clip[held:], 120.0)
        assert np.flatnonzero(find_cuts(motion)).tolist() == list(range(held + 1, end + 1))
        assert count_leading_rest_frames(motion) == end
        (note,) = ignored_frames_notes(motion)
        assert names_in_one_line(note, f" 0–{end - 1} ")
    assert count_leading_rest_frames(WALK) == 1
    assert ignored_frames_notes(WALK) == ignored_frames_notes(CAPTURE) == ()


def test_a_clip_that_is_a_blend_to_its_end_has_no_capture():
    q = out_of(REST, CAPTURE.rotations[::-1], 12, eased=True)[::-1][-22:]
    motion = replace(CAPTURE, rotations=q, positions=CAPTURE.positions[:22])
    assert trailing_rest_frames_of_rotations(q, 120.0) > 9
    assert count_leading_rest_frames(motion) == 21
