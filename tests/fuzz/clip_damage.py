"""Damage to clips that are text: by bytes, by lines, by words, and by the structure of a BVH."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence

from tests.fuzz.byte_damage import Damage, cut_at, flip, repeat_at

NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e999", b"1_000", b"0x10", b"1,5", b"1e", b"--1", b"1.2.3", b"-",
    b"99999999999999999999", b"-99999999999999999999", b"1e-400", b"\xef\xbc\x91", b"9" * 5000,
    b"0." + b"1" * 400, b"1e99", b"-9.99e99", b"1e-320", b"0", b"-0.0", b"1e6", b"+3", b".5", b"7.",
)  # fmt: skip
_CONTROL = (b"", b"\x00", b"\r", b"\n", b"\x0c", b"\x85", b"}", b"{", b"\x1b[2J", b"#", b"\xff\xfe")
_BVH_WORDS = (
    b"CHANNELS 999999999", b"CHANNELS 0", b"CHANNELS 1 Xposition", b"Frames: 999999999999",
    b"MOTION", b"HIERARCHY", b"End Site", b"End Site\n{\nOFFSET 0 1 0\n}", b"JOINT x {", b"OFFSET",
    b"OFFSET 0 0 0", b"JOINT x\n{\nOFFSET 0 1 0\n}",
)  # fmt: skip
_AMC_WORDS = (
    b":RADIANS", b":DEGREES", b":SAMPLES-PER-SECOND 60", b":SAMPLES-PER-SECOND 0", b"1", b"0",
    b"root 1 2 3 4 5 6", b"begin", b"end", b"dof rx", b"dof rx ry rz tx l", b"axis 1 2 3 ZYX",
    b":hierarchy", b":bonedata", b":units", b"angle rad", b"order TX TX", b"order RX", b"length 0",
    b"direction 0 0 0", b"limits (-1 1)", b"(-inf inf)", b"id 1", b"name root",
)  # fmt: skip
_NUMBER = re.compile(rb"(?<![^\s(])[-+]?[0-9]*\.[0-9]+(?:e[-+]?[0-9]+)?(?![^\s)])")
_NAME = re.compile(rb"name (\w+)")


def damaged(
    data: bytes, rng: random.Random, kinds: Sequence[Damage] | None = None, most: int = 4
) -> bytes:
    """A copy with one to four damages; of BVH, unless others are given."""
    for _ in range(rng.randint(1, most)):
        data = rng.choice(kinds or BVH_BYTES)(data, rng)
    return data


# -- of any text -----------------------------------------------------------------------------------


def _place(data: bytes, rng: random.Random) -> int:
    """Anywhere, but as often as not near the beginning, where most can go wrong."""
    header = max(data.find(b"Frame Time") + 40, 2000)
    return rng.randint(0, min(header, len(data)) if rng.random() < 0.5 else len(data))


cut, repeat = cut_at(_place), repeat_at(_place)


def line_ends(data: bytes, rng: random.Random) -> bytes:
    return data.replace(b"\n", rng.choice((b"\r", b"\r\n", b" ", b"\n\n", b"\x0b")))


def lines(data: bytes, rng: random.Random) -> bytes:
    """A line gone, twice, or many times, or in another's place."""
    every = data.splitlines(keepends=True)
    if len(every) < 2:
        return data
    head = min(len(every), 300) if rng.random() < 0.5 else len(every)
    a, b = rng.randrange(head), rng.randrange(head)
    what = rng.randrange(4)
    if what == 0:
        every[a], every[b] = every[b], every[a]
    elif what == 1:
        every[a] = every[a] * rng.choice((2, 2, 1000))
    elif what == 2:
        every[a] = every[b]
    else:
        del every[a]
    return b"".join(every)


def words(other: Sequence[bytes]) -> Damage:
    """A word replaced by one of these, by an odd number, or by none."""

    def replaced(data: bytes, rng: random.Random) -> bytes:
        at = _place(data, rng)
        start = max(data.rfind(b" ", 0, at), data.rfind(b"\n", 0, at)) + 1
        ends = [e for e in (data.find(b" ", at), data.find(b"\n", at)) if e >= 0]
        new = rng.choice(rng.choice((other, NUMBERS, _CONTROL)))
        return data[:start] + new + data[min(ends, default=len(data)) :]

    return replaced


def numbers(data: bytes, rng: random.Random) -> bytes:
    """Some numbers become others, as large or small as numbers can be: mostly a file still."""
    places = [found.span() for found in _NUMBER.finditer(data)]
    chosen = sorted(rng.sample(places, min(len(places), rng.choice((1, 1, 5, 200)))))
    size = 10.0 ** rng.choice((-300, -20, -6, -1, 0, 1, 2, 3, 6, 20, 60))
    out, before = [], 0
    for start, stop in chosen:
        out += [data[before:start], b"%.6g" % (rng.uniform(-1.0, 1.0) * size)]
        before = stop
    return b"".join([*out, data[before:]])


# -- of a BVH's structure -------------------------------------------------------------------------


def rename(data: bytes, rng: random.Random) -> bytes:
    """Joints of other names: all one, none at all, odd letters, or the sides exchanged."""
    new = rng.choice((b"a", b"", b"Left Hand", b"b\xff\xfe", "Böne ".encode() * 50, b"LeftHand #2"))
    share, swap = rng.random(), rng.random() < 0.2

    def one(found: re.Match[bytes]) -> bytes:
        if swap:
            return found[0].replace(b"Left", b"Right")
        return found[1] + new if rng.random() < share else found[0]

    return re.sub(rb"((?:JOINT|ROOT) )[^\r\n]*", one, data)


def scale(data: bytes, rng: random.Random) -> bytes:
    """Other units: every OFFSET is so many times as long, or all are none."""
    factor = rng.choice((0.0, 1e-12, 0.01, -1.0, 2.54, 1e4, 1e30, 1e90))

    def one(found: re.Match[bytes]) -> bytes:
        try:
            return b"OFFSET " + b" ".join(b"%.6g" % (factor * float(x)) for x in found[1].split())
        except ValueError:
            return found[0]

    return re.sub(rb"OFFSET ([^\r\n]*)", one, data)


def channels(data: bytes, rng: random.Random) -> bytes:
    """A joint's channels in another order, of another kind, or fewer, with their numbers or not."""
    found = list(re.finditer(rb"CHANNELS (\d+) ([^\r\n]*)", data))
    if not found:
        return data
    which = rng.randrange(len(found))
    own = found[which][2].split()
    rng.shuffle(own)
    own = own[: rng.choice((0, 1, 2, 3, 6, 6))]
    if own and rng.random() < 0.3:
        own[0] = rng.choice((b"Xrotation", b"Yposition", b"Zrotation", own[-1]))
    text = b"CHANNELS %d %b" % (len(own), b" ".join(own))
    head, motion, rows = (
        data[: found[which].start()] + text + data[found[which].end() :]
    ).partition(b"Frame Time")
    if rng.random() < 0.3:
        return head + motion + rows
    before = sum(len(f[2].split()) for f in found[:which])
    after = before + len(found[which][2].split())
    first, *others = rows.splitlines(keepends=True) or [b""]
    numbered = (line.split() for line in others)
    kept = [b" ".join([*n[:before], *n[before : before + len(own)], *n[after:]]) for n in numbered]
    return head + motion + first + b"\n".join(kept) + b"\n"


def frames(data: bytes, rng: random.Random) -> bytes:
    """Fewer rows, rows again, rows turned round, or wrapped over lines; with the count or not."""
    head, motion, rows = data.partition(b"Frame Time")
    first, *others = rows.splitlines(keepends=True) or [b""]
    what = rng.randrange(5)
    if what == 0:
        others = others[: rng.choice((0, 1, 2, 3, 5, 10))]
    elif what == 1:
        others = others[: rng.randrange(1, 20)] * rng.choice((2, 5))
    elif what == 2:
        others = others[::-1]
    elif what == 3:
        others = [b"\n".join(line.split()) + b"\n" for line in others]
    else:
        others = [others[0]] * len(others) if others else []
    if rng.random() < 0.7:
        head = re.sub(rb"Frames: *\d+", b"Frames: %d" % len(others), head)
    return head + motion + first + b"".join(others)


def nest(data: bytes, rng: random.Random) -> bytes:
    """A joint with many below it, or a line of them."""
    count = rng.choice((1, 3, 300))
    one = b"JOINT n\n{\nOFFSET 0 1 0\nCHANNELS 0\n"
    grown = one * count + b"}\n" * count if rng.random() < 0.5 else (one + b"}\n") * count
    at = data.find(b"JOINT", rng.randrange(2000))
    return data if at < 0 else data[:at] + grown + data[at:]


# -- of a skeleton and its motion together ---------------------------------------------------------


def pair(skeleton: bytes, motion: bytes, rng: random.Random) -> tuple[bytes, bytes]:
    """An ASF and its AMC with another figure or other frames, that belong together still."""
    what = rng.randrange(6)
    names = _NAME.findall(skeleton)
    if what == 0 and names:  # other degrees of freedom, and as many numbers
        name = rng.choice(names)
        dofs = rng.sample((b"rx", b"ry", b"rz"), rng.randint(0, 3))
        own = re.compile(rb"(name %b\b(?:(?!  end).)*?)(    dof [^\r\n]*)" % name, re.S)
        skeleton = own.sub(rb"\1    dof " + b" ".join(dofs), skeleton)
        row = name + b"".join(b" %.3f" % rng.uniform(-180, 180) for _ in dofs) if dofs else b""
        motion = re.sub(rb"(?m)^%b [^\r\n]*" % name, row, motion)
    elif what == 1:
        order = rng.sample((b"TX", b"TY", b"TZ", b"RX", b"RY", b"RZ"), rng.randint(1, 6))
        skeleton = re.sub(rb"order [^\r\n]*", b"order " + b" ".join(order), skeleton)
        row = b"root" + b" 1.5" * len(order)
        motion = re.sub(rb"(?m)^root [^\r\n]*", row, motion)
    elif what == 2:
        skeleton = skeleton.replace(b"angle deg", rng.choice((b"angle rad", b"angle", b"length 1")))
        motion = motion.replace(
            b":DEGREES", rng.choice((b":RADIANS", b"", b":SAMPLES-PER-SECOND 60"))
        )
    elif what == 3:
        rotated = rng.choice((b"ZYX", b"YXZ", b"XZY"))
        skeleton = re.sub(rb"(axis [^\r\n]*)XYZ", rb"\1" + rotated, skeleton)
        skeleton = re.sub(rb"orientation [^\r\n]*", b"orientation 10 20 -30", skeleton)
    elif what == 4:
        name, new = rng.choice(names or [b"root"]), rng.choice((b"x", b"b\xff", b"LeftHand", b"-"))
        skeleton, motion = (re.sub(rb"\b%b\b" % name, new, d) for d in (skeleton, motion))
    else:
        parts = re.split(rb"(?m)^(?=\d+\s*$)", motion)
        own = parts[1:][: rng.choice((1, 2, 3, 30))]
        motion = parts[0] + b"".join(own[:: rng.choice((1, -1))])
    return skeleton, motion


BVH_BYTES = (flip, flip, cut, repeat, lines, words(_BVH_WORDS), words(_BVH_WORDS), line_ends)
BVH_STRUCTURE = (rename, scale, channels, frames, nest, numbers, numbers, lines)
AMC_BYTES = (flip, cut, repeat, lines, words(_AMC_WORDS), words(_AMC_WORDS), line_ends)
AMC_STRUCTURE = (numbers, numbers, numbers, lines)
