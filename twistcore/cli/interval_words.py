"""Describe how many intervals were found, corrected and left, and which limbs were not examined."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.cli.output import print_note
from twistcore.detection import Interval, Kind
from twistcore.detection.kind import plural_kind_name
from twistcore.formats.clip import ChannelJump
from twistcore.skeleton.body import Unexamined
from twistcore.skeleton.notes import NOT_EXAMINED, Note


def jump_sentences(output: Path, jumps: Sequence[ChannelJump]) -> list[str]:
    """Return at most 11 sentences about channels that change by more than 180° in a frame."""
    sentences = [f"{output}: note: {jump}" for jump in jumps[:10]]
    if len(jumps) > 10:
        sentences.append(f"{output}: note: {len(jumps) - 10} more such jumps")
    return sentences


def print_channel_jumps(output: Path, jumps: Sequence[ChannelJump]) -> None:
    """Print notes about channels that change by more than 180° in a frame."""
    for sentence in jump_sentences(output, jumps):
        print_note(sentence)


def note_sentences(
    clip: object, analysis: ClipAnalysis | Detection, more: Iterable[Note] = ()
) -> list[str]:
    """Return the notes about an analysis and the notes in `more`, each with the clip's name.

    If a clip could not be examined, this is a problem and not a note; see
    :func:`nothing_examined_sentence`.
    """
    notes = (*analysis.notes, *more)
    return [f"{clip}: note: {note}" for note in notes if note.kind != NOT_EXAMINED]


def nothing_examined_sentence(clip: object, found: ClipAnalysis | Detection) -> tuple[str, ...]:
    """Return a tuple with a sentence if nothing in a clip could be examined, or an empty tuple."""
    return (f"{clip}: could not be examined: {why}",) if (why := found.not_examined) else ()


def unexamined_limbs_to_json(analysis: ClipAnalysis) -> list[dict[str, str]]:
    """Return the limbs that were not examined as JSON data."""
    return [limb.to_json() for limb in analysis.unexamined]


def unexamined_limbs_text(unexamined: Sequence[Unexamined]) -> str:
    """Return text such as '; left arm and right arm not examined', or '' if all were examined."""
    if not unexamined:
        return ""
    *first, last = (one.title for one in unexamined)
    return f"; {', '.join(first)}{' and ' if first else ''}{last} not examined"


def error_kind_counts_text(intervals: Iterable[Interval], among: Iterable[Interval] = ()) -> str:
    """Return text such as ' (2 counter-twists, 7 limb flips)', or '' if all are counter-twists.

    The text is empty only if all intervals in `among` are counter-twists, too.
    """
    count = Counter(i.kind for i in intervals)
    if not count or {*count, *(i.kind for i in among)} == {Kind.COUNTER_TWIST}:
        return ""
    return f" ({', '.join(_counted(count[k], k) for k in _in_order(count))})"


def corrected_interval_count_text(
    applied: Sequence[Interval], every: Iterable[Interval], verb: str
) -> str:
    """Return text such as '5 of 7 intervals corrected (5 limb flips)'.

    `applied` are the corrected intervals. The total is the number of twist errors in `every`, plus
    the corrected intervals of other kinds. `verb` is 'corrected' or 'applied'.
    """
    every = tuple(every)
    repairable = sum(i.repairable for i in every) + sum(not i.repairable for i in applied)
    return (
        f"{len(applied)} of {repairable} intervals {verb}{error_kind_counts_text(applied, every)}"
    )


def uncorrectable_counts(intervals: Iterable[Interval], mark: str = "") -> str:
    """Return text such as ', 6 lone jumps, 1 noise burst', or '' if all can be corrected.

    `mark` is a word to add after each kind.
    """
    count = Counter(i.kind for i in intervals if not i.repairable)
    return "".join(f", {_counted(count[k], k)}{mark}" for k in _in_order(count))


def _in_order(kinds: Iterable[Kind]) -> list[Kind]:
    """Return kinds of errors in the order in which the program lists them."""
    return sorted(kinds, key=lambda kind: (kind.info.place, kind))


def _counted(count: int, kind: Kind) -> str:
    """Return a count with its kind, such as '2 limb flips' or '1 frozen span'."""
    word = kind.info.counted or kind.value
    return f"{count} {word if count == 1 else plural_kind_name(word)}"
