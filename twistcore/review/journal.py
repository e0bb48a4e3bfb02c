"""Write every command of a review to a journal immediately, so a crash does not lose decisions.

A journal is a text file with one JSON document per line. The first line contains the session at the
time when the journal began, and the number of unsaved steps before it. Every other line contains
one of the following:

- a command
- an undo or a redo
- the whole session again, after an undo of a step from before the journal

If the last line is incomplete because of a crash, it is ignored and the lines before it are used. A
journal never replaces an existing file, and its valid lines are never removed.
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
from twistcore.detection.interval_json import (
    interval_from_json,
    interval_to_json,
    tau_from_json,
    tau_to_json,
)
from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import first_unused_path, sync_folder, write_atomically
from twistcore.files.document_values import (
    check_bool,
    check_choice,
    check_integer,
    check_keys,
    check_string,
    check_string_list,
    parsed_json,
    read_bytes_limited,
    read_each,
)
from twistcore.files.encoding import json_bytes
from twistcore.files.lock import is_file_locked, lock_file
from twistcore.files.ordinary import read_file
from twistcore.formats.clip import Clip
from twistcore.quamo.tracking_settings import tracking_from_json, tracking_to_json
from twistcore.review.commands import (
    CarryOver,
    ChangeChains,
    Command,
    Edit,
    Insert,
    Redetect,
    Settle,
    Track,
)
from twistcore.review.history import Review
from twistcore.review.left_out import LeaveOut, excluded_spans_from_json
from twistcore.review.model import Decision, ReviewState
from twistcore.review.session import (
    Session,
    judged_from_json,
    judged_to_json,
    session_document,
    session_from_document,
    tracks_place_or_both_ways,
)
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import Rig, rig_from_json, rig_to_json
from twistcore.work.frozen import dataclass

SCHEMA = "twistcore.journal/1"
_DAMAGE = FormatError, KeyError, ValueError  # the last two if a command does not fit the state
_MOST_BYTES = 1 << 32  # high, because a journal is the only copy of its contents
UNDO, REDO = {"undo": True}, {"redo": True}


class Journal:
    """An open journal file.

    An entry that could not be written is written together with the next entry.
    """

    def __init__(self, path: Path, clip: Clip, state: ReviewState, steps: int = 0) -> None:
        """Create a journal that begins with `state`.

        `steps` is the number of unsaved steps before the journal. Raises FileExistsError if the
        file exists, and OSError if it cannot be written. If writing fails, the incomplete file is
        deleted.
        """
        self.path = path
        self._file: BinaryIO = path.open("xb", buffering=0)
        lock_file(self._file.fileno())  # shows other programs that the journal is in use
        self._good = 0  # bytes of complete lines on disk
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
        """Continue writing a journal of an earlier run. Raises OSError if this fails.

        If some lines could not be replayed, the file is first copied to a new file next to it.
        """
        path = recovered.path
        data = read_file(path)
        if recovered.damaged:
            write_atomically(first_unused_path(path, ".damaged"), data)
        try:  # a new file, because another window may still have the old one open
            write_atomically(path, data[: recovered.size])
        except OSError:
            if is_file_locked(path):
                raise
        file = path.open("r+b", buffering=0)
        lock_file(file.fileno())
        file.truncate(recovered.size)  # drop an incomplete last line, or lines saved in the copy
        journal = cls.__new__(cls)
        journal.path, journal._file = path, file
        journal._good, journal._waiting = recovered.size, []
        return journal

    @property
    def waiting(self) -> int:
        """The number of entries that are not yet on disk."""
        return len(self._waiting)

    def do(self, command: Command) -> None:
        """Record a command that was run successfully."""
        self.append(review_command_to_json(command))

    def append(self, entry: Mapping[str, Any]) -> None:
        """Write an entry. If this fails, keep the entry for later and raise OSError."""
        self._waiting.append(json_bytes(entry, indent=None))
        self.write_waiting()

    def write_waiting(self) -> None:
        """Write the entries that are not yet on disk. Raises OSError if this fails again."""
        if self._file.closed:
            raise OSError("the journal is closed")
        if not self._waiting:
            return
        data = b"".join(self._waiting)
        try:
            self._file.seek(self._good)
            left = memoryview(data)
            while left:  # a nearly full disk may accept only a part
                left = left[self._file.write(left) :]
            os.fsync(self._file.fileno())
        except OSError:
            with suppress(OSError):
                self._file.truncate(self._good)  # drop the incomplete line
            raise
        self._good += len(data)
        self._waiting.clear()

    def is_there(self) -> bool:
        """Return True if the file still exists and has not been replaced."""
        try:
            return os.path.samestat(self.path.stat(), os.fstat(self._file.fileno()))
        except (OSError, ValueError):  # ValueError if the file is closed
            return False

    def close(self) -> None:
        """Close the file without deleting it."""
        with suppress(OSError):  # such as a full disk
            self._file.close()

    def discard(self) -> None:
        """Close and delete the journal, because its contents were saved or deliberately discarded.

        If the file cannot be deleted, the program offers to recover it at the next start.
        """
        mine = self.is_there()
        self.close()
        if mine:
            with suppress(OSError):
                self.path.unlink()


@dataclass(frozen=True, eq=False)
class Recovered:
    """The contents of a journal after replaying it.

    Parameters
    ----------
    path
        The journal.
    session
        The session at the beginning of the journal.
    review
        The review after all readable entries were replayed.
    entries
        Number of replayed entries.
    steps
        Number of unsaved steps of the review, including steps from before the journal.
    size
        Number of bytes of the replayed lines.
    damaged
        Number of complete lines that could not be replayed.
    """

    path: Path
    session: Session
    review: Review
    entries: int
    steps: int
    size: int
    damaged: int


def replay_journal(path: Path, clip: Clip | None = None) -> Recovered:
    """Replay a journal, and return the review and the session in it.

    `clip` is the clip on which the journal is replayed. If the journal was written for this clip,
    entries with frames that the clip does not have count as damaged. Raises TwistError if the
    journal cannot be read or its first line is damaged.
    """
    lines = read_bytes_limited(path, _MOST_BYTES).split(b"\n")
    try:
        if len(lines) < 2:
            raise FormatError("expected a complete line")
        head = check_keys(parsed_json(lines[0]), "schema", "session")
        if head["schema"] != SCHEMA:
            raise FormatError(f"expected a document with schema {SCHEMA!r}")
        session = session_from_document(head["session"])
        steps = check_integer(head.get("steps", 0), "steps")
        own = clip is not None and clip.sha256 == session.sha256
        motion = clip.motion if clip is not None and own else None
        found = (judged.interval for judged in session.state.intervals)
        _check((), found, None, None if motion is None else motion.frames)
    except _DAMAGE:
        raise FormatError(f"{path}: expected a journal, but the first line is damaged") from None
    review = Review(session.state)
    review.mark_unsaved()
    entries, size = 0, len(lines[0]) + 1
    # The part after the last newline is empty, or a line that a crash cut short.
    finished = lines[1:-1]
    for line in finished:
        try:
            review = _replayed(review, parsed_json(line), motion)
        except _DAMAGE:
            break  # later commands may depend on this one
        entries += 1
        size += len(line) + 1
    return Recovered(path, session, review, entries, steps + entries, size, len(finished) - entries)


def _replayed(review: Review, entry: Any, motion: Motion | None) -> Review:
    frames = None if motion is None else motion.frames
    if "session" in check_keys(entry, what="an entry"):
        state = session_from_document(entry["session"]).state
        if state.rig != review.state.rig:  # an undo restored other chains
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
                raise FormatError("expected excluded frames within the clip")
            case Settle():
                _check((), (j.interval for j in command.earlier), review.state, frames)
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
    """Raise FormatError unless all chains are in the review and all intervals are within the clip.

    If `state` is None, the chains are not checked. If `frames`, the clip's number of frames, is
    None, the frames are not checked.
    """
    intervals = tuple(intervals)
    named = {*chains, *(interval.chain for interval in intervals)}
    if state is not None and not named <= state.tau.keys():
        raise FormatError("expected only chains that the review contains")
    if frames is not None and any(interval.stop > frames for interval in intervals):
        raise FormatError("expected intervals within the clip")


def _check_chains(rig: Rig, tau: Mapping[str, float], motion: Motion | None) -> None:
    """Raise FormatError unless `tau` has a value for every chain of the rig and for nothing else.

    Values for limbs are optional. If `motion` is None, nothing is checked.
    """
    if motion is None:
        return
    try:
        every = rig.chains(motion)
    except TwistError as error:
        raise FormatError(str(error)) from None
    chains = {c.name for c in every if not isinstance(c, Limb)}
    if not chains <= tau.keys() <= {c.name for c in every}:
        raise FormatError("expected τ for exactly the chains of the rig")


def session_journal_entry(clip: Clip, state: ReviewState) -> dict[str, Any]:
    """Return a journal entry with the whole session."""
    return {"session": session_document(clip, state)}


_DECIDE = "Decide"
# Names that older programs do not know, so that they stop there instead of tracking differently.
_BOTH_WAYS = "TrackBothWays"  # tracks forward and backward, or tracks the position
_SPLINE = "Smooth"  # smooths with the spline
_MOVED = "ChangeFirstChain"  # moves errors of the whole body
_KINDS: Mapping[str, Callable[..., Command]] = {
    **{kind.__name__: kind for kind in Command.__subclasses__()},
    _BOTH_WAYS: Track,
    _SPLINE: Track,
    _MOVED: ChangeChains,
}
_TEXTS = "reviewer", "decided_at", "note", "reason", "method", "what"


def _as_is(value: Any) -> Any:
    return value


def _moved_from_json(entry: Any) -> dict[str, str]:
    return {
        name: check_string(chain, name) for name, chain in check_keys(entry, what="moved").items()
    }


# For each field of a command, the functions that convert it to and from JSON data.
_FORMS: Mapping[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    **{name: (_as_is, partial(check_string, what=name)) for name in _TEXTS},
    **{name: (_as_is, partial(check_bool, what=name)) for name in ("same_clip", "in_bulk")},
    **{name: (_as_is, partial(check_integer, what=name)) for name in ("id", "drag")},
    "ids": (list, partial(read_each, what="ids", read=partial(check_integer, what="an id"))),
    "again": (list, partial(check_string_list, what="again")),
    "rig": (rig_to_json, rig_from_json),
    "decision": (str, lambda d: Decision(check_choice(d, "decision", [d.value for d in Decision]))),
    "spans": (lambda spans: [list(span) for span in spans], excluded_spans_from_json),
    "interval": (interval_to_json, interval_from_json),
    "tau": (tau_to_json, tau_from_json),
    "moved": (dict, _moved_from_json),
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


def review_command_to_json(command: Command) -> dict[str, Any]:
    """Return a command as a dict of its fields, in which the key "do" names the command."""
    fields = {_NAMES.get(k, k): _FORMS[k][0](v) for k, v in vars(command).items()}
    verb = type(command).__name__
    if verb == _DECIDE and not fields["reason"]:
        del fields["reason"]
    if isinstance(command, ChangeChains):
        if command.moved:
            verb = _MOVED
        else:
            del fields["moved"]
    if isinstance(command, Track) and tracks_place_or_both_ways(command.tracking):
        verb = _SPLINE if command.tracking and command.tracking.spline else _BOTH_WAYS
    return {"do": verb, **fields}


def command_from_json(entry: Any) -> Command:
    """Convert a dict from :func:`review_command_to_json` to a command. Raises FormatError."""
    kind: Any = _KINDS[check_choice(check_keys(entry, "do")["do"], "do", _KINDS)]
    # The first journals did not have these fields.
    entry = {"same_clip": False, "in_bulk": False, "what": "", **entry}
    if entry["do"] == _DECIDE:
        entry.setdefault("reason", "")  # written only if there is one
    if entry["do"] == ChangeChains.__name__:
        entry["moved"] = {}
    names = {field.name: _NAMES.get(field.name, field.name) for field in fields(kind)}
    check_keys(entry, *names.values())
    read = {name: _FORMS[name][1](entry[key]) for name, key in names.items()}
    command: Command = kind(**read)
    return command
