"""Create the mutants of a module with mutmut's operators, for benchmarks/mutation.py.

Unlike mutmut's own command, this module also mutates properties, other decorated functions, and
constants outside functions. Each mutant is a whole source file. Strings with a blank are not
changed, because tests should not depend on the wording of sentences.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import libcst as cst
from libcst.metadata import MetadataWrapper, PositionProvider
from mutmut.mutation.file_mutation import Mutation, MutationVisitor, deep_replace
from mutmut.mutation.mutators import mutation_operators
from mutmut.mutation.pragma_handling import IgnoredCode


@dataclass(frozen=True)
class Mutant:
    """One change of a source file.

    Attributes
    ----------
    path
        The file.
    lines
        The first and last line of the change, counted from 1.
    function
        The first and last line of the enclosing function's body, or None outside functions.
    change
        The old and the new code, as text.
    source
        A function that returns the source code of the whole changed file.
    """

    path: Path
    lines: tuple[int, int]
    function: tuple[int, int] | None
    change: str
    source: Callable[[], str]

    def __str__(self) -> str:
        return f"{self.path}:{self.lines[0]}: {self.change}"


class _Visitor(MutationVisitor):
    def _skip_node_and_children(self, node: cst.CSTNode) -> bool:
        if isinstance(node, cst.FunctionDef):  # including decorated functions
            return False
        if isinstance(node, cst.SimpleString):
            return " " in node.value
        return super()._skip_node_and_children(node)


def mutants_of(path: Path) -> list[Mutant]:
    """Return all mutants of a Python file, sorted by line."""
    wrapper = MetadataWrapper(cst.parse_module(path.read_text(encoding="utf-8")))
    visitor = _Visitor(mutation_operators, IgnoredCode(set(), set(), set()))
    wrapper.visit(visitor)
    places = wrapper.resolve(PositionProvider)
    functions = []  # first line, first line of the body, last line
    for node in _below(wrapper.module):
        if isinstance(node, cst.FunctionDef):
            begin, end = places[node].start.line, places[node].end.line
            functions.append((begin, places[node.body.body[0]].start.line, end))
    made = []
    for mutation in visitor.mutations:
        place = places[mutation.original_node]
        lines = (place.start.line, place.end.line)
        around = [f for f in functions if f[0] <= lines[0] and lines[1] <= f[2]]
        old, new = (
            _text(wrapper.module, n) for n in (mutation.original_node, mutation.mutated_node)
        )
        if old != new:
            function = max(around)[1:] if around else None  # the innermost function begins last
            source = partial(_changed, wrapper.module, mutation)
            made.append(Mutant(path, lines, function, _shown(old, new), source))
    return sorted(made, key=lambda mutant: (mutant.lines, mutant.change))


def _changed(module: cst.Module, mutation: Mutation) -> str:
    changed = deep_replace(module, mutation.original_node, mutation.mutated_node)
    return cst.ensure_type(changed, cst.Module).code


def _shown(old: str, new: str, around: int = 24) -> str:
    """Return the old and the new code as text, without the parts that are equal.

    At each end, `around` equal characters remain for context.
    """
    begin = max(_alike(old, new) - around, 0)
    end = max(_alike(old[begin:][::-1], new[begin:][::-1]) - around, 0)
    first, last = ("… " if begin else ""), (" …" if end else "")
    return "  →  ".join(first + text[begin : len(text) - end] + last for text in (old, new))


def _alike(a: str, b: str) -> int:
    """Return the length of the common prefix of two strings."""
    pairs = enumerate(zip(a, b, strict=False))
    return next((i for i, (x, y) in pairs if x != y), min(len(a), len(b)))


def _text(module: cst.Module, node: cst.CSTNode) -> str:
    return " ".join(module.code_for_node(node).split())


def _below(node: cst.CSTNode) -> Iterator[cst.CSTNode]:
    yield node
    for child in node.children:
        yield from _below(child)


def files_of(names: Iterable[str]) -> list[Path]:
    """Return the Python files with these names, and all Python files in folders with these names.

    Raises ValueError for any other name.
    """
    found: list[Path] = []
    for name in map(Path, names):
        if name.is_dir():
            found += [p for p in sorted(name.glob("*.py")) if p.name != "__init__.py"]
        elif name.suffix == ".py" and name.is_file():
            found.append(name)
        else:
            raise ValueError(f"{name} is neither a Python file nor a folder of Python files")
    return found
