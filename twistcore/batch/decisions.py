"""Summarise the progress of a clip's review for the manifest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from twistcore.review import Decision, read_session
from twistcore.review.agreement import reviewers_of


def count_decisions(session: Path) -> dict[str, Any]:
    """Count the accepted, rejected and undecided intervals in a session file, and list reviewers.

    The result is the argument `decisions` of :meth:`Manifest.note_decisions`, or {} if no interval
    has a decision. Raises TwistError if the session cannot be read.
    """
    judged = read_session(session).state.intervals
    decided = [j for j in judged if j.decision != Decision.UNDECIDED]
    if not decided:
        return {}
    return {
        **{d.value: sum(j.decision == d for j in judged) for d in Decision},
        "reviewers": list(reviewers_of(decided)),
        "session": str(session),
        "at": max((j.decided_at for j in decided), default=""),
    }
