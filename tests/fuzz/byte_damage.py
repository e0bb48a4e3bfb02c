"""Bytes flipped, cut out or repeated: damage to any file."""

from __future__ import annotations

import random
from collections.abc import Callable

Damage = Callable[[bytes, random.Random], bytes]


def anywhere(data: bytes, rng: random.Random) -> int:
    return rng.randint(0, len(data))


def flip(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 3, 50))):
        if out:
            out[rng.randrange(len(out))] = rng.randrange(256)
    return bytes(out)


def cut_at(place: Callable[[bytes, random.Random], int]) -> Damage:
    """Some bytes gone, or all behind a place."""

    def cut(data: bytes, rng: random.Random) -> bytes:
        at = place(data, rng)
        return data[:at] + data[at + rng.choice((1, 10, 1000, len(data))) :]

    return cut


def repeat_at(place: Callable[[bytes, random.Random], int]) -> Damage:
    """Some bytes many times over."""

    def repeat(data: bytes, rng: random.Random) -> bytes:
        at = place(data, rng)
        part = data[at : at + rng.choice((1, 20, 500))]
        return data[:at] + part * rng.choice((2, 5, 200)) + data[at:]

    return repeat
