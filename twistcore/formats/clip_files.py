"""The clips of a folder: which files are taken for motion."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from twistcore.errors import TwistError
from twistcore.files.ordinary import is_file, is_there
from twistcore.formats.reading import is_other_data
from twistcore.formats.suffixes import CLIP_SUFFIXES

BVH = (".bvh",)  # for studies, whose figures are of BVH files


def clips_in(
    folder: Path, *, below: bool = False, suffixes: Sequence[str] = CLIP_SUFFIXES
) -> list[Path]:
    """The clips of a folder, sorted; none where it is no folder or may not be read.

    below: those of the folders below it, too; suffixes: of their names, which may have them in
    capitals. A link that leads nowhere is a clip: whoever reads it says so. Folders and devices are
    none, whatever their names, nor is an .npz of other data.
    """
    if not folder.is_dir():
        return []
    there = folder.rglob("*") if below else folder.glob("*")
    named = (path for path in there if path.suffix.lower() in suffixes)
    return sorted(path for path in named if _is_clip(path))


def no_files_in(folder: Path) -> dict[str, Path]:
    """What bears a clip's name in a folder, or below it, and is a FIFO, a socket or a device."""
    named = (path for path in folder.rglob("*") if path.suffix.lower() in CLIP_SUFFIXES)
    odd = (path for path in sorted(named) if is_there(path) and not _is_file_or_folder(path))
    return {path.relative_to(folder).as_posix(): path for path in odd}


def _is_file_or_folder(path: Path) -> bool:
    return is_file(path) or path.is_dir()


def clips_by_name(folder: Path, *, suffixes: Sequence[str] = CLIP_SUFFIXES) -> dict[str, Path]:
    """The clips of a folder and of those below it, by their path in it with '/' between.

    Raises TwistError where there is none.
    """
    found = clips_in(folder, below=True, suffixes=suffixes)
    if not found:
        raise TwistError(f"{folder}: expected a folder with {kinds_of_clips(suffixes)} files")
    return {path.relative_to(folder).as_posix(): path for path in found}


def kinds_of_clips(suffixes: Sequence[str] = CLIP_SUFFIXES) -> str:
    """'BVH', 'BVH or NPZ': for a sentence about what was expected."""
    return " or ".join(suffix[1:].upper() for suffix in suffixes)


def _is_clip(path: Path) -> bool:
    with suppress(OSError):  # a folder that tells names, and nothing of what bears them
        return (is_file(path) and not is_other_data(path)) or not is_there(path)
    return True
