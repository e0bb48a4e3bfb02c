"""Writing: the kept bytes with the numbers of corrected joints in corrected frames replaced."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.atomic import is_stream, same_file, write_atomically
from twistcore.bvh.clip import Clip
from twistcore.bvh.euler_branch import angle_jumps, continuous_angles
from twistcore.errors import TwistError
from twistcore.motion import Motion, check_motion
from twistcore.rotation import Array

_MIN_DECIMALS = 6
_MAX_DECIMALS = 15


@dataclass(frozen=True)
class EulerJump:
    """A step of more than 180° in a written channel, which no equivalent angles could avoid.

    frame: the later one of the step; channel: such as 'Zrotation'. The pose is right in every
    frame; only who interpolates the channels between frames sees a spin.
    """

    joint: str
    frame: int
    channel: str

    def __str__(self) -> str:
        return f"{self.joint} {self.channel} jumps by a turn at frame {self.frame}"


@dataclass(frozen=True, eq=False)
class Patch:
    """The bytes to write and the jumps that stayed in them."""

    data: bytes = field(repr=False)
    jumps: tuple[EulerJump, ...]


def changed_rotations(clip: Clip, motion: Motion) -> NDArray[np.bool_]:
    """Which local rotations differ from the clip's, bit for bit, shape (frames, joints)."""
    if motion.rotations is clip.motion.rotations:
        return np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    differs = motion.rotations != clip.motion.rotations
    # Four flags seen as one number: several times faster than any() along so short an axis.
    changed: NDArray[np.bool_] = differs.view(np.uint32)[..., 0] != 0
    return changed


def write_bvh(
    clip: Clip, motion: Motion, path: str | Path, *, replace_source: bool = False
) -> tuple[EulerJump, ...]:
    """Write `clip` with the rotations and positions of `motion`; only what differs is rewritten.

    Atomically. Returns the jumps of Euler angles that could not be avoided. Raises TwistError where
    the file that the clip was read from would be replaced, unless `replace_source`; OSError.
    """
    check_motion(motion)
    path = Path(path)
    if not replace_source and not is_stream(path) and same_file(path, clip.path):
        raise TwistError(
            f"{path}: expected another file than the clip's own source "
            "(replace_source=True replaces it)"
        )
    moved = motion.positions is not clip.motion.positions
    patch = patched(clip, motion, changed_rotations(clip, motion), positions=moved)
    write_atomically(path, patch.data)
    return patch.jumps


def patch_rotations(clip: Clip, motion: Motion, changed: NDArray[np.bool_]) -> bytes:
    """The bytes of :func:`patched`."""
    return patched(clip, motion, changed).data


def patched(
    clip: Clip, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
) -> Patch:
    """The clip's bytes with the rotation numbers at `changed` (frames, joints) taken from `motion`.

    positions: also its position numbers where they differ. Every other byte stays. A number keeps
    its count of decimals, at least 6, and never gets an exponent. Joints without three rotation
    channels cannot be rewritten: ValueError.
    """
    columns = clip.values.shape[1]
    tokens, numbers, jumps = [], [], []
    for joint in np.flatnonzero(changed.any(axis=0)):
        layout, name = clip.channels[joint], clip.skeleton.names[joint]
        if not layout.rotatable:
            raise ValueError(f"joint {name!r} has no three rotation channels to write to")
        rotation = list(layout.rotation)
        source = np.radians(clip.values[:, rotation])
        rotations = np.ascontiguousarray(motion.rotations[:, joint])
        for start, stop in _runs(changed[:, joint]).tolist():
            before = source[start - 1] if start > 0 else None
            after = source[stop] if stop < len(source) else None
            q, own = rotations[start:stop], source[start:stop]
            found = continuous_angles(layout.order, q, own, before, after)
            for row, channel in angle_jumps(found, before, after):
                letter = layout.order[channel]
                jumps.append(EulerJump(name, start + row, f"{letter}rotation"))
            tokens.append((np.arange(start, stop)[:, None] * columns + rotation).ravel())
            numbers.append(np.degrees(found).ravel())
    if positions:
        for place, positioned in enumerate(motion.positioned):
            for axis, column in clip.channels[positioned].position:
                here, there = (m.positions[:, place, axis] for m in (motion, clip.motion))
                at = np.flatnonzero(here != there)
                tokens.append(at * columns + column)
                numbers.append(here[at])
    if not sum(map(len, tokens)):
        return Patch(clip.data, ())
    return Patch(_replaced(clip, np.concatenate(tokens), np.concatenate(numbers)), tuple(jumps))


def _replaced(clip: Clip, tokens: NDArray[np.int64], numbers: Array) -> bytes:
    """The clip's bytes with the tokens of these numbers (from 0, in reading order) written anew."""
    order = np.argsort(tokens, kind="stable")
    tokens, numbers = tokens[order], numbers[order]
    starts, ends = (span[tokens] for span in clip.token_spans)
    decimals = _decimals(clip.data, starts, ends)
    # Neighbours with one space between are written together: far fewer pieces to join.
    together = np.zeros(len(tokens), dtype=np.bool_)
    buffer = np.frombuffer(clip.data, dtype=np.uint8)
    together[:-1] = (starts[1:] - ends[:-1] == 1) & (buffer[ends[:-1]] == 32)
    form = 2 * np.clip(decimals, _MIN_DECIMALS, _MAX_DECIMALS) + together
    # One format for all: a call for each number would take longer than the rest together.
    forms = [f"%.{k // 2}f{' ' if k % 2 else chr(10)}" for k in range(2 * _MAX_DECIMALS + 2)]
    text = "".join([forms[k] for k in form.tolist()]) % tuple(numbers.tolist())
    first = np.roll(~together, 1)
    stops = [0, *ends[~together].tolist()]
    nexts = [*starts[first].tolist(), len(clip.data)]
    pieces = [b""] * (2 * len(stops) - 1)
    pieces[0::2] = [clip.data[a:b] for a, b in zip(stops, nexts, strict=True)]
    pieces[1::2] = text.encode().split(b"\n")[:-1]
    return b"".join(pieces)


def _decimals(data: bytes, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """Digits behind the point of the tokens at these offsets, an exponent left out."""
    buffer = np.frombuffer(data, dtype=np.uint8)
    decimals = np.zeros(len(starts), dtype=np.int64)
    longest = int((ends - starts).max())
    for back in range(min(longest, 40)):
        at = np.maximum(ends - 1 - back, starts)
        byte = buffer[at]
        decimals[(byte == 46) & (at == ends - 1 - back)] = back
        # An exponent is behind the mantissa: its letters do not count, and it is not kept.
        behind = ((byte | 32) == 101) & (at == ends - 1 - back)
        for k in np.flatnonzero(behind).tolist():
            mantissa = data[starts[k] : at[k]]
            ends = ends.copy()
            ends[k] = starts[k]
            decimals[k] = len(mantissa.partition(b".")[2])
    return decimals


def _runs(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Half-open [start, stop) of the True runs, shape (n, 2)."""
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return edges.reshape(-1, 2)
