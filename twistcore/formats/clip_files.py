"""Find the clips in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from twistcore.errors import TwistError
from twistcore.files.ordinary import is_file, is_there
from twistcore.formats.reading import is_other_data
from twistcore.formats.suffixes import CLIP_SUFFIXES

BVH = (".bvh",)  # for studies, which use BVH files only


def clips_in(
    folder: Path, *, below: bool = False, suffixes: Sequence[str] = CLIP_SUFFIXES
) -> list[Path]:
    """Return the clips in a folder, sorted. The result is empty if the folder cannot be read.

    Set `below` to True to include subfolders. `suffixes` are the suffixes of clips, in upper or
    lower case. A broken link is included, so that an error is reported when it is read. Folders and
    devices with a clip's name are left out, and so is an .npz with other data.
    """
    if not folder.is_dir():
        return []
    there = folder.rglob("*") if below else folder.glob("*")
    named = (path for path in there if path.suffix.lower() in suffixes)
    return sorted(path for path in named if _is_clip(path))


def no_files_in(folder: Path) -> dict[str, Path]:
    """Return FIFOs, sockets and devices named like clips in a folder and its subfolders.

    The dict is keyed by relative path.
    """
    named = (path for path in folder.rglob("*") if path.suffix.lower() in CLIP_SUFFIXES)
    odd = (path for path in sorted(named) if is_there(path) and not _is_file_or_folder(path))
    return {path.relative_to(folder).as_posix(): path for path in odd}


def _is_file_or_folder(path: Path) -> bool:
    return is_file(path) or path.is_dir()


def clips_by_name(folder: Path, *, suffixes: Sequence[str] = CLIP_SUFFIXES) -> dict[str, Path]:
    """Return the clips in a folder and its subfolders, keyed by relative path with '/'.

    Raises TwistError if there are no clips.
    """
    found = clips_in(folder, below=True, suffixes=suffixes)
    if not found:
        raise TwistError(f"{folder}: expected a folder with {kinds_of_clips(suffixes)} files")
    return {path.relative_to(folder).as_posix(): path for path in found}


def kinds_of_clips(suffixes: Sequence[str] = CLIP_SUFFIXES) -> str:
    """Return the names of the formats with these suffixes, for messages, such as 'BVH or NPZ'."""
    return " or ".join(suffix[1:].upper() for suffix in suffixes)


def _is_clip(path: Path) -> bool:
    with suppress(OSError):  # the files of a folder can be listed but not examined
        return (is_file(path) and not is_other_data(path)) or not is_there(path)
    return True
