"""Review intervals: propose, edit and decide on them, store sessions, and apply the decisions.

The package contains the state of a review, its commands with undo and redo, the journal that
protects it from a crash, and the session file that stores it.
"""

from twistcore.quamo.tracking_settings import Tracking
from twistcore.review.commands import (
    Annotate,
    CarryOver,
    ChangeChains,
    Command,
    Edit,
    Insert,
    Redetect,
    Remove,
    Settle,
    Track,
)
from twistcore.review.decisions import Decide, Sign
from twistcore.review.history import Review
from twistcore.review.journal import Journal, Recovered, replay_journal
from twistcore.review.left_out import LeaveOut
from twistcore.review.model import Decision, Judged, ReviewState, start_review
from twistcore.review.session import (
    Session,
    read_session,
    session_bytes,
    write_session,
)

__all__ = [
    "Annotate",
    "CarryOver",
    "ChangeChains",
    "Command",
    "Decide",
    "Decision",
    "Edit",
    "Insert",
    "Journal",
    "Judged",
    "LeaveOut",
    "Recovered",
    "Redetect",
    "Remove",
    "Review",
    "ReviewState",
    "Session",
    "Settle",
    "Sign",
    "Track",
    "Tracking",
    "read_session",
    "replay_journal",
    "session_bytes",
    "start_review",
    "write_session",
]
