"""Write a lesson as a web page with equations, sliders and a 3D figure that works offline.

The template, the styles and the scripts of the page are in assets/lesson_page.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from inspector.language import chosen_language, texts_of_script, tr, tr_as
from inspector.lessons.lesson_file import LessonFile
from inspector.lessons.page_data import PageData
from inspector.lessons.page_texts import Formulas, markdown_html
from inspector.session.opening import Analysed, analyse_clip
from inspector.teaching.equation_table import SECTIONS
from inspector.teaching.gizmo_drawing import highlighted_gizmo_symbols
from inspector.teaching.symbols import MARKS, SYMBOLS, symbol_family_colour
from inspector.viewport.bone_colours import GHOST_ALPHA
from inspector.viewport.web_figure import PAGE_PARTS, read_page_asset, theme_data, three_js
from inspector.widgets.theme import DARK, LIGHT, Theme
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encode_utf8
from twistcore.formats.bvh import read_bvh

LARGEST = 5_000_000  # maximum size of a page in bytes
# Seconds before and after a page's frame; the first value that fits is used
_SPANS = (1.0, 0.5, 0.25, 0.1)
_ELSEWHERE = ("accepted", "tau", "listed")  # conditions that only the program can check
_SCRIPTS = (
    *("language.js", "swing_twist.js", "labels.js", "words.js", "clip_data.js"),
    *("orbit_camera.js", "gizmo.js", "striped_skin.js", "figure_view.js", "curves.js"),
    *("hand.js", "playback.js", "lesson.js"),
)


def export_page(lesson: LessonFile, path: Path) -> None:
    """Write a lesson as a web page. Raises TwistError if that fails. Thread-safe."""
    write_atomically(path, encode_utf8(page_text(lesson)))


def page_text(lesson: LessonFile, largest: int = LARGEST) -> str:
    """Return the HTML of a lesson with as many frames as fit into `largest` bytes.

    Raises TwistError if not even the fewest frames fit.
    """
    opened = cache(_opened)
    for seconds in _SPANS:
        text = _assembled(lesson, opened, seconds)
        if len(encode_utf8(text)) <= largest:
            return text
    why = tr(
        "the web page would be {size:.1f} MB, more than the limit of {most:.1f} MB. "
        "Shorten the lesson, or let several of its pages show the same frames.",
        size=len(encode_utf8(text)) / 1e6,
        most=largest / 1e6,
    )
    raise TwistError(f"{lesson.path.name}: {why}")


def _opened(clip: Path) -> Analysed:
    return analyse_clip(read_bvh(clip))


def _assembled(lesson: LessonFile, opened: Callable[[Path], Analysed], seconds: float) -> str:
    rights = [row.right for section in SECTIONS for row in section.rows]
    formulas = Formulas([*(mark.tex for mark in MARKS.values()), *rights])
    pages = [
        {
            "title": p.title,
            "body": markdown_html(p.body, formulas),
            "task": markdown_html(p.task, formulas),
        }
        for p in lesson.pages
    ]
    done_elsewhere = [any(c.name in _ELSEWHERE for c in page.done) for page in lesson.pages]
    data = PageData(lesson, opened, seconds).gathered() | _looks(formulas)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(PAGE_PARTS),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(
        tr=tr,
        language=chosen_language(),
        title=lesson.title,
        pages=[page | {"elsewhere": e} for page, e in zip(pages, done_elsewhere, strict=True)],
        sections=SECTIONS,
        symbols=SYMBOLS,
        formula=formulas.svg,
        style=Markup(_colours() + read_page_asset("page.css")),
        library=Markup(three_js()),
        scripts=[Markup(read_page_asset(name)) for name in _SCRIPTS],
        data=Markup(_json(data)),
    )


def _json(data: Any) -> str:
    """Return data as JSON for a script element, with HTML characters escaped."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _looks(formulas: Formulas) -> dict[str, Any]:
    """Return the colours of the light and the dark theme, and the labels of the gizmo."""
    return {
        "themes": {"light": _theme(LIGHT), "dark": _theme(DARK)},
        "ghost": GHOST_ALPHA,
        "words": _words(),
        "marks": {
            name: formulas.outline(mark.tex) | {"family": mark.family}
            for name, mark in MARKS.items()
        },
        "together": {name: sorted(highlighted_gizmo_symbols(name)) for name in SYMBOLS},
    }


def _words() -> dict[str, str]:
    """Return the translations of the texts in the scripts, keyed by the English text."""
    texts = {found for name in _SCRIPTS for found in texts_of_script(read_page_asset(name))}
    translated = {text: tr_as(meaning, text) for meaning, text in sorted(texts)}
    return {text: own for text, own in translated.items() if own != text}


def _theme(theme: Theme) -> dict[str, Any]:
    families = {mark.family for mark in MARKS.values()}
    own = {family: symbol_family_colour(family, theme) for family in sorted(families)}
    return theme_data(theme) | {"families": own}


def _colours() -> str:
    """Return the colours of the light and the dark theme as CSS custom properties."""

    def properties(theme: Theme) -> str:
        data = _theme(theme)
        own = data["roles"] | {f"family-{f}": c for f, c in data["families"].items()}
        return "".join(f"--{name.replace('_', '-')}:{value};" for name, value in own.items())

    dark = f"@media (prefers-color-scheme: dark){{:root{{color-scheme:dark;{properties(DARK)}}}}}"
    return f":root{{color-scheme:light;{properties(LIGHT)}}}\n{dark}\n"
