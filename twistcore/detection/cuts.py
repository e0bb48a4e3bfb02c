"""Find discontinuities of a clip, such as cuts or a T-pose at its start or end [Method, step 7].

Discontinuities divide a clip into segments. They are not errors.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from twistcore.detection.bends import bend_steps
from twistcore.detection.leading_blend import (
    count_held_frames,
    leading_blend_end,
    trailing_rest_frames_of_rotations,
)
from twistcore.detection.prediction import Mask
from twistcore.skeleton.medians import medians
from twistcore.skeleton.motion import Motion, cache_per_object
from twistcore.skeleton.notation import DistinctFrames, without_repeated_frames

# Seconds between cuts. In a shorter segment, errors cannot be distinguished from motion.
SHORTEST_SEGMENT = 0.25
JUMP = 5.0  # minimum ratio of a jump to the joint's usual pace
SMALLEST = float(np.radians(0.5))  # joints that bend less do not vote
SHARE = 0.55  # minimum share of the voting joints that jump; tremors in captures reach 0.52
# If fewer than this share of all joints ever bend, the votes are counted as if this share did. An
# error in a clip in which nearly all joints are still is therefore not mistaken for a cut.
FEWEST = 1.0 / 3.0
# A frame with at least this share of jumping joints belongs to a cut if the gap between them is at
# most HOLE frames.
SHARE_BESIDE, HOLE = 0.3, 3
LEADING = 12  # maximum number of transitions over which a T-pose blends into the capture
# Seconds. The pace is the median of a block of this length, so that the few frames of a cut do not
# change it.
BLOCK_SECONDS = 0.13


def find_cuts(motion: Motion) -> Mask:
    """Return a mask of the frames whose change from the previous frame is not motion, (frames,).

    Such a change is a cut, or part of a blend from the clip's first pose or into a rest pose at the
    clip's end.
    """
    return _cuts(motion).copy()


@cache_per_object
def _cuts(motion: Motion) -> Mask:
    if (held := without_repeated_frames(motion)) is not None:
        return _among_held(find_cuts(held.motion), held)
    rotations, fps = motion.rotations, motion.fps
    cut = _jumps(motion)
    first = count_held_frames(rotations)
    if end := leading_blend_end(rotations[first:], fps):
        cut[first + 1 : first + end + 1] = True
    if last := trailing_rest_frames_of_rotations(rotations, fps):
        cut[-last:] = True
    return cut


def _among_held(cut: Mask, held: DistinctFrames) -> Mask:
    """Expand a mask of the cuts in a clip without held (repeated) frames to the whole clip.

    Held frames within a blend belong to the blend.
    """
    full = np.zeros(held.frames, dtype=bool)
    full[held.first] = cut
    full[held.first[0] : held.first[-1]] |= np.repeat(cut[:-1] & cut[1:], np.diff(held.first))
    return full


def _jumps(motion: Motion) -> Mask:
    """Return a mask of the frames in which the bends of most joints jump at the same time.

    A joint votes for a cut if its bend changes by more than JUMP times the joint's pace. A pace is
    the median change in the block of the frame or in the calmer neighbouring block, whichever is
    larger. At a cut, more than the fraction SHARE of the joints that ever bend must vote.
    """
    frames = motion.frames
    cut = np.zeros(frames, dtype=bool)
    block = max(8, round(BLOCK_SECONDS * motion.fps))
    if frames < 2 * block:
        return cut
    turns = bend_steps(motion)
    voting = turns.max(axis=1, initial=0.0) > SMALLEST
    voters = max(int(voting.sum()), FEWEST * len(voting))
    if not voting.any():
        return cut
    turns = turns if voting.all() else turns[voting]
    blocks = (frames - 1) // block
    pace = medians(turns[:, : blocks * block].reshape(-1, blocks, block))
    padded = np.concatenate([pace[:, :1], pace, pace[:, -1:]], axis=1)
    calm = np.maximum(np.minimum(padded[:, :-2], padded[:, 2:]), pace)
    least = np.minimum(np.maximum(JUMP * calm, SMALLEST), np.pi)
    at = np.minimum(np.arange(frames - 1) // block, blocks - 1)
    share = np.zeros(frames)
    for turn, most in zip(turns, least, strict=True):
        share[1:] += turn > most[at]
    share /= voters
    # A blend from a T-pose fades out, so a cut includes nearby frames in which fewer joints jump.
    candidates = np.flatnonzero(share > SHARE_BESIDE)
    if len(candidates):
        groups = np.split(candidates, np.flatnonzero(np.diff(candidates) > HOLE) + 1)
        for group in groups:
            if (share[group] > SHARE).any():
                cut[group[0] : group[-1] + 1] = True
    return cut


def segments_between(cut: Mask, fps: float) -> tuple[tuple[int, int], ...]:
    """Return the segments [low, high) between cuts, excluding those too short to examine."""
    shortest = round(SHORTEST_SEGMENT * fps)
    borders = [0, *np.flatnonzero(cut).tolist(), len(cut)]
    return tuple(
        (a, b) for a, b in pairwise(borders) if b - a >= min(shortest, len(cut)) and b - a > 1
    )


def count_leading_rest_frames(motion: Motion) -> int:
    """Return the number of frames at the start of a clip that are a rest pose or a blend from it.

    These frames end at the last cut (:func:`find_cuts`) within 12 transitions after the first pose,
    which may be held. If that cut belongs to a longer blend, all frames of the blend are included.
    In CMU clips, this is only frame 0; in the Daz conversion, it is the first 8 to 12 frames.
    """
    cut = find_cuts(motion)
    near = np.flatnonzero(cut[: count_held_frames(motion.rotations) + LEADING + 1])
    if not len(near):
        return 0
    behind = np.flatnonzero(~cut[near[-1] :])
    return int(near[-1] + (behind[0] if len(behind) else len(cut) - near[-1]) - 1)


def count_trailing_rest_frames(motion: Motion) -> int:
    """Return the number of frames at the end of a clip that repeat a rest pose or blend into it."""
    return trailing_rest_frames_of_rotations(motion.rotations, motion.fps)


def ignored_frames_notes(motion: Motion) -> tuple[str, ...]:
    """Return notes about ignored frames at the start and the end of a clip.

    A single ignored frame at the start is not mentioned.
    """
    first, last = count_leading_rest_frames(motion), count_trailing_rest_frames(motion)
    notes = []
    if first > 1:
        notes.append(
            f"Frames 0–{first - 1} are an initial pose and the transition from it to the "
            "motion. They were not captured, so they are ignored."
        )
    if last:
        notes.append(
            f"Frames {motion.frames - last}–{motion.frames - 1} are a transition to a rest "
            "pose. They were not captured, so they are ignored."
        )
    return tuple(notes)
