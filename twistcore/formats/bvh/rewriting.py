"""Rewrite a BVH file with different angles, axes, units, channels, names or frame rates.

Each function takes a clip and returns the clip after the change, with a list of what changed. Bytes
that need not change stay the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.euler_branch import (
    continuous_euler_angles_in_order,
    nearest_euler_angles,
    unwrapped_euler_angles,
)
from twistcore.formats.bvh.header_places import HeaderPlace, header_word_spans
from twistcore.formats.bvh.lower_rate import reparse_bvh, select_bvh_frames
from twistcore.formats.bvh.patch import MIN_DECIMALS, replace_numbers
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.resampling import frames_at_times, interpolate_poses_at_times
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

STILL = 1e-5  # share of the height; a position that differs less from OFFSET does not move
_SAME = 1e-9  # degrees; smaller differences are rounding errors
_SAME_RATE = 5e-4  # the same for ratios of frame rates: 0.01667 means 1/60, but not 1/59.94
_SIMPLE = 10  # largest denominator of a ratio of frame rates that is treated as exact


@dataclass(frozen=True)
class RewrittenJoint:
    """The changes of one joint.

    Attributes
    ----------
    joint
        The joint's name.
    numbers
        Number of motion values that differ or were removed.
    start, stop
        The first frame with such a value, and the frame after the last one. Both are 0 if no value
        differs.
    frames
        Number of frames with such values.
    words
        Number of words and numbers in the hierarchy that differ.
    """

    joint: str
    numbers: int
    start: int
    stop: int
    frames: int
    words: int


@dataclass(frozen=True, eq=False)
class Rewriting:
    """A rewritten clip, its changed joints, and notes about data that did not change."""

    clip: BvhClip
    changes: tuple[RewrittenJoint, ...]
    notes: tuple[str, ...] = ()


def unwrap_bvh_clip_angles(clip: BvhClip) -> Rewriting:
    """Replace angles that jump with equivalent angles (see :func:`unwrapped_euler_angles`)."""
    values = clip.values.copy()
    for layout in clip.channels:
        if columns := list(layout.rotation):
            values[:, columns] = unwrapped_euler_angles(layout.order, values[:, columns])
    return _rewritten(clip, values)


def change_rotation_order(clip: BvhClip, orders: Mapping[str, str]) -> Rewriting:
    """Change the rotation order of joints.

    `orders` maps joint names to orders such as 'ZYX'. The key '' applies to all other joints.
    Raises TwistError if a named joint does not exist or does not have three rotation channels.
    """
    names = clip.skeleton.names
    if unknown := sorted(orders.keys() - {"", *names}):
        raise TwistError(f"{clip.path}: expected a joint of the clip, found {unknown[0]!r}")
    values, notes = clip.values.copy(), []
    letters: dict[int, str] = {}
    for joint, (name, layout) in enumerate(zip(names, clip.channels, strict=True)):
        order = orders.get(name, orders.get("", layout.order))
        if not layout.rotatable and name in orders:
            raise TwistError(
                f"{clip.path}: expected {name!r} to have three rotation channels to reorder, "
                f"found {len(layout.order)}"
            )
        if not layout.rotatable and layout.order:
            notes.append(f"{name} keeps its channels, because it does not turn about three axes")
        elif layout.rotatable and order != layout.order:
            columns = list(layout.rotation)
            angles = continuous_euler_angles_in_order(order, clip.motion.rotations[:, joint])
            same = np.abs(angles - values[:, columns]) < _SAME
            values[:, columns] = np.where(same, values[:, columns], angles)
            letters |= dict(zip(columns, order, strict=True))
    return _rewritten(clip, values, letters=letters, notes=tuple(notes))


def change_axes_and_unit(clip: BvhClip, matrix: Array) -> Rewriting:
    """Convert a clip to different axes and a different unit.

    `matrix`, (3, 3), is a rotation by multiples of 90° times a factor. Because such a rotation only
    renames axes and changes signs, numbers stay exact, except that numbers with exponents are
    rounded when written.
    """
    axes, sizes = np.abs(matrix).argmax(axis=0), matrix.sum(axis=0)  # where x, y and z are mapped
    values, letters = clip.values.copy(), {}
    for layout in clip.channels:
        turning = [("XYZ".index(a), c) for a, c in zip(layout.order, layout.rotation, strict=True)]
        for axis, column in (*layout.position, *turning):
            letters[column] = "XYZ"[axes[axis]]
            values[:, column] *= np.sign(sizes[axis]) if (axis, column) in turning else sizes[axis]
    # Numbers keep their precision.
    decimals = MIN_DECIMALS + max(0, math.ceil(-math.log10(np.abs(sizes[0]))))
    return _rewritten(clip, values, letters=letters, matrix=matrix, decimals=decimals)


def with_joint_names(clip: BvhClip, names: Mapping[str, str]) -> Rewriting:
    """Rename joints. `names` maps old names to new ones.

    Raises TwistError if the new names could not be read back.
    """
    old = clip.skeleton.names
    new = [names.get(name, name) for name in old]
    if repeated := [name for name in new if new.count(name) > 1]:
        raise TwistError(f"{clip.path}: two joints would have the name {repeated[0]!r}")
    if odd := [n for n in new if not n or n != n.strip() or set(n) & set("{\r\n")]:
        raise TwistError(f"{clip.path}: expected a name on one line without '{{', found {odd[0]!r}")
    places = [p for p in _header(clip) if p.kind == "name" and new[p.joint] != old[p.joint]]
    parts = [(p.start, p.stop, new[p.joint].encode("utf-8", "surrogateescape")) for p in places]
    found = reparse_bvh(clip, _spliced(clip.text, parts))
    pairs = zip(new, found.skeleton.names, strict=True)
    if lost := [name for name, again in pairs if name != again]:
        raise TwistError(
            f"{clip.path}: expected new names for all joints that share a name, found none for "
            f"{lost[0]!r}"
        )
    nothing = np.zeros(clip.values.shape, dtype=np.bool_)
    return Rewriting(found, _changes(clip, nothing, [p.joint for p in places]))


def without_redundant_positions(clip: BvhClip, *, keep_moving: bool) -> Rewriting:
    """Remove position channels of joints below the root that always equal OFFSET.

    If such a joint moves away from its OFFSET, it keeps its channels if `keep_moving` is True. If
    not, TwistError is raised with the joint and the frame.
    """
    gone, notes = np.zeros(clip.columns, dtype=np.bool_), []
    for joint, layout in enumerate(clip.channels):
        if clip.skeleton.parents[joint] < 0 or not layout.position:
            continue
        axes, columns = map(list, zip(*layout.position, strict=True))
        away = np.abs(clip.values[:, columns] - clip.skeleton.offsets[joint, axes]).max(axis=1)
        far = np.flatnonzero(away > STILL * clip.skeleton.height)
        if not len(far):
            gone[columns] = True
            continue
        name, frame = clip.skeleton.names[joint], int(far[0])
        why = f"{name} is {away[frame]:.6g} away from its OFFSET in frame {frame}"
        if not keep_moving:
            raise TwistError(f"{clip.path}: {why}, so its position channels cannot be removed")
        notes.append(f"{why}, and keeps its position channels")
    if not gone.any():
        return Rewriting(clip, (), tuple(notes))
    if gone.all():
        raise TwistError(
            f"{clip.path}: expected at least one channel that is not a position below the root"
        )
    found = np.broadcast_to(gone, clip.values.shape)
    joints = [place.joint for place, column in _channels(clip) if gone[column]]
    joints += dict.fromkeys(joints)  # the number of channels changes, too
    again = reparse_bvh(clip, _without_columns(clip, gone))
    return Rewriting(again, _changes(clip, found, joints), tuple(notes))


def resample_clip(clip: BvhClip, fps: float) -> Rewriting:
    """Resample a clip at a different frame rate.

    Rotations are interpolated on the shorter arc, positions linearly. A frame at the time of a
    source frame keeps its bytes. In other frames, the numbers of joints that do not move stay the
    same.
    """
    if abs(fps * clip.frame_time - 1.0) < _SAME_RATE:
        return Rewriting(clip, (), (f"the frame rate is already {clip.fps:.6g} frames per second",))
    times = resampled_frame_times(clip.frames, clip.frame_time, fps)
    before, after, share = frames_at_times(times, clip.frames)
    held = select_bvh_frames(clip, before.tolist(), 1.0 / fps)
    way = clip.values[after] - held.values
    turning = [column for layout in clip.channels for column in layout.rotation]
    way[:, turning] = np.degrees(wrap(np.radians(way[:, turning])))
    values = held.values + share[:, None] * way
    q = resample_motion(clip.motion, times, 1.0 / fps).rotations
    # In other joints, each axis is interpolated separately.
    for joint, layout in enumerate(clip.channels):
        columns = np.array(layout.rotation, dtype=np.intp)
        moving = np.flatnonzero(way[:, columns].any(axis=1))
        if layout.rotatable and len(moving):
            at = np.ix_(moving, columns)
            values[at] = nearest_euler_angles(layout.order, q[moving, joint], values[at])
    return _rewritten(held, values)


def resampled_frame_times(frames: int, frame_time: float, fps: float) -> Array:
    """Return the times of the frames at the rate `fps`, in frames of the clip, (new frames,)."""
    step = 1.0 / (frame_time * fps)
    simple = float(Fraction(step).limit_denominator(_SIMPLE))
    step = simple if abs(simple - step) < _SAME_RATE * step else step
    count = int(np.floor((frames - 1) / step + 1e-9)) + 1
    times: Array = np.minimum(np.arange(count) * step, float(frames - 1))
    return times


def resample_motion(motion: Motion, times: Array, frame_time: float) -> Motion:
    """Return a motion interpolated at `times`, which are in frames. `frame_time` is in seconds."""
    rotations, positions = interpolate_poses_at_times(motion.rotations, motion.positions, times)
    return Motion(motion.skeleton, rotations, motion.positioned, positions, frame_time)


# -- changes to the text ---------------------------------------------------------------------------


def _rewritten(
    clip: BvhClip,
    values: Array,
    *,
    letters: Mapping[int, str] | None = None,
    matrix: Array | None = None,
    decimals: int = MIN_DECIMALS,
    notes: tuple[str, ...] = (),
) -> Rewriting:
    """Return a copy of a clip with new motion values, channel axes and offsets.

    Parameters
    ----------
    clip
        The clip.
    values
        The new motion numbers, shape (frames, columns).
    letters
        New axes of channels, keyed by column.
    matrix
        Matrix that converts offsets, shape (3, 3).
    decimals
        Minimum number of decimals of a changed number.
    notes
        Notes about data that did not change.
    """
    found, parts, joints = values != clip.values, [], list[int]()
    for place, column in _channels(clip):
        old = clip.text[place.start : place.start + 1].decode()
        new = (letters or {}).get(column, old)
        new = new.upper() if old.isupper() else new.lower()
        if new != old:
            parts.append((place.start, place.start + 1, new.encode()))
            joints.append(place.joint)
    text = _spliced(clip.text, parts)  # the length stays the same
    if len(tokens := np.flatnonzero(found)):
        text = replace_numbers(text, clip.token_spans, tokens, values.ravel()[tokens], decimals)
    places = [place for place in _header(clip) if place.kind == "offset"]
    if matrix is not None and places:
        before = np.array([float(clip.text[p.start : p.stop]) for p in places])
        numbers = (before.reshape(-1, 3) @ matrix.T).ravel()
        spans = np.array([p.start for p in places]), np.array([p.stop for p in places])
        if len(differs := np.flatnonzero(numbers != before)):
            text = replace_numbers(text, spans, differs, numbers[differs], decimals)
        joints += [places[k].joint for k in differs.tolist()]
    again = clip if text == clip.text else reparse_bvh(clip, text)
    return Rewriting(again, _changes(clip, found, joints), notes)


def _header(clip: BvhClip) -> list[HeaderPlace]:
    return header_word_spans(clip.text[: clip.data_start])


def _channels(clip: BvhClip) -> list[tuple[HeaderPlace, int]]:
    """Return the place of each channel's name in the header, with the channel's column."""
    counts = [len(layout.rotation) + len(layout.position) for layout in clip.channels]
    first = np.cumsum([0, *counts]).tolist()
    return [(p, first[p.joint] + p.place) for p in _header(clip) if p.kind == "channel"]


def _spliced(text: bytes, parts: Iterable[tuple[int, int, bytes]]) -> bytes:
    """Return a text in which spans are replaced. `parts` has (start, stop, new bytes) in order."""
    pieces, done = [], 0
    for start, stop, new in parts:
        pieces += [text[done:start], new]
        done = stop
    return b"".join([*pieces, text[done:]])


def _without_columns(clip: BvhClip, gone: NDArray[np.bool_]) -> bytes:
    """Return the text without the channels of some columns and without an incomplete last row.

    `gone` is a mask of the columns, shape (columns,).
    """
    columns, places, parts = dict(_channels(clip)), _header(clip), []
    for k, place in enumerate(places):
        if place.kind == "count":
            left = sum(not gone[columns[p]] for p in places[k + 1 : k + 1 + place.place])
            parts.append((place.start, place.stop, str(left).encode()))
        elif place in columns and gone[columns[place]]:
            parts.append((places[k - 1].stop, place.stop, b""))
    starts, stops = clip.token_spans
    rows = np.arange(clip.frames) * clip.columns
    for a, b in np.flatnonzero(np.diff(gone, prepend=False, append=False)).reshape(-1, 2).tolist():
        # If the last column is removed, the space before it is removed instead of the one after it.
        last = b == clip.columns
        spans = (stops, a - 1, b - 1) if last else (starts, a, b)
        begin, end = (spans[0][rows + column].tolist() for column in spans[1:])
        parts += zip(begin, end, repeat(b""), strict=False)
    if len(starts) > clip.values.size:
        parts.append((int(stops[clip.values.size - 1]), int(stops[-1]), b""))
    return _spliced(clip.text, sorted(parts))


def _changes(
    clip: BvhClip, found: NDArray[np.bool_], joints: list[int] | None = None
) -> tuple[RewrittenJoint, ...]:
    """Return the changes of each joint.

    `found` is a mask of changed motion numbers, (frames, columns). `joints` lists the index of the
    joint to which each changed word of the hierarchy belongs.
    """
    changes = []
    for joint, layout in enumerate(clip.channels):
        mask = found[:, [*layout.rotation, *(column for _, column in layout.position)]]
        at = np.flatnonzero(mask.any(axis=1))
        words = (joints or []).count(joint)
        if len(at) or words:
            start, stop = (int(at[0]), int(at[-1]) + 1) if len(at) else (0, 0)
            name = clip.skeleton.names[joint]
            changes.append(RewrittenJoint(name, int(mask.sum()), start, stop, len(at), words))
    return tuple(changes)
