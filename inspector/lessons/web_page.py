"""Write a lesson as a web page that needs no network, with equations, sliders and a 3D figure.

Its template, styles and scripts are in assets/lesson_page. The 3D library three.js is taken from
the package trimesh, whose viewer uses it.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import jinja2
from markupsafe import Markup

from inspector.bundled import ASSETS
from inspector.language import chosen_language, texts_of_script, tr, tr_as
from inspector.lessons.lesson_file import LessonFile
from inspector.lessons.page_data import PageData
from inspector.lessons.page_texts import Formulas, markdown_html
from inspector.session.opening import Analysed, analyse_clip
from inspector.teaching.equation_table import SECTIONS
from inspector.teaching.gizmo_drawing import lit_parts
from inspector.teaching.symbols import MARKS, SYMBOLS, colour
from inspector.viewport.bone_colours import GHOST_ALPHA, palette
from inspector.widgets.theme import DARK, LIGHT, Theme
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encoded
from twistcore.formats.bvh import read_bvh

LARGEST = 5_000_000  # maximum bytes of a page
_SPANS = (1.0, 0.5, 0.25, 0.1)  # seconds around a page's frame; the first that fits
_ELSEWHERE = ("accepted", "tau", "listed")  # conditions that only the program can check
_FOLDER = ASSETS / "lesson_page"
_SCRIPTS = (
    *("language.js", "swing_twist.js", "labels.js", "words.js", "clip_data.js"),
    *("orbit_camera.js", "gizmo.js", "striped_skin.js", "figure_view.js", "curves.js"),
    *("hand.js", "lesson.js"),
)
_LIBRARY_ENDS = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


def export_page(lesson: LessonFile, path: Path) -> None:
    """Write a lesson as a web page. Raises TwistError if that fails. Thread-safe."""
    write_atomically(path, encoded(page_text(lesson)))


def page_text(lesson: LessonFile, largest: int = LARGEST) -> str:
    """Return the page as HTML of at most `largest` bytes, with as many frames as possible."""
    opened = cache(_opened)
    for seconds in _SPANS:
        text = _assembled(lesson, opened, seconds)
        if len(encoded(text)) <= largest:
            return text
    why = tr(
        "its web page would take {size:.1f} MB, more than the limit of {most:.1f} MB. Use "
        "fewer pages, or let several pages show the same frames.",
        size=len(encoded(text)) / 1e6,
        most=largest / 1e6,
    )
    raise TwistError(f"{lesson.path.name}: {why}")


def three_js() -> str:
    """Return three.js from the package trimesh, with its licence.

    Raises TwistError if it is missing.
    """
    package = find_spec("trimesh")
    if package is None or package.origin is None:
        raise _without_library(tr("it is not installed"))
    try:
        with ZipFile(Path(package.origin).parent / "resources/templates/viewer.zip") as viewer:
            text = viewer.read("viewer.html.template").decode("utf-8")
        start, stop = text.index("/**\n * @license"), text.index(_LIBRARY_ENDS)
    except (OSError, KeyError, ValueError, BadZipFile):
        why = tr("the installed version does not contain it")
        raise _without_library(why) from None
    return text[start : stop + len(_LIBRARY_ENDS)]


def _without_library(why: str) -> TwistError:
    text = tr(
        "The web page of a lesson needs three.js from the Python package trimesh, but {why}. "
        "Install the version of trimesh that this program requires.",
        why=why,
    )
    return TwistError(text)


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
        loader=jinja2.FileSystemLoader(_FOLDER),
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
        style=Markup(_colours() + _read("page.css")),
        library=Markup(three_js()),
        scripts=[Markup(_read(name)) for name in _SCRIPTS],
        data=Markup(_json(data)),
    )


def _read(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")


def _json(data: Any) -> str:
    """Return data as JSON with HTML characters escaped, to put it into a script element."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _looks(formulas: Formulas) -> dict[str, Any]:
    """Return the colours of both themes, and the labels of the gizmo."""
    return {
        "themes": {"light": _theme(LIGHT), "dark": _theme(DARK)},
        "ghost": GHOST_ALPHA,
        "words": _words(),
        "marks": {
            name: formulas.outline(mark.tex) | {"family": mark.family}
            for name, mark in MARKS.items()
        },
        "together": {name: sorted(lit_parts(name)) for name in SYMBOLS},
    }


def _words() -> dict[str, str]:
    """Return the scripts' texts with their translations; untranslated texts are left out."""
    texts = {found for name in _SCRIPTS for found in texts_of_script(_read(name))}
    translated = {text: tr_as(meaning, text) for meaning, text in sorted(texts)}
    return {text: own for text, own in translated.items() if own != text}


def _theme(theme: Theme) -> dict[str, Any]:
    families = {mark.family for mark in MARKS.values()}
    return {
        "dark": theme.dark,
        "roles": _roles(theme),
        "families": {family: colour(family, theme) for family in sorted(families)},
        "palette": palette(theme).clip(0.0, 255.0).round().astype(int).tolist(),
    }


def _roles(theme: Theme) -> dict[str, str]:
    return {name: value for name, value in vars(theme).items() if isinstance(value, str)}


def _colours() -> str:
    """Return the colours of both themes as CSS properties."""

    def properties(theme: Theme) -> str:
        own = _roles(theme) | {f"family-{f}": c for f, c in _theme(theme)["families"].items()}
        return "".join(f"--{name.replace('_', '-')}:{value};" for name, value in own.items())

    dark = f"@media (prefers-color-scheme: dark){{:root{{color-scheme:dark;{properties(DARK)}}}}}"
    return f":root{{color-scheme:light;{properties(LIGHT)}}}\n{dark}\n"
