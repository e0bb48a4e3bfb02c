"""What those who do not see the teaching tab are told by a screen reader."""

import pytest
from PySide6.QtGui import QAccessible

from tests.gui.windows import act, wait_until_active

pytestmark = pytest.mark.thorough


@pytest.fixture
def teaching(qtbot, at_forearm):
    act(at_forearm, "show_teaching")
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=20_000)
    wait_until_active(at_forearm)
    at_forearm.document.select_chain("LeftArm")
    return at_forearm.teaching


def focus(qtbot, window, widget):
    """Give a widget the focus of the keys, as soon as it takes it."""

    def focused():
        window.activateWindow()
        widget.setFocus()
        return widget.hasFocus()

    qtbot.waitUntil(focused)


def heard(widget):
    told = QAccessible.queryAccessibleInterface(widget)
    return told.text(QAccessible.Text.Name), told.text(QAccessible.Text.Description)


def test_a_symbol_is_heard_with_its_meaning_and_value(qtbot, at_forearm, teaching):
    button, value = (
        of["theta_p"] for of in (teaching.equations.buttons, teaching.equations.values)
    )
    focus(qtbot, at_forearm, button)
    assert heard(button) == ("the twist of P about its bone", value.text())
    before = value.text()
    at_forearm.document.go_to(at_forearm.document.frame + 20)
    assert value.text() != before
    assert heard(button)[1] == value.text()
    teaching.what_if.reset.setFocus()
    at_forearm.document.go_to(at_forearm.document.frame + 20)
    button.setFocus()
    assert heard(button)[1] == value.text()


def test_a_slider_is_heard_with_its_value_not_its_steps(qtbot, at_forearm, teaching):
    slider = teaching.what_if.sliders["twist"]
    focus(qtbot, at_forearm, slider)
    assert heard(slider) == ("Twist parent", "0.0°")
    slider.setValue(605)
    assert heard(slider) == ("Twist parent", "+60.5°")


def test_the_plots_of_five_trackers_say_what_they_show(qtbot, at_forearm):
    act(at_forearm, "why_quaternions")
    five = at_forearm.lesson_actions.five_trackers
    five.go_to(45)
    name, told = heard(five.plots["axis-angle, raw"])
    assert "Axis-angle" in name
    assert told in five.titles["axis-angle, raw"].text()
    assert f"{five.found['axis-angle, raw'][45]:.1f}°" in told
    five.close()
