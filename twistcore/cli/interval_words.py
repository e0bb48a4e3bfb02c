"""Intervals in words: how many, of which kinds, what was taken out, what was left."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from twistcore.analysis import ClipAnalysis
from twistcore.chain import Chain
from twistcore.cli.output import note, problem
from twistcore.clip import ChannelJump
from twistcore.detection import Interval, Kind


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


def note_sentences(clip: object, analysis: ClipAnalysis) -> list[str]:
    """The notes of an analysis, each with the clip's name."""
    return [f"{clip}: note: {note}" for note in analysis.notes]


def tell_no_chain(clip: object, chains: Sequence[Chain]) -> int:
    """1, with a sentence, where there was nothing to look at; else 0."""
    if not chains:
        problem(no_chain(clip))
    return int(not chains)


def no_chain(clip: object) -> str:
    """The sentence."""
    return f"{clip}: no chain of parent, child and grandchild"


def by_kind(intervals: Iterable[Interval], among: Iterable[Interval] = ()) -> str:
    """' (2 counter-twists, 7 limb flips)' where these or others among them are not all twists."""
    count = Counter(i.kind for i in intervals)
    if not count or {*count, *(i.kind for i in among)} == {Kind.COUNTER_TWIST}:
        return ""
    words = (f"{count[k]} {k}{'' if count[k] == 1 else 's'}" for k in Kind if count[k])
    return f" ({', '.join(words)})"


def told_of(applied: Sequence[Interval], every: Iterable[Interval], verb: str) -> str:
    """'5 of 7 intervals corrected (5 limb flips)', of those in which there is anything to take out.

    applied: those of them of which it was taken out; verb: what was done, 'corrected'.
    """
    every = tuple(every)
    repairable = sum(i.repairable for i in every)
    return f"{len(applied)} of {repairable} intervals {verb}{by_kind(applied, every)}"


def lone_jumps(intervals: Iterable[Interval], mark: str = "") -> str:
    """', 6 lone jumps' where there are any; mark: what is said of them."""
    count = sum(not i.repairable for i in intervals)
    return f", {count} {Kind.LONE_JUMP}{'' if count == 1 else 's'}{mark}" if count else ""
