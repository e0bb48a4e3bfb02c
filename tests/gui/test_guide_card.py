"""The card's buttons: who leads gives them, and takes them from who led before."""

import pytest
from PySide6.QtWidgets import QApplication, QPushButton

from inspector.lessons.guide_card import GuideCard, leave_button
from inspector.widgets.theme import LIGHT, Colours
from inspector.widgets.typeset import Typesetter


@pytest.fixture
def card(qtbot):
    card = GuideCard(Typesetter(), Colours(LIGHT))
    qtbot.addWidget(card)
    card.show()
    qtbot.waitExposed(card)
    return card


@pytest.fixture
def leaders(qapp):
    """Of a lesson and of an exercise: a button, a control above it, and what ends it."""
    return [
        (QPushButton(n), QPushButton(f"{n}'s control"), leave_button(n)) for n in ("one", "two")
    ]


def lead(card, leader):
    """Give the card a leader's buttons."""
    button, control, leave = leader
    card.set_buttons([button], [control], leave)


def on_screen(leader):
    """Which of a leader's buttons are seen, once Qt has done all that it put off."""
    QApplication.processEvents()
    return [w.isVisible() for w in leader]


def test_buttons_taken_out_at_once_never_come_up_as_windows(card, leaders):
    """Qt shows what was put into a layout only later: by then it may belong to nobody."""
    first, second = leaders
    lead(card, first)
    lead(card, second)
    assert (on_screen(first), on_screen(second)) == ([False] * 3, [True] * 3)
    assert [w for w in QApplication.topLevelWidgets() if w.isVisible()] == [card]


def test_who_led_before_may_lead_again(card, leaders):
    first, second = leaders
    for leader in (first, second, first):
        lead(card, leader)
        assert on_screen(leader) == [True] * 3
    assert on_screen(second) == [False] * 3
    rows = [card.controls, card._buttons, card._leave]
    assert [row.count() for row in rows] == [1, 1, 1]
