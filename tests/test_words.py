"""Ratchet for plain English: words of docs/contributing/words.md to avoid become only fewer.

python -m tests.test_words FILE…      list the words to replace in these files
python -m tests.test_words --lower    write today's counts where they are lower
"""

from __future__ import annotations

import ast
import io
import json
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
COUNTS = Path(__file__).with_name("words.txt")
FOLDERS = ("twistcore", "inspector", "docs")
FILES = ("README.md", "CONTRIBUTING.md", "dev.py")
AVOIDED = re.compile(
    r"\b(told|beside|otherwise|unasked|anew|mend(?:s|ed|ing)?|whoever|whatever|thereby"
    r"|stands(?! for)|those\s+that|that\s+of|what\s+is)\b",
    re.IGNORECASE,
)
PRONOUN_FIRST = re.compile(r"\s*(It|They|This)\b")
CODE = re.compile(r"^( *)```.*?^\1```+ *$|`[^`\n]+`", re.DOTALL | re.MULTILINE)
QUOTE = re.compile(r"""(?:\b[bfru]{1,2})?["']+""", re.IGNORECASE)
QUOTED_PRONOUN = re.compile(r"""["']\\?\s*(It|They|This)\b""")


class Prose(NamedTuple):
    """A piece of prose, where it begins, and whether it is a docstring."""

    line: int
    text: str
    is_docstring: bool = False


def python_prose(source: str) -> Iterator[Prose]:
    """Yield docstrings, comments and string literals with a blank in them, but no identifiers."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    tree = ast.parse(source)
    docstrings = {
        node.body[0].value
        for node in ast.walk(tree)
        if isinstance(node, kinds) and node.body and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield Prose(node.lineno, node.value, node in docstrings)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield Prose(token.start[0], token.string)


def may_have_words(source: str) -> bool:
    """Return False if no string and no comment of the source can have a word to avoid.

    A string may be split between two words, so quotes are left out.
    """
    text = QUOTE.sub("", source.replace("\\n", " ").replace("\\", ""))
    return bool(AVOIDED.search(text) or QUOTED_PRONOUN.search(source))


def prose_of(path: Path) -> Iterator[Prose]:
    """Yield the prose of a Python, Markdown or notebook file."""
    text = path.read_text("utf-8")
    if path.suffix == ".py":
        if may_have_words(text):  # to parse all files takes seconds
            yield from python_prose(text)
    elif path.suffix == ".ipynb":
        for cell in json.loads(text)["cells"]:
            if cell["cell_type"] == "markdown":
                yield Prose(1, "".join(cell["source"]))
    else:
        yield Prose(1, text)


def avoided_words(prose: Prose) -> Iterator[tuple[int, str]]:
    """Yield line and word of everything to replace; code in backticks is left out."""
    text = CODE.sub(lambda found: re.sub(r"[^\n]", "·", found[0]), prose.text)
    places = [(found.start(), found[1]) for found in AVOIDED.finditer(text)]
    if prose.is_docstring and (first := PRONOUN_FIRST.match(text)):
        places.append((0, f"{first[1]} … (first word of a docstring)"))
    for place, word in sorted(places):
        yield prose.line + text.count("\n", 0, place), " ".join(word.split())


def words_of(path: Path) -> list[tuple[int, str]]:
    """Return line and word of everything to replace in a file."""
    return sorted(place for prose in prose_of(path) for place in avoided_words(prose))


def watched_files() -> list[Path]:
    """Return all files whose prose is counted."""
    files = [ROOT / name for name in FILES]
    for folder in FOLDERS:
        files += [p for p in (ROOT / folder).rglob("*") if p.suffix in (".py", ".md", ".ipynb")]
    return sorted(p for p in files if ".ipynb_checkpoints" not in p.parts)


def read_counts() -> dict[str, int]:
    """Return the stored counts by file."""
    lines = COUNTS.read_text("utf-8").splitlines() if COUNTS.exists() else []
    return {name: int(count) for count, name in (line.split(maxsplit=1) for line in lines)}


def counts_now() -> dict[str, int]:
    """Return today's counts of the files that have any."""
    counts = {path.relative_to(ROOT).as_posix(): len(words_of(path)) for path in watched_files()}
    return {name: count for name, count in counts.items() if count}


def risen(stored: dict[str, int], now: dict[str, int], there: set[str]) -> list[str]:
    """Return the files whose count has risen.

    New files may have as many together as vanished files had: a file may be moved or split.
    """
    worse = [name for name, count in now.items() if name in stored and count > stored[name]]
    new = [name for name in now if name not in stored and name in there]
    vanished = sum(count for name, count in stored.items() if name not in there)
    return worse + (new if sum(now[name] for name in new) > vanished else [])


def all_names() -> set[str]:
    """Return the names of all watched files."""
    return {path.relative_to(ROOT).as_posix() for path in watched_files()}


def test_words_to_avoid_become_fewer() -> None:
    worse = risen(read_counts(), counts_now(), all_names())
    lines = [f"{name}:{line}: {word}" for name in worse for line, word in words_of(ROOT / name)]
    assert not worse, "\n".join([*lines, "see docs/contributing/words.md for better words"])


def test_names_and_code_are_no_prose(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    path.write_text(
        '"""It counts."""\ntold = {"beside": 1}  # whoever reads\nx = f"what is {told}"\n'
        'def f():\n    """Return `anew` the sum.\n\n    As those\n    that stand.\n    """\n'
    )
    assert [word for _, word in words_of(path)] == [
        "It … (first word of a docstring)",
        "whoever",
        "what is",
        "those that",
    ]
    page = tmp_path / "page.md"
    page.write_text("# Beside\n\n```sh\ntold\n```\n\nWhat\nis `mend`?\n")
    assert words_of(page) == [(1, "Beside"), (7, "What is")]


def test_a_file_may_move_but_not_grow() -> None:
    assert risen({"a": 2}, {"b": 1, "c": 1}, {"b", "c"}) == []
    assert risen({"a": 2}, {"b": 1, "c": 2}, {"b", "c"}) == ["b", "c"]
    assert risen({"a": 2}, {"a": 3}, {"a"}) == ["a"]
    assert risen({}, {"new": 1}, {"new"}) == ["new"]


def lower() -> None:
    """Write today's counts; a count that has risen stays as it was."""
    stored, now = read_counts(), counts_now()
    worse = set(risen(stored, now, all_names())) if stored else set()
    kept = {name: stored.get(name, 0) if name in worse else count for name, count in now.items()}
    text = "".join(f"{count:4d} {name}\n" for name, count in sorted(kept.items()) if count)
    COUNTS.write_text(text, "utf-8")
    print(f"{sum(stored.values())} → {sum(kept.values())} words")


if __name__ == "__main__":
    if sys.argv[1:] == ["--lower"]:
        lower()
    for name in sys.argv[1:]:
        if name != "--lower":
            for line, word in words_of(Path(name)):
                print(f"{name}:{line}: {word}")
