"""Render report pages as self-contained files, which need no network."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import jinja2

from twistcore.detection.kind import plural_kind_name
from twistcore.files.version import __version__

GENERATOR = "twistcore report"  # named as the generator at the start of a page


def render_page_template(template: str, **context: Any) -> str:
    """Return a template filled with values. All strings are escaped."""
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
        "kinds": plural_kind_name,
        "degrees": _degrees,
        "href": _href,
        "thousands": _thousands,
        "rate": _rate,
    }
    return environment


def _when(stamp: str) -> str:
    """Format an ISO 8601 time for display, to the minute."""
    return stamp[:16].replace("T", " ") + (" UTC" if stamp.endswith(("+00:00", "Z")) else "")


def _plural(count: int, word: str, words: str = "") -> str:
    """Return a count with its noun, such as '1 clip' or '2 clips'."""
    return f"{_thousands(count)} {word if count == 1 else words or word + 's'}"


def _degrees(angle: float, decimals: int = 1) -> str:
    return f"{angle:.{decimals}f}°"


def _thousands(number: float) -> str:
    return f"{number:,.0f}"


def _rate(number: float) -> str:
    """Format a number with two significant digits, such as '0.35', '4.2' or '2,840'."""
    return f"{number:.2g}" if 0.0 < number < 10.0 else _thousands(number)


def _href(path: str) -> str:
    """Return a relative path as the URL of a link."""
    return quote(os.fsencode(path))  # preserves bytes that are not UTF-8
