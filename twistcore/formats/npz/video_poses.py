"""Read poses that ROMP or BEV estimated from a video [Sun et al. 2021].

In `video_results.npz`, `results` is a pickled dict of frames, which is read without running any
code (:mod:`pickled_arrays <twistcore.formats.npz.pickled_arrays>`). Each frame is a dict of arrays
with a row for each person: `smpl_thetas` (people, 72), `cam_trans` (people, 3) and, if people were
tracked, `track_ids`. In earlier versions, a frame is a list of dicts with `poses` (72,).
`sequence_results` repeats the rows, sorted by person.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import NpzError
from twistcore.formats.npz.archive import Archive, npy_header
from twistcore.formats.npz.pickled_arrays import LimitError, Places, read_pickle_with_offsets
from twistcore.formats.npz.stored_arrays import overwrite_array
from twistcore.skeleton.rotation import Array, exponential, logarithm, slerp
from twistcore.work.frozen import dataclass

RESULTS, SEQUENCES = "results", "sequence_results"
THETAS, PLACE = "smpl_thetas", "cam_trans"
_POSES, _PLACES = (THETAS, "poses", "pose"), (PLACE, "trans")
_NUMBERS = 72


@dataclass(frozen=True, eq=False)
class _Object:
    """An archive member that is a single pickled object.

    Attributes
    ----------
    raw
        The member's bytes.
    start
        Offset of the pickle in these bytes.
    found
        The pickle's contents.
    places
        Offsets of the arrays' bytes in the pickle.
    """

    raw: bytes = field(repr=False)
    start: int
    found: Any
    places: Places


@dataclass(frozen=True, eq=False)
class _Row:
    """One person in one frame.

    Attributes
    ----------
    frame
        Index of the frame.
    who
        The person's track number.
    pose, place
        The frame's arrays, with a row for each person or for one person only.
    row
        The person's row in these arrays.
    """

    frame: int
    who: int
    pose: NDArray[Any]
    place: NDArray[Any] | None
    row: int

    def array(self, name: str) -> NDArray[Any]:
        """Return the array THETAS or PLACE with all people of the frame."""
        found = self.pose if name == THETAS else self.place
        assert found is not None
        return found

    def numbers(self, name: str) -> NDArray[Any]:
        """Return this person's row of the array THETAS or PLACE."""
        array = self.array(name)
        return array[self.row] if array.ndim > 1 else array


@dataclass(frozen=True, eq=False)
class VideoPoses:
    """One person's poses, as the arrays THETAS, (frames, 72), and PLACE, (frames, 3).

    Attributes
    ----------
    archive
        The file.
    objects
        The pickled members of the file, keyed by name.
    rows
        One row for each frame in which the person was seen.
    notes
        Sentences about other people and about missing frames.
    """

    archive: Archive
    objects: Mapping[str, _Object] = field(repr=False)
    rows: tuple[_Row, ...] = field(repr=False)
    notes: tuple[str, ...]

    @property
    def path(self) -> Path:
        """Path of the file, for use in messages."""
        return self.archive.path

    def __contains__(self, name: object) -> bool:
        return name == THETAS or (name == PLACE and self.rows[0].place is not None)

    def described(self) -> str:
        """Return the names of the arrays in the archive, for a message."""
        return self.archive.described()

    @property
    def filled(self) -> NDArray[np.bool_]:
        """Mask of the frames in which the person was not seen. These frames are never written."""
        frames = np.array([row.frame for row in self.rows]) - self.rows[0].frame
        filled = np.ones(frames[-1] + 1, dtype=np.bool_)
        filled[frames] = False
        return filled

    def array(self, name: str) -> NDArray[Any]:
        """Return THETAS or PLACE from the first to the last frame in which the person was seen.

        In missing frames, rotations are interpolated by slerp and positions linearly.
        """
        rows = np.stack([row.numbers(name) for row in self.rows])
        if not (absent := self.filled).any():
            return rows
        frames = np.flatnonzero(~absent)
        times = np.interp(np.arange(len(absent)), frames, np.arange(len(frames)))
        filled = _turned(rows, times) if name == THETAS else _moved(rows, times)
        filled[frames] = rows
        return filled.astype(rows.dtype)

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> bytes:
        """Return the archive's bytes with new numbers for the person, except in missing frames.

        `sequence_results` is updated where it has the same numbers as before.
        """
        contents = {name: bytearray(one.raw) for name, one in self.objects.items()}
        for name, values in arrays.items():
            repeated = self._repeated(name)
            for row in self.rows:
                now = values[row.frame - self.rows[0].frame]
                if np.array_equal(row.numbers(name), now):
                    continue
                self._put(contents, RESULTS, row.array(name), row.row, now)
                if row.frame in repeated:
                    self._put(contents, SEQUENCES, repeated[row.frame], 0, now)
        changed = {n: bytes(c) for n, c in contents.items() if c != self.objects[n].raw}
        return self.archive.with_contents(changed) if changed else self.archive.data

    def _put(
        self,
        contents: dict[str, bytearray],
        member: str,
        there: NDArray[Any],
        row: int,
        now: NDArray[Any],
    ) -> None:
        one, fresh = self.objects[member], there.copy()
        if there.ndim > 1:
            fresh[row] = now
        else:
            fresh[:] = now
        overwrite_array(contents[member], self.path, one.places, there, fresh, one.start)

    def _repeated(self, name: str) -> dict[int, NDArray[Any]]:
        """Return arrays in 'sequence_results' that repeat the person's values, keyed by frame."""
        sequences = self.objects.get(SEQUENCES)
        every = sequences.found if sequences is not None else None
        own = every.get(self.rows[0].who) if isinstance(every, dict) else None
        if not isinstance(own, dict):
            return {}
        here = {row.frame: row.numbers(name) for row in self.rows}
        there = zip(_items(own.get("frame_id")), _items(own.get(name)), strict=False)
        return {
            frame: array
            for frame, array in there
            if isinstance(frame, int)
            and frame in here
            and isinstance(array, np.ndarray)
            and (array.dtype, array.shape) == (here[frame].dtype, here[frame].shape)
            and array.tobytes() == here[frame].tobytes()
        }


def read_video_poses(archive: Archive) -> VideoPoses | None:
    """Return the poses of the person who is seen in most frames, or None for other data.

    Raises NpzError if the poses cannot be used.
    """
    objects = {}
    for name in (RESULTS, SEQUENCES):
        if name in archive and (one := _object(archive, name)) is not None:
            objects[name] = one
    if RESULTS not in objects:
        return None
    frames = objects[RESULTS].found
    if isinstance(frames, list) or (isinstance(frames, dict) and _pose(frames) is not None):
        frames = {"": frames}  # these are the results for a single image
    if not isinstance(frames, dict):
        return None
    rows = [row for k, frame in enumerate(frames.values()) for row in _rows(k, frame)]
    if not rows:
        return None
    seen = Counter(row.who for row in rows)
    who, count = seen.most_common(1)[0]
    own = tuple(row for row in rows if row.who == who)
    if len({row.frame for row in own}) < count:
        raise NpzError(
            f"{archive.path}: expected one person per frame, or 'track_ids' to tell people apart "
            "(ROMP writes them with --temporal_optimize)"
        )
    placed = all(row.place is not None for row in own)
    own = own if placed else tuple(replace(row, place=None) for row in own)
    if len({(row.pose.dtype, None if row.place is None else row.place.dtype) for row in own}) > 1:
        return None
    return VideoPoses(archive, objects, own, tuple(_notes(own, seen)))


def _object(archive: Archive, name: str) -> _Object | None:
    """Return a member that is a single pickled object, or None for plain or damaged data.

    Raises NpzError if the member exceeds a limit.
    """
    raw = archive.raw(name)
    try:
        start, _, dtype, _ = npy_header(raw)
        if not dtype.hasobject:
            return None
        found, places = read_pickle_with_offsets(raw[start:])
    except LimitError as error:
        raise NpzError(f"{archive.path}: {error}") from None
    except Exception:  # a damaged header or pickle can raise almost anything
        return None
    return _Object(raw, start, found, places)


def _rows(frame: int, found: Any) -> Iterator[_Row]:
    """Yield a row for each person in a frame."""
    if isinstance(found, list):  # earlier versions have one dict per person
        for row, one in enumerate(found):
            if isinstance(one, dict) and (pose := _pose(one)) is not None and pose.ndim == 1:
                known = one.get("track_id")
                if not isinstance(known, int | np.integer):
                    known = row if len(found) > 1 else 0
                yield _Row(frame, int(known), pose, _numbers(one, _PLACES, 3), 0)
        return
    pose = _pose(found) if isinstance(found, dict) else None
    if pose is None:
        return
    place = _numbers(found, _PLACES, 3)
    count = 1 if pose.ndim == 1 else len(pose)
    if place is not None and (1 if place.ndim == 1 else len(place)) != count:
        place = None
    ids = found.get("track_ids")
    known = isinstance(ids, np.ndarray) and ids.dtype.kind in "iu" and ids.shape == (count,)
    for row in range(count):
        yield _Row(frame, int(ids[row]) if known else 0, pose, place, row)


def _pose(found: dict[Any, Any]) -> NDArray[Any] | None:
    return _numbers(found, _POSES, _NUMBERS)


def _numbers(found: dict[Any, Any], names: tuple[str, ...], width: int) -> NDArray[Any] | None:
    """Return the first array with one of these names and `width` columns, or None."""
    for name in names:
        array = found.get(name)
        if not (isinstance(array, np.ndarray) and array.dtype.kind == "f"):
            continue
        if array.ndim in (1, 2) and array.shape[-1] == width:
            return array
    return None


def _items(found: Any) -> list[Any]:
    return list(found) if isinstance(found, list | np.ndarray) else []


def _notes(own: Sequence[_Row], seen: Counter[int]) -> Iterator[str]:
    """Yield sentences about the person who was chosen and about missing frames."""
    if len(seen) > 1:
        others = ", ".join(f"{who} in {n} frames" for who, n in seen.most_common(6)[1:])
        yield (
            f"The file contains {len(seen)} people. The program reads {own[0].who} (in "
            f"{len(own)} frames), not {others}."
        )
    first, span = own[0].frame, own[-1].frame - own[0].frame + 1
    if span > len(own):
        frames = {row.frame for row in own}
        absent = next(k for k in range(first, first + span) if k not in frames) - first
        yield (
            f"This person is missing from {span - len(own)} of {span} frames; the first of "
            f"these is {absent}. The program interpolates these frames and does not write "
            "them."
        )
    if own[0].place is None:
        yield f"The root has no position ({PLACE!r}), so the figure stays in one place."


def _turned(rows: NDArray[Any], times: Array) -> Array:
    """Return rotation vectors, (times, numbers), interpolated between rows by slerp.

    `times` are indices of rows and may be fractions.
    """
    before = np.minimum(times.astype(np.intp), len(rows) - 1)
    after = np.minimum(before + 1, len(rows) - 1)
    q = exponential(np.asarray(rows, dtype=np.float64).reshape(len(rows), -1, 3))
    between = slerp(q[before], q[after], (times - before)[:, None])
    return logarithm(between).reshape(len(times), -1)


def _moved(rows: NDArray[Any], times: Array) -> Array:
    values, at = np.asarray(rows, dtype=np.float64), np.arange(len(rows))
    return np.stack([np.interp(times, at, column) for column in values.T], axis=1)
