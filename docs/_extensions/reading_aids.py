"""Add attributes for screen readers and keyboard users that the theme leaves out."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

_FIXES = (
    # Give headings their level, and the two side columns a name.
    (re.compile(r'(<p class="caption" role="heading")>'), r'\1 aria-level="2">'),
    (re.compile(r'(<aside class="sidebar-drawer")>'), r'\1 aria-label="All pages">'),
    (re.compile(r'(<aside class="toc-drawer[^"]*")>'), r'\1 aria-label="This page">'),
    # Let the keyboard reach everything that scrolls.
    (re.compile(r'(<div class="highlight"><pre)>'), r'\1 tabindex="0">'),
    # Parameters on separate lines are not a definition list, as there are no terms.
    (re.compile(r"<dl>\n((?:<dd>(?:(?!</?d[ld]\b).)*</dd>\n)+)</dl>", re.DOTALL), "LINES"),
)


def with_aids(text: str) -> str:
    """Return a page with missing attributes added."""
    for pattern, instead in _FIXES:
        text = pattern.sub(_lines if instead == "LINES" else instead, text)
    return text


def _lines(found: re.Match[str]) -> str:
    lines = found[1].replace("<dd>", '<span class="parameter-line">').replace("</dd>", "</span>")
    return f"{lines}"


def _fix_pages(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        for page in Path(app.outdir).rglob("*.html"):
            text = page.read_text("utf-8")
            if (better := with_aids(text)) != text:
                page.write_text(better, "utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Fix all pages at the end of a build."""
    app.connect("build-finished", _fix_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
