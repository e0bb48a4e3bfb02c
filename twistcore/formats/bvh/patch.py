"""Replace the numbers of corrected joints in a file's text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.bvh.channels import JointChannels
from twistcore.formats.bvh.euler_branch import continuous_euler_angles, euler_jump_rows_and_channels
from twistcore.formats.clip import ChannelJump
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array

MIN_DECIMALS = 6
_MAX_DECIMALS = 15
_FARTHEST = 2e6 * np.pi  # radians; an angle of more than a million turns loses digits
_LONG = 40  # bytes; the decimals of longer numbers are counted one number at a time


def changed_rotation_values(
    values: Array,
    channels: Sequence[JointChannels],
    names: Sequence[str],
    motion: Motion,
    changed: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], Array, tuple[ChannelJump, ...]]:
    """Return the rotation values to write, which are continuous with the neighbouring frames.

    Parameters
    ----------
    values
        The numbers in the file, shape (frames, columns), angles in degrees.
    channels, names
        The channels and the name of each joint.
    motion
        The motion to write.
    changed
        Mask of the rotations to write, shape (frames, joints).

    Returns
    -------
    tokens : ndarray, shape (n,)
        Index of each number in reading order.
    numbers : ndarray, shape (n,)
        The new numbers, in degrees.
    jumps : tuple of ChannelJump
        Steps of more than 180° that cannot be avoided.

    Raises
    ------
    ValueError
        If a changed joint does not have three rotation channels.
    """
    columns = values.shape[1]
    tokens, numbers, jumps = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], []
    for joint in np.flatnonzero(changed.any(axis=0)).tolist():
        layout, name = channels[joint], names[joint]
        if not layout.rotatable:
            raise ValueError(f"joint {name!r} does not have three rotation channels to write to")
        rotation = list(layout.rotation)
        source = np.radians(values[:, rotation])
        wrapped = np.arctan2(np.sin(source), np.cos(source))
        near = np.where(np.abs(source) < _FARTHEST, source, wrapped)
        rotations = np.ascontiguousarray(motion.rotations[:, joint])
        for start, stop in _runs(changed[:, joint]).tolist():
            q, own = rotations[start:stop], near[start:stop]
            found = continuous_euler_angles(layout.order, q, own, *_neighbours(near, start, stop))
            for row, channel in euler_jump_rows_and_channels(
                found, *_neighbours(source, start, stop)
            ):
                letter = layout.order[channel]
                jumps.append(ChannelJump(name, start + row, f"{letter}rotation"))
            tokens.append((np.arange(start, stop)[:, None] * columns + rotation).ravel())
            numbers.append(np.degrees(found).ravel())
    return np.concatenate(tokens), np.concatenate(numbers), tuple(jumps)


def _neighbours(angles: Array, start: int, stop: int) -> tuple[Array | None, Array | None]:
    """Return the rows before and after a run of frames, or None at an end of the clip."""
    before = angles[start - 1] if start > 0 else None
    return before, angles[stop] if stop < len(angles) else None


def changed_position_values(
    channels: Sequence[JointChannels], columns: int, before: Motion, motion: Motion
) -> tuple[NDArray[np.int64], Array]:
    """Return the position values that differ between two motions.

    Returns
    -------
    tokens : ndarray, shape (n,)
        Index of each number in reading order.
    numbers : ndarray, shape (n,)
        The numbers of `motion`, in the file's unit.
    """
    tokens, numbers = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for place, positioned in enumerate(motion.positioned):
        for axis, column in channels[positioned].position:
            here, there = (m.positions[:, place, axis] for m in (motion, before))
            at = np.flatnonzero(here != there)
            tokens.append(at * columns + column)
            numbers.append(here[at])
    return np.concatenate(tokens), np.concatenate(numbers)


def replace_numbers(
    data: bytes,
    spans: tuple[NDArray[np.int64], NDArray[np.int64]],
    tokens: NDArray[np.int64],
    numbers: Array,
    least: int = MIN_DECIMALS,
) -> bytes:
    """Return the text with some of its tokens replaced by new numbers.

    All other bytes stay the same. A new number has as many decimals as the old one, but at least
    `least`, and no exponent.

    Parameters
    ----------
    data
        The text.
    spans
        Byte offsets of the starts and the ends of all tokens, in reading order.
    tokens
        Indices of the tokens to replace, shape (n,).
    numbers
        The new numbers, shape (n,).
    least
        Minimum number of decimals.
    """
    order = np.argsort(tokens, kind="stable")
    tokens, numbers = tokens[order], numbers[order]
    starts, ends = (span[tokens] for span in spans)
    decimals = _decimals(data, starts, ends)
    # Neighbouring numbers with one space between them are written together, so that there are fewer
    # parts to join.
    together = np.zeros(len(tokens), dtype=np.bool_)
    buffer = np.frombuffer(data, dtype=np.uint8)
    together[:-1] = (starts[1:] - ends[:-1] == 1) & (buffer[ends[:-1]] == 32)
    form = 2 * np.clip(decimals, least, _MAX_DECIMALS) + together
    # All numbers are formatted in one call. Separate calls would take longer than everything else.
    forms = [f"%.{k // 2}f{' ' if k % 2 else chr(10)}" for k in range(2 * _MAX_DECIMALS + 2)]
    text = "".join([forms[k] for k in form.tolist()]) % tuple(numbers.tolist())
    first = np.roll(~together, 1)
    stops = [0, *ends[~together].tolist()]
    nexts = [*starts[first].tolist(), len(data)]
    pieces = [b""] * (2 * len(stops) - 1)
    pieces[0::2] = [data[a:b] for a, b in zip(stops, nexts, strict=True)]
    pieces[1::2] = text.encode().split(b"\n")[:-1]
    return b"".join(pieces)


def _decimals(data: bytes, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of decimals of each token, ignoring exponents."""
    buffer = np.frombuffer(data, dtype=np.uint8)
    decimals = np.zeros(len(starts), dtype=np.int64)
    length = ends - starts
    odd = length > _LONG
    for back in range(min(int(length.max()), _LONG)):
        byte, inside = buffer[ends - 1 - back], back < length
        decimals[(byte == 46) & inside] = back
        odd |= ((byte | 32) == 101) & inside
    # Exponents and very long numbers are rare. Only the mantissa has decimals.
    for k in np.flatnonzero(odd).tolist():
        mantissa = data[starts[k] : ends[k]].lower().partition(b"e")[0]
        decimals[k] = len(mantissa.partition(b".")[2])
    return decimals


def _runs(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the spans [start, stop) of runs of True values, shape (runs, 2)."""
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return edges.reshape(-1, 2)
