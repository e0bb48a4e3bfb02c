"""Sentences about the parts of the open clip that were not examined."""

from __future__ import annotations

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.opening import Analysed


def reason_unexamined(data: Analysed | None) -> str:
    """Return a sentence with the reason why the whole clip could not be examined, or ''."""
    why = data.analysis.not_examined if data is not None else ""
    return (
        tr("The clip could not be examined: {why}.", why=translate_core_sentence(why))
        if why
        else ""
    )


def unexamined_sentences(data: Analysed | None) -> tuple[str, ...]:
    """Return one sentence for each limb that was not examined.

    If the whole clip was not examined, return a single sentence about the clip.
    """
    if data is None:
        return ()
    whole = reason_unexamined(data)
    return (
        (whole,)
        if whole
        else tuple(translate_core_sentence(str(limb)) for limb in data.analysis.unexamined)
    )


def one_line_summary(sentences: tuple[str, ...]) -> str:
    """Return the first sentence, followed by the number of other sentences, such as "(2 more)"."""
    if len(sentences) < 2:
        return "".join(sentences)
    more = plural("{n} more", "{n} more", len(sentences) - 1)
    return f"{sentences[0]} ({more})"
