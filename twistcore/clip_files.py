"""The clips of a folder: which files are taken for motion."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from twistcore.errors import TwistError

SUFFIXES = (".bvh",)  # of motion that can be read; in a name they may be in capitals


def clips_in(folder: Path, *, below: bool = False) -> list[Path]:
    """The motion files of a folder, sorted; none where it is no folder or may not be read.

    below: those of the folders below it, too. A link that leads nowhere is one of them: whoever
    reads it says so. Folders and devices are none, whatever their names.
    """
    if not folder.is_dir():
        return []
    there = folder.rglob("*") if below else folder.glob("*")
    named = (path for path in there if path.suffix.lower() in SUFFIXES)
    return sorted(path for path in named if _is_clip(path))


def clips_by_name(folder: Path) -> dict[str, Path]:
    """The motion files of a folder and those below it, by their path in it with '/' between.

    Raises TwistError where there is none.
    """
    found = clips_in(folder, below=True)
    if not found:
        raise TwistError(f"{folder}: expected a folder with BVH files")
    return {path.relative_to(folder).as_posix(): path for path in found}


def _is_clip(path: Path) -> bool:
    with suppress(OSError):  # a folder that tells names, and nothing of what bears them
        return path.is_file() or not path.exists()
    return True
