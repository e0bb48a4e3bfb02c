"""Texts that somebody may have written to have them obeyed, by what shows, opens or runs them."""

from __future__ import annotations

import os
from pathlib import Path

CHAINED = 12  # joints that chains are made of
_FRAMES = 200
_OF_CHAINS = ("Arm", "Leg")

# In every text of HTML there is a tag <s>: nothing in the program is struck out, so that its being
# so anywhere tells that a text was taken for HTML. {trap} is a file that nothing may open.
HTML = (
    '<img src="file://{trap}"><s>img</s>',
    "<s>struck out</s>",
    "<b><s>bold</s></b> more",
    '<a href="javascript:alert(1)"><s>link</s></a>',
    '<a href="file://{trap}"><s>file</s></a>',
    '<table background="file://{trap}"><tr><td><s>cell</s></td></tr></table>',
    "<p style='background-image:url(file://{trap})'><s>style</s></p>",
    '<link rel="stylesheet" href="file://{trap}"><s>sheet</s>',
    "<script>window.hostile=1</script><s>script</s>",
    "</script></style></title><script>window.hostile=1</script><s>ends</s>",
    '<img src=x onerror="window.hostile=1"><s>error</s>',
    "<svg onload='window.hostile=1'><s>svg</s></svg>",
    '"><script>window.hostile=1</script><s>attribute</s>',
    "' onmouseover='window.hostile=1'><s>quote</s>",
    "--><!--<s>comment</s>-->",
    "]]><s>cdata</s><![CDATA[",
    "&lt;s&gt;entities&lt;/s&gt; &amp;",
    "<qt><s>qt</s></qt>",
    "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY e SYSTEM 'file://{trap}'>]><s>&e;</s>",
    "{{ 7*7 }} {% raw %} <s>template</s>",
    "![x](file://{trap}) [x](javascript:window.hostile=1) <s>markdown</s>",
)
FORMULAE = (
    "=1+1",
    "=cmd|' /C calc'!A0",
    '=HYPERLINK("http://127.0.0.1:9/","x")',
    "+1-2",
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "x;=1+1",
    "\uff1d1+1",
)
TERMINAL = (
    "\x1b[31mred\x1b[0m",
    "\x1b]0;title\x07",
    "\x1b[2J\x1b[H",
    "\x9b31m\x90q\x9c",
    "a\rb\bc\x7f",
    "one\ntwo\u2028three\x85four",
)
UNICODE = (
    "\u202egnp.exe\u202c",
    "\u2066a\u2069\u200fb\u061c",
    "zero\u200bwidth\ufeff",
    "e\u0301\u0301\u0301 \U0001f468\u200d\U0001f469",
    "bytes \udcff\udc80 of none",
    "\ufffe\uffff\U0010ffff",
)
PROGRAMS = (
    "%s %n %d %1 %p",
    "{0} {x.__class__} {text.__init__}",
    "&File && &x",
    "$(touch hostile) `touch hostile`; touch hostile | touch hostile",
    "'; touch hostile #",
    '"""\nraise SystemExit(99)\n"""',
    "' + str(1/0) + '",
    "\\N{BULLET} \\x41 \\",
    "$\\frac{a}{$ $x^2$ \\input{hostile}",
    "[*] [*] name[*]",
)
PATHS = (
    "../hostile",
    "/hostile-absolute",
    "..\\hostile",
    "C:\\hostile",
    "file:///hostile",
    "http://127.0.0.1:9/hostile",
    "-o",
    "~root",
    "CON",
    ".",
)
LONG = ("n" * 5000, "<s>" * 2000)


def hostile_texts(trap: str = "/nonexistent/trap") -> tuple[str, ...]:
    """All of them; trap: the path of a file that nothing may open."""
    made = tuple(text.replace("{trap}", trap) for text in HTML)
    return (*made, *FORMULAE, *TERMINAL, *UNICODE, *PROGRAMS, *PATHS, *LONG)


def as_joint(text: str) -> str:
    """The text as a name in a BVH file may have it: on a line, no brace, no space at the ends."""
    ends = dict.fromkeys(map(ord, "\n\r\v\f\x1c\x1d\x1e\x85\u2028"), "\N{NO-BREAK SPACE}")
    name = text.translate(ends | {ord("{"): "(", ord("}"): ")", 0: None})
    return name.strip() or "joint"


def as_file_name(text: str, longest: int = 200) -> str:
    """The text as the name of a file on Linux: no '/', no NUL, so many bytes at most."""
    name = text.replace("/", "\N{FRACTION SLASH}").replace("\x00", "")
    while len(name.encode("utf-8", "surrogateescape")) > longest:
        name = name[: len(name) * 2 // 3]
    return name if name.strip(". ") else f"name{name}"


# -- clips whose names they are --------------------------------------------------------------------


def shares(rotations: int = 1) -> list[int]:
    """Where a clip begins in the texts; with TWIST_INSPECTOR_TEXTS=all so that all have a turn."""
    count = len(hostile_texts())
    if os.environ.get("TWIST_INSPECTOR_TEXTS") == "all":
        return list(range(0, count, CHAINED))
    return [k * count // rotations for k in range(rotations)]


def hostile_clip(source: Path, target: Path, begin: int, trap: str) -> list[str]:
    """Its first frames with other names of joints, those of chains first; gives the names.

    begin: number of the text that the first joint is called by.
    """
    texts = hostile_texts(trap)
    lines = source.read_text("utf-8").split("\n")
    motion = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    lines[motion:] = [f"Frames: {_FRAMES}", *lines[motion + 1 : motion + 2 + _FRAMES], ""]
    named = [k for k, line in enumerate(lines) if line.split()[:1] in (["JOINT"], ["ROOT"])]
    named.sort(key=lambda k: not any(word in lines[k] for word in _OF_CHAINS))
    names = []
    for number, k in enumerate(named):
        names.append(as_joint(texts[(begin + number) % len(texts)]))
        head, name = lines[k].split()
        lines[k] = lines[k].replace(f"{head} {name}", f"{head} {names[-1]}")
    target.write_bytes("\n".join(lines).encode("utf-8", "surrogateescape"))
    return names
