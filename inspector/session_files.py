"""Where a clip's review is kept: names and places of its session, journals and lock.

Where the clip's folder cannot be written, they are in a folder of the person's own: the refuge.
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

import platformdirs

from twistcore.atomic import free_name

SESSION_SUFFIX = ".twist.json"
REPLAY_SUFFIX = ".replay.json"  # what an export did: never a review that goes on
JOURNAL_SUFFIX = ".journal"
# A crash before an earlier journal was answered leaves another; the last is an older program's.
_JOURNAL = re.compile(r"-[0-9]+|\.unanswered|")


def session_path(clip: Path) -> Path:
    """Where a clip's session lies unless the person says otherwise."""
    return clip.with_name(clip.stem + SESSION_SUFFIX)


def replay_path(export: Path) -> Path:
    """Where the session that replays an export lies."""
    return export.with_name(export.stem + REPLAY_SUFFIX)


def is_session(path: Path) -> bool:
    """Whether a file is to be opened as a session, by its name: `.twist.json.earlier` is, too."""
    return path.suffix == ".json" or SESSION_SUFFIX in path.name


def refuge_path(clip: Path) -> Path:
    """Where the session lies if the clip's folder cannot be written."""
    mark = hashlib.sha256(os.fsencode(clip.resolve())).hexdigest()[:12]
    folder = platformdirs.user_state_path("twist-inspector", appauthor=False)
    return folder / f"{clip.stem}-{mark}{SESSION_SUFFIX}"


def kept_session(clip: Path) -> Path | None:
    """The session that there is of a clip, the newer one if the refuge has one too."""
    there = [p for p in (refuge_path(clip), session_path(clip)) if p.exists()]
    return max(there, key=written, default=None)


def journals(session: Path) -> list[Path]:
    """The journals beside a session, whether it has been saved or not."""
    start = session.name + JOURNAL_SUFFIX
    try:
        with os.scandir(session.parent) as entries:
            names = [e.name for e in entries if e.name.startswith(start)]
    except OSError:
        return []
    return [session.with_name(n) for n in names if _JOURNAL.fullmatch(n.removeprefix(start))]


def written(path: Path) -> int:
    """When a file was last written, nanoseconds; 0 for one that has gone."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def set_aside(path: Path, why: str) -> str:
    """Rename a file that is of no use; returns the sentence that says so."""
    aside = free_name(path, ".damaged")
    try:
        path.replace(aside)
    except OSError as error:
        return f"{why}. It cannot be set aside ({error.strerror})."
    return f"{why}. It was set aside as {aside.name}."
