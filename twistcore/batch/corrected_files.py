"""Corrected clips in a batch folder: each is the old one or the new, and no other file is lost."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from twistcore.batch.clip_task import signature_of
from twistcore.batch.manifest import ManifestRow
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically, write_companions
from twistcore.files.marks import sha256_of

FOLDER = "corrected"


def write_corrected(
    folder: Path,
    row: ManifestRow,
    known: ManifestRow | None,
    data: bytes,
    companions: Mapping[str, bytes],
) -> ManifestRow:
    """Write a corrected clip below the folder; the row with what is known of it.

    known: the clip as the manifest has it; companions: what has to lie beside it. A file that is
    there is replaced if it is the one that was noted, and taken as written if it holds these bytes,
    as one written just before a process was killed does. TwistError for any other; OSError.
    """
    relative = f"{FOLDER}/{row.name}"
    path, mark = folder / relative, hashlib.sha256(data).hexdigest()
    path.parent.mkdir(parents=True, exist_ok=True)
    there = sha256_of(path) if path.is_file() else "" if not path.exists() else "other"
    if there != mark:
        if path.is_symlink() or (there and (known is None or there != known.corrected_sha256)):
            raise TwistError(f"{path}: expected no file that twistcore batch has not written")
        write_companions(companions, path.parent)
        write_atomically(path, data)
    return replace(
        row,
        corrected=relative,
        corrected_sha256=mark,
        corrected_signature=signature_of(path)[0],
    )


def is_intact(folder: Path, row: ManifestRow) -> bool:
    """Whether a clip's corrected file is there as it was written.

    By its size, time and number or, where it has been copied since, by its bytes.
    """
    path = folder / row.corrected
    try:
        if signature_of(path)[0] == row.corrected_signature:
            return True
        known = bool(row.corrected) and path.is_file()
        return known and sha256_of(path) == row.corrected_sha256
    except OSError:
        return False


def remove_parts(folder: Path) -> None:
    """Remove what a killed process left half written."""
    for part in (folder / FOLDER).rglob(".*.part"):
        part.unlink(missing_ok=True)
