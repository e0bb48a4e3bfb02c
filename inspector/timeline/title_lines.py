"""Break the title of a plot into lines, for a figure."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

Parts = list[tuple[str, str]]  # pairs (text, name of a colour in the theme)


def title_lines(title: Sequence[tuple[str, str]], room: float,
                advance: Callable[[str], float]) -> list[Parts]:  # fmt: skip
    """Return the parts of the title in each line. A symbol and its numbers stay on one line.

    Spaces that only align columns are removed.

    Parameters
    ----------
    title
        The title as pairs (text, name of a colour in the theme).
    room
        The width of a line.
    advance
        A function that returns the width of a text.
    """
    lines: list[Parts] = [[]]
    used = 0.0
    for group in _groups(title):
        wide = sum(advance(text) for text, _ in group)
        if lines[-1] and used + wide > room:
            text, role = group[0]
            group = [(text.lstrip(), role), *group[1:]]
            wide = sum(advance(text) for text, _ in group)
            lines.append([])
            used = 0.0
        lines[-1] += group
        used += wide
    return lines


def _groups(title: Sequence[tuple[str, str]]) -> list[Parts]:
    """Return the groups of parts that must stay on one line: words, or a symbol and its numbers."""
    groups: list[Parts] = []
    for raw, role in title:
        text = re.sub(r"  +", " ", raw)
        before = {r for t, r in groups[-1] if t.strip()} if groups else set()
        symbol = (role == "text" and before != {"soft"}) or bool({"●", "○"} & set(text))
        if not groups or symbol or (role == "soft" and text.strip()) or text.startswith("━"):
            groups.append([])
        groups[-1].append((text, role))
    return groups
