"""Write corrected clips atomically into a batch folder.

A file that this program did not write is never replaced.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from twistcore.batch.clip_task import file_change_signature
from twistcore.batch.manifest import ManifestRow
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically, write_missing_companion_files
from twistcore.files.marks import sha256_of
from twistcore.files.ordinary import check_no_links

FOLDER = "corrected"


def write_corrected(
    folder: Path,
    row: ManifestRow,
    known: ManifestRow | None,
    data: bytes,
    companions: Mapping[str, bytes],
) -> ManifestRow:
    """Write a corrected clip into the batch folder, and return its row with the new path and hash.

    An existing file is replaced only if its hash matches the one in the manifest. A file that
    already contains `data` is not written again. This happens if an earlier process was killed
    right after writing the file.

    Parameters
    ----------
    folder
        The batch folder.
    row
        The clip's new row.
    known
        The clip's row in the manifest, or None.
    data
        The bytes of the corrected clip.
    companions
        Other files that the corrected clip needs, keyed by name.

    Raises
    ------
    TwistError
        If there is a file that this program did not write.
    OSError
        If the file cannot be written.
    """
    relative = f"{FOLDER}/{row.name}"
    path, mark = folder / relative, hashlib.sha256(data).hexdigest()
    check_no_links(folder, path.parent)
    path.parent.mkdir(parents=True, exist_ok=True)
    there = sha256_of(path) if path.is_file() else "" if not path.exists() else "other"
    if there != mark:
        if path.is_symlink() or (there and (known is None or there != known.corrected_sha256)):
            raise TwistError(
                f"{path} was not written by `twistcore batch`; move the file to another folder"
            )
        write_missing_companion_files(companions, path.parent)
        write_atomically(path, data)
    return replace(
        row,
        corrected=relative,
        corrected_sha256=mark,
        corrected_signature=file_change_signature(path)[0],
    )


def is_corrected_file_unchanged(folder: Path, row: ManifestRow) -> bool:
    """Return True if a clip's corrected file is unchanged since it was written.

    If its size, modification time and inode are the same, the file counts as unchanged. If they
    differ, as after copying the folder, the file's hash is compared.
    """
    path = folder / row.corrected
    try:
        if file_change_signature(path)[0] == row.corrected_signature:
            return True
        known = bool(row.corrected) and path.is_file()
        return known and sha256_of(path) == row.corrected_sha256
    except OSError:
        return False
