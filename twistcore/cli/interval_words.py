"""Intervals in words: how many, of which kinds, what was taken out, what was left."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.cli.output import note
from twistcore.detection import Interval, Kind
from twistcore.detection.kind import plural
from twistcore.formats.clip import ChannelJump
from twistcore.skeleton.body import Unexamined
from twistcore.skeleton.notes import NOT_EXAMINED


def jump_sentences(output: Path, jumps: Sequence[ChannelJump]) -> list[str]:
    """Where a channel had to turn by more than 180° in one frame; many are counted."""
    sentences = [f"{output}: note: {jump}" for jump in jumps[:10]]
    if len(jumps) > 10:
        sentences.append(f"{output}: note: {len(jumps) - 10} more such jumps")
    return sentences


def tell_jumps(output: Path, jumps: Sequence[ChannelJump]) -> None:
    """Say so."""
    for sentence in jump_sentences(output, jumps):
        note(sentence)


def note_sentences(clip: object, analysis: ClipAnalysis | Detection) -> list[str]:
    """The notes of an analysis, each with the clip's name.

    That nothing could be examined is no note of a command but its result: :func:`not_examined`.
    """
    return [f"{clip}: note: {note}" for note in analysis.notes if note.kind != NOT_EXAMINED]


def not_examined(clip: object, found: ClipAnalysis | Detection) -> tuple[str, ...]:
    """The sentence on a clip in which nothing could be examined; none on any other clip."""
    return (f"{clip}: could not be examined: {why}",) if (why := found.not_examined) else ()


def unexamined_to_json(analysis: ClipAnalysis) -> list[dict[str, str]]:
    """The limbs that no chain examines, as documents list them."""
    return [limb.to_json() for limb in analysis.unexamined]


def without_limbs(unexamined: Sequence[Unexamined]) -> str:
    """'; left arm and right arm not examined' where there are such limbs."""
    if not unexamined:
        return ""
    *first, last = (one.title for one in unexamined)
    return f"; {', '.join(first)}{' and ' if first else ''}{last} not examined"


def by_kind(intervals: Iterable[Interval], among: Iterable[Interval] = ()) -> str:
    """' (2 counter-twists, 7 limb flips)' where these or others among them are not all twists."""
    count = Counter(i.kind for i in intervals)
    if not count or {*count, *(i.kind for i in among)} == {Kind.COUNTER_TWIST}:
        return ""
    return f" ({', '.join(_counted(count[k], k) for k in _in_order(count))})"


def told_of(applied: Sequence[Interval], every: Iterable[Interval], verb: str) -> str:
    """'5 of 7 intervals corrected (5 limb flips)', of those in which there is anything to take out.

    applied: those of them of which it was taken out; verb: what was done, 'corrected'.
    """
    every = tuple(every)
    repairable = sum(i.repairable for i in every)
    return f"{len(applied)} of {repairable} intervals {verb}{by_kind(applied, every)}"


def shown_only(intervals: Iterable[Interval], mark: str = "") -> str:
    """', 6 lone jumps, 1 noise burst' where there are any; mark: a word after each."""
    count = Counter(i.kind for i in intervals if not i.repairable)
    return "".join(f", {_counted(count[k], k)}{mark}" for k in _in_order(count))


def _in_order(kinds: Iterable[Kind]) -> list[Kind]:
    """From the usual to the rare."""
    return sorted(kinds, key=lambda kind: (kind.info.place, kind))


def _counted(count: int, kind: Kind) -> str:
    """'2 limb flips', '1 frozen span': frames are not counted, spans of them are."""
    word = kind.info.counted or kind.value
    return f"{count} {word if count == 1 else plural(word)}"
