"""Draw the architecture from the imports: `python docs/draw_architecture.py`.

The result is images/house.svg, drawn as two houses. Floors are the layers of the import contracts
in pyproject.toml, and rooms are the folders and modules in a layer. An arrow leads from a room to
one that it imports. Arrows that follow from others are left out: if A imports B and B imports C,
there is no arrow from A to C.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "house.svg"
HOUSES = ("inspector", "twistcore")
WIDTH, MARGIN, GAP, FLOOR_GAP, LINE = 1160, 20, 14, 24, 14
CHARACTER = 5.9  # pixels of a letter, so that lines are broken alike on every machine
COLOURS = {"inspector": ("#fff4e6", "#c05a00"), "twistcore": ("#e8f1fb", "#1f5fa8")}


@dataclass(frozen=True)
class Box:
    """A room on the page: its lines of text, position and size in pixels."""

    room: str
    lines: tuple[str, ...]
    x: float
    y: float
    width: float
    height: float


def floors() -> dict[str, list[list[str]]]:
    """Return the rooms by house and floor, from the top down, from the import contracts."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    found = {}
    for contract in project["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers" and "containers" in contract:
            (house,) = contract["containers"]
            found[house] = [
                [f"{house}.{room.strip()}" for room in layer.split("|")]
                for layer in contract["layers"]
            ]
    return found


def room_of(module: str) -> str:
    """Return the room of a module: the first two parts of its name."""
    return ".".join(module.split(".")[:2])


def arrows(graph: grimp.ImportGraph) -> set[tuple[str, str]]:
    """Return the arrows as pairs (room, imported room), without implied ones."""
    below: dict[str, set[str]] = {}
    for module in graph.modules:
        room = below.setdefault(room_of(module), set())
        room |= {room_of(other) for other in graph.find_modules_directly_imported_by(module)}
    for house in HOUSES:
        del below[house]  # what a package's face shows is no arrow of a room
    known = {room: reached(below, others) for room, others in below.items()}
    return {
        (room, other)
        for room, others in below.items()
        for other in others - {room}
        if not any(other in known[between] for between in others - {room, other})
    }


def reached(below: Mapping[str, set[str]], rooms: Iterable[str]) -> set[str]:
    """Return the given rooms and all rooms that can be reached from them."""
    seen: set[str] = set()
    waiting = list(rooms)
    while waiting:
        room = waiting.pop()
        if room not in seen:
            seen.add(room)
            waiting += below.get(room, ())
    return seen


def contents(graph: grimp.ImportGraph, room: str) -> list[str]:
    """Return the names of a room's modules; modules of a folder follow `folder/`."""
    words = []
    for child in sorted(graph.find_children(room)):
        name, inner = child.rsplit(".", 1)[1], sorted(graph.find_children(child))
        words += ["", f"{name}/", *(i.rsplit(".", 1)[1] for i in inner), ""] if inner else [name]
    return words


def wrapped(words: Iterable[str], width: float) -> tuple[str, ...]:
    """Break words into lines of at most `width` pixels. An empty word ends a line."""
    lines = [""]
    for word in words:
        longer = f"{lines[-1]}  {word}".strip()
        if not word or (lines[-1] and len(longer) * CHARACTER > width):
            lines.append(word)
        else:
            lines[-1] = longer
    return tuple(line for line in lines if line)


def placed(graph: grimp.ImportGraph) -> tuple[list[Box], float]:
    """Return the boxes of all rooms on the page, and the height of the page."""
    boxes, y = [], float(MARGIN)
    for layers in floors().values():
        y += 26
        for layer in layers:
            words = {room: contents(graph, room) for room in layer}
            # A room is as wide as it has letters to show, and never too narrow for its name.
            weight = {r: 120.0 + 2.2 * sum(map(len, words[r])) for r in layer}
            share = (WIDTH - 2 * MARGIN - GAP * (len(layer) - 1)) / sum(weight.values())
            x, row = float(MARGIN), []
            for room in layer:
                width = weight[room] * share
                row.append((room, wrapped(words[room], width - 16), x, width))
                x += width + GAP
            height = 26 + LINE * max(len(lines) for _, lines, _, _ in row)
            boxes += [Box(room, lines, x, y, width, height) for room, lines, x, width in row]
            y += height + FLOOR_GAP
    return boxes, y


def picture(graph: grimp.ImportGraph) -> str:
    """Return the drawing as SVG."""
    boxes, height = placed(graph)
    at = {box.room: box for box in boxes}
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0f}" '
        'font-family="DejaVu Sans, Helvetica, Arial, sans-serif">',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#777"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height:.0f}" fill="#ffffff"/>',
    ]
    for above, below in sorted(arrows(graph)):
        a, b = at[above], at[below]
        x1, x2 = a.x + a.width / 2, b.x + b.width / 2
        # Straight down where the rooms lie over each other.
        low, high = max(a.x, b.x) + 12, min(a.x + a.width, b.x + b.width) - 12
        if low < high:
            x1 = x2 = (low + high) / 2
        out.append(
            f'<path d="M{x1:.0f} {a.y + a.height:.0f}L{x2:.0f} {b.y - 1:.0f}" stroke="#777" '
            'fill="none" marker-end="url(#tip)"/>'
        )
    for house, layers in floors().items():
        top = at[layers[0][0]].y
        out.append(f'<text x="{MARGIN}" y="{top - 10:.0f}" font-size="16">{house}/</text>')
    for box in boxes:
        fill, edge = COLOURS[box.room.split(".")[0]]
        out.append(
            f'<rect x="{box.x:.0f}" y="{box.y:.0f}" width="{box.width:.0f}" '
            f'height="{box.height:.0f}" rx="4" fill="{fill}" stroke="{edge}"/>'
        )
        name = box.room.split(".")[1] + ("/" if graph.find_children(box.room) else "")
        out.append(
            f'<text x="{box.x + 8:.0f}" y="{box.y + 17:.0f}" font-size="13" font-weight="bold" '
            f'fill="{edge}">{escape(name)}</text>'
        )
        for k, line in enumerate(box.lines):
            out.append(
                f'<text x="{box.x + 8:.0f}" y="{box.y + 32 + LINE * k:.0f}" font-size="10.5" '
                f'fill="#222">{escape(line)}</text>'
            )
    return "\n".join([*out, "</svg>", ""])


def house_graph() -> grimp.ImportGraph:
    """Return the import graph of both packages, including imports for type checkers."""
    return grimp.build_graph(*HOUSES, cache_dir=None)


if __name__ == "__main__":
    PICTURE.write_text(picture(house_graph()), "utf-8")
    print(PICTURE.relative_to(ROOT))
