"""The names and folders of a clip's session, journals and lock.

If the clip's folder is read-only, these files are stored in a folder in the user's home, which is
called the refuge in the code.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TypeVar

import platformdirs

from inspector.language import tr, translate_core_sentence
from twistcore.errors import TwistError
from twistcore.export.exported_clips import REPLAY_SUFFIX, clip_name_from_session_file
from twistcore.files.atomic import first_unused_path, write_atomically
from twistcore.files.document_values import (
    check_keys,
    check_list,
    check_path_string,
    parsed_json,
    read_bytes_limited,
)
from twistcore.files.encoding import json_bytes
from twistcore.files.ordinary import (
    path_exists,
    read_file,
    real_path,
    user_folder_or_uncreatable_path,
)
from twistcore.formats.reading import companion_file_prefix, same_format

_Made = TypeVar("_Made")

SESSION_SUFFIX = ".twist.json"
# Filter of a file dialog; [!k] excludes locks, such as *.journal.lock
SESSION_PATTERNS = f"*{SESSION_SUFFIX} *{SESSION_SUFFIX}*[!k] *{REPLAY_SUFFIX}"
JOURNAL_SUFFIX = ".journal"
# Several crashes may leave several journals. An older version wrote the ending `.unanswered`.
_JOURNAL = re.compile(r"-[0-9]+|\.unanswered|")
_SESSION = re.compile(r".*(\.json|\.twist\.json\.earlier(-[0-9]+)?)", re.DOTALL)
_LONGEST_NAME = 180  # maximum length, in bytes, of the clip's name in the refuge
_GRAIN_NS = 2_000_000_000  # the coarsest time resolution of a file system
_POINTER_SUFFIX = ".elsewhere.json"


def session_path(clip: Path) -> Path:
    """Return the default path of a clip's session."""
    return clip.with_name(companion_file_prefix(clip) + SESSION_SUFFIX)


def replay_path(export: Path) -> Path:
    """Return the path of the session that is saved with an export to make it repeatable."""
    return export.with_name(companion_file_prefix(export) + REPLAY_SUFFIX)


def is_session(path: Path) -> bool:
    """Return True if this may be the name of a session, such as `walk.twist.json.earlier`."""
    return _SESSION.fullmatch(path.name) is not None


def fallback_session_path(clip: Path) -> Path:
    """Return the path, in the user's home, for the session of a clip in a read-only folder."""
    mark = hashlib.sha256(os.fsencode(real_path(clip))).hexdigest()[:12]
    name = companion_file_prefix(clip)
    if len(os.fsencode(name)) > _LONGEST_NAME:  # room for the endings of journal and lock
        name = name[:20]
    return _refuge() / f"{name}-{mark}{SESSION_SUFFIX}"


def _refuge() -> Path:
    return user_folder_or_uncreatable_path(
        partial(platformdirs.user_state_path, "twist-inspector", appauthor=False)
    )


def first_success(
    places: Iterable[Path], make: Callable[[Path], _Made]
) -> tuple[Path, _Made, OSError | None]:
    """Call `make` with one path after another until it succeeds.

    Returns the path, the result of `make` and the last OSError, or None if there was none. Raises
    the last OSError if `make` fails with every path.
    """
    trouble = None
    for place in places:
        try:
            if place.parent == _refuge():
                place.parent.mkdir(parents=True, exist_ok=True)
            return place, make(place), trouble
        except OSError as error:
            trouble = error
    assert trouble is not None
    raise trouble


def find_existing_sessions(clip: Path) -> list[Path]:
    """Return the existing sessions of a clip, the latest first.

    Sessions may be next to the clip, in the user's home, or where "Save as" last saved one.
    Sessions of a clip with the same name in another format are ignored. Earlier versions did not
    include the format in the session's name; such a session is used only if there is no other.
    """
    refuge = fallback_session_path(clip)
    places = [session_path(clip), refuge]
    with suppress(TwistError):
        document = parsed_json(read_bytes_limited(_pointer(refuge)))
        places.append(
            Path(check_path_string(check_keys(document, "session")["session"], "session"))
        )
    there = [
        p
        for p in dict.fromkeys(places)
        if path_exists(p) and same_format(clip_name_from_session_file(p) or clip, clip)
    ]
    old = clip.with_name(clip.stem + SESSION_SUFFIX)
    if not there and clip_name_from_session_file(old) == clip.name:
        there = [old]
    return sorted(there, key=modified_ns, reverse=True)


def remember_session_path(clip: Path, session: Path) -> None:
    """Store the path at which a clip's session was saved, unless it is one of the default paths."""
    refuge = fallback_session_path(clip)
    if session not in (session_path(clip), refuge):
        with suppress(OSError):
            refuge.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(_pointer(refuge), json_bytes({"session": str(session.absolute())}))


def _pointer(refuge: Path) -> Path:
    return refuge.with_name(refuge.name.removesuffix(SESSION_SUFFIX) + _POINTER_SUFFIX)


def journals(session: Path) -> list[Path]:
    """Return the journals next to a session path, even if the session itself does not exist."""
    start = session.name + JOURNAL_SUFFIX
    try:
        with os.scandir(session.parent) as entries:
            names = [e.name for e in entries if e.name.startswith(start)]
    except OSError:
        return []
    return [session.with_name(n) for n in names if _JOURNAL.fullmatch(n.removeprefix(start))]


def journal_owners(folder: Path) -> set[str]:
    """Return the names of the sessions that have a journal in a folder."""
    try:
        with os.scandir(folder) as entries:
            cut = (e.name.rpartition(JOURNAL_SUFFIX) for e in entries)
            return {name for name, mark, end in cut if mark and _JOURNAL.fullmatch(end)}
    except OSError:
        return set()


def modified_ns(path: Path) -> int:
    """Return a file's modification time in nanoseconds, or 0 if the file is missing."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def ensure_latest_modification_time(path: Path, others: Iterable[Path]) -> None:
    """Make sure that a newly written file has a later modification time than the other files.

    A change is needed only if the clock was set back or another computer wrote the other files.
    """
    newest = max((modified_ns(other) for other in others if other != path), default=0)
    if modified_ns(path) <= newest:
        with suppress(OSError):
            os.utime(path, ns=(newest + _GRAIN_NS, newest + _GRAIN_NS))


def rename_damaged(path: Path, why: str) -> str:
    """Rename a damaged file. Return a sentence about the damage and the new file name.

    `why` is a description of the damage.
    """
    aside = first_unused_path(path, ".damaged")
    try:
        path.replace(aside)
    except OSError as error:
        trouble = translate_core_sentence(str(error.strerror))
        return tr(
            "{why}. The file could not be renamed ({trouble}).",
            why=translate_core_sentence(why),
            trouble=trouble,
        )
    return tr(
        "{why}. The file was renamed to {name}.", why=translate_core_sentence(why), name=aside.name
    )


def write_session_with_backup(path: Path, data: bytes, known: dict[Path, str]) -> str:
    """Write a session and return a sentence about a copy of the previous file, or ''.

    The previous file is copied if it contains a review that this program has neither read nor
    written. `known` contains the SHA-256 of each session file when this program last read or wrote
    it, and is updated. If OSError is raised, the previous file is not changed.
    """
    message = ""
    if path_exists(path):
        there = read_file(path)
        if hashlib.sha256(there).hexdigest() != known.get(path):
            kept = first_unused_path(path, ".earlier")
            write_atomically(kept, there)
            message = tr(
                "{name} contained another review, which was kept as {kept}.",
                name=path.name,
                kept=kept.name,
            )
            message += " "
    write_atomically(path, data)
    known[path] = hashlib.sha256(data).hexdigest()
    return message


def decided_counts(clip: Path) -> tuple[int, int] | None:
    """Return the number of decided intervals and of all intervals in a clip's latest session.

    Returns None if there is no readable session.
    """
    with suppress(IndexError, TwistError):
        document = parsed_json(read_bytes_limited(find_existing_sessions(clip)[0]))
        intervals = check_list(check_keys(document, "intervals")["intervals"], "intervals")
        decisions = [check_keys(i, "decision")["decision"] for i in intervals]
        return sum(d != "undecided" for d in decisions), len(decisions)
    return None
