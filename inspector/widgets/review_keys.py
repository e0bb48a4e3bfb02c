"""Decide whether a pressed key is a shortcut of the program or input for a field.

- A text field receives characters and the keys for editing and copying.
- A number field receives digits. Ctrl+Z in a number field undoes a step of the review.
- All other shortcuts of the program still work while a field has the focus.
- Enter applies the input, and Esc restores the previous text or clears a search. Both keys return
  the focus to the review.
- A widget that is hidden loses the focus.
- The mouse wheel changes only a field that has the focus.
"""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QChildEvent, QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QDoubleSpinBox,
    QLineEdit,
    QPlainTextEdit,
    QSpinBox,
    QTextEdit,
    QWidget,
)
from shiboken6 import isValid

from inspector.widgets.late_panel import LatePanel

_Key = Qt.Key
_ENDS = (_Key.Key_Return, _Key.Key_Enter, _Key.Key_Escape)
_MODIFIERS = (_Key.Key_Shift, _Key.Key_Control, _Key.Key_Alt, _Key.Key_AltGr, _Key.Key_Meta)
_MOVES = (  # keys that edit text, with any modifiers
    _Key.Key_Left, _Key.Key_Right, _Key.Key_Home, _Key.Key_End, _Key.Key_Backspace, _Key.Key_Delete,
)  # fmt: skip
_STEPS = (_Key.Key_Up, _Key.Key_Down, _Key.Key_PageUp, _Key.Key_PageDown)
_FIGURES = "0123456789.,+-−"
_COPYING = tuple(
    getattr(QKeySequence.StandardKey, name) for name in ("Copy", "Cut", "Paste", "SelectAll")
)
_UNDOING = QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo


class ReviewKeys(QObject):
    """An event filter for the keys that are pressed in the input fields of a window.

    Call `watch` for widgets that are built later.
    """

    def __init__(self, window: QWidget, home: Callable[[], QWidget]) -> None:
        """Watch all input fields of a window.

        `home` is a function that returns the widget that gets the focus after typing.
        """
        super().__init__(window)
        self._window, self._home = window, home
        self._before = ""  # the text of the focused widget when it got the focus
        self.watch(window)
        window.installEventFilter(self)
        for late in window.findChildren(LatePanel):
            late.made.connect(self.watch)
        for dock in window.findChildren(QDockWidget):
            dock.visibilityChanged.connect(lambda on, d=dock: None if on else self._out_of_sight(d))
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        app.focusChanged.connect(self._focus_changed)

    def watch(self, root: QWidget) -> None:
        """Watch all input fields and tables inside a widget."""
        for table in root.findChildren(QAbstractItemView):
            table.setTabKeyNavigation(False)  # Tab leaves the table, and arrow keys move inside it
        boxes: list[QWidget] = [*root.findChildren(QAbstractSpinBox)]
        boxes += root.findChildren(QComboBox)
        for box in boxes:
            if box.focusPolicy() == Qt.FocusPolicy.WheelFocus:
                box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        lines = [
            e for kind in (QLineEdit, QTextEdit, QPlainTextEdit) for e in root.findChildren(kind)
        ]
        for widget in (*boxes, *lines):
            widget.removeEventFilter(self)  # prevent a second installation
            widget.installEventFilter(self)

    def return_focus(self) -> None:
        """Move the focus from an input field back to the review."""
        self._home().setFocus(Qt.FocusReason.OtherFocusReason)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle keys and the mouse wheel, and pass on all other events."""
        kind = event.type()
        if isinstance(event, QChildEvent):
            child = event.child()
            polished = kind == QEvent.Type.ChildPolished and watched is self._window
            if polished and isinstance(child, QWidget):
                self.watch(child)  # the child is a dialog
        elif kind == QEvent.Type.Wheel and isinstance(watched, QAbstractSpinBox | QComboBox):
            if not watched.hasFocus():
                event.ignore()  # the widget below the field may scroll
                return True
        elif kind == QEvent.Type.FocusIn and _line(watched) is not None:
            self._before = _text(watched)
        elif isinstance(event, QKeyEvent) and self._is_here(watched):
            if kind == QEvent.Type.ShortcutOverride:
                return self._sort(watched, event)
            if kind == QEvent.Type.KeyPress and event.key() in _ENDS:
                return self._end(watched, event)
        return False

    def _is_here(self, watched: QObject) -> bool:
        """Return True if an input field in the window or in a floating dock has the focus.

        Fields in dialogs do not count.
        """
        if not isinstance(watched, QWidget) or not watched.hasFocus() or _line(watched) is None:
            return False
        return watched.window() is self._window or isinstance(watched.window(), QDockWidget)

    def _sort(self, watched: QObject, event: QKeyEvent) -> bool:
        if event.key() in _MODIFIERS:
            return False
        number = watched if isinstance(watched, QAbstractSpinBox) else None
        own = _of_text(event) if number is None else _of_number(event)
        if event.key() in _ENDS or own:
            event.accept()
        else:
            if number is not None:
                number.interpretText()  # apply the typed number before the action of the review
            event.ignore()
        return True

    def _end(self, watched: QObject, event: QKeyEvent) -> bool:
        if event.key() == _Key.Key_Escape:
            _restore(watched, self._before)
        elif not isinstance(watched, QAbstractSpinBox):
            watched.event(event)  # lets the line handle Enter itself
        self.return_focus()
        return True

    def _focus_changed(self, old: QWidget | None, new: QWidget | None) -> None:
        """Return the focus to the review if Qt moved it from a hidden widget to an input field."""
        if old is None or new is None or not isValid(old) or (old.isVisible() and old.isEnabled()):
            return
        if new.window() is self._window and _line(new) is not None:
            self.return_focus()

    def _out_of_sight(self, dock: QDockWidget) -> None:
        focus = QApplication.focusWidget()
        if focus is not None and dock.isAncestorOf(focus):
            self.return_focus()


def is_typing_text() -> bool:
    """Return True if the user is typing text. Letters must then not act as shortcuts."""
    focus = QApplication.focusWidget()
    number = isinstance(focus, QAbstractSpinBox)
    return focus is not None and not number and _line(focus) is not None


def _line(widget: QObject) -> QWidget | None:
    """Return the text field of a widget, or None if the user cannot type into it."""
    if isinstance(widget, QAbstractSpinBox):
        return None if widget.isReadOnly() else widget
    if isinstance(widget, QComboBox):
        return widget.lineEdit()
    if isinstance(widget, QLineEdit | QTextEdit | QPlainTextEdit):
        return None if widget.isReadOnly() else widget
    return None


def _text(widget: QObject) -> str:
    if isinstance(widget, QComboBox):
        return widget.currentText()
    if isinstance(widget, QLineEdit | QAbstractSpinBox):
        return widget.text()
    return widget.toPlainText() if isinstance(widget, QTextEdit | QPlainTextEdit) else ""


def _restore(widget: QObject, before: str) -> None:
    if isinstance(widget, QSpinBox):
        widget.setValue(widget.value())  # discards the typed text
    elif isinstance(widget, QDoubleSpinBox):
        widget.setValue(widget.value())
    elif isinstance(widget, QComboBox):
        widget.setCurrentText(before)
    elif isinstance(widget, QLineEdit):
        # A search line has a clear button, and is cleared.
        widget.setText("" if widget.isClearButtonEnabled() else before)
    elif isinstance(widget, QTextEdit | QPlainTextEdit):
        widget.setPlainText(before)


def _of_text(event: QKeyEvent) -> bool:
    control, alt = (
        bool(event.modifiers() & m)
        for m in (Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier)
    )
    # AltGr counts as both Ctrl and Alt
    character = event.text().isprintable() and event.text() and control == alt
    standard = any(event.matches(k) for k in (*_COPYING, *_UNDOING))
    return bool(character) or standard or event.key() in (*_MOVES, _Key.Key_Up, _Key.Key_Down)


def _of_number(event: QKeyEvent) -> bool:
    plain = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier in (
        Qt.KeyboardModifier.NoModifier,
        Qt.KeyboardModifier.ShiftModifier,
    )
    figure = plain and event.text() and event.text() in _FIGURES
    moves = plain and event.key() in (*_MOVES, *_STEPS)
    return bool(figure or moves) or any(event.matches(k) for k in _COPYING)
