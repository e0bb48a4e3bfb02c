"""Find body steps, in which many joints jump in the same frame, and jumps in joint positions.

A joint *steps* in a frame if it rotates much farther than in the frames before and after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.bends import bend_steps
from twistcore.detection.cuts import count_leading_rest_frames, count_trailing_rest_frames
from twistcore.skeleton.medians import median, medians
from twistcore.skeleton.motion import Motion, cache_per_object
from twistcore.skeleton.notation import find_keys_of_linear_motion, without_repeated_frames
from twistcore.skeleton.people import Person, find_people
from twistcore.skeleton.rotation import Array, vector_lengths
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]

SHARE, FEWEST = 0.3, 5  # minimum share of the moving joints, and minimum number, that step together
# A joint steps if its rotation deviates from its pace by more than _TIMES its usual deviation, and
# by more than _LEAST degrees. The usual deviation is assumed to be at least _FLOOR degrees.
_TIMES, _LEAST, _FLOOR = 6.0, 0.5, 0.1
_SLOW, _LEAST_SLOW = 45.0, 5.0  # below this frame rate, the minimum deviation is this, in degrees
_AROUND = 0.08  # seconds; the usual deviation is the median of a block about twice as long
_MOVES = 0.02  # a joint moves if its median rotation is larger, in degrees per frame
_SHOWS = 2.0  # degrees: a step with a smaller median is hardly visible
_NEARBY = 10  # number of frames on either side with which the bends at a step are compared
_EDGE = 4  # number of frames at each end, and after a first pose, that are not examined

# The minimum distance from the path at a jump in position, as a share of the skeleton's height, in
# general and at a low frame rate.
PLACE, PLACE_SLOW = 0.02, 0.05
# The minimum ratio of this distance to the usual distance, the smallest usual distance as a share
# of the height, and the number of frames on either side that show the usual distance.
_PLACE_TIMES, _PLACE_FLOOR, _REACH = 8.0, 5e-4, 10


@dataclass(frozen=True)
class BodyStep:
    """A sudden rotation of many joints of a person in frames [start, stop).

    Attributes
    ----------
    share
        The fraction of the person's moving joints that step, in the frame in which it is largest.
    degrees
        The median rotation of the stepping joints, in degrees, in the frame in which it is largest.
    person
        The name of the person, '' if there is only one.
    """

    start: int
    stop: int
    share: float
    degrees: float
    person: str = ""


@dataclass(frozen=True)
class PlaceStep:
    """A jump in the position of a joint in frames [start, stop).

    `way` is the distance of the position from its interpolated path, as a fraction of the
    skeleton's height.
    """

    joint: int
    start: int
    stop: int
    way: float


@cache_per_object
def body_steps(motion: Motion) -> tuple[BodyStep, ...]:
    """Return the body steps of all people, sorted by start, with the frame numbers of the clip.

    In a body step, many joints step in the same frame. A joint steps if its rotation since the
    previous frame deviates from the mean of the rotations before and after by more than is usual
    nearby. Steps at both ends of a clip are omitted, because a clip may begin in another pose or
    blend into one.
    """
    kept = without_repeated_frames(motion)
    if kept is None and (keys := find_keys_of_linear_motion(motion)) is not None:
        kept = keys.alone(motion)  # at a key every joint changes its pace
    if kept is not None:
        return tuple(
            replace(b, start=kept.begin(b.start), stop=kept.end(b.stop - 1) + 1)
            for b in body_steps(kept.motion)
        )
    first = count_leading_rest_frames(motion) + _EDGE
    last = motion.frames - count_trailing_rest_frames(motion) - _EDGE
    if last - first < _EDGE:
        return ()
    every = _steps(motion.rotations)
    found = (
        one
        for person in find_people(motion.skeleton)
        for one in _of_person(motion, every, person, first, last)
    )
    return tuple(sorted(found, key=lambda one: one.start))


def _of_person(
    motion: Motion, every: Array, person: Person, first: int, last: int
) -> Iterator[BodyStep]:
    """Yield the body steps of one person.

    `every` contains the rotation angle of each joint of the skeleton since the previous frame, in
    degrees, (frames, joints). Only frames [first, last) are examined.
    """
    moving = [j for j in person.joints if median(every[:, j]) > _MOVES]
    if len(moving) < FEWEST:
        return
    least = _least_step(motion)
    wanted = max(FEWEST, int(np.ceil(SHARE * len(moving))))
    step = every[:, moving]
    off = _pace(step)
    off -= step
    np.abs(off, out=off)
    suspected = np.flatnonzero((off > least).sum(axis=1) >= wanted)
    suspected = suspected[(suspected >= first) & (suspected < last)]
    if not len(suspected):
        return
    most = _most_off_pace(off, suspected, motion.fps, least)
    over = _steps_at(step, off, suspected, most)
    many = over.sum(axis=1) >= wanted
    for k in np.flatnonzero(many).tolist():
        many[k] = _bends(motion, int(suspected[k]), least) >= 0.5 * wanted
    stepping = np.zeros(motion.frames, dtype=bool)
    stepping[suspected[many]] = True
    by_frame = dict(zip(suspected.tolist(), range(len(suspected)), strict=True))
    for start, stop in runs_of_true(stepping):
        rows = [by_frame[t] for t in range(start, stop)]
        share = max(float(over[k].mean()) for k in rows)
        turns = max(median(step[suspected[k]][over[k]]) for k in rows)
        if turns >= _SHOWS:
            yield BodyStep(start, stop, share, turns, person.name)


def _pace(step: Array) -> Array:
    """Return the pace of each joint, in degrees per frame, (frames, joints).

    The pace in a frame is the mean of the joint's rotations, `step`, in the frames before and after
    it. In the first and the last frame, it is the joint's rotation in this frame.
    """
    pace = step.copy()
    pace[1:-1] = 0.5 * (step[:-2] + step[2:])
    return pace


def _least_step(motion: Motion) -> float:
    """Return the minimum deviation from a joint's usual pace that counts as a step, in degrees."""
    least = _LEAST_SLOW if motion.fps < _SLOW else _LEAST
    return max(least, 2.0 * float(np.degrees(motion.angle_step)))


def _most_off_pace(off: Array, frames: NDArray[np.intp], fps: float, least: float) -> Array:
    """Return the largest natural deviation of each joint from its pace, in degrees, (n, joints).

    The pace is the mean rotation in the frames before and after. `off` contains the deviations in
    all frames, (frames, joints), and `frames` the n frames to examine. The result is at least
    `least`.
    """
    usual = _usual_around(off, frames, max(8, 2 * round(_AROUND * fps)))
    return np.maximum(_TIMES * np.maximum(usual, _FLOOR), least)


def _steps_at(step: Array, off: Array, frames: NDArray[np.intp], most: Array) -> Mask:
    """Return a mask of the joints that step in n given frames, (n, joints).

    `step` contains the rotations since the previous frame and `off` their deviations from the pace,
    both in degrees, (frames, joints). `most` is the result of :func:`_most_off_pace`.
    """
    # The frames next to a step also deviate, so a step must not be smaller than its neighbours.
    return np.asarray(
        (off[frames] > most) & (step[frames] >= np.maximum(step[frames - 1], step[frames + 1]))
    )


def body_rotation_curve_and_limit(
    motion: Motion, joints: Sequence[int], start: int, stop: int
) -> tuple[Array, Array] | None:
    """Return the median rotation of the joints that step in frames [start, stop), and its limit.

    Both have a value for each frame of the clip, in degrees, (frames,). The limit is the largest
    natural rotation, given the rotations in the frames before and after. `joints` contains the
    joints of a person, and `motion` must not contain held frames. The result is None if no joint
    steps.
    """
    frames = np.arange(max(start, 1), min(stop, motion.frames - 1))
    if not len(frames):
        return None
    step = _steps(motion.rotations[:, list(joints)])
    step = step[:, medians(step, axis=0) > _MOVES]
    pace = _pace(step)
    off = np.abs(step - pace)
    most = _most_off_pace(off, frames, motion.fps, _least_step(motion))
    over = _steps_at(step, off, frames, most)
    rows = zip(frames.tolist(), over, strict=True)
    turns = [median(step[t][own]) if own.any() else 0.0 for t, own in rows]
    best = int(np.argmax(turns))
    if not (own := over[best]).any():
        return None
    limit = medians(pace[:, own] + most[best, own])
    return medians(step[:, own]), limit


def _bends(motion: Motion, frame: int, least: float) -> int:
    """Return the number of joints whose bend jumps in a frame.

    The change of a joint's bend must exceed `least` degrees and be far larger than nearby. Twist
    errors in many chains rotate many joints in the same frame, but do not change any bend.
    """
    first = max(frame - _NEARBY, 0)
    bends = np.degrees(bend_steps(motion.sliced(first, min(frame + _NEARBY, motion.frames))))
    off = np.abs(bends[:, 1:-1] - 0.5 * (bends[:, :-2] + bends[:, 2:]))
    at = frame - first - 2  # the change from the previous frame
    usual = medians(np.delete(off, [at - 1, at, at + 1], axis=1))
    return int((off[:, at] > np.maximum(_TIMES * usual, least)).sum())


def _steps(rotations: Array) -> Array:
    """Return each joint's rotation since the previous frame, in degrees, (frames, joints)."""
    step = np.zeros(rotations.shape[:2])
    turn = step[1:]  # all in place, because the arrays of a long clip are large
    np.einsum("tji,tji->tj", rotations[1:], rotations[:-1], out=turn)
    np.minimum(np.abs(turn, out=turn), 1.0, out=turn)
    np.arccos(turn, out=turn)
    turn *= 2.0
    np.degrees(turn, out=turn)
    return step


def _usual_around(off: Array, frames: NDArray[np.intp], width: int) -> Array:
    """Return the usual deviation of each joint from its pace near n given frames, (n, joints).

    The usual deviation is the median of `off`, (frames, joints), over the block of `width` frames
    that contains the given frame.
    """
    blocks = max(len(off) // width, 1)
    at = np.minimum(frames // width, blocks - 1).tolist()
    usual = {b: medians(off[b * width : (b + 1) * width], axis=0) for b in set(at)}
    return np.array([usual[b] for b in at])


def position_jumps(motion: Motion, counted: Mask) -> list[PlaceStep]:
    """Return the jumps in position of roots and of joints with position channels, sorted by start.

    If a position leaves its path for a frame or two and then returns, this is one jump. `motion`
    must not contain held frames. `counted` is the mask of the frames to search, shape (frames,).
    """
    frames = motion.frames
    if frames < 4 * _REACH or not motion.positioned:
        return []
    height, least = motion.skeleton.height, _least_way(motion)
    off = _off_path(motion)
    found = []
    for k, joint in enumerate(motion.positioned):
        over = (off[:, k] > least) & counted
        over[: _EDGE + 1] = False
        over[frames - _EDGE :] = False
        jumps = [
            t
            for t in np.flatnonzero(over).tolist()
            if off[t, k] > _PLACE_TIMES * _usual_way(motion, off[:, k], t)
        ]
        mask = np.zeros(frames, dtype=bool)
        mask[jumps] = True
        for start, stop in runs_of_true(mask | np.roll(mask, 1) & np.roll(mask, -1)):
            way = float(off[start:stop, k].max()) / height
            found.append(PlaceStep(joint, start, stop, way))
    return sorted(found, key=lambda p: (p.start, p.joint))


def path_distance_and_jump_limit(
    motion: Motion, joint: int, frame: int
) -> tuple[Array, float] | None:
    """Return the distance of a joint from its path, (frames,), and the minimum jump in a frame.

    Both are fractions of the skeleton's height. The second is the smallest distance in frame
    `frame` that is reported as a jump. `motion` must not contain held frames. The result is None
    for a joint without position channels.
    """
    if joint not in motion.positioned:
        return None
    off = _off_path(motion)[:, motion.positioned.index(joint)]
    least = max(_least_way(motion), _PLACE_TIMES * _usual_way(motion, off, frame))
    return off / motion.skeleton.height, least / motion.skeleton.height


def _off_path(motion: Motion) -> Array:
    """Return the distance of each position from its path, in the file's unit, (frames, n).

    n is the number of joints with position channels. The distance in a frame is the length of the
    difference between the movement into the frame and the movement before or after it, whichever is
    more similar.
    """
    off = np.zeros((motion.frames, len(motion.positioned)))
    turned = vector_lengths(np.diff(motion.positions, n=2, axis=0))
    off[2:-1] = np.minimum(turned[:-1], turned[1:])
    return off


def _least_way(motion: Motion) -> float:
    """Return the minimum distance from the path at a jump in position, in the file's unit."""
    return (PLACE_SLOW if motion.fps < _SLOW else PLACE) * motion.skeleton.height


def _usual_way(motion: Motion, off: Array, t: int) -> float:
    """Return the usual distance of a position from its path near frame `t`, in the file's unit.

    `off` contains the position's distance from the path in each frame.
    """
    around = np.concatenate([off[max(t - _REACH, 2) : max(t - 2, 0)], off[t + 3 : t + 1 + _REACH]])
    floor = _PLACE_FLOOR * motion.skeleton.height
    return max(median(around), floor) if len(around) else floor
