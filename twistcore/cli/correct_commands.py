"""`twistcore refine | apply | diff`: corrected clips, and how they differ from what they were."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence

from twistcore.atomic import is_stream
from twistcore.chain import Chain
from twistcore.cli.detect_commands import detected
from twistcore.cli.folder_commands import apply_folder, diff_folders
from twistcore.cli.output import (
    lone_jumps,
    print_json,
    refuse_overwrite,
    tell_jumps,
    tell_no_chain,
    told_of,
)
from twistcore.clip import Clip, check_ending, write_clip
from twistcore.detection import Interval
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import compare, difference_to_json
from twistcore.export.replay import accepted_motion, correctable, replayed, uncorrected
from twistcore.formats import own_name, read_clip
from twistcore.refinement import SURE_ENOUGH, applied_unasked
from twistcore.report.clip_report import check_report, write_clip_report
from twistcore.report.report_document import Report
from twistcore.review import Review
from twistcore.review.model import SEEN


def refine(arguments: argparse.Namespace) -> int:
    """Write a corrected clip, and a report if asked."""
    clip = read_clip(arguments.clip, fps=arguments.fps)
    check_ending(clip, arguments.output)
    refuse_overwrite(
        [arguments.output], [p for p in (arguments.clip, arguments.profile, arguments.rig) if p]
    )
    if arguments.report and arguments.report.exists() and not arguments.report.is_dir():
        raise TwistError(f"{arguments.report}: expected a folder for the report")
    if arguments.report:
        check_report(arguments.report, own_name(clip.path), clip)
    found = detected(arguments, clip)
    chains, review = found.chains_and_limbs, Review.of(found)
    review.accept(arguments.min_confidence, include_open=arguments.include_open)
    applied = review.accepted
    refined = accepted_motion(clip, chains, review.state)
    tell_jumps(arguments.output, write_clip(clip, refined, arguments.output))
    if arguments.report:
        written = None if is_stream(arguments.output) else arguments.output
        report = Report(
            clip,
            chains,
            review.state,
            refined,
            own_name(clip.path),
            analysis=found.analysis,
            written=written,
        )
        write_clip_report(arguments.report, report)
    count = told_of(correctable(clip.motion, chains, applied), found, "corrected")
    print(f"{arguments.output}: {count}{_too_unsure(arguments, found)}{lone_jumps(found)}")
    skipped = _tell_uncorrected(clip, chains, applied)
    return int(skipped or bool(tell_no_chain(arguments.clip, found.analysis.chains_and_limbs)))


def apply(arguments: argparse.Namespace) -> int:
    """Replay a session, or those of a folder: the same bytes as the program's export."""
    if arguments.session.is_dir() or arguments.clip.is_dir():
        return apply_folder(arguments)
    refuse_overwrite([arguments.output], [arguments.clip, arguments.session])
    replay = replayed(arguments.session, arguments.clip)
    clip, chains, session = replay.clip, replay.chains, replay.session
    tell_jumps(arguments.output, write_clip(clip, replay.motion, arguments.output))
    chosen, judged = session.state.chosen(), session.state.intervals
    done = correctable(clip.motion, chains, chosen)
    count = told_of(done, [j.interval for j in judged], "applied")
    seen = lone_jumps([j.interval for j in judged if j.verdict == SEEN], " seen")
    print(f"{arguments.output}: {count}{seen}")
    return int(_tell_uncorrected(clip, chains, chosen))


def _too_unsure(arguments: argparse.Namespace, found: Iterable[Interval]) -> str:
    """', 2 of a confidence below 0.5 left' where there are any that nothing else speaks against."""
    least, also = arguments.min_confidence, arguments.include_open
    may_be, sure = (applied_unasked(found, at, include_open=also) for at in (0.0, least))
    left = len(may_be) - len(sure)
    return f", {left} of a confidence below {_least(least):g} left" if left else ""


def _least(asked: float | None) -> float:
    return SURE_ENOUGH if asked is None else asked


def _tell_uncorrected(clip: Clip, chains: Sequence[Chain], chosen: Sequence[Interval]) -> bool:
    """Say what could not be corrected, or not without moving a helper joint; True if skipped."""
    left, beside = uncorrected(clip, chains, chosen)
    for sentence in (*left, *beside):
        print(sentence, file=sys.stderr)
    return bool(left)


def diff(arguments: argparse.Namespace) -> int:
    """Print what differs between two clips, or the clips of two folders."""
    if arguments.a.is_dir() or arguments.b.is_dir():
        return diff_folders(arguments)
    a, b = read_clip(arguments.a), read_clip(arguments.b)
    try:
        difference = compare(a.motion, b.motion)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{arguments.a}, {arguments.b}: {error}") from None
    if arguments.json:
        print_json(difference_to_json(difference, str(arguments.a), str(arguments.b)))
        return 0
    for j in difference.joints:
        print(f"{j.joint:<24} {j.start:>7} – {j.stop:<7} up to {j.max_degrees:8.3f}°")
    for m in difference.moved:
        print(f"{m.joint} moves by up to {m.of_height:.2g} of the height in {m.frames} frames")
    print(
        f"{len({j.joint for j in difference.joints})} joints rotate otherwise, in "
        f"{difference.frames} frames; joints move by at most "
        f"{difference.max_position_of_height:.1e} of the height"
    )
    return 0
