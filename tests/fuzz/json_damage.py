"""Documents of ours, damaged by structure: values of other types, absurd numbers, other bytes."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

from tests.fuzz.byte_damage import Damage, anywhere, cut_at, flip, repeat_at


class Raw:
    """What stands in the text of a document as it is."""

    def __init__(self, text: str) -> None:
        self.text = text


class Entries(list[tuple[Any, Any]]):
    """An object as its entries, so that a key may stand there twice."""


DEEP = 100_000
NUMBERS = (
    "NaN", "Infinity", "-Infinity", "1e999", "-1e999", "1" + "0" * 400, "-1" + "0" * 400,
    "9" * 5000, "1e308", "-1e308", "1e-400", "-0", "-0.0", "0", "1", "-1", "0.5", "2",
    "9223372036854775807", "9223372036854775808", "-9223372036854775809", "2147483648",
    "99999999", "100000000", "18446744073709551616", "0.1e1", "1.0", "179.999999999999",
    "180", "181", "360", "1e17", "4294967296", "300", "1e5",
)  # fmt: skip
TEXTS = (
    "", " ", "\0", "a\0b", "\n", "\r\n", "\x1b[31m", "\ud800", "\udc80", "\udfff\ud800", "é", "😀",
    "\u202e", "\u2028", "../../etc/passwd", "/dev/zero", "C:\\x", "nan", "Infinity", "1", "true",
    "null", "%s%n", "{0}", "{frames}", "=1+1", "<img src='file:///x'>", "x" * 300, "x" * 70_000,
    "١", "_", "1_0", "0x10", "undecided", "accepted", "LIMB_FLIP", "𝟙", "\ufeff", "\x7f",
)  # fmt: skip


def nasty(rng: random.Random) -> Any:
    """Any value that JSON can hold, and some that it cannot."""
    what = rng.random()
    if what < 0.35:
        return Raw(rng.choice(NUMBERS))
    if what < 0.6:
        return rng.choice(TEXTS)
    if what < 0.75:
        return rng.choice((None, True, False))
    if what < 0.9:
        return rng.choice(([], {}, [[]], [{}], {"": []}, [None], [1, 2], [1, 2, 3], ["a"], [0.5],
                           {"x": 1}, [True], [[0, 1]], [[1, 0]], [[0, 10**30]]))  # fmt: skip
    if what < 0.97:
        thing = rng.choice((0, 1.5, "x", None, [], {}, Raw("1e999")))
        return [thing] * rng.choice((3, 100, 20_000))
    return Raw(_deep(rng))


def huge(rng: random.Random) -> Any:
    """A value of some megabytes: seldom, for it takes its time."""
    return rng.choice(("x" * 10_000_000, [0.5] * 500_000, "\ud800" * 200_000, Raw("9" * 2_000_000)))


def _deep(rng: random.Random) -> str:
    depth = rng.choice((90, 900, 1100, DEEP))
    begin, end = rng.choice((("[", "]"), ('{"a":', "}"), ('[{"a":', "}]")))
    return begin * depth + rng.choice(("1", "")) + end * rng.choice((depth, depth, 0))


def _places(document: Any) -> list[tuple[Any, int]]:
    """Every entry of every list and object, as where it is and its place there."""
    found, todo = [], [document]
    while todo:
        thing = todo.pop()
        if isinstance(thing, list) and len(thing) <= 2000:
            found += [(thing, k) for k in range(len(thing))]
            todo += [e[1] if isinstance(thing, Entries) else e for e in thing]
    return found


def _value(thing: Any, k: int) -> Any:
    return thing[k][1] if isinstance(thing, Entries) else thing[k]


def _put(thing: Any, k: int, value: Any) -> None:
    thing[k] = (thing[k][0], value) if isinstance(thing, Entries) else value


def _replaced(old: Any, rng: random.Random) -> Any:
    """Another value for one: like it or not like it at all."""
    like = rng.random()
    if isinstance(old, bool) and like < 0.5:
        return rng.choice((int(old), str(old).lower(), not old, None))
    if isinstance(old, int | float) and like < 0.6:
        return rng.choice(
            (Raw(rng.choice(NUMBERS)), -old, str(old), old + 1, old - 1, float(old), old * 1000,
             [old], bool(old), old + 0.5)
        )  # fmt: skip
    if isinstance(old, str) and like < 0.5:
        return rng.choice(
            (old + "x", old[:-1], old.upper(), [old], rng.choice(TEXTS), old[:9000] * 300)
        )
    if isinstance(old, list) and like < 0.5:
        some = list(old)
        change = rng.randrange(5)
        if change == 0:
            some = some[: len(some) // 2]
        elif change == 1:
            some = (some * rng.choice((2, 3, 50)))[:5000]
        elif change == 2:
            some.insert(rng.randint(0, len(some)), nasty(rng))
        elif change == 3:
            rng.shuffle(some)
        else:
            some = some[1:]
        return (
            Entries(e for e in some if isinstance(e, tuple)) if isinstance(old, Entries) else some
        )
    return nasty(rng)


def damage_tree(document: Any, rng: random.Random) -> Any:
    """One place of a document's tree changed."""
    places = _places(document)
    if not places or rng.random() < 0.02:
        return huge(rng) if rng.random() < 0.05 else nasty(rng)
    # Nearer the top as often as in the many lists of numbers.
    thing, k = rng.choice(places[: rng.choice((12, 60, len(places)))])
    what = rng.random()
    if what < 0.6:
        _put(thing, k, _replaced(_value(thing, k), rng))
    elif what < 0.7:
        del thing[k]
    elif what < 0.8 and isinstance(thing, Entries):
        thing.insert(rng.randint(0, len(thing)), (thing[k][0], nasty(rng)))
    elif what < 0.87 and isinstance(thing, Entries):
        key = rng.choice((rng.choice(TEXTS), str(thing[k][0]).upper(), "__class__", "schema"))
        thing[k] = (key, thing[k][1])
    elif what < 0.93:
        other, j = rng.choice(places)
        if j < len(other):
            _put(thing, k, copy.deepcopy(_value(other, j)))
    elif what < 0.995:
        thing.insert(k, ("extra", nasty(rng)) if isinstance(thing, Entries) else nasty(rng))
    else:
        _put(thing, k, huge(rng))
    return document


def tree(document: Any) -> Any:
    """A document with its objects as entries."""
    if isinstance(document, dict):
        return Entries((k, tree(v)) for k, v in document.items())
    if isinstance(document, list | tuple):
        return [tree(v) for v in document]
    return document


def text_of(document: Any) -> str:
    """The text of a document's tree, however absurd; what is very deep is cut."""
    out: list[str] = []
    _write(document, out, 0)
    return "".join(out)


def _write(thing: Any, out: list[str], depth: int) -> None:
    if depth > 60:
        out.append("null")
    elif isinstance(thing, Raw):
        out.append(thing.text)
    elif isinstance(thing, dict):
        _write(tree(thing), out, depth)
    elif isinstance(thing, Entries):
        out.append("{")
        for k, (key, value) in enumerate(thing):
            out.append(f"{', ' * bool(k)}{json.dumps(key)}: ")
            _write(value, out, depth + 1)
        out.append("}")
    elif isinstance(thing, list | tuple):
        out.append("[")
        for k, value in enumerate(thing):
            if k:
                out.append(", ")
            _write(value, out, depth + 1)
        out.append("]")
    else:
        out.append(json.dumps(thing))


def damage_bytes(data: bytes, rng: random.Random) -> bytes:
    """Bytes flipped, cut, repeated, or of another encoding."""
    return rng.choice(_BYTES)(data, rng)


def _insert(data: bytes, rng: random.Random) -> bytes:
    at = rng.randint(0, len(data))
    some = (
        b"\0",
        b"\xff",
        b"\xc3",
        b"\xed\xa0\x80",
        b"\n",
        b"\\ud800",
        b"[" * 2000,
        b"NaN",
        b"1e999",
    )
    return data[:at] + rng.choice(some) + data[at:]


def _other_encoding(data: bytes, rng: random.Random) -> bytes:
    text = data.decode("utf-8", "replace")
    name = rng.choice(("utf-16", "utf-16-le", "utf-32", "utf-8-sig", "latin-1", "cp037", "utf-7"))
    return text.encode(name, "replace")


def _whole(data: bytes, rng: random.Random) -> bytes:
    return rng.choice((b"", b"\0" * 100, b"\xff\xfe", b"null", b"[]", b"{}", b"\n", b"0", b'""',
                       b"[" * DEEP, b'{"a":' * DEEP, data + data, data[::-1],
                       rng.randbytes(200), b"\xef\xbb\xbf", b"9" * 100_000))  # fmt: skip


_cut = cut_at(anywhere)
_BYTES: tuple[Damage, ...] = (
    flip, flip, flip, _cut, _cut, repeat_at(anywhere), _insert, _insert, _other_encoding, _whole,
)  # fmt: skip


def damaged_json(document: Any, rng: random.Random) -> bytes:
    """A document with one to four damages; seldom it is as it was."""
    root = [tree(document)]
    what = rng.random()
    for _ in range(rng.choice((1, 1, 1, 2, 4)) if what < 0.85 else 0):
        if rng.random() < 0.97:
            # Only what is in the document: it stays one, as a rule.
            root[0] = damage_tree(root[0], rng)
    data = text_of(root[0]).encode("utf-8", "surrogatepass")
    return damage_bytes(data, rng) if 0.8 < what < 0.99 else data
