"""Compare two folders of clips, such as two deliveries of the same captures."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import Difference, compare_motions, joint_position_change_to_json
from twistcore.files.ordinary import read_file
from twistcore.formats.clip_files import clips_by_name, fifos_and_devices_in
from twistcore.formats.reading import read_clip
from twistcore.work.frozen import dataclass
from twistcore.work.processes import describe_failure, map_in_processes
from twistcore.work.progress import Counter, silent_clip_progress


@dataclass(frozen=True)
class FolderDifference:
    """The differences between two folders of clips.

    Clips are named by their relative paths and are sorted by name.

    Parameters
    ----------
    only_a, only_b
        Clips that exist in only one of the folders.
    identical
        Clips with equal bytes.
    same_motion
        Clips with different bytes but the same motion.
    different
        The differences between clips with different motions, keyed by name.
    failed
        The reason why a clip could not be compared, keyed by the clip's name.
    """

    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    identical: tuple[str, ...]
    same_motion: tuple[str, ...]
    different: dict[str, Difference]
    failed: dict[str, str]

    @property
    def in_both(self) -> int:
        """The number of clips that exist in both folders and could be compared."""
        return len(self.identical) + len(self.same_motion) + len(self.different)


def compare_folders(
    a: Path, b: Path, *, workers: int = 1, counter: Counter = silent_clip_progress
) -> FolderDifference:
    """Compare the clips in two folders and their subfolders.

    Parameters
    ----------
    a, b
        The folders.
    workers
        Number of processes.
    counter
        A function that shows the progress, as in :mod:`twistcore.work.progress`.

    Raises
    ------
    TwistError
        If a folder has no clips.
    """
    of_a, of_b = clips_by_name(a), clips_by_name(b)
    both = sorted(of_a.keys() & of_b.keys())
    found: dict[str, Difference | None] = {}
    odd = fifos_and_devices_in(b) | fifos_and_devices_in(
        a
    )  # opening a FIFO would wait for its writer
    failed = {
        name: f"{path}: expected a file, found a FIFO, a socket or a device"
        for name, path in odd.items()
    }
    both = [name for name in both if name not in odd]
    with counter(len(both)) as tell:
        for name, result in map_in_processes(partial(_compare_clip, a, b), both, workers):
            if isinstance(result, Exception):
                failed[name] = describe_failure(name, result)
            else:
                found[name] = result
            tell(name)
    different = {name: d for name in both if (d := found.get(name)) is not None}
    same = {name for name, difference in different.items() if _is_same(difference)}
    return FolderDifference(
        only_a=tuple(sorted(of_a.keys() - of_b.keys() - odd.keys())),
        only_b=tuple(sorted(of_b.keys() - of_a.keys() - odd.keys())),
        identical=tuple(name for name in both if name in found and found[name] is None),
        same_motion=tuple(name for name in both if name in same),
        different={name: d for name, d in different.items() if name not in same},
        failed={name: failed[name] for name in sorted(failed)},
    )


def _compare_clip(a: Path, b: Path, name: str) -> Difference | None:
    """Compare the clip `name` in folders `a` and `b`, or return None if the bytes are equal.

    Files with equal bytes need not be valid clips.
    """
    path_a, path_b = a / name, b / name
    if _read(path_a) == _read(path_b):
        return None
    clip_a, clip_b = read_clip(path_a), read_clip(path_b)
    try:
        return compare_motions(clip_a.motion, clip_b.motion)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{path_a}, {path_b}: {error}") from None


def _read(path: Path) -> bytes:
    try:
        return read_file(path)
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None


def _is_same(difference: Difference) -> bool:
    return not (difference.joints or difference.moved or difference.moved_channels)


def folder_difference_to_json(found: FolderDifference, a: str, b: str) -> dict[str, Any]:
    """Return the differences as a JSON document. `a` and `b` are the names of the two folders."""
    return {
        "schema": "twistcore.folder_diff/1",
        "a": a,
        "b": b,
        "only_a": list(found.only_a),
        "only_b": list(found.only_b),
        "identical": list(found.identical),
        "same_motion": list(found.same_motion),
        "different": [_clip_to_json(name, d) for name, d in found.different.items()],
        "failed": [{"clip": name, "reason": why} for name, why in found.failed.items()],
    }


def _clip_to_json(name: str, difference: Difference) -> dict[str, Any]:
    joints: dict[str, dict[str, Any]] = {}
    for j in difference.joints:
        known = joints.setdefault(j.joint, {"joint": j.joint, "frames": 0, "max_deg": 0.0})
        known["frames"] += j.stop - j.start
        known["max_deg"] = max(known["max_deg"], j.max_degrees)
    return {
        "clip": name,
        "frames": difference.frames,
        "max_deg": largest_rotation_difference(difference),
        "joints": list(joints.values()),
        "max_position_of_height": difference.max_position_of_height,
        "changed_position_channels": difference.moved_channels,
        "moved": [joint_position_change_to_json(move) for move in difference.moved],
    }


def largest_rotation_difference(difference: Difference) -> float:
    """Return the largest rotation difference of any joint, in degrees, or 0 if there is none."""
    return max((j.max_degrees for j in difference.joints), default=0.0)
