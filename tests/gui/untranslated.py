"""Texts that wait for a translation: `python -m tests.gui.untranslated` lists them, as dev.py does.

A contributor need not know the other languages: a missing translation is a warning. Where CI is
set, as in continuous integration and before a release, it is an error.
"""

import os
import re
import sys
import warnings
from functools import cache

import polib

from inspector.bundled import LANGUAGES
from inspector.language.extraction import catalogue_entry_key, texts_in_code

ERROR = bool(os.environ.get("CI"))
_SHOWN = 5  # texts of a catalogue


def catalogue(code):
    return polib.pofile(str(LANGUAGES / f"{code}.po"))


@cache
def code_texts():
    """The keys of all texts in the code; to read the code takes seconds."""
    return tuple(texts_in_code())


@cache
def untranslated(code):
    """Keys of texts in the code that the language lacks, and of its texts that left the code."""
    entries, texts = catalogue(code), set(code_texts())
    translated = {
        catalogue_entry_key(e) for e in entries if e.translated() and not e.fuzzy and not e.obsolete
    }
    return sorted((texts - translated) | ({catalogue_entry_key(e) for e in entries} - texts))


def told(code):
    """One sentence: how many texts the language lacks, some of them, and what to do."""
    lacking = untranslated(code)
    texts = ", ".join(repr(text) for _, text, _ in lacking[:_SHOWN])
    more = ", …" if len(lacking) > _SHOWN else ""
    return (
        f"{code}.po is not up to date: {len(lacking)} texts ({texts}{more}). Run "
        "python -m inspector.language.extraction and translate the empty ones, or leave them to "
        "a translator."
    )


def assert_translated(code):
    """Fail where a text lacks its translation and CI is set; warn anywhere else."""
    if untranslated(code):
        assert not ERROR, told(code)
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            warnings.warn(told(code), stacklevel=2)


@cache
def _forms(code):
    texts = {text for _, *both in untranslated(code) for text in both if text}
    holes = [re.sub(r"\\\{[^{}]*\\\}", ".+", re.escape(text)) for text in texts]
    return re.compile("|".join(holes)) if holes else None


def waits(code, text):
    """True if the text, or a part of it, waits for a translation where that is no error."""
    forms = None if ERROR else _forms(code)
    return bool(forms and forms.search(text))


def main():
    """List what every catalogue lacks; return 1 if anything, 0 if nothing."""
    lacking = [
        code for code in sorted(f.stem for f in LANGUAGES.glob("*.po")) if untranslated(code)
    ]
    for code in lacking:
        print(("Error: " if ERROR else "Warning: ") + told(code))
    return int(bool(lacking))


if __name__ == "__main__":
    sys.exit(main())
