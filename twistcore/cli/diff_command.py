"""`twistcore diff`: compare two clips, two folders of clips, or two reviews of a clip."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from twistcore.cli.clip_inputs import clip_name, open_clip, tell_clip
from twistcore.cli.decided_sessions import refuse_decided
from twistcore.cli.folder_commands import diff_folders
from twistcore.cli.output import (
    count_of,
    note,
    print_json,
    refuse_overwrite,
    remark,
    say,
    terminal_text,
)
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import compare, difference_to_json
from twistcore.export.replay import check_bytes
from twistcore.files.marks import found_file
from twistcore.formats.reading import read_clip
from twistcore.review import Judged, Session, read_session, write_session
from twistcore.review.agreement import (
    Agreement,
    agreement_to_json,
    check_same_clip,
    decided_by_person,
    merged_review,
    paired,
    reviewers_of,
)


def diff_command(arguments: argparse.Namespace) -> int:
    """Print the differences between two clips, two folders of clips, or two sessions."""
    sessions = [path for path in (arguments.a, arguments.b) if _is_session(path)]
    if len(sessions) == 1 or (arguments.merge and not sessions):
        only = f"expected two sessions, but only {sessions[0]} is one" if sessions else ""
        raise TwistError(only or "--merge needs two sessions")
    if sessions:
        return _diff_sessions(arguments)
    if arguments.a.is_dir() or arguments.b.is_dir():
        return diff_folders(arguments)
    return _diff_clips(arguments)


def _diff_clips(arguments: argparse.Namespace) -> int:
    names = clip_name(arguments.a), clip_name(arguments.b)
    if names == ("-", "-"):
        raise TwistError("- (standard input) can be given only once")
    a, b = open_clip(arguments.a), open_clip(arguments.b)
    for name, clip in zip(names, (a, b), strict=True):
        tell_clip(name, clip)
    try:
        difference = compare(a.motion, b.motion)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{', '.join(names)}: {error}") from None
    if arguments.json:
        print_json(difference_to_json(difference, *names))
        return 0
    width = max([24, *(len(terminal_text(j.joint)) for j in difference.joints)])
    if difference.joints:
        say(f"{'joint':<{width}} {'start':>7} – {'stop':<7} rotation differs", head=True)
    for j in difference.joints:
        name = f"{terminal_text(j.joint):<{width}}"
        say(f"{name} {j.start:>7} – {j.stop:<7} up to {j.max_degrees:8.3f}°")
    for m in difference.moved:
        say(f"{m.joint} moves by up to {m.of_height:.2g} of the height in {m.frames} frames")
    say(
        f"rotations differ in {count_of(len({j.joint for j in difference.joints}), 'joint')} and "
        f"{count_of(difference.frames, 'frame')}; joints move by at most "
        f"{difference.max_position_of_height:.1e} of the height"
    )
    return 0


# -- two reviews -----------------------------------------------------------------------------------


def _is_session(path: Path) -> bool:
    return ".json" in path.suffixes and not path.is_dir()  # also NAME.twist.json.earlier


def _diff_sessions(arguments: argparse.Namespace) -> int:
    """Print how far two reviewers agree and where they differ, and merge their sessions."""
    a, b = read_session(arguments.a), read_session(arguments.b)
    try:
        check_same_clip(a.sha256, b.sha256)
        found = Agreement(paired(a.state.intervals, b.state.intervals))
        if arguments.merge:
            refuse_overwrite([arguments.merge], [arguments.a, arguments.b])
            refuse_decided(arguments.merge)
            _merge(arguments.a, a, b, found, arguments.merge)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{arguments.a}, {arguments.b}: {error}") from None
    if arguments.json:
        print_json(_sessions_to_json(arguments, a, b, found))
    else:
        _tell_sessions(arguments, (a, b), found)
    if arguments.merge:
        agreed = sum(p.decided_by_both and p.difference is None for p in found.pairs)
        left = f"{count_of(len(found.differences), 'interval')} left undecided, see their notes"
        remark(f"{arguments.merge}: agreed decisions: {agreed}; {left}")
    return 0


def _merge(path: Path, a: Session, b: Session, found: Agreement, output: Path) -> None:
    """Write a session with the agreed decisions. `path` is the file of session `a`."""
    places = Path(a.clip), path.parent / Path(a.clip).name
    if (clip_path := found_file(places, a.sha256)) is None:
        raise TwistError(f"{path}: the clip of this session was not found; put it next to it")
    clip = read_clip(clip_path, fps=a.fps)
    check_bytes(a, clip)
    write_session(clip, merged_review(found, a.state), output)
    if a.state.tracking != b.state.tracking:
        note(f"{output}: note: the sessions differ in tracking; the tracking of {path} was kept")


def _tell_sessions(
    arguments: argparse.Namespace, sessions: tuple[Session, Session], found: Agreement
) -> None:
    for name, path, session in zip("AB", (arguments.a, arguments.b), sessions, strict=True):
        intervals = session.state.intervals
        decided, who = sum(map(decided_by_person, intervals)), reviewers_of(intervals)
        by = f" by {', '.join(who)}" if who else ""
        say(f"{name} {path}: {decided} of {len(intervals)} intervals decided{by}")
    if found.differences:
        width = max(16, *(len(pair.either.interval.chain) for pair in found.differences))
        say(f"{'chain':<{width}} {'A':<32} {'B':<32} difference", head=True)
    for pair in found.differences:
        chain = terminal_text(pair.either.interval.chain)
        sides = f"{_side(pair.mine):<32} {_side(pair.theirs):<32}"
        say(f"{chain:<{width}} {sides} {pair.difference}")
    say(found.summary)


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
