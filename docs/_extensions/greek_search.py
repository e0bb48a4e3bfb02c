"""The search finds τ where somebody types "tau", and θ where somebody types "theta"."""

from __future__ import annotations

import unicodedata

import sphinx.search
from sphinx.application import Sphinx
from sphinx.search.en import SearchEnglish


def names_of_greek(word: str) -> list[str]:
    """What the Greek letters in a word are called: "tau" in "τ", "theta" in "θp"."""
    letters = [unicodedata.name(letter, "").split() for letter in word]
    return [name[-1].lower() for name in letters if name[:1] == ["GREEK"] and "LETTER" in name]


class EnglishWithGreek(SearchEnglish):
    """English, and each Greek letter by its name as well."""

    def split(self, input: str) -> list[str]:
        """The words of a text, with the names of its letters behind them."""
        words = super().split(input)
        return words + [name for word in words for name in names_of_greek(word)]


def setup(app: Sphinx) -> dict[str, bool]:
    """In place of plain English."""
    sphinx.search.languages["en"] = EnglishWithGreek
    return {"parallel_read_safe": True, "parallel_write_safe": True}
