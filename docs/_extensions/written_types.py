"""Show types and docstrings as they are in the code.

By default, Sphinx would expand `Array` to four lines of numpy types, and docutils would read |x| as
a substitution and '@x' as an e-mail address.
"""

from __future__ import annotations

import inspect
import re
from enum import Enum
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.inspect import stringify_signature
from sphinx.util.nodes import make_refnode


def _as_written(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, arguments: str, returns: str
) -> tuple[str, str] | None:
    """Return the signature's arguments and result as written, or None to use Sphinx's."""
    if not arguments or what not in ("function", "method", "class", "exception"):
        return None
    try:
        signature = inspect.signature(obj)
    except (TypeError, ValueError):
        return None
    if inspect.isclass(obj):
        if issubclass(obj, Enum) or getattr(obj, "_is_protocol", False):
            return "", ""  # these are not created by calling the class
        signature = signature.replace(return_annotation=inspect.Signature.empty)
    words = list(signature.parameters.values())
    if words and words[0].name in ("self", "cls"):
        signature = signature.replace(parameters=words[1:])
    text = stringify_signature(signature)
    arguments, _, returns = text.partition(") -> ")
    return (f"{arguments})", returns) if returns else (text, "")


def _plain_letters(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    parts = re.split(r"(`+[^`]*`+)", "\n".join(lines))
    parts[::2] = [re.sub(r"([|@])", r"\\\1", part) for part in parts[::2]]
    lines[:] = "".join(parts).split("\n")


def _by_last_name(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, text: nodes.Node
) -> nodes.Node | None:
    """Resolve an annotation to the page of its class by the last part of the name."""
    if node.get("refdomain") != "py":
        return None
    name = node["reftarget"].rpartition(".")[2]
    objects = env.domains.python_domain.objects
    found = {o.node_id: o for key, o in objects.items() if key.endswith(f".{name}")}
    if len(found) != 1:
        return None
    (place,) = found.values()
    return make_refnode(app.builder, node["refdoc"], place.docname, place.node_id, text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the functions to events of autodoc and Sphinx."""
    app.connect("autodoc-process-signature", _as_written)
    app.connect("autodoc-process-docstring", _plain_letters)
    app.connect("missing-reference", _by_last_name)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
