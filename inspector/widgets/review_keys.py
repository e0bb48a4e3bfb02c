"""Whose a key is, in one place: the review's, unless a text or a number is being written.

Of a text being written are characters and what edits or copies them, of a number its figures;
every other key of the program works meanwhile, of a number also Ctrl+Z. Enter keeps what was
written, Esc brings back what stood there or clears a search, and both give the keyboard back to
the review. What goes out of sight loses the keyboard, and a wheel turns no box that does not have
it.
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

_Key = Qt.Key
_ENDS = (_Key.Key_Return, _Key.Key_Enter, _Key.Key_Escape)
_MODIFIERS = (_Key.Key_Shift, _Key.Key_Control, _Key.Key_Alt, _Key.Key_AltGr, _Key.Key_Meta)
_MOVES = (  # with whatever modifiers
    _Key.Key_Left, _Key.Key_Right, _Key.Key_Home, _Key.Key_End, _Key.Key_Backspace, _Key.Key_Delete,
)  # fmt: skip
_STEPS = (_Key.Key_Up, _Key.Key_Down, _Key.Key_PageUp, _Key.Key_PageDown)
_FIGURES = "0123456789.,+-−"
_COPYING = tuple(
    getattr(QKeySequence.StandardKey, name) for name in ("Copy", "Cut", "Paste", "SelectAll")
)
_UNDOING = QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo


class ReviewKeys(QObject):
    """Watches a window's boxes and lines; `watch` takes in what is built later."""

    def __init__(self, window: QWidget, home: Callable[[], QWidget]) -> None:
        """`home`: what has the keyboard while nothing is being written."""
        super().__init__(window)
        self._window, self._home = window, home
        self._before = ""  # of a text that has the keyboard: what stood there when it got it
        self.watch(window)
        window.installEventFilter(self)
        for dock in window.findChildren(QDockWidget):
            dock.visibilityChanged.connect(lambda on, d=dock: None if on else self._out_of_sight(d))
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        app.focusChanged.connect(self._moved_on)

    def watch(self, root: QWidget) -> None:
        """Boxes, lines and tables in a widget: the rules are theirs from now on."""
        for table in root.findChildren(QAbstractItemView):
            table.setTabKeyNavigation(False)  # Tab goes on, arrows go about in it
        boxes: list[QWidget] = [*root.findChildren(QAbstractSpinBox)]
        boxes += root.findChildren(QComboBox)
        for box in boxes:
            if box.focusPolicy() == Qt.FocusPolicy.WheelFocus:
                box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        lines = [
            e for kind in (QLineEdit, QTextEdit, QPlainTextEdit) for e in root.findChildren(kind)
        ]
        for widget in (*boxes, *lines):
            widget.removeEventFilter(self)  # installed twice, it would be asked twice
            widget.installEventFilter(self)

    def go_home(self) -> None:
        """The keyboard is the review's."""
        self._home().setFocus(Qt.FocusReason.OtherFocusReason)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Sort keys and wheel; all else goes its way."""
        kind = event.type()
        if isinstance(event, QChildEvent):
            child = event.child()
            polished = kind == QEvent.Type.ChildPolished and watched is self._window
            if polished and isinstance(child, QWidget):
                self.watch(child)  # a dialog
        elif kind == QEvent.Type.Wheel and isinstance(watched, QAbstractSpinBox | QComboBox):
            if not watched.hasFocus():
                event.ignore()  # what it lies on may scroll
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
        """Whether it has the keyboard in the window or a dock beside it: a dialog has own rules."""
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
                number.interpretText()  # what was typed counts before the review goes on
            event.ignore()
        return True

    def _end(self, watched: QObject, event: QKeyEvent) -> bool:
        if event.key() == _Key.Key_Escape:
            _restore(watched, self._before)
        elif not isinstance(watched, QAbstractSpinBox):
            watched.event(event)  # who waits for its Enter is told
        self.go_home()
        return True

    def _moved_on(self, old: QWidget | None, new: QWidget | None) -> None:
        """What had the keyboard is put away: Qt hands it on, perhaps to a line to write in."""
        if old is None or new is None or not isValid(old) or (old.isVisible() and old.isEnabled()):
            return
        if new.window() is self._window and _line(new) is not None:
            self.go_home()

    def _out_of_sight(self, dock: QDockWidget) -> None:
        focus = QApplication.focusWidget()
        if focus is not None and dock.isAncestorOf(focus):
            self.go_home()


def is_text_written() -> bool:
    """Whether the keyboard is a text's now: a letter that comes next is no decision."""
    focus = QApplication.focusWidget()
    number = isinstance(focus, QAbstractSpinBox)
    return focus is not None and not number and _line(focus) is not None


def _line(widget: QObject) -> QWidget | None:
    """Where the letters are that it has being written; None where none are."""
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
        widget.setValue(widget.value())  # not what was typed since
    elif isinstance(widget, QDoubleSpinBox):
        widget.setValue(widget.value())
    elif isinstance(widget, QComboBox):
        widget.setCurrentText(before)
    elif isinstance(widget, QLineEdit):
        # A line to search in, which can be cleared, is: then all is listed again.
        widget.setText("" if widget.isClearButtonEnabled() else before)
    elif isinstance(widget, QTextEdit | QPlainTextEdit):
        widget.setPlainText(before)


def _of_text(event: QKeyEvent) -> bool:
    control, alt = (
        bool(event.modifiers() & m)
        for m in (Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier)
    )
    character = event.text().isprintable() and event.text() and control == alt  # AltGr is both
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
