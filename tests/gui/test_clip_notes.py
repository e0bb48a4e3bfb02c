"""Notes on a clip in the window: said once when it opens, in the chosen language."""

import pytest

from inspector.language import catalogue, translate_core_sentence, use_language
from inspector.session.opening import analyse_clip, opening_notes
from tests.twistcore.test_notation import HELD, KEYS10, TENTHS, WHOLE, noted, written


@pytest.mark.parametrize("notation", [WHOLE, HELD, KEYS10], ids=lambda n: n.name)
def test_opening_says_a_note_once(notation):
    said = " ".join(text for text, _ in opening_notes(analyse_clip(written(notation)), None, ()))
    (note,) = noted(written(notation).motion)
    assert said.count(note) == 1


def test_notes_are_translated():
    before = catalogue.chosen_language()
    use_language("de")
    try:
        said = [
            translate_core_sentence(n)
            for k in (WHOLE, TENTHS, HELD, KEYS10)
            for n in noted(written(k).motion)
        ]
    finally:
        use_language(before)
    assert (
        said[0] == "Winkel sind in ganzen Grad geschrieben: Fehler unter 3° sehen aus wie Rundung."
    )
    assert said[1].startswith("Winkel sind in Schritten von 0.1° geschrieben")
    assert said[2].startswith("Frames sind wiederholt: Die Bewegung hat 30 Frames in der Sekunde")
    assert said[3].startswith("Alle 10 Frames steht ein Schlüsselbild")
