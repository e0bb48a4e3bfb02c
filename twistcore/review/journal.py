"""The journal: every command on disk before the next one, so that no decision is ever lost.

A journal is a text file, one JSON document a line. The first line holds the session as it was when
the journal began; each further line one command, an undo, a redo, or the whole session again (an
undo of something older than the journal). A line cut short by a crash is left out; what stands
before it counts.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from twistcore.bvh import Clip
from twistcore.errors import FormatError, TwistError
from twistcore.review.commands import (
    Annotate,
    CarryOver,
    Command,
    Decide,
    Edit,
    Insert,
    Redetect,
    Remove,
    Track,
)
from twistcore.review.model import Decision, ReviewState
from twistcore.review.review import Review
from twistcore.review.session import (
    Session,
    interval_from_json,
    interval_to_json,
    judged_from_json,
    judged_to_json,
    session_document,
    session_from_document,
    tracking_from_json,
    tracking_to_json,
)

SCHEMA = "twistcore.journal/1"
UNDO, REDO = {"undo": True}, {"redo": True}


class Journal:
    """An open journal; every entry is on disk when :meth:`append` returns."""

    def __init__(self, path: Path, clip: Clip, state: ReviewState) -> None:
        """Begin a journal anew at `path`; raises OSError."""
        self.path = path
        self.entries = 0
        self._file: BinaryIO | None = path.open("wb")
        try:
            self._write({"schema": SCHEMA, "session": session_document(clip, state)})
        except OSError:
            self._drop()
            raise

    def do(self, command: Command) -> None:
        """Record a command that has succeeded."""
        self.append(command_to_json(command))

    def append(self, entry: Mapping[str, Any]) -> None:
        """Record an entry; raises OSError if the disk says no."""
        self._write(entry)
        self.entries += 1

    def close(self) -> None:
        """Close the file and keep it."""
        if self._file is not None:
            file, self._file = self._file, None
            with suppress(OSError):  # a full disk: what could be written is there
                file.close()

    def _drop(self) -> None:
        self.close()
        self.path.unlink(missing_ok=True)

    def discard(self) -> None:
        """Close and delete: everything in it is in a session file, or given up knowingly."""
        self._drop()

    def _write(self, document: Mapping[str, Any]) -> None:
        if self._file is None:
            raise OSError("the journal is closed")
        self._file.write(json.dumps(document, ensure_ascii=False).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())


@dataclass(frozen=True, eq=False)
class Recovered:
    """What a journal holds: the session it began with, the review as it was, commands replayed.

    damaged: lines that could not be replayed, 0 for a journal that ends in a whole line or in one
    cut short.
    """

    session: Session
    review: Review
    entries: int
    damaged: int


def recover(path: Path) -> Recovered:
    """Replay a journal; raises TwistError where nothing of it can be used."""
    try:
        lines = path.read_bytes().split(b"\n")
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    try:
        head = json.loads(lines[0])
        if head.get("schema") != SCHEMA:
            raise FormatError(f"expected a document with schema {SCHEMA!r}")
        session = session_from_document(head["session"])
    except (ValueError, KeyError, AttributeError, FormatError):
        raise FormatError(f"{path}: expected a journal; its first line is damaged") from None
    review = Review(session.state)
    entries = 0
    # Behind the last newline stands nothing, or a line that a crash cut short.
    whole = [line for line in lines[1:-1] if line]
    for line in whole:
        try:
            review = _replayed(review, json.loads(line))
        except (ValueError, KeyError, TypeError, AttributeError, FormatError):
            break  # later commands may refer to what this one did
        entries += 1
    return Recovered(session, review, entries, len(whole) - entries)


def _replayed(review: Review, entry: Mapping[str, Any]) -> Review:
    if "session" in entry:
        return Review(session_from_document(entry["session"]).state)
    if "undo" in entry:
        review.undo()
    elif "redo" in entry:
        review.redo()
    else:
        review.do(command_from_json(entry))
    return review


def state_entry(clip: Clip, state: ReviewState) -> dict[str, Any]:
    """An entry with the whole session."""
    return {"session": session_document(clip, state)}


def command_to_json(command: Command) -> dict[str, Any]:
    """A command as data, by its class name."""
    kind = type(command).__name__
    match command:
        case Decide():
            return {
                "do": kind,
                "ids": list(command.ids),
                "decision": command.decision.value,
                "reviewer": command.reviewer,
                "decided_at": command.decided_at,
            }
        case Edit():
            interval = interval_to_json(command.interval)
            return {"do": kind, "id": command.id, "interval": interval, "drag": command.drag}
        case Annotate():
            return {"do": kind, "id": command.id, "note": command.note, "reason": command.reason}
        case Insert():
            return {"do": kind, "interval": interval_to_json(command.interval)}
        case Remove():
            return {"do": kind, "id": command.id}
        case Redetect():
            return {
                "do": kind,
                "tau_deg": {n: round(float(np.degrees(t)), 9) for n, t in command.tau.items()},
                "found": [interval_to_json(i) for i in command.found],
                "method": command.method,
                "drag": command.drag,
            }
        case CarryOver():
            return {"do": kind, "earlier": [judged_to_json(j) for j in command.earlier]}
        case Track():
            made = command.tracking and tracking_to_json(command.tracking)
            return {"do": kind, "tracking": made}
    raise TypeError(f"{kind} has no form in a journal")


_READERS: Mapping[str, Callable[[Mapping[str, Any]], Command]] = {
    "Decide": lambda e: Decide(
        tuple(e["ids"]), Decision(e["decision"]), e["reviewer"], e["decided_at"]
    ),
    "Edit": lambda e: Edit(e["id"], interval_from_json(e["interval"]), e["drag"]),
    "Annotate": lambda e: Annotate(e["id"], e["note"], e["reason"]),
    "Insert": lambda e: Insert(interval_from_json(e["interval"])),
    "Remove": lambda e: Remove(e["id"]),
    "Redetect": lambda e: Redetect(
        {n: float(np.radians(t)) for n, t in e["tau_deg"].items()},
        tuple(interval_from_json(i) for i in e["found"]),
        e["method"],
        e["drag"],
    ),
    "CarryOver": lambda e: CarryOver(tuple(judged_from_json(j) for j in e["earlier"])),
    "Track": lambda e: Track(e["tracking"] and tracking_from_json(e["tracking"])),
}


def command_from_json(entry: Mapping[str, Any]) -> Command:
    """The reverse; KeyError, TypeError or ValueError where it is damaged."""
    return _READERS[entry["do"]](entry)
