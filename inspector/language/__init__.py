"""The language of the window: English, as the code has it, or a catalogue of `assets/languages`."""

from inspector.language.catalogue import (
    chosen_language,
    codes,
    languages,
    plural,
    tr,
    tr_as,
    use_language,
    wished,
)
from inspector.language.core_sentences import of_core

__all__ = [
    "chosen_language",
    "codes",
    "languages",
    "of_core",
    "plural",
    "tr",
    "tr_as",
    "use_language",
    "wished",
]
