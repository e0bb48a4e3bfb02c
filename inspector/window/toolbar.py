"""The toolbar: icons of the most frequent actions, with labels if there is room."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QToolBar

from inspector.language import tr
from inspector.widgets.icons import SIDE, has_icon, icon
from inspector.widgets.theme import Colours, Theme
from inspector.window.actions import Menus, rows

# The groups of buttons without labels: none; in a narrow window, common actions such as undo; in a
# narrower one, the views as well.
_SPARED: tuple[tuple[int, ...], ...] = ((), (1,), (1, 2))
_Word = Qt.ToolButtonStyle
_MARGIN = 2  # pixels around the buttons; the style's margin is wider


class ToolBar(QToolBar):
    """A toolbar with buttons for frequent actions. In a narrow window, some labels are hidden."""

    def __init__(self, menus: Menus, actions: Mapping[str, QAction], colours: Colours) -> None:
        super().__init__(tr("Tools"))
        self.setObjectName("tools")
        self.setMovable(False)
        self.setIconSize(QSize(SIDE, SIDE))
        tools = [(row.tool, row.id) for row in rows(menus) if row.tool is not None]
        self._tools = {name: tool for tool, name in sorted(tools, key=lambda entry: entry[0].place)}
        self._actions = {name: actions[name] for name in self._tools}
        before: int | None = None
        for name, tool in self._tools.items():
            if before is not None and before // 10 != tool.place // 10:
                self.addSeparator()
            before = tool.place
            actions[name].setIconText(tool.word)
            self.addAction(actions[name])
        self._fitted = 0  # the width, in pixels, for which the labels were chosen
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        for name, action in self._actions.items():
            if has_icon(name):
                action.setIcon(icon(name, theme))
                # If an icon were shown, a menu would show it instead of the tick.
                action.setIconVisibleInMenu(not action.isCheckable())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as many labels as fit into the new width."""
        super().resizeEvent(event)
        if event.size().width() != self._fitted:
            self._fitted = event.size().width()
            self._fit()

    def changeEvent(self, event: QEvent) -> None:
        """After a font or style change, show as many labels as fit, and restore the margins."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange and (layout := self.layout()) is not None:
            layout.setContentsMargins(*4 * (_MARGIN,))
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange) and self._fitted:
            self._fit()

    def _fit(self) -> None:
        for spared in _SPARED:
            self.setToolButtonStyle(_Word.ToolButtonTextBesideIcon)
            for name, action in self._actions.items():
                low = self._tools[name].spared in spared
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
