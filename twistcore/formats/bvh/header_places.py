"""Find the words of a HIERARCHY section that can be rewritten: names, offsets and channels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from twistcore.formats.bvh.header import HeaderWords
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class HeaderPlace:
    """The place of a word in the text of a file.

    Attributes
    ----------
    kind
        'name', 'offset' (a number of an OFFSET), 'count' (the number of channels) or 'channel'.
    joint
        Index of the joint to which the word belongs. An End Site belongs to its joint.
    place
        The axis of an offset, the number of channels of a count, or the index of a channel among
        the joint's channels.
    start, stop
        Offsets of the word, in bytes.
    """

    kind: str
    joint: int
    place: int
    start: int
    stop: int


def header_word_spans(text: bytes) -> list[HeaderPlace]:
    """Return the places of all words that can be rewritten in a valid BVH text, in file order."""
    words = text.decode("utf-8", "surrogateescape")
    found, at, stop = [], 0, 0
    for kind, joint, place, start, end in _places(words):
        # Convert characters to bytes, because a name may have characters of several bytes.
        begin = stop + len(words[at:start].encode("utf-8", "surrogateescape"))
        at, stop = end, begin + len(words[start:end].encode("utf-8", "surrogateescape"))
        found.append(HeaderPlace(kind, joint, place, begin, stop))
    return found


def _places(text: str) -> Iterator[tuple[str, int, int, int, int]]:
    """Yield the fields of each place, with `start` and `stop` in characters."""
    words = HeaderWords("", text.replace("\ufeff", " ", 1) if text[:1] == "\ufeff" else text)
    stack: list[int] = []
    joints, channels = 0, Counter[int]()
    while (key := (words.next() or "MOTION").upper()) != "MOTION":
        if key in ("ROOT", "JOINT"):
            begin = words.span[1]
            name = words.rest_of_line()
            start = text.find(name, begin, words.span[1])
            yield "name", joints, 0, start, start + len(name)
            stack.append(joints)
            joints += 1
        elif key == "END":
            words.rest_of_line()
            stack.append(stack[-1])
        elif key == "OFFSET":
            for axis in range(3):
                words.next()
                yield "offset", stack[-1], axis, *words.span
        elif key == "CHANNELS":
            count = int(words.number("CHANNELS"))
            yield "count", stack[-1], count, *words.span
            for _ in range(count):
                words.next()
                yield "channel", stack[-1], channels[stack[-1]], *words.span
                channels[stack[-1]] += 1
        elif key == "}":
            stack.pop()
