"""Translate the texts of the window, which are in English in the code.

The translations are in `assets/languages`.
"""

from inspector.language.catalogue import (
    chosen_language,
    language_codes,
    language_to_use,
    languages,
    plural,
    tr,
    tr_as,
    translate_declared_text,
    translated_page_path,
    use_language,
)
from inspector.language.core_sentences import translate_core_sentence
from inspector.language.script_texts import texts_of_script

__all__ = [
    "chosen_language",
    "language_codes",
    "language_to_use",
    "languages",
    "plural",
    "texts_of_script",
    "tr",
    "tr_as",
    "translate_core_sentence",
    "translate_declared_text",
    "translated_page_path",
    "use_language",
]
