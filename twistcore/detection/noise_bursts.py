"""Find bursts of noise, in which a joint jitters more than any body can.

If a joint has white noise with the standard deviation σ, its rotations from frame to frame have the
variance 2σ². The changes of these rotations have the variance 6σ², three times as much. Natural
motion is smooth, so its rotations change little. Frames in which the changes are larger than the
rotations themselves therefore contain noise, and the size of the changes determines σ.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.body import ancestors
from twistcore.skeleton.medians import median, pad_with_edge_values, quantile, running_medians
from twistcore.skeleton.motion import Motion, cache_per_object
from twistcore.skeleton.notation import without_repeated_frames
from twistcore.skeleton.rotation import Array, conjugate, logarithm, multiply
from twistcore.skeleton.runs import group_overlapping_spans, runs_of_true
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]

_WINDOW, _FEWEST = 0.6, 21  # length of the window in seconds and at least in frames
_ROUGH = 2.5  # variance of changes over variance of turns: 3 for white noise, below 1 for motion
_LEAST = 4.5  # degrees; noise with a smaller σ may be fast motion
_BEYOND = 2.0  # minimum ratio to the usual σ of the joint in the clip
_MIDDLE = 6.0 * 2.366  # the median of |change|² of white noise about three axes, in units of σ²
_SWINGS = 0.8  # minimum share of frames in which a change is reversed; 5/6 for white noise
# If another joint compensates for the noise, at most this share of the squared changes remains.
_TAKEN_BACK = 0.25
_GAP = 5  # maximum number of successive frames in a burst that are smooth by chance
_MOST = 5  # maximum number of spans in the notes, and of joints in a note
_EDGE = 1.2  # minimum distance of a burst's frames from the mean of their neighbours, in σ


@dataclass(frozen=True)
class NoiseBurst:
    """A burst of noise in frames [start, stop) of a joint.

    `degrees` is the σ of the noise about each axis.
    """

    joint: int
    start: int
    stop: int
    degrees: float


@cache_per_object
def noise_bursts(motion: Motion) -> tuple[NoiseBurst, ...]:
    """Return the bursts of noise of all joints, sorted by start."""
    found = []
    for joint, sigma in enumerate(_levels(motion, range(len(motion.skeleton)))):
        for start, stop in runs_of_true(sigma > 0.0):
            found.append(NoiseBurst(joint, start, stop, median(sigma[start:stop])))
    return tuple(sorted(found, key=lambda b: (b.start, b.stop, b.joint)))


def largest_joint_and_ancestor_noise(motion: Motion, joints: Iterable[int]) -> Array:
    """Return the largest noise σ among the joints and their ancestors, in degrees, (frames,).

    The result is 0 in frames without a burst.
    """
    near = set(joints)
    for joint in tuple(near):
        near.update(ancestors(motion.skeleton, joint))
    return np.asarray(np.max([np.zeros(motion.frames), *_levels(motion, sorted(near))], axis=0))


def _levels(motion: Motion, joints: Iterable[int]) -> list[Array]:
    """Return the noise σ of each joint, in degrees, (frames,).

    A held frame has the value of the frame that it repeats.
    """
    if (held := without_repeated_frames(motion)) is None:
        return [_of_joint(motion, joint) for joint in joints]
    shown = np.maximum(np.searchsorted(held.first, np.arange(motion.frames), side="right") - 1, 0)
    return [_of_joint(held.motion, joint)[shown] for joint in joints]


def _of_joint(motion: Motion, joint: int) -> Array:
    """Return the noise σ of a joint in degrees, (frames,), from a cache if possible.

    Callers must not change the array. The array of a joint without noise takes no memory.
    """
    known = _by_joint(motion)
    if joint not in known:
        sigma = _noise_of(motion, joint)
        known[joint] = sigma if sigma.any() else np.broadcast_to(0.0, motion.frames)
    return known[joint]


@cache_per_object
def _by_joint(motion: Motion) -> dict[int, Array]:
    """Return the cache of :func:`_of_joint` for a motion, keyed by joint."""
    del motion
    return {}


def _noise_of(motion: Motion, joint: int) -> Array:
    """Return the noise σ of a joint in degrees, (frames,).

    Bursts for which the parent or a child of the joint compensates are excluded.
    """
    own = motion.rotations[:, joint]
    turns = rotation_vector_steps(own)
    sigma = joint_noise_level(turns, motion.fps)
    if not sigma.any():
        return sigma
    parent = int(motion.skeleton.parents[joint])
    pairs = [(motion.rotations[:, parent], own)] if parent >= 0 else []
    pairs += [(own, motion.rotations[:, child]) for child in motion.skeleton.children[joint]]
    changes = [
        _changes(turns),
        *(_changes(rotation_vector_steps(multiply(a, b))) for a, b in pairs),
    ]
    for start, stop in runs_of_true(sigma > 0.0):
        alone, *both = (median(c[start:stop]) for c in changes)
        if min(both, default=alone) < _TAKEN_BACK * alone:
            sigma[start:stop] = 0.0
    return sigma


def _changes(turns: Array) -> Array:
    """Return the squared change of a rotation vector in each frame, (frames, 3) → (frames,)."""
    out = np.zeros(len(turns))
    out[1:-1] = ((turns[2:] - turns[1:-1]) ** 2).sum(axis=1)
    return out


def noise_burst_sentences(
    count: int, outside: Iterable[NoiseBurst], names: Sequence[str]
) -> tuple[str, ...]:
    """Return the notes about the bursts of noise in a clip.

    Parameters
    ----------
    count
        The number of noise bursts in chains, which are reported in a single note.
    outside
        The bursts in joints that belong to no chain, sorted by start. Each group of overlapping
        bursts has its own note, up to a maximum number of notes.
    names
        The names of the joints.
    """
    spans = group_overlapping_spans(outside)
    said = [_sentence(span, names) for span in spans[:_MOST]]
    if len(spans) > _MOST:
        said.append(f"{len(spans) - _MOST} more bursts of noise are outside the chains.")
    if count:
        one = (
            "A burst of noise was found (kind 'noise burst'). Smooth it with 'Track this burst' in "
            "the window or with `quamo refine --where noisy`."
        )
        many = (
            f"{count} bursts of noise were found (kind 'noise burst'). Smooth them with 'Track "
            "this burst' in the window or with `quamo refine --where noisy`."
        )
        said.insert(0, one if count == 1 else many)
    return tuple(said)


def _sentence(span: Sequence[NoiseBurst], names: Sequence[str]) -> str:
    joints = list(dict.fromkeys(names[b.joint] for b in span))
    listed = ", ".join(joints[:_MOST]) + (" …" if len(joints) > _MOST else "")
    start, stop = min(b.start for b in span), max(b.stop for b in span)
    most = max(b.degrees for b in span)
    return (
        f"There is noise of about {most:.0f}° in frames {start}–{stop} ({listed}), "
        "outside the chains. Smooth it in Quality → Track."
    )


def rotation_vector_steps(q: Array) -> Array:
    """Return the rotation from the previous frame to each frame as a rotation vector.

    `q` has the shape (frames, 4). The result is in degrees and has the shape (frames, 3).
    """
    turns = logarithm(multiply(conjugate(q[:-1]), q[1:]))
    return np.asarray(np.degrees(np.concatenate([np.zeros((1, 3)), turns])))


def joint_noise_level(turns: Array, fps: float) -> Array:
    """Return the noise σ of a joint in each frame, in degrees, (frames,), or 0 outside bursts.

    `turns` is the result of :func:`rotation_vector_steps`.
    """
    frames = len(turns)
    width = max(_FEWEST, round(_WINDOW * fps))
    none = np.zeros(frames)
    if frames < width + 2:
        return none
    change = np.zeros((frames, 3))
    change[1:-1] = turns[2:] - turns[1:-1]
    size, far = ((v**2).sum(axis=1) for v in (change, turns))
    if not _may_be_mostly_true(size > 0.99 * _MIDDLE * _LEAST**2, width):
        return none
    # Use medians, so that one or two jumps are not mistaken for noise.
    changes, moves = (running_medians(v, width) for v in (size, far))
    sigma = np.sqrt(changes / _MIDDLE)
    against = np.zeros(frames)
    against[1:-2] = (change[1:-2] * change[2:-1]).sum(axis=1) < 0.0
    swings = _running_sums(against, width) / width
    noisy = (changes > _ROUGH * moves) & (swings > _SWINGS)
    noisy &= sigma > _least_noise(sigma)
    out = np.zeros(frames)
    off = 0.5 * np.sqrt(size)
    for start, stop in runs_of_true(noisy):
        level = median(sigma[start:stop])
        low, high = max(start - width, 0), min(stop + width, frames)
        rough = np.flatnonzero(off[low:high] > _EDGE * level) + low
        for part in np.split(rough, np.flatnonzero(np.diff(rough) > _GAP) + 1):
            if len(part) >= _FEWEST // 2 and part[0] < stop and part[-1] >= start:
                out[part[0] : part[-1] + 1] = level
    return out


def _least_noise(sigma: Array) -> float:
    """Return the minimum σ of a burst, given the σ of a joint in each frame, in degrees."""
    usual = quantile(sigma, 0.15)  # a burst may last for most of a short clip
    return max(_LEAST, _BEYOND * usual)


def joint_noise_and_burst_threshold(motion: Motion, joint: int) -> tuple[Array, float]:
    """Return the noise σ of a joint near each frame, (frames,), and the smallest σ of a burst.

    Both are in degrees. `motion` must not contain held frames.
    """
    width = max(_FEWEST, round(_WINDOW * motion.fps))
    changes = running_medians(_changes(rotation_vector_steps(motion.rotations[:, joint])), width)
    sigma = np.sqrt(changes / _MIDDLE)
    return sigma, _least_noise(sigma)


def _may_be_mostly_true(mask: Mask, width: int) -> bool:
    """Return True if some window of `width` values in a mask may be mostly True."""
    half = width // 2
    return bool(_running_sums(mask, 2 * half + 1).max() >= width - half)


def _running_sums(values: Array | Mask, width: int) -> Array:
    """Return the sum of `width` values around each value.

    Both ends are padded as in :func:`running_medians`.
    """
    before = width // 2
    padded = pad_with_edge_values(values, before, width - 1 - before)
    sums = np.concatenate([[0.0], np.cumsum(padded)])
    return np.asarray(sums[width:] - sums[:-width])
