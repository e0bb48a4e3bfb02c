"""From the bytes of a BVH to a Clip."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.bvh.clip import Clip, JointChannels, token_spans
from twistcore.bvh.header import parse_header
from twistcore.errors import BvhError
from twistcore.motion import Motion, Skeleton
from twistcore.rotation import Array, quaternion_from_euler

_MOTION = re.compile(rb"(?:^|(?<=[\r\n]))[ \t]*MOTION[ \t]*(?=[\r\n]|$)")
_TIMING = re.compile(
    rb"\s*Frames[ \t]*:?[ \t]*(\S*)[^\r\n]*\s+Frame[ \t]*Time[ \t]*:?[ \t]*(\S*)[^\r\n]*", re.I
)
_NUMBER_BYTES = b"0123456789+-.eE \t\r\n\v\f"
_ASSUMED_FPS = 30.0


def read_bvh(path: str | Path, *, fps: float | None = None) -> Clip:
    """Read a BVH file; `fps` overrides the rate in the file.

    Raises BvhError (file, line, column, what was expected) for anything that cannot be read
    without a guess that would move a joint; what was assumed harmlessly is in Clip.warnings.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise BvhError(str(path), "expected a BVH file, but there is no such file") from None
    except IsADirectoryError:
        raise BvhError(str(path), "expected a BVH file, but this is a folder") from None
    except OSError as error:
        raise BvhError(str(path), f"cannot be read ({error.strerror})") from None
    return parse_bvh(data, path, fps=fps)


def parse_bvh(data: bytes, path: str | Path = "clip.bvh", *, fps: float | None = None) -> Clip:
    """The same from bytes in memory."""
    path = Path(path)
    name = str(path)
    if not data.strip():
        raise BvhError(name, "expected HIERARCHY, but the file is empty", line=1, column=1)
    found = _MOTION.search(data)
    header = data[: found.start()] if found else data
    text = header.removeprefix(b"\xef\xbb\xbf").decode("utf-8", errors="surrogateescape")
    skeleton, channels = parse_header(name, text.replace("\x0b", " ").replace("\x0c", " "))
    if found is None:
        raise BvhError(name, "expected MOTION after the hierarchy", line=_line_of(data, len(data)))
    timing = _TIMING.match(data, found.end())
    if timing is None:
        raise BvhError(
            name,
            "expected 'Frames:' and 'Frame Time:' after MOTION",
            line=_line_of(data, found.end()) + 1,
        )
    warnings: list[str] = []
    declared = _declared_frames(name, data, timing)
    frame_time = _frame_time(timing.group(2), fps, warnings)
    columns = sum(len(c.rotation) + len(c.position) for c in channels)
    values = _read_values(name, data, timing.end(), columns, declared, warnings)
    return Clip(
        path=path,
        data=data,
        data_start=timing.end(),
        motion=_motion(skeleton, channels, values, frame_time),
        channels=channels,
        values=values,
        warnings=tuple(warnings),
    )


def timing_fields(data: bytes) -> tuple[tuple[int, int], tuple[int, int]]:
    """Byte spans of the numbers after 'Frames:' and 'Frame Time:' of a readable BVH."""
    found = _MOTION.search(data)
    timing = _TIMING.match(data, found.end()) if found else None
    assert timing is not None
    return timing.span(1), timing.span(2)


def _line_of(data: bytes, offset: int) -> int:
    """1-based line number of a byte offset; CR, LF and CRLF each end a line."""
    return len((data[:offset] + b"x").splitlines())


def _place(data: bytes, offset: int) -> tuple[int, int]:
    line_start = max(data.rfind(b"\n", 0, offset), data.rfind(b"\r", 0, offset)) + 1
    return _line_of(data, offset), offset - line_start + 1


def _declared_frames(name: str, data: bytes, timing: re.Match[bytes]) -> int:
    try:
        count = int(timing.group(1))
    except ValueError:
        count = -1
    if count < 0:
        line, column = _place(data, timing.start(1))
        raise BvhError(name, "expected a whole number after 'Frames:'", line=line, column=column)
    return count


def _frame_time(written: bytes, fps: float | None, warnings: list[str]) -> float:
    if fps is not None:
        return 1.0 / fps
    try:
        seconds = float(written)
    except ValueError:
        seconds = float("nan")
    if 1e-4 <= seconds <= 1.0:
        return seconds
    warnings.append(
        f"Frame Time {written.decode('ascii', 'replace')!r} is not usable; "
        f"{_ASSUMED_FPS:g} frames a second are assumed."
    )
    return 1.0 / _ASSUMED_FPS


def _read_values(
    name: str, data: bytes, start: int, columns: int, declared: int, warnings: list[str]
) -> Array:
    """The numbers, shape (frames, columns); whole rows only."""
    body = data[start:]
    if body.translate(None, _NUMBER_BYTES):
        bad = re.compile(rb"\S*[^0-9+\-.eE\s]\S*").search(data, start)
        assert bad is not None
        line, column = _place(data, bad.start())
        word = bad.group()[:40].decode("utf-8", "replace")
        raise BvhError(name, f"expected a number, found {word!r}", line=line, column=column)
    tokens = body.split()
    starts, _ = token_spans(data, start)
    rows = _whole_rows(name, data, starts, columns)
    try:
        values = np.array(tokens[: rows * columns], dtype=np.float64)
    except ValueError:
        values = np.array([_float_or_nan(token) for token in tokens[: rows * columns]])
    if not np.isfinite(values).all():
        k = int(np.flatnonzero(~np.isfinite(values))[0])
        line, column = _place(data, int(starts[k]))
        word = tokens[k][:40].decode()
        raise BvhError(name, f"expected a finite number, found {word!r}", line=line, column=column)
    if rows != declared:
        warnings.append(f"The header declares {declared} frames, {rows} whole rows were read.")
    if len(tokens) != rows * columns:
        warnings.append(
            f"The last row is incomplete ({len(tokens) - rows * columns} of {columns} numbers) "
            "and was left out."
        )
    return values.reshape(rows, columns)


def _float_or_nan(token: bytes) -> float:
    try:
        return float(token)
    except ValueError:
        return float("nan")


def _whole_rows(name: str, data: bytes, starts: NDArray[np.int64], columns: int) -> int:
    """Number of whole frames; a frame may be wrapped over lines, but no line may hold two parts."""
    if columns == 0:
        raise BvhError(name, "expected at least one channel in the hierarchy")
    if len(starts) < columns:
        raise BvhError(
            name,
            f"expected {columns} numbers a frame, found {len(starts)} in all: no whole frame",
            line=_line_of(data, len(data)),
        )
    buffer = np.frombuffer(data, dtype=np.uint8)
    breaks = np.flatnonzero((buffer == 10) | (buffer == 13))
    line_of_token = np.searchsorted(breaks, starts)
    # A frame's first number must be the first of its line, or a row before it was short or long.
    heads = np.arange(0, len(starts), columns)
    wrong = heads[1:][line_of_token[heads[1:]] == line_of_token[heads[1:] - 1]]
    if len(wrong):
        line, column = _place(data, int(starts[wrong[0]]))
        raise BvhError(
            name,
            f"expected {columns} numbers in every row; the rows up to this line do not add up",
            line=line,
            column=column,
        )
    return len(starts) // columns


def _motion(
    skeleton: Skeleton, channels: tuple[JointChannels, ...], values: Array, frame_time: float
) -> Motion:
    rotations = np.zeros((values.shape[0], len(skeleton), 4))
    rotations[..., 0] = 1.0
    by_order: dict[str, list[int]] = {}
    for joint, layout in enumerate(channels):
        if layout.order:
            by_order.setdefault(layout.order, []).append(joint)
    for order, joints in by_order.items():
        columns = np.array([channels[j].rotation for j in joints])
        rotations[:, joints] = quaternion_from_euler(order, np.radians(values[:, columns]))
    positioned = tuple(j for j, layout in enumerate(channels) if layout.position)
    positions = np.broadcast_to(
        skeleton.offsets[list(positioned)], (values.shape[0], len(positioned), 3)
    ).copy()
    for k, joint in enumerate(positioned):
        for axis, column in channels[joint].position:
            positions[:, k, axis] = values[:, column]
    return Motion(skeleton, rotations, positioned, positions, frame_time)
