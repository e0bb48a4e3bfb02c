"""One window for the tests of a module: each finds it as a new window with its own clip open.

A module with `ONE_WINDOW = True` asks for this. To build a window takes half of the processor time
of most tests. A test that needs a new one (first start, settings in a file) asks `show_window`.
"""

from copy import deepcopy
from dataclasses import fields

import shiboken6
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
)

from inspector.session.settings import Settings
from inspector.widgets.late_panel import LatePanel
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from tests.gui.windows import wait_until_active


class KeptWindow:
    """The window, and how it was when it was new."""

    def __init__(self, settings: Settings, size: tuple[int, int] | None = None) -> None:
        self._settings, self._wanted = deepcopy(settings), size
        self.window = MainWindow(settings, None)
        if size is not None:
            self.window.resize(*size)
        self.window.show()
        wait_until_active(self.window)
        self._size = self.window.size()
        self._layout = self.window.saveState()
        actions = self.window.actions_by_id.values()
        self._switches = {a: a.isChecked() for a in actions if a.isCheckable()}
        self._values = _values_in(self.window)
        for area in self.window.findChildren(LatePanel):
            area.made.connect(self._note_values)

    def fits(self, settings: Settings, size: tuple[int, int] | None) -> bool:
        """Whether a new window would be the same."""
        return (self._settings, self._wanted) == (settings, size)

    def show(self) -> MainWindow:
        """Put the window in front."""
        self.window.show()
        wait_until_active(self.window)
        return self.window

    def put_away(self) -> None:
        """Undo what a test has changed, and hide the window."""
        window = self.window
        window.lesson_actions.leave_guide()
        window.player.pause()
        for other in QApplication.topLevelWidgets():
            if other is not window and other.isVisible():
                other.close()
        self._forget_decisions()
        for action, on in self._switches.items():
            if action.isChecked() != on and (on or not _is_one_of_several(action)):
                action.trigger() if action.isEnabled() else action.setChecked(on)
        for widget, value in self._values:
            if shiboken6.isValid(widget) and _value(widget) != value:
                _put(widget, value)
        for name in (field.name for field in fields(Settings)):
            setattr(window.settings, name, deepcopy(getattr(self._settings, name)))
        window.program.take_settings()
        self._forget_decisions()  # what was put back may have been a change
        window.document.close_clip()
        window.bar.clear()
        window.bar.label.setText("")  # no test takes an earlier one's message for its own
        window.statusBar().clearMessage()
        window.usual_layout.reset()
        window.restoreState(self._layout)
        window.docks["intervals"].raise_()
        window.resize(self._size)
        window.hide()
        wait(20)

    def close(self) -> None:
        """Close the window for good."""
        self._forget_decisions()
        self.window.close()
        self.window.deleteLater()
        wait(20)

    def _forget_decisions(self) -> None:
        if self.window.document.data is not None:
            self.window.document.review.mark_saved()

    def _note_values(self, panel):
        """Note how a panel is when it is new."""
        self._values += _values_in(panel)


def _values_in(part) -> list:
    kinds = QComboBox, QLineEdit, QAbstractButton
    found = [widget for kind in kinds for widget in part.findChildren(kind)]
    return [(widget, _value(widget)) for widget in found if _is_set_by_a_person(widget)]


def _is_set_by_a_person(widget) -> bool:
    if isinstance(widget, QLineEdit):
        return not isinstance(widget.parent(), QAbstractSpinBox | QComboBox)
    return isinstance(widget, QComboBox) or widget.isCheckable()


def _is_one_of_several(action) -> bool:
    return action.actionGroup() is not None and action.actionGroup().isExclusive()


def _value(widget):
    if isinstance(widget, QComboBox):
        return widget.currentIndex()
    return widget.text() if isinstance(widget, QLineEdit) else widget.isChecked()


def _put(widget, value) -> None:
    if isinstance(widget, QComboBox):
        widget.setCurrentIndex(value)
    elif isinstance(widget, QLineEdit):
        widget.setText(value)
    else:
        widget.setChecked(value)
