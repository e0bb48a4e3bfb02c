"""Break the title of a figure's plot into lines."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

_NUMBER = re.compile(r"\s*[−+±]?\d")

Parts = list[tuple[str, str]]  # pairs (text, name of a colour in the theme)


def title_lines(title: Sequence[tuple[str, str]], room: float,
                advance: Callable[[str], float]) -> list[Parts]:  # fmt: skip
    """Break a title into lines, and return the parts of each line.

    A symbol and its numbers stay on the same line. A phrase is divided only if it is wider than a
    line. Spaces that only align columns are removed.

    Parameters
    ----------
    title
        The title as pairs (text, name of a colour in the theme).
    room
        The maximum width of a line in pixels.
    advance
        A function that returns the width of a text in pixels.
    """

    def width(group: Parts) -> float:
        return sum(advance(text) for text, _ in group)

    lines: list[Parts] = [[]]
    used = 0.0
    groups = _groups(title)
    for group in (part for g in groups for part in ([g] if width(g) <= room else _words(g))):
        wide = width(group)
        if lines[-1] and used + wide > room:
            text, role = group[0]
            group = [(text.lstrip(), role), *group[1:]]
            wide = width(group)
            lines.append([])
            used = 0.0
        lines[-1] += group
        used += wide
    return lines


def _groups(title: Sequence[tuple[str, str]]) -> list[Parts]:
    """Return groups of parts that stay on one line: a phrase, or a symbol and its numbers."""
    groups: list[Parts] = []
    for raw, role in title:
        text = re.sub(r"  +", " ", raw)
        before = {r for t, r in groups[-1] if t.strip()} if groups else set()
        symbol = (role == "text" and before != {"soft"}) or bool({"●", "○"} & set(text))
        word = role == "soft" and text.strip() and not _NUMBER.match(text)
        if not groups or symbol or word or text.startswith("━"):
            groups.append([])
        groups[-1].append((text, role))
    return groups


def _words(group: Parts) -> list[Parts]:
    """Split a group into one group for each word, including the spaces before the word."""
    return [[(word, role)] for text, role in group for word in re.findall(r"\s*\S+", text)]
