"""The pages' templates: each page is one file that needs no other and no network."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2

from twistcore.files.version import __version__

GENERATOR = "twistcore report"  # what a page says first of who wrote it


def rendered(template: str, **context: Any) -> str:
    """A page from its template; what comes from files and people is escaped."""
    return _environment().get_template(template).render(**context)


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["generator"] = f"{GENERATOR}, {__version__}"
    environment.filters |= {
        "when": _when,
        "plural": _plural,
        "degrees": _degrees,
        "href": _href,
        "thousands": _thousands,
        "rate": _rate,
    }
    return environment


def _when(stamp: str) -> str:
    """ISO 8601 as people read it, to the minute."""
    return stamp[:16].replace("T", " ") + (" UTC" if stamp.endswith(("+00:00", "Z")) else "")


def _plural(count: int, word: str, words: str = "") -> str:
    """'1 clip', '2 clips'."""
    return f"{_thousands(count)} {word if count == 1 else words or word + 's'}"


def _degrees(angle: float, decimals: int = 1) -> str:
    return f"{angle:.{decimals}f}°"


def _thousands(number: float) -> str:
    return f"{number:,.0f}"


def _rate(number: float) -> str:
    """With two figures that count, '0.35', '4.2', '2,840'."""
    return f"{number:.2g}" if 0.0 < number < 10.0 else _thousands(number)


def _href(path: str) -> str:
    """A relative path as an address."""
    return quote(os.fsencode(path))  # bytes that are no UTF-8 as they are on the disk
