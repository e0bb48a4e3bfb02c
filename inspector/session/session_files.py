"""Where a clip's review is kept: names and places of its session, journals and lock.

Where the clip's folder cannot be written, they are in a folder of the person's own: the refuge.
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

from inspector.language import of_core, tr
from twistcore.errors import TwistError
from twistcore.export.exports_beside import REPLAY_SUFFIX, clip_of_session
from twistcore.files.atomic import free_name, write_atomically
from twistcore.files.document_values import bytes_of, has, items, parsed_json, path_text
from twistcore.files.encoding import json_bytes
from twistcore.files.ordinary import is_there, own_folder, read_file, real_path
from twistcore.formats.reading import own_name, same_format

_Made = TypeVar("_Made")

SESSION_SUFFIX = ".twist.json"
JOURNAL_SUFFIX = ".journal"
# A crash before an earlier journal was answered leaves another; the last is an older program's.
_JOURNAL = re.compile(r"-[0-9]+|\.unanswered|")
_SESSION = re.compile(r".*(\.json|\.twist\.json\.earlier(-[0-9]+)?)", re.DOTALL)
_LONGEST_NAME = 180  # bytes of a clip's name in those of its files in the refuge
_GRAIN_NS = 2_000_000_000  # the coarsest time that a file system keeps
_POINTER_SUFFIX = ".elsewhere.json"


def session_path(clip: Path) -> Path:
    """Where a clip's session lies unless the person says otherwise."""
    return clip.with_name(own_name(clip) + SESSION_SUFFIX)


def replay_path(export: Path) -> Path:
    """Where the session that replays an export lies."""
    return export.with_name(own_name(export) + REPLAY_SUFFIX)


def is_session(path: Path) -> bool:
    """Whether a file is to be opened as a session, by its name: `.twist.json.earlier` is, too."""
    return _SESSION.fullmatch(path.name) is not None


def refuge_path(clip: Path) -> Path:
    """Where the session lies if the clip's folder cannot be written."""
    mark = hashlib.sha256(os.fsencode(real_path(clip))).hexdigest()[:12]
    name = own_name(clip)
    if len(os.fsencode(name)) > _LONGEST_NAME:  # its journal's and lock's names have to fit, too
        name = name[:20]
    return _refuge() / f"{name}-{mark}{SESSION_SUFFIX}"


def _refuge() -> Path:
    return own_folder(partial(platformdirs.user_state_path, "twist-inspector", appauthor=False))


def at_first(
    places: Iterable[Path], make: Callable[[Path], _Made]
) -> tuple[Path, _Made, OSError | None]:
    """What `make` makes at the first place that takes it, where, and why not at the one before.

    Raises the last OSError where none does.
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


def kept_sessions(clip: Path) -> list[Path]:
    """The sessions that there are of a clip, the latest first.

    Beside it, in the refuge, and where a person last saved it under another name. One of a clip of
    another format is none of it; where there is no other, one without the format in its name is.
    """
    refuge = refuge_path(clip)
    places = [session_path(clip), refuge]
    with suppress(TwistError):
        document = parsed_json(bytes_of(_pointer(refuge)))
        places.append(Path(path_text(has(document, "session")["session"], "session")))
    there = [
        p
        for p in dict.fromkeys(places)
        if is_there(p) and same_format(clip_of_session(p) or clip, clip)
    ]
    old = clip.with_name(clip.stem + SESSION_SUFFIX)
    if not there and clip_of_session(old) == clip.name:
        there = [old]
    return sorted(there, key=written, reverse=True)


def remember_place(clip: Path, session: Path) -> None:
    """Keep in mind where a clip's session was saved, if not where it is looked for anyway."""
    refuge = refuge_path(clip)
    if session not in (session_path(clip), refuge):
        with suppress(OSError):
            refuge.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(_pointer(refuge), json_bytes({"session": str(session.absolute())}))


def _pointer(refuge: Path) -> Path:
    return refuge.with_name(refuge.name.removesuffix(SESSION_SUFFIX) + _POINTER_SUFFIX)


def journals(session: Path) -> list[Path]:
    """The journals beside a session, whether it has been saved or not."""
    start = session.name + JOURNAL_SUFFIX
    try:
        with os.scandir(session.parent) as entries:
            names = [e.name for e in entries if e.name.startswith(start)]
    except OSError:
        return []
    return [session.with_name(n) for n in names if _JOURNAL.fullmatch(n.removeprefix(start))]


def journal_owners(folder: Path) -> set[str]:
    """Names of the sessions in a folder beside which journals lie."""
    try:
        with os.scandir(folder) as entries:
            cut = (e.name.rpartition(JOURNAL_SUFFIX) for e in entries)
            return {name for name, mark, end in cut if mark and _JOURNAL.fullmatch(end)}
    except OSError:
        return set()


def written(path: Path) -> int:
    """When a file was last written, nanoseconds; 0 for one that has gone."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def make_latest(path: Path, others: Iterable[Path]) -> None:
    """Give a file that was just written a later time than others have.

    Which it has already, unless the clock was set back since, or theirs is another computer's.
    """
    newest = max((written(other) for other in others if other != path), default=0)
    if written(path) <= newest:
        with suppress(OSError):
            os.utime(path, ns=(newest + _GRAIN_NS, newest + _GRAIN_NS))


def set_aside(path: Path, why: str) -> str:
    """Rename a file that is of no use; returns the sentence that says so."""
    aside = free_name(path, ".damaged")
    try:
        path.replace(aside)
    except OSError as error:
        trouble = of_core(str(error.strerror))
        return tr("{why}. It cannot be set aside ({trouble}).", why=of_core(why), trouble=trouble)
    return tr("{why}. It was set aside as {name}.", why=of_core(why), name=aside.name)


def write_known(path: Path, data: bytes, known: dict[Path, str]) -> str:
    """Write a session; another review that lies there is kept beside it, and a sentence says so.

    known: SHA-256 of session files as this program read or wrote them, this one's from now on.
    Raises OSError and leaves what is there as it was.
    """
    told = ""
    if is_there(path):
        there = read_file(path)
        if hashlib.sha256(there).hexdigest() != known.get(path):
            kept = free_name(path, ".earlier")
            write_atomically(kept, there)
            told = tr(
                "{name} held another review; that one is now {kept}.",
                name=path.name,
                kept=kept.name,
            )
            told += " "
    write_atomically(path, data)
    known[path] = hashlib.sha256(data).hexdigest()
    return told


def decided_in(clip: Path) -> tuple[int, int] | None:
    """Intervals decided, of all, by the session kept of a clip; None without a readable one."""
    with suppress(IndexError, TwistError):
        document = parsed_json(bytes_of(kept_sessions(clip)[0]))
        intervals = items(has(document, "intervals")["intervals"], "intervals")
        decisions = [has(i, "decision")["decision"] for i in intervals]
        return sum(d != "undecided" for d in decisions), len(decisions)
    return None
