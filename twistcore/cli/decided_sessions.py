"""Protect sessions that contain a reviewer's decisions from being replaced."""

from __future__ import annotations

from pathlib import Path

from twistcore.errors import TwistError
from twistcore.files.atomic import is_stream
from twistcore.files.ordinary import path_exists
from twistcore.review import Decision, read_session
from twistcore.review.model import APPLIED, Judged


def refuse_overwriting_decisions(path: Path) -> None:
    """Raise TwistError if an existing file is a session with decisions, or not a session."""
    if is_stream(path) or not path_exists(path):
        return
    state = read_session(path).state
    by_person = state.left_out or state.tracking or any(map(_is_of_a_person, state.intervals))
    if by_person:
        raise TwistError(
            f"{path} is a session with a reviewer's decisions; write the new session to "
            "another file"
        )


def _is_of_a_person(judged: Judged) -> bool:
    """Return True if a person has decided on an interval, changed it or written a note."""
    made = judged.by_hand or judged.edited or bool(judged.note or judged.reason)
    return made or judged.verdict not in (APPLIED, Decision.UNDECIDED.value)
