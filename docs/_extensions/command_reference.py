"""Generate the reference of all commands from their parsers, on pages that contain a mark."""

from __future__ import annotations

import argparse
import os
import re
import textwrap
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

from sphinx.application import Sphinx

MARK = re.compile(r"^<!-- commands of (\S+):(\S+) -->$", re.MULTILINE)
_WIDTH = "88"  # characters of a line of usage
_MARKDOWN = re.compile(r"([\\`*_\[\]<>|])")

_PAGE = re.compile(r"docs/([\w-]+)\.md")


def reference(parser: argparse.ArgumentParser, level: int = 2) -> str:
    """Return a parser and its subcommands as Markdown, each under its own heading."""
    name = parser.prog
    lines = [f"{'#' * level} {name}", _escaped(parser.description or "")]
    lines += [f"```text\n{_usage(parser)}\n```", *_words(parser)]
    for part in filter(None, (parser.epilog or "").split("\n\n")):
        head, _, examples = part.partition("\n  ")
        lines.append(f"```sh\n{_lines(f'  {examples}', name)}\n```" if examples else _escaped(head))
    below = next((a for a in parser._actions if isinstance(a, argparse._SubParsersAction)), None)
    for child in below.choices.values() if below else ():
        lines.append(reference(child, level + 1))
    return "\n\n".join(line for line in lines if line)


def _escaped(text: str) -> str:
    """Escape Markdown characters outside of `code` and turn the names of pages into links."""
    parts = text.strip().split("`")
    parts[::2] = (_PAGE.sub(r"[\1](\1.md)", _MARKDOWN.sub(r"\\\1", part)) for part in parts[::2])
    return "`".join(parts)


def _usage(parser: argparse.ArgumentParser) -> str:
    if hasattr(parser, "color"):
        parser.color = False
    with patch.dict(os.environ, {"COLUMNS": _WIDTH}):
        return parser.format_usage().removeprefix("usage: ").rstrip()


def _words(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield the arguments and options as one Markdown list, without --help."""
    entries = []
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):
            continue
        text = (action.help or "") % {**vars(action), "prog": parser.prog}
        text = " ".join(text.split())
        if action.choices:
            text += f"{'; ' if text else ''}one of {', '.join(map(str, action.choices))}"
        says = f": {_escaped(text)}" if text else ""
        entries.append(f"- {_spelled(action)}{says}")
    yield "\n".join(entries)


def _spelled(action: argparse.Action) -> str:
    """Return the spellings of an argument: `-o OUT`, `--output OUT`."""
    places = action.metavar or (action.dest.upper() if not action.choices else "CHOICE")
    place = " ".join(places) if isinstance(places, tuple) else places
    if not action.option_strings:
        return f"`{place}`"
    value = "" if action.nargs == 0 else f" {place}"
    more = " …" if action.nargs in ("+", "*") else ""
    return ", ".join(f"`{word}{value}{more}`" for word in action.option_strings)


def _lines(epilog: str, name: str) -> str:
    """Return the examples of an epilog."""
    return textwrap.dedent(epilog % {"prog": name}).strip()


def _fill_in(app: Sphinx, page: str, source: list[str]) -> None:
    def commands(found: re.Match[str]) -> str:
        return reference(getattr(import_module(found[1]), found[2])())

    source[0] = MARK.sub(commands, source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Fill in the pages with a mark. Read them in every build, since parsers may have changed."""
    app.connect("source-read", _fill_in)
    app.connect(
        "env-get-outdated",
        lambda _, env, *__: [page for page in env.found_docs if _has_mark(env.doc2path(page))],
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _has_mark(path: os.PathLike[str]) -> bool:
    return bool(MARK.search(Path(path).read_text("utf-8")))
