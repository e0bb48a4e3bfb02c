"""Show each table of docs/tables as a page of the site, and link to it instead of the CSV file."""

from __future__ import annotations

import csv
import html
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

TABLES = Path(__file__).resolve().parents[1] / "tables"


def cell_html(text: str) -> str:
    """Return the HTML of a cell, converting `code` in backticks and *menu names* in asterisks."""
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text))
    return re.sub(r"(?<!\w)\*([^*]+)\*(?!\w)", r"<em>\1</em>", text)


def table_html(path: Path) -> str:
    """Return the HTML of a CSV table with a header row."""
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    names = "".join(f'<th scope="col">{cell_html(text)}</th>' for text in head)
    lines = ("".join(f"<td>{cell_html(text)}</td>" for text in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    table = f"<table><thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="table-wrapper docutils container" tabindex="0">{table}</div>'


def _pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    copied = {str(file): place for file, (_, place) in app.env.dlfiles.items()}
    for path in sorted(TABLES.glob("*.csv")):
        title = path.stem.replace("-", " ")
        title = title[0].upper() + title[1:]
        place = copied[f"tables/{path.name}"]
        link = f'<p><a href="../_downloads/{place}">{path.name}</a></p>'
        body = f"<h1>{html.escape(title)}</h1>\n{link}\n{table_html(path)}"
        yield f"tables/{path.stem}", {"title": title, "body": body}, "page.html"


def _lead_to_pages(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Replace download links of tables by links to their pages."""
    if app.builder.format != "html":
        return
    for node in list(doctree.findall(addnodes.download_reference)):
        target = Path(node["reftarget"])
        if target.suffix == ".csv" and (TABLES / target.name).exists():
            uri = app.builder.get_relative_uri(page, f"tables/{target.stem}")
            link = nodes.reference("", "", *node.children, internal=True, refuri=uri)
            node.replace_self(link)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the pages and the links to them."""
    app.connect("html-collect-pages", _pages)
    app.connect("doctree-resolved", _lead_to_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
