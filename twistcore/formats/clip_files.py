"""Find the clips in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from twistcore.errors import TwistError
from twistcore.files.ordinary import is_file, path_exists
from twistcore.formats.reading import is_clip_without_motion
from twistcore.formats.suffixes import CLIP_SUFFIXES

BVH = (".bvh",)  # the suffixes for studies, which use BVH files only


def clip_paths_in_folder(
    folder: Path, *, below: bool = False, suffixes: Sequence[str] = CLIP_SUFFIXES
) -> list[Path]:
    """Return the paths of the clips in a folder, sorted, or [] if the folder cannot be read.

    Broken links are included, so that reading them reports an error. Folders and devices with a
    clip's suffix are excluded, and so are .npz and .pkl files without motion.

    Parameters
    ----------
    folder
        The folder.
    below
        True to include subfolders.
    suffixes
        Suffixes of clips, in lower case. Case is ignored in file names.
    """
    if not folder.is_dir():
        return []
    there = folder.rglob("*") if below else folder.glob("*")
    named = (path for path in there if path.suffix.lower() in suffixes)
    return sorted(path for path in named if _is_clip(path))


def fifos_and_devices_in(folder: Path) -> dict[str, Path]:
    """Return FIFOs, sockets and devices with a clip's suffix, keyed by relative path.

    Subfolders are searched, too.
    """
    named = (path for path in folder.rglob("*") if path.suffix.lower() in CLIP_SUFFIXES)
    odd = (path for path in sorted(named) if path_exists(path) and not _is_file_or_folder(path))
    return {path.relative_to(folder).as_posix(): path for path in odd}


def _is_file_or_folder(path: Path) -> bool:
    return is_file(path) or path.is_dir()


def clips_by_name(folder: Path, *, suffixes: Sequence[str] = CLIP_SUFFIXES) -> dict[str, Path]:
    """Return the clips in a folder and its subfolders, keyed by relative path with '/'.

    Raises TwistError if there are none.
    """
    found = clip_paths_in_folder(folder, below=True, suffixes=suffixes)
    if not found:
        raise TwistError(
            f"{folder}: expected a folder with {format_names_from_suffixes(suffixes)} files"
        )
    return {path.relative_to(folder).as_posix(): path for path in found}


def format_names_from_suffixes(suffixes: Sequence[str] = CLIP_SUFFIXES) -> str:
    """Return the names of the formats with these suffixes, such as 'BVH or NPZ', for a message."""
    return " or ".join(suffix[1:].upper() for suffix in suffixes)


def _is_clip(path: Path) -> bool:
    with suppress(OSError):  # a folder may allow its files to be listed, but not to be examined
        return (is_file(path) and not is_clip_without_motion(path)) or not path_exists(path)
    return True
