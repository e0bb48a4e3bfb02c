"""twistcore's sentences in another language: found again by their forms, whole or joined."""

import re
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inspector.bundled import FLIPPED, SAMPLE
from inspector.language import catalogue, tr, translate_core_sentence, use_language
from tests.gui.untranslated import code_texts, waits
from tests.tiers import parametrize
from twistcore import analyse, read_bvh
from twistcore.analysis.why_not import why_frame_bounds_no_interval, why_peaks_lack_interval
from twistcore.errors import TwistError
from twistcore.formats.bvh.reader import parse_bvh
from twistcore.review import Decide, Decision, LeaveOut, Redetect
from twistcore.skeleton.body import Unexamined

_ENGLISH = re.compile(r"\b(the|is|are|its|it|which|there|of|and|to|by|as|or|edge|jump)\b")


@cache
def _analysed(clip):
    return analyse(read_bvh(clip))


@pytest.fixture(autouse=True)
def german():
    """Everything here is in German, and nothing after it."""
    before = catalogue.chosen_language()
    use_language("de")
    yield
    use_language(before)


@parametrize(
    ("clip", "method", "tau"),
    [
        (SAMPLE, "consistency", None),
        (SAMPLE, "consistency", 12.0),
        (SAMPLE, "paper", None),
        (FLIPPED, "consistency", None),
        (FLIPPED, "consistency", 0.6),
    ],
)
def test_no_reason_has_words_of_english(clip, method, tau):
    """Whatever is found or not: a part of a sentence that has no form would stay English."""
    found = _analysed(clip).detect(method, tau_degrees=tau)
    frames = range(0, found.analysis.motion.frames, 5)
    for name in found.tau:
        reasons = [why_frame_bounds_no_interval(found, name, frame) for frame in frames]
        for reason in (*reasons, *why_peaks_lack_interval(found, name)):
            said = translate_core_sentence(reason.text)
            english = _ENGLISH.search(said) and not waits("de", said)
            assert not english, f"{reason.text} -> {said}"


_FORMS = sorted(
    text
    for meaning, text, _ in code_texts()
    if meaning == catalogue.CORE and not re.search(r"\}\{|^ ", text)
)


@given(st.sampled_from(_FORMS), st.integers(100, 999))
def test_a_form_is_found_again_whatever_is_put_in(form, first):
    numbers = [first + k for k in range(10)]
    entries = dict(catalogue.core_translations())
    assert translate_core_sentence(form.format(*numbers)) == entries.get(form, form).format(
        *numbers
    )


def test_what_is_joined_is_translated_part_by_part():
    assert translate_core_sentence(
        "a.bvh, line 3, column 7: expected '{' after End Site, found 'x'"
    ) == ("a.bvh, Zeile 3, Spalte 7: '{' nach End Site erwartet, 'x' gefunden")
    with pytest.raises(TwistError) as raised:
        parse_bvh(b"", "b.bvh")
    assert translate_core_sentence(raised.value) == (
        "b.bvh, Zeile 1, Spalte 1: HIERARCHY erwartet, aber die Datei ist leer"
    )
    assert translate_core_sentence(
        "Hips: the bone's direction varies by more than 1°. of my own"
    ) == ("Hips: Die Richtung des Knochens schwankt um mehr als 1°. of my own")


@pytest.mark.parametrize(
    "note",
    [
        Unexamined(
            "left arm",
            "no joint name is recognised as a hand; these names are unknown: 'X', 'Y' …",
        ),
        Unexamined("right shin", "it has no foot joint", person="B"),
        Unexamined(
            "other limbs",
            "no joint has a known name, and only 2 of the four limbs were found by shape",
        ),
        "The clip could not be examined: no arm or leg was found in its skeleton.",
        "The clip could not be examined: no joint in the arms or legs moves.",
        "The clip could not be examined: 3 frames are not enough to tell errors from motion.",
        "7 frames were not examined for twists, because the pieces between cuts that contain "
        "them are too short: 25–28, 30, 40–41.",
        "Left Arm · upper is twisted by about +60° relative to its child in every frame, compared "
        "with Right Arm.",
        "Left Leg or Right Leg is twisted by about 60° relative to its child in every frame: the "
        "sides differ.",
    ],
    ids=str,
)
def test_what_was_not_examined_has_no_words_of_english(note):
    said = translate_core_sentence(str(note))
    assert waits("de", said) or not _ENGLISH.search(said.replace("unter", "")), said


def test_a_sentence_that_nobody_knows_stays_and_english_is_as_it_was():
    assert translate_core_sentence("so (was: nobody; knows, it).") == "so (was: nobody; knows, it)."
    use_language("en")
    assert translate_core_sentence("Accept interval") == "Accept interval"


def test_steps_of_the_history_are_said():
    decide = Decide((1, 2), Decision.ACCEPTED)
    by_paper = Redetect({}, (), method="paper")
    steps = decide, Redetect({"LeftArm": 1.0}, ()), by_paper, LeaveOut(())
    assert [translate_core_sentence(step.text) for step in steps] == [
        "2 Intervalle annehmen",
        "τ von LeftArm setzen",
        "Mit dem Detektor des Artikels suchen",
        "Alle Frames für die Abstimmung verwenden",
    ]


def test_a_text_inside_another_is_found_in_the_code():
    """`f"{tr('Strength')} "` is a text, too."""
    assert ("", "Strength", "") in set(code_texts())
    assert tr("Strength") == "Stärke"


def test_whose_a_limb_is_stays_and_the_limb_is_translated():
    assert translate_core_sentence("Left Arm") == "Oberarm links"
    assert translate_core_sentence("B · Left Arm") == "B · Oberarm links"
    assert translate_core_sentence("Anna · Left arm · limb").startswith("Anna · Arm links · ")
    assert translate_core_sentence("B · Tail") == "B · Tail"
