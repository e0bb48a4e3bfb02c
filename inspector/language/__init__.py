"""Translate the texts of the window, which are in English in the code.

The translations are in `assets/languages`.
"""

from inspector.language.catalogue import (
    announced,
    chosen_language,
    codes,
    in_language,
    language_to_use,
    languages,
    plural,
    tr,
    tr_as,
    use_language,
)
from inspector.language.core_sentences import of_core
from inspector.language.script_texts import texts_of_script

__all__ = [
    "announced",
    "chosen_language",
    "codes",
    "in_language",
    "language_to_use",
    "languages",
    "of_core",
    "plural",
    "texts_of_script",
    "tr",
    "tr_as",
    "use_language",
]
