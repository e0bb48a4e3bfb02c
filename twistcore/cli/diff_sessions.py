"""Run `twistcore diff` on two sessions: print the reviewers' agreement and merge the sessions."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from twistcore.cli.decided_sessions import refuse_overwriting_decisions
from twistcore.cli.output import (
    count_with_noun,
    print_json,
    print_note,
    print_remark,
    print_result,
    refuse_overwrite,
    terminal_text,
)
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.files.marks import find_file_by_sha256
from twistcore.formats.reading import read_clip
from twistcore.review import Judged, Session, read_session, write_session
from twistcore.review.agreement import (
    Agreement,
    agreement_to_json,
    check_same_clip,
    decided_by_person,
    merged_review,
    pair_intervals,
    reviewers_of,
)
from twistcore.review.replay import session_chains


def diff_sessions(arguments: argparse.Namespace) -> int:
    """Print where two reviewers agree and differ, and merge their sessions on request."""
    a, b = read_session(arguments.a), read_session(arguments.b)
    try:
        check_same_clip(a.sha256, b.sha256)
        found = Agreement(pair_intervals(a.state.intervals, b.state.intervals))
        if arguments.merge:
            refuse_overwrite([arguments.merge], [arguments.a, arguments.b])
            refuse_overwriting_decisions(arguments.merge)
            _merge(arguments.a, a, b, found, arguments.merge)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{arguments.a}, {arguments.b}: {error}") from None
    if arguments.json:
        print_json(_sessions_to_json(arguments, a, b, found))
    else:
        _tell_sessions(arguments, (a, b), found)
    if arguments.merge:
        agreed = sum(p.decided_by_both and p.difference is None for p in found.pairs)
        left = (
            f"{count_with_noun(len(found.differences), 'interval')} left undecided; see their notes"
        )
        print_remark(f"{arguments.merge}: agreed decisions: {agreed}; {left}")
    return 0


def _merge(path: Path, a: Session, b: Session, found: Agreement, output: Path) -> None:
    """Write a session with the agreed decisions to `output`. `path` is the file of session `a`."""
    places = Path(a.clip), path.parent / Path(a.clip).name
    if (clip_path := find_file_by_sha256(places, a.sha256)) is None:
        raise TwistError(
            f"{path}: the clip of this session was not found; put it in the same folder as the "
            "session"
        )
    clip = read_clip(clip_path, fps=a.fps)
    for session in (a, b):
        session_chains(session, clip)  # raises an error if the session is damaged
    write_session(clip, merged_review(found, a.state), output)
    if a.state.tracking != b.state.tracking:
        print_note(
            f"{output}: note: the sessions differ in tracking; the tracking of {path} was kept"
        )


def _tell_sessions(
    arguments: argparse.Namespace, sessions: tuple[Session, Session], found: Agreement
) -> None:
    for name, path, session in zip("AB", (arguments.a, arguments.b), sessions, strict=True):
        intervals = session.state.intervals
        decided, who = sum(map(decided_by_person, intervals)), reviewers_of(intervals)
        by = f" by {', '.join(who)}" if who else ""
        print_result(f"{name} {path}: {decided} of {len(intervals)} intervals decided{by}")
    if found.differences:
        width = max(16, *(len(pair.either.interval.chain) for pair in found.differences))
        print_result(f"{'chain':<{width}} {'A':<32} {'B':<32} difference", head=True)
    for pair in found.differences:
        chain = terminal_text(pair.either.interval.chain)
        sides = f"{_side(pair.mine):<32} {_side(pair.theirs):<32}"
        print_result(f"{chain:<{width}} {sides} {pair.difference}")
    print_result(found.summary)


def _side(judged: Judged | None) -> str:
    if judged is None:
        return "–"
    interval = judged.interval
    return f"{judged.verdict} {interval.start} – {interval.stop} {interval.angle_text(1)}"


def _sessions_to_json(
    arguments: argparse.Namespace, a: Session, b: Session, found: Agreement
) -> dict[str, Any]:
    return {
        "schema": "twistcore.agreement/1",
        "a": str(arguments.a),
        "b": str(arguments.b),
        "sha256": a.sha256,
        "reviewers": {
            "a": list(reviewers_of(a.state.intervals)),
            "b": list(reviewers_of(b.state.intervals)),
        },
        **agreement_to_json(found),
        "merged": str(arguments.merge) if arguments.merge else None,
    }
