"""Writing: the kept bytes with the numbers of corrected joints in corrected frames replaced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.atomic import write_atomically
from twistcore.bvh.branch import continuous_angles
from twistcore.bvh.clip import Clip
from twistcore.motion import Motion

_MIN_DECIMALS = 6
_MAX_DECIMALS = 15


def changed_rotations(clip: Clip, motion: Motion) -> NDArray[np.bool_]:
    """Which local rotations differ from the clip's, bit for bit, shape (frames, joints)."""
    changed: NDArray[np.bool_] = (motion.rotations != clip.motion.rotations).any(axis=-1)
    return changed


def write_bvh(clip: Clip, motion: Motion, path: str | Path) -> None:
    """Write `clip` with the rotations of `motion`, atomically; only what differs is rewritten."""
    write_atomically(Path(path), patch_rotations(clip, motion, changed_rotations(clip, motion)))


def patch_rotations(clip: Clip, motion: Motion, changed: NDArray[np.bool_]) -> bytes:
    """The clip's bytes with the rotation numbers at `changed` (frames, joints) taken from `motion`.

    Every other byte stays. A number keeps its count of decimals, at least 6, and never gets an
    exponent. Joints without three rotation channels cannot be rewritten: ValueError.
    """
    starts, ends = clip.token_spans
    columns = clip.values.shape[1]
    edits: list[tuple[int, int, bytes]] = []
    for joint in np.flatnonzero(changed.any(axis=0)):
        layout = clip.channels[joint]
        if not layout.rotatable:
            name = clip.skeleton.names[joint]
            raise ValueError(f"joint {name!r} has no three rotation channels to write to")
        rotation = list(layout.rotation)
        source = np.radians(clip.values[:, rotation])
        for start, stop in _runs(changed[:, joint]):
            angles = np.degrees(
                continuous_angles(
                    layout.order,
                    motion.rotations[start:stop, joint],
                    source[start:stop, 2],
                    source[start - 1] if start > 0 else None,
                    source[stop] if stop < len(source) else None,
                )
            )
            tokens = (np.arange(start, stop)[:, None] * columns + rotation).ravel()
            for token, value in zip(tokens, angles.ravel(), strict=True):
                s, e = int(starts[token]), int(ends[token])
                edits.append((s, e, _format(value, clip.data[s:e])))
    edits.sort()
    pieces = []
    done = 0
    for s, e, text in edits:
        pieces += [clip.data[done:s], text]
        done = e
    pieces.append(clip.data[done:])
    return b"".join(pieces)


def _runs(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Half-open [start, stop) of the True runs, shape (n, 2)."""
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return edges.reshape(-1, 2)


def _format(degrees: float, written: bytes) -> bytes:
    mantissa = written.lower().partition(b"e")[0]
    decimals = len(mantissa.partition(b".")[2])
    decimals = min(max(decimals, _MIN_DECIMALS), _MAX_DECIMALS)
    return f"{degrees:.{decimals}f}".encode()
