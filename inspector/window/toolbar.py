"""The tool bar: the most frequent actions, each with an icon and, if there is room, a word."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QToolBar

from inspector.language import tr, tr_as
from inspector.widgets.icons import SIDE, has_icon, icon
from inspector.widgets.theme import Colours, Theme

_TOOLS = {  # by the action's id: the word on its button; "|": a separator
    "open_dialog": tr_as("tool", "Open"), "open_folder": tr_as("tool", "Folder"),
    "export_dialog": tr_as("tool", "Export"), "|1": "",
    "undo": tr_as("tool", "Undo"), "redo": tr_as("tool", "Redo"), "|2": "",
    "previous_interval": tr_as("tool", "Previous"), "next_interval": tr_as("tool", "Next"),
    "accept": tr_as("tool", "Accept"), "reject": tr_as("tool", "Reject"),
    "reset": tr_as("tool", "Undecided"), "|3": "",
    "loop_interval": tr_as("tool", "Loop"), "cycle_show": tr_as("tool", "Before/after"),
    "side_by_side": tr_as("tool", "Side by side"), "focus_chain": tr_as("tool", "Focus"),
}  # fmt: skip
# In a narrow window these lose their words: first what every program has, then the views.
_SPARED = (
    (),
    ("undo", "redo", "open_dialog", "open_folder"),
    ("undo", "redo", "open_dialog", "open_folder", "cycle_show", "side_by_side", "focus_chain"),
)
_Word = Qt.ToolButtonStyle


class ToolBar(QToolBar):
    """Actions as buttons, which lose their words in a narrow window."""

    def __init__(self, actions: Mapping[str, QAction], colours: Colours) -> None:
        super().__init__(tr("Tools"))
        self.setObjectName("tools")
        self.setMovable(False)
        self.setIconSize(QSize(SIDE, SIDE))
        self._actions = {name: actions[name] for name in _TOOLS if name in actions}
        for name, word in _TOOLS.items():
            if name in actions:
                actions[name].setIconText(word)
                self.addAction(actions[name])
            else:
                self.addSeparator()
        self._fitted = 0  # the width, in pixels, for which the words were chosen
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        for name, action in self._actions.items():
            if has_icon(name):
                action.setIcon(icon(name, theme))
                # A menu would show the icon instead of the tick.
                action.setIconVisibleInMenu(not action.isCheckable())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as many words as fit."""
        super().resizeEvent(event)
        if event.size().width() != self._fitted:
            self._fitted = event.size().width()
            self._fit()

    def changeEvent(self, event: QEvent) -> None:
        """Fit the words again for another font."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange) and self._fitted:
            self._fit()

    def _fit(self) -> None:
        for spared in _SPARED:
            self.setToolButtonStyle(_Word.ToolButtonTextBesideIcon)
            for name, action in self._actions.items():
                low = name in spared
                priority = QAction.Priority.LowPriority if low else QAction.Priority.NormalPriority
                if action.priority() != priority:
                    action.setPriority(priority)
            if self._needed_width() <= self.width():
                return
        self.setToolButtonStyle(_Word.ToolButtonIconOnly)

    def _needed_width(self) -> int:
        layout = self.layout()
        assert layout is not None
        layout.invalidate()
        return layout.sizeHint().width()
