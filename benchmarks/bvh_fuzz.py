"""Damaged BVH files: python -m benchmarks.bvh_fuzz FOLDER… [--count N] [--seed N].

Every file is damaged at random, again and again: bytes flipped, parts cut, lines swapped, numbers
replaced. Reading must end in a motion or in a BvhError, within 2 s of processor time. Anything else
is listed with the seed that makes it again, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
import time
from collections import Counter
from pathlib import Path

from twistcore.bvh import parse_bvh
from twistcore.chain import find_chains
from twistcore.clip_files import BVH, clips_in
from twistcore.errors import BvhError

SLOW = 2.0
NASTY = (
    b"nan", b"inf", b"-inf", b"1e999", b"1_000", b"0x10", b"1,5", b"1e", b"--1", b"1.2.3", b"-",
    b"",
    b"99999999999999999999", b"-99999999999999999999", b"1e-400", b"\x00", b"\xef\xbc\x91",
    b"9" * 5000, b"0." + b"1" * 400, b"CHANNELS 999999999", b"Frames: 999999999999", b"}", b"{",
    b"MOTION", b"HIERARCHY", b"End Site", b"JOINT x {", b"\r", b"\n", b"\x0c", b"\x85", b"OFFSET",
)  # fmt: skip


def damaged(data: bytes, rng: random.Random) -> bytes:
    """A copy with one to four damages."""
    for _ in range(rng.randint(1, 4)):
        data = rng.choice(_DAMAGES)(data, rng)
    return data


def _flip(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 3, 50))):
        if out:
            out[rng.randrange(len(out))] = rng.randrange(256)
    return bytes(out)


def _place(data: bytes, rng: random.Random) -> int:
    """Anywhere, but as often as not within the header, where most can go wrong."""
    header = data.find(b"Frame Time") + 40
    return rng.randint(0, min(header, len(data)) if rng.random() < 0.5 else len(data))


def _cut(data: bytes, rng: random.Random) -> bytes:
    at = _place(data, rng)
    return data[:at] + data[at + rng.choice((1, 10, 1000, len(data))) :]


def _repeat(data: bytes, rng: random.Random) -> bytes:
    at = _place(data, rng)
    part = data[at : at + rng.choice((1, 20, 500))]
    return data[:at] + part * rng.choice((2, 5, 200)) + data[at:]


def _swap_lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if len(lines) > 1:
        head = min(len(lines), 300) if rng.random() < 0.5 else len(lines)
        a, b = rng.randrange(head), rng.randrange(head)
        lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def _replace(data: bytes, rng: random.Random) -> bytes:
    at = _place(data, rng)
    start = max(data.rfind(b" ", 0, at), data.rfind(b"\n", 0, at)) + 1
    ends = [e for e in (data.find(b" ", at), data.find(b"\n", at)) if e >= 0]
    return data[:start] + rng.choice(NASTY) + data[min(ends, default=len(data)) :]


def _line_ends(data: bytes, rng: random.Random) -> bytes:
    return data.replace(b"\n", rng.choice((b"\r", b"\r\n", b" ", b"\n\n", b"\x0b")))


_DAMAGES = (_flip, _flip, _cut, _repeat, _swap_lines, _replace, _replace, _line_ends)


def outcome(data: bytes) -> str:
    """'motion' or 'BvhError'; lets every other exception through."""
    try:
        clip = parse_bvh(data, "damaged.bvh")
    except BvhError as error:
        return "BvhError" if "\n" not in str(error) else "a message of several lines"
    find_chains(clip.motion)
    return "motion"


def main() -> int:
    """Run and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    files = sorted(
        f for folder in arguments.folders for f in clips_in(folder, below=True, suffixes=BVH)
    )
    # The 2 s are for a file of any ordinary size; a damaged 4 MB one says no more than its start.
    sources = [f.read_bytes()[:400_000] for f in files]
    counts: Counter[str] = Counter()
    slowest, largest, failures = 0.0, 0, 0
    for k in range(arguments.seed, arguments.seed + arguments.count):
        rng = random.Random(k)
        which = rng.randrange(len(files))
        data = damaged(sources[which], rng)
        begun = time.process_time()
        try:
            counts[outcome(data)] += 1
        except Exception as error:
            failures += 1
            print(f"seed {k}, {files[which].name}: {type(error).__name__}: {error}")
        took = time.process_time() - begun
        slowest, largest = max(slowest, took), max(largest, len(data))
        if took > SLOW:
            failures += 1
            print(f"seed {k}, {files[which].name}: took {took:.1f} s")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{arguments.count} damaged files: {dict(counts)}, {failures} failures")
    print(f"slowest {slowest:.2f} s, largest {largest / 1e6:.1f} MB, peak memory {memory:.0f} MB")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
