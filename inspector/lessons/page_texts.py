"""Convert the Markdown of a lesson to HTML, and its TeX to outlines, for a web page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.rules_inline import StateInline
from markdown_it.token import Token
from markupsafe import Markup, escape

from inspector.widgets.typeset import EM, formula_outlines

# SVG letter and number of points, keyed by matplotlib's path code
_LETTERS = {1: ("M", 1), 2: ("L", 1), 3: ("Q", 2), 4: ("C", 3), 79: ("Z", 1)}
_TEX = re.compile(r"\$([^$\n]+)\$(?!\$)")


class Formulas:
    """Converts TeX formulas to SVG images in the colour of the text."""

    def __init__(self, texts: Iterable[str]) -> None:
        self._known: dict[str, Any] = formula_outlines(dict.fromkeys(texts))

    def outline(self, tex: str) -> dict[str, Any]:
        """Return the outline of a formula as an SVG path, and its box (left, top, width, height).

        The y axis points down, and one em is 100 units.
        """
        vertices, codes = self._set(tex)
        corners = vertices[codes != 79]  # the code that closes a path has no point of its own
        (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
        box = [round(float(x), 1) for x in (left, -high, right - left, high - low)]
        return {"d": _path(vertices, codes), "box": box}

    def svg(self, tex: str, words: str = "") -> Markup:
        """Return a formula as an inline SVG image, aligned with the baseline of the text.

        The alternative text is `words` or, by default, the TeX source.
        """
        shape = self.outline(tex)
        left, top, wide, high = shape["box"]
        em = 1.12  # with this scale, a formula looks as large as the text around it
        size = f"width:{em * wide / EM:.3f}em;height:{em * high / EM:.3f}em"
        below = f"vertical-align:{-em * (top + high) / EM:.3f}em"
        return Markup(
            '<svg class="formula" role="img" aria-label="{}" style="{};{}" '
            'viewBox="{} {} {} {}"><path d="{}"/></svg>'
        ).format(words or tex, size, below, left, top, wide, high, shape["d"])

    def _set(self, tex: str) -> Any:
        """Return the vertices and codes of a formula's path.

        Raises ValueError if the text cannot be typeset.
        """
        if tex not in self._known:
            self._known |= formula_outlines([tex])
        if tex not in self._known:
            raise ValueError(tex)
        return self._known[tex]


def markdown_html(text: str, formulas: Formulas) -> Markup:
    """Convert Markdown to HTML. TeX between $…$ is typeset, and any HTML is escaped."""
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table").disable("image")
    markdown.validateLink = _goes_to_the_web  # type: ignore[method-assign, assignment]
    markdown.inline.ruler.before("escape", "tex", _take_tex)
    markdown.add_render_rule("tex", _tex_rule(formulas))
    return Markup(markdown.render(text))


def _goes_to_the_web(address: str) -> bool:
    """Return True for a web or mail address, and False for a script or a local file."""
    return address.startswith(("https://", "http://", "mailto:"))


def _take_tex(state: StateInline, silent: bool) -> bool:
    found = _TEX.match(state.src, state.pos)
    if found is None:
        return False
    if not silent:
        state.push("tex", "", 0).content = found[1]
    state.pos = found.end()
    return True


def _tex_rule(formulas: Formulas) -> Any:
    def rule(_renderer: object, tokens: Sequence[Token], at: int, *_: object) -> str:
        tex = tokens[at].content
        try:
            return str(formulas.svg(tex))
        except ValueError:  # the formula cannot be typeset
            return f"<code>${escape(tex)}$</code>"

    return rule


def _path(vertices: Any, codes: Any) -> str:
    """Convert a matplotlib path to an SVG path, in which the y axis points down."""
    out, at = [], 0
    while at < len(vertices):
        letter, count = _LETTERS[int(codes[at])]
        points = vertices[at : at + count] if letter != "Z" else []
        out.append(letter + " ".join(f"{x:.1f} {-y:.1f}" for x, y in points))
        at += count
    return "".join(out)
