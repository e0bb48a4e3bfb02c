"""Create a marker file during an export, so that an interrupted export can be recognised.

An export writes the clip before its session and report. If the program is killed in between, the
session of an earlier export remains next to the new clip.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from twistcore.errors import TwistError
from twistcore.files.atomic import open_temporary, temporary_file_path
from twistcore.files.document_values import parsed_json, read_bytes_limited
from twistcore.files.encoding import json_bytes
from twistcore.files.lock import is_file_locked
from twistcore.files.ordinary import is_file

_EXPORT = ".export"  # end of a marker file's name
_MOST = 10_000  # maximum size of a marker file in bytes


@contextmanager
def mark_export_in_progress(session: Path, clip: Path) -> Iterator[None]:
    """Create a marker file next to the session of an export, and remove it after the export.

    No error is raised if the marker file cannot be created, since the export itself reports the
    reason.
    """
    handle, mark = -1, None
    with suppress(OSError):
        handle, mark = open_temporary(temporary_file_path(session, _EXPORT))
        os.write(handle, json_bytes({"clip": clip.name, "session": session.name}))
    try:
        yield
    finally:
        if mark is not None:
            mark.unlink(missing_ok=True)
            os.close(handle)


def was_export_interrupted(session: Path) -> bool:
    """Return True if the last export with this session was killed.

    In this case, the session may be missing or older than the exported clip.
    """
    mark = temporary_file_path(session, _EXPORT)
    return is_file(mark) and not is_file_locked(mark)


def interrupted_export_sentence(session: Path) -> str:
    """Return a sentence if the last export of a session was killed, or ''."""
    if not was_export_interrupted(session):
        return ""
    return (
        f"{session}: the last export was interrupted, so the exported clip next to this session "
        "may be newer than the session; export it again"
    )


def interrupted_exports(clip: Path) -> list[str]:
    """Return the names of the sessions of a clip whose last exports were killed."""
    found = []
    with suppress(OSError):
        for mark in sorted(clip.parent.glob(f".*{_EXPORT}")):
            with suppress(OSError, TwistError, TypeError, KeyError):
                noted = parsed_json(read_bytes_limited(mark, _MOST))
                session = clip.with_name(Path(noted["session"]).name)
                if noted["clip"] == clip.name and temporary_file_path(session, _EXPORT) == mark:
                    found += [session.name] * was_export_interrupted(session)
    return found
