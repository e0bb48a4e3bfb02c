"""What commands say and where they write: JSON, problems, and outputs that replace nothing."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from twistcore.atomic import destination, is_stream, same_file
from twistcore.chain import Chain
from twistcore.clip import ChannelJump
from twistcore.detection import Interval, Kind
from twistcore.encoding import json_text
from twistcore.errors import TwistError


def print_json(document: dict[str, Any]) -> None:
    """Write a JSON document to stdout; ValueError where a number is not finite."""
    text = json_text(document)
    if (sys.stdout.encoding or "utf-8").lower() != "utf-8":
        text = json.dumps(json.loads(text), indent=1)  # what it cannot write, escaped
    print(text)


def tell_jumps(output: Path, jumps: Sequence[ChannelJump]) -> None:
    """Say where a channel had to turn by more than 180° in one frame."""
    for jump in jumps[:10]:
        print(f"{output}: note: {jump}", file=sys.stderr)
    if len(jumps) > 10:
        print(f"{output}: note: {len(jumps) - 10} more such jumps", file=sys.stderr)


def tell_no_chain(clip: Path, chains: Sequence[Chain]) -> int:
    """1, with a sentence, where there was nothing to look at; else 0."""
    if not chains:
        print(f"{clip}: no chain of parent, child and grandchild", file=sys.stderr)
    return int(not chains)


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


def tell_problems(problems: Sequence[str], done: int) -> int:
    """List what could not be processed beside so many that could; the exit code."""
    for problem in problems:
        print(problem, file=sys.stderr)
    return int(bool(problems)) if done else 2


def refuse_overwrite(outputs: Sequence[Path], sources: Iterable[Path]) -> None:
    """Before anything is written: every output has a folder and replaces no input or output.

    Links are followed. Raises TwistError, and OSError for what cannot be written at all.
    """
    for k, output in enumerate(outputs):
        end = destination(output)
        if any(same_file(output, source) for source in sources):
            raise TwistError(f"{output}: expected another file than an input of this command")
        if any(end == destination(other) or same_file(output, other) for other in outputs[:k]):
            raise TwistError(f"{output}: expected different files for different outputs")
        if not is_stream(output) and not end.parent.is_dir():
            raise TwistError(f"{output}: expected an existing folder to write into")
