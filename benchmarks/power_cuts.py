"""Simulate power cuts at every byte of a journal and a session: python -m benchmarks.power_cuts.

A journal of random steps is cut at every byte (or every --step bytes). At every eighth cut
(--tails), it is also tried with a block of zeros, rubbish, or rubbish with line ends after the cut.
The restored state must equal the state after the last complete line, to the byte of its session,
and the journal must continue from there. The session file is cut in the same way: the damage must
be reported, and the file must never be read as a different session. The output shows the number of
trials and failures; the exit code is 1 if any trial failed.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from tests.twistcore.reviews import CLIP, fresh
from twistcore.detection.interval_offsets import resized_interval
from twistcore.errors import FormatError, TwistError
from twistcore.review import (
    Annotate,
    Decide,
    Decision,
    Edit,
    Journal,
    read_session,
    replay_journal,
    session_bytes,
)

STEPS = 25
_ZEROS = bytes(4096)
TAILS = (b"", _ZEROS, b"\xff\xfe{]\x00rubbish", b'{"do": "Decide", "ids": [1]\n\x00\xff\n')


@dataclass(frozen=True)
class MadeJournal:
    """A journal of random steps.

    Attributes
    ----------
    data
        The bytes of the journal.
    states
        The bytes of the session after each line of the journal.
    """

    data: bytes
    states: tuple[bytes, ...]


def made_journal(folder: Path, seed: int) -> MadeJournal:
    """Return a journal of random steps, which `seed` seeds."""
    rng, review, path = random.Random(seed), fresh(), folder / "made.journal"
    states = [session_bytes(CLIP, review.state)]
    with closing(Journal(path, CLIP, review.state)) as journal:
        for number in range(STEPS):
            judged = rng.choice(review.state.intervals)
            match rng.choice(("decide", "decide", "annotate", "edit", "undo")):
                case "undo" if review.position:
                    review.undo()
                    journal.append({"undo": True})
                case "annotate":
                    review.do(note := Annotate(judged.id, f"note {number} – ü"))
                    journal.do(note)
                case "edit":
                    stop = min(judged.interval.stop + 1, CLIP.motion.frames)
                    moved = resized_interval(judged.interval, judged.interval.start, stop)
                    review.do(edit := Edit(judged.id, moved))
                    journal.do(edit)
                case _:
                    said = rng.choice((Decision.ACCEPTED, Decision.REJECTED))
                    review.do(decide := Decide((judged.id,), said, "Ada", f"now {number}"))
                    journal.do(decide)
            states.append(session_bytes(CLIP, review.state))
    return MadeJournal(path.read_bytes(), tuple(states))


def cut_journal(
    journal: MadeJournal, places: Iterable[int], folder: Path, tails: Iterable[bytes] = TAILS
) -> int:
    """Cut the journal at each place, append each tail, and recover it. Return the number of trials.

    Raises AssertionError if a trial fails.
    """
    path, tried = folder / "cut.journal", 0
    for place in places:
        for tail in tails:
            path.write_bytes(journal.data[:place] + tail)
            _check(journal, place, tail, path)
            tried += 1
            for left in folder.iterdir():
                left.unlink()
    return tried


def _check(journal: MadeJournal, place: int, tail: bytes, path: Path) -> None:
    whole = journal.data[:place].count(b"\n")
    # No tail begins with a line end, which would complete a line that lacks only its end.
    where = f"cut at {place} before {tail[:8]!r}"
    try:
        back = replay_journal(path)
    except FormatError:
        assert whole == 0, where
        return
    assert whole > 0, where
    assert back.entries == whole - 1, where
    assert session_bytes(CLIP, back.review.state) == journal.states[whole - 1], where
    Journal.resume(back).close()
    kept = path.read_bytes()
    assert kept == journal.data[: len(kept)], where
    assert kept.count(b"\n") == whole, where


def cut_session(folder: Path, step: int = 1, tails: int = 1) -> int:
    """Cut the session every `step` bytes and read it. Return the number of trials.

    At every `tails`-th cut, variants with a tail are also tried. Raises AssertionError if a damaged
    session is read.
    """
    path, tried = folder / "cut.twist.json", 0
    data = session_bytes(CLIP, fresh().state)
    for place in range(0, len(data) - 2, step):
        for tail in TAILS if place // step % tails == 0 else TAILS[:1]:
            path.write_bytes(data[:place] + tail)
            tried += 1
            try:
                read_session(path)
            except TwistError:
                continue
            raise AssertionError(f"a session cut at {place} before {tail[:8]!r} was read")
    return tried


def main(argv: Sequence[str] | None = None) -> int:
    """Run all trials, print the numbers of trials and failures, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--step", type=int, default=1, help="bytes between cuts (default: 1)")
    parser.add_argument("--tails", type=int, default=8, help="cuts between tails (default: 8)")
    parser.add_argument(
        "--seed", type=int, default=1, help="seed of the review's steps (default: 1)"
    )
    words = parser.parse_args(argv)
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        journal = made_journal(folder, words.seed)
        (folder / "made.journal").unlink()
        places, tried = range(0, len(journal.data) + 1, words.step), 0
        for k, place in enumerate(places):
            try:
                tails = TAILS if k % words.tails == 0 else TAILS[:1]
                tried += cut_journal(journal, (place,), folder, tails)
            except Exception as error:  # report each failure, and try the next
                print(f"{type(error).__name__}: {error}", file=sys.stderr)
                failed += 1
        print(f"journal: {len(places)} places, {tried} files, {failed} failed", flush=True)
        wrong = 0
        try:
            tried = cut_session(folder, words.step, words.tails)
        except Exception as error:
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
            tried, wrong = 0, 1
        print(f"session: {tried} files, {wrong} failed")
    return int(bool(failed + wrong))


if __name__ == "__main__":
    sys.exit(main())
