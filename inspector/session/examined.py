"""What of the open clip was not examined, in sentences: nothing found there means nothing."""

from __future__ import annotations

from inspector.language import of_core, plural, tr
from inspector.session.opening import Analysed


def reason_unexamined(data: Analysed | None) -> str:
    """Why nothing could be examined in a clip, as a sentence; '' where something could."""
    why = data.analysis.not_examined if data is not None else ""
    return tr("The clip could not be examined: {why}.", why=of_core(why)) if why else ""


def unexamined_sentences(data: Analysed | None) -> tuple[str, ...]:
    """A sentence for each limb that no chain examines, or one about the whole clip."""
    if data is None:
        return ()
    whole = reason_unexamined(data)
    return (whole,) if whole else tuple(of_core(str(limb)) for limb in data.analysis.unexamined)


def in_a_line(sentences: tuple[str, ...]) -> str:
    """The first sentence, and how many more there are."""
    if len(sentences) < 2:
        return "".join(sentences)
    more = plural("{n} more", "{n} more", len(sentences) - 1)
    return f"{sentences[0]} ({more})"
