"""The texts of tour and exercise: Markdown files in assets/tour, one a page, to be translated."""

from __future__ import annotations

from dataclasses import dataclass

from inspector.bundled import PAGES


@dataclass(frozen=True)
class Page:
    """title: the heading; body: Markdown; task: what is to be done, the quoted last paragraph."""

    title: str
    body: str
    task: str


def read_page(name: str) -> Page:
    """A page by its file's name without suffix."""
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    head, _, rest = text.partition("\n")
    body, _, task = rest.rpartition("\n> ")
    return Page(head.removeprefix("# ").strip(), body.strip(), task.replace("\n> ", " ").strip())
