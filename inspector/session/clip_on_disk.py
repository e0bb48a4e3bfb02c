"""Whether the clip's file is still the one that was read."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from twistcore.bvh import Clip


@dataclass(frozen=True)
class Stamp:
    """What changes with a file: seen at no cost, unlike its bytes."""

    modified: int  # nanoseconds
    size: int
    file: int  # its number in the file system


def stamp_of(path: Path) -> Stamp | None:
    """The file's stamp; None for one that is not there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)


def what_changed(clip: Clip, then: Stamp | None, now: Stamp | None) -> str:
    """A sentence if the file's bytes are no longer the clip's, else ''.

    then: the stamp with which it was read. The bytes are compared only where the stamps differ.
    """
    if now == then:
        return ""
    if now is None:
        return f"{clip.name} is no longer where it was; what is open stays as it is."
    try:
        same = hashlib.sha256(clip.path.read_bytes()).hexdigest() == clip.sha256
    except OSError as error:
        return f"{clip.name} can no longer be read ({error.strerror})."
    return "" if same else f"{clip.name} has changed on disk since it was opened."
