"""The journal: every command on disk before the next one, so that no decision is ever lost.

A journal is a text file, one JSON document a line. The first line holds the session as it was when
the journal began, and how many steps of the review went into it unsaved; each further line one
command, an undo, a redo, or the whole session again (an undo of something older than the journal).
A line cut short by a crash is left out; what stands before it counts. A journal never takes the
place of a file that is there, and what stands in it is never shortened.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from twistcore.detection import Interval
from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import free_name, sync_folder, write_atomically
from twistcore.files.document_values import (
    bytes_of,
    flag,
    has,
    one_of,
    parsed_json,
    read_each,
    text,
    texts,
    whole,
)
from twistcore.files.encoding import json_bytes
from twistcore.files.lock import is_held, lock
from twistcore.files.ordinary import read_file
from twistcore.formats.clip import Clip
from twistcore.review.commands import (
    CarryOver,
    ChangeChains,
    Command,
    Edit,
    Insert,
    Redetect,
    Track,
)
from twistcore.review.history import Review
from twistcore.review.left_out import LeaveOut, spans_from_json
from twistcore.review.model import Decision, ReviewState
from twistcore.review.session import (
    Session,
    interval_from_json,
    interval_to_json,
    judged_from_json,
    judged_to_json,
    session_document,
    session_from_document,
    tau_from_json,
    tau_to_json,
    tracking_from_json,
    tracking_to_json,
    tracks_otherwise,
)
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import Rig, rig_from_json, rig_to_json
from twistcore.work.frozen import dataclass

SCHEMA = "twistcore.journal/1"
_DAMAGE = FormatError, KeyError, ValueError  # the last two where a command does not fit
_MOST_BYTES = 1 << 32  # of a journal: what is in it is nowhere else
UNDO, REDO = {"undo": True}, {"redo": True}


class Journal:
    """An open journal. What the disk does not take waits, and goes before the next entry."""

    def __init__(self, path: Path, clip: Clip, state: ReviewState, steps: int = 0) -> None:
        """Begin a journal with `state`, which `steps` unsaved steps led to.

        Raises FileExistsError where there is such a file, OSError where the disk says no; then
        nothing of it is left.
        """
        self.path = path
        self._file: BinaryIO = path.open("xb", buffering=0)
        lock(self._file.fileno())  # by which others see that it is no leftover
        self._good = 0  # bytes that are whole lines on disk
        self._waiting: list[bytes] = []
        try:
            self.append(
                {"schema": SCHEMA, "steps": steps, "session": session_document(clip, state)}
            )
            sync_folder(path.parent)
        except OSError:
            self.discard()
            raise

    @classmethod
    def resume(cls, recovered: Recovered) -> Journal:
        """Go on with a journal that an earlier run left; raises OSError and shortens nothing good.

        Lines that could not be replayed are first put beside it, under a name of their own.
        """
        path = recovered.path
        data = read_file(path)
        if recovered.damaged:
            write_atomically(free_name(path, ".damaged"), data)
        try:  # a file of our own: another window may still have the old one open
            write_atomically(path, data[: recovered.size])
        except OSError:
            if is_held(path):
                raise
        file = path.open("r+b", buffering=0)
        lock(file.fileno())
        file.truncate(recovered.size)  # what a crash cut short, or what was put beside
        journal = cls.__new__(cls)
        journal.path, journal._file = path, file
        journal._good, journal._waiting = recovered.size, []
        return journal

    @property
    def waiting(self) -> int:
        """Entries that are not on disk yet."""
        return len(self._waiting)

    def do(self, command: Command) -> None:
        """Record a command that has succeeded."""
        self.append(command_to_json(command))

    def append(self, entry: Mapping[str, Any]) -> None:
        """Record an entry; raises OSError if the disk says no, and the entry waits."""
        self._waiting.append(json_bytes(entry, indent=None))
        self.write_waiting()

    def write_waiting(self) -> None:
        """Put what waits on disk; raises OSError if that fails again."""
        if self._file.closed:
            raise OSError("the journal is closed")
        if not self._waiting:
            return
        data = b"".join(self._waiting)
        try:
            self._file.seek(self._good)
            left = memoryview(data)
            while left:  # a disk that is nearly full takes a part
                left = left[self._file.write(left) :]
            os.fsync(self._file.fileno())
        except OSError:
            with suppress(OSError):
                self._file.truncate(self._good)  # a line cut short; those before it stay
            raise
        self._good += len(data)
        self._waiting.clear()

    def is_there(self) -> bool:
        """Whether the file is still where it was begun: nobody has deleted or replaced it."""
        try:
            return os.path.samestat(self.path.stat(), os.fstat(self._file.fileno()))
        except (OSError, ValueError):  # a ValueError where it is closed
            return False

    def close(self) -> None:
        """Close the file and keep it."""
        with suppress(OSError):  # a full disk: what could be written is there
            self._file.close()

    def discard(self) -> None:
        """Close and delete: everything in it is in a session file, or given up knowingly.

        One that cannot be deleted stays: it is offered once more, and holds nothing new.
        """
        mine = self.is_there()
        self.close()
        if mine:
            with suppress(OSError):
                self.path.unlink()


@dataclass(frozen=True, eq=False)
class Recovered:
    """What a journal holds: the session it began with, the review as it was, commands replayed.

    steps: of the review that were never saved, those before the journal among them; size: bytes of
    the lines that could be replayed; damaged: lines that could not, 0 for a journal that ends in a
    whole line or in one cut short.
    """

    path: Path
    session: Session
    review: Review
    entries: int
    steps: int
    size: int
    damaged: int


def recover(path: Path, clip: Clip | None = None) -> Recovered:
    """Replay a journal; raises TwistError where nothing of it can be used.

    clip: if it is the journal's own, entries about frames that it has not are damaged ones.
    """
    lines = bytes_of(path, _MOST_BYTES).split(b"\n")
    try:
        if len(lines) < 2:
            raise FormatError("expected a complete line")
        head = has(parsed_json(lines[0]), "schema", "session")
        if head["schema"] != SCHEMA:
            raise FormatError(f"expected a document with schema {SCHEMA!r}")
        session = session_from_document(head["session"])
        steps = whole(head.get("steps", 0), "steps")
        own = clip is not None and clip.sha256 == session.sha256
        motion = clip.motion if clip is not None and own else None
        found = (judged.interval for judged in session.state.intervals)
        _check((), found, None, None if motion is None else motion.frames)
    except _DAMAGE:
        raise FormatError(f"{path}: expected a journal; its first line is damaged") from None
    review = Review(session.state)
    review.mark_unsaved()
    entries, size = 0, len(lines[0]) + 1
    # Behind the last newline stands nothing, or a line that a crash cut short.
    finished = lines[1:-1]
    for line in finished:
        try:
            review = _replayed(review, parsed_json(line), motion)
        except _DAMAGE:
            break  # later commands may refer to what this one did
        entries += 1
        size += len(line) + 1
    return Recovered(path, session, review, entries, steps + entries, size, len(finished) - entries)


def _replayed(review: Review, entry: Any, motion: Motion | None) -> Review:
    frames = None if motion is None else motion.frames
    if "session" in has(entry, what="an entry"):
        state = session_from_document(entry["session"]).state
        if state.rig != review.state.rig:  # an undo leads back to other chains
            _check_chains(state.rig, state.tau, motion)
            review = Review(state)
        _check(tuple(state.tau), (j.interval for j in state.intervals), review.state, frames)
        review = Review(state)
        review.mark_unsaved()
    elif "undo" in entry:
        review.undo()
    elif "redo" in entry:
        review.redo()
    else:
        command = command_from_json(entry)
        match command:
            case Edit() | Insert():
                _check((), (command.interval,), review.state, frames)
            case Redetect():
                _check(tuple(command.tau), command.found, review.state, frames)
            case ChangeChains():
                _check_chains(command.rig, command.tau, motion)
                _check((), command.found, None, frames)
            case LeaveOut() if frames is not None and any(b > frames for _, b in command.spans):
                raise FormatError("frames after the last one")
            case CarryOver():
                _check((), (j.interval for j in command.earlier), None, frames)
        review.do(command)
    return review


def _check(
    chains: Iterable[str],
    intervals: Iterable[Interval],
    state: ReviewState | None,
    frames: int | None,
) -> None:
    """FormatError where there is no such chain in the review, or no such frame in the clip."""
    intervals = tuple(intervals)
    named = {*chains, *(interval.chain for interval in intervals)}
    if state is not None and not named <= state.tau.keys():
        raise FormatError("a chain that is not in the review")
    if frames is not None and any(interval.stop > frames for interval in intervals):
        raise FormatError("an interval after the last frame")


def _check_chains(rig: Rig, tau: Mapping[str, float], motion: Motion | None) -> None:
    """FormatError where τ is not that of the rig's chains, with some limbs or none."""
    if motion is None:
        return
    try:
        every = rig.chains(motion)
    except TwistError as error:
        raise FormatError(str(error)) from None
    chains = {c.name for c in every if not isinstance(c, Limb)}
    if not chains <= tau.keys() <= {c.name for c in every}:
        raise FormatError("τ of chains that are not in the rig")


def state_entry(clip: Clip, state: ReviewState) -> dict[str, Any]:
    """An entry with the whole session."""
    return {"session": session_document(clip, state)}


# A step of tracking both ways or of the place: a program that knows neither is to stop here.
_BOTH_WAYS = "TrackBothWays"
_KINDS: Mapping[str, Callable[..., Command]] = {
    **{kind.__name__: kind for kind in Command.__subclasses__()},
    _BOTH_WAYS: Track,
}
_TEXTS = "reviewer", "decided_at", "note", "reason", "method", "what"


def _as_is(value: Any) -> Any:
    return value


# How fields of commands are written and read, and their names if others.
_FORMS: Mapping[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    **{name: (_as_is, partial(text, what=name)) for name in _TEXTS},
    **{name: (_as_is, partial(flag, what=name)) for name in ("same_clip", "in_bulk")},
    **{name: (_as_is, partial(whole, what=name)) for name in ("id", "drag")},
    "ids": (list, partial(read_each, what="ids", read=partial(whole, what="an id"))),
    "again": (list, partial(texts, what="again")),
    "rig": (rig_to_json, rig_from_json),
    "decision": (str, lambda d: Decision(one_of(d, "decision", [d.value for d in Decision]))),
    "spans": (lambda spans: [list(span) for span in spans], spans_from_json),
    "interval": (interval_to_json, interval_from_json),
    "tau": (tau_to_json, tau_from_json),
    "found": (
        lambda found: [interval_to_json(i) for i in found],
        partial(read_each, what="found", read=interval_from_json),
    ),
    "earlier": (
        lambda earlier: [judged_to_json(j) for j in earlier],
        partial(read_each, what="earlier", read=judged_from_json),
    ),
    "tracking": (
        lambda t: t and tracking_to_json(t),
        lambda t: None if t is None else tracking_from_json(t),
    ),
}
_NAMES = {"tau": "tau_deg"}


def command_to_json(command: Command) -> dict[str, Any]:
    """A command as data: its verb, as a rule its class name, then its fields in their order."""
    fields = {_NAMES.get(k, k): _FORMS[k][0](v) for k, v in vars(command).items()}
    other = isinstance(command, Track) and tracks_otherwise(command.tracking)
    return {"do": _BOTH_WAYS if other else type(command).__name__, **fields}


def command_from_json(entry: Any) -> Command:
    """The reverse; FormatError where it is damaged."""
    kind: Any = _KINDS[one_of(has(entry, "do")["do"], "do", _KINDS)]
    # Which the first journals did not have.
    entry = {"same_clip": False, "in_bulk": False, **entry}
    names = {field.name: _NAMES.get(field.name, field.name) for field in fields(kind)}
    has(entry, *names.values())
    read = {name: _FORMS[name][1](entry[key]) for name, key in names.items()}
    command: Command = kind(**read)
    return command
