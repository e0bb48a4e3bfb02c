"""Configuration of the documentation site: `python3 dev.py docs`. F1 shows the same pages.

Pages are therefore plain Markdown; only index.md, cli.md and api/ use features of the site.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pygments.lexers.data import JsonLexer

if TYPE_CHECKING:
    from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS.parent), str(DOCS / "_extensions")]

from twistcore.files.version import __version__  # noqa: E402  # once the checkout is on the path

project = "Twist Inspector"
author = "Twist Inspector developers"
release = version = __version__
language = "en"

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "myst_nb",
    "sphinx_copybutton",
    "command_reference",
    "greek_search",
    "mathml",
    "reading_aids",
    "table_pages",
    "written_types",
]
exclude_patterns = ["_*", "**.ipynb_checkpoints"]
nitpicky = True
smartquotes = False  # the text already has typographic characters, and `--json` two hyphens

# --- pages -----------------------------------------------------------------------------------

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4  # the same anchors as on GitHub and in the window
# Notebooks are stored without results and run again whenever they change. Tests that need only the
# pages turn this off; tests/test_notebooks.py checks that they run.
nb_execution_mode = "cache"
nb_execution_cache_path = str(DOCS.parent / "build" / "notebooks")
nb_execution_timeout = 180
nb_execution_raise_on_error = True
nb_merge_streams = True

# --- the API, from docstrings --------------------------------------------------------------------

default_role = "code"  # docstrings write `name`, as Markdown does
autosummary_generate = False
napoleon_google_docstring = False
napoleon_use_param = napoleon_use_rtype = False  # a shape is not a link
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # written_types.py adds them
autodoc_preserve_defaults = True
autodoc_use_type_comments = False
autodoc_inherit_docstrings = False
python_display_short_literal_types = True
add_module_names = False
toc_object_entries_show_parents = "hide"
maximum_signature_line_length = 80
# Types of the standard library and numpy are not links, since no inventory is downloaded for them.
nitpick_ignore_regex = [("py:(class|data|obj)", r"(?!twistcore\.).*")]

# --- looks ---------------------------------------------------------------------------------------

html_theme = "furo"  # one column of text, light or dark as the system, system fonts
html_title = f"Twist Inspector {version}"
html_logo = html_favicon = "../assets/icons/program.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True, "top_of_page_buttons": []}
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True

# --- links, checked only by `dev.py docs --links` ------------------------------------------------

linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_allowed_redirects = {r"https://doi\.org/.*": r".*"}


def setup(app: Sphinx) -> None:
    """Add the JSON lines lexer and make links to files outside docs/ work."""
    app.add_lexer("jsonl", JsonLexer)
    app.connect("source-read", _offer_files_outside)


def _offer_files_outside(app: Sphinx, page: str, source: list[str]) -> None:
    """Turn links to files outside docs/ into links that open these files."""
    source[0] = re.sub(r"(?<=\]\()(?=(?:\.\./)+[^)]*\.md\))", "path:", source[0])
