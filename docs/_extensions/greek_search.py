"""Let the search find τ by "tau" and θ by "theta"."""

from __future__ import annotations

import unicodedata

import sphinx.search
from sphinx.application import Sphinx
from sphinx.search.en import SearchEnglish


def names_of_greek(word: str) -> list[str]:
    """Return the names of the Greek letters in a word: "tau" of "τ", "theta" of "θp"."""
    letters = [unicodedata.name(letter, "").split() for letter in word]
    return [name[-1].lower() for name in letters if name[:1] == ["GREEK"] and "LETTER" in name]


class EnglishWithGreek(SearchEnglish):
    """Search in English that also indexes Greek letters by name."""

    def split(self, input: str) -> list[str]:
        """Return the words of a text, followed by the names of its Greek letters."""
        words = super().split(input)
        return words + [name for word in words for name in names_of_greek(word)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Replace the plain English search."""
    sphinx.search.languages["en"] = EnglishWithGreek
    return {"parallel_read_safe": True, "parallel_write_safe": True}
