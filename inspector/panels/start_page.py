"""The start page, with buttons to open a clip or folder, the sample or the tour."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QBoxLayout,
    QFrame,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from inspector.language import tr
from inspector.panels.first_look_picture import FirstLookPicture
from inspector.widgets.building import hbox, hint, use_secondary_text_colour, vbox
from inspector.widgets.icons import SIDE, icon
from inspector.widgets.labels import escape_menu_text, escape_tool_tip_text
from inspector.widgets.theme import Colours, Theme

_RECENT, _FOLDERS = 5, 2  # maximum number of listed clips and folders
_PARTS = 4  # maximum number of parts of a folder's path
_LONGEST = 48  # maximum number of letters of a name
_WIDTH = 520  # pixels: width of the column
_APART = 8  # pixels between the buttons
_MARGIN = 12  # pixels at the sides of the column
_FIRST = {"tour": tr("Tour (6 minutes)"), "open_sample": tr("Try the sample")}
_OWN = {"open_dialog": tr("Open…"), "open_folder": tr("Open folder…")}


class StartPage(QScrollArea):
    """The page that covers the 3D view while no clip is open. It also lists recent files."""

    def __init__(
        self,
        view: QWidget,
        actions: Mapping[str, QAction],
        open_path: Callable[[Path], None],
        complaint: str,
        colours: Colours,
    ) -> None:
        """Build the page.

        Parameters
        ----------
        view
            The widget that the page covers.
        actions
            The window's actions, keyed by id.
        open_path
            A function that opens a clip or a folder.
        complaint
            The reason why there is no 3D view, or ''.
        """
        super().__init__(view)
        self.setObjectName("start")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self._open_path = open_path
        self.title = QLabel(tr("Open a motion clip"), alignment=Qt.AlignmentFlag.AlignHCenter)
        self.title.setObjectName("start_title")
        offered = (*_FIRST.items(), *_OWN.items())
        self.buttons = {name: _button(actions[name], text) for name, text in offered}
        self._rows = [
            hbox(*(self.buttons[name] for name in names), spacing=_APART)
            for names in (_FIRST, _OWN)
        ]
        first, own = (hbox(None, row, None) for row in self._rows)
        self._heading = use_secondary_text_colour(
            QLabel(tr("Recent"), alignment=Qt.AlignmentFlag.AlignHCenter)
        )
        self._recent = QVBoxLayout()
        self._recent.setSpacing(0)
        drop = hint(tr("or drop a clip, a session or a folder here."))
        column = QWidget()
        column.setMaximumWidth(_WIDTH)
        vbox(
            None, self.title, 6, first, 2, own, 2, drop, 10, self._heading, self._recent,
            *([hint(complaint)] if complaint else []), None,
            owner=column, margins=(_MARGIN, 4, _MARGIN, 4), spacing=4,
        )  # fmt: skip
        page = QWidget()
        page.setObjectName("start_page")
        box = hbox(owner=page, margins=(0, 0, 0, 0))
        box.addWidget(column)
        self.setWidget(page)
        self.picture = FirstLookPicture(self, colours)
        view.installEventFilter(self)
        self.setGeometry(view.rect())
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        for name, button in self.buttons.items():
            button.setIcon(icon(name, theme))
        self._folder_icon = icon("open_folder", theme)
        for button in self.findChildren(QPushButton, "recent_folder"):
            button.setIcon(self._folder_icon)

    def show_recent(self, clips: Sequence[Path], folders: Sequence[Path] = ()) -> None:
        """List the recent folders and then the recent clips, each with the most recent first."""
        while item := self._recent.takeAt(0):
            if widget := item.widget():
                widget.hide()
                widget.deleteLater()
        for path in (*folders[:_FOLDERS], *clips[:_RECENT]):
            button = QPushButton(_short_path(path), flat=True)
            button.setObjectName("recent")
            if path in folders:
                button.setObjectName("recent_folder")
                button.setIcon(self._folder_icon)
            button.setToolTip(escape_tool_tip_text(str(path)))
            button.clicked.connect(partial(self._open, path))
            self._recent.addWidget(button, 0, Qt.AlignmentFlag.AlignHCenter)
        self._heading.setVisible(bool(clips or folders))

    def _open(self, path: Path, _checked: bool = False) -> None:
        self._open_path(path)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Resize the page together with the view that it covers."""
        view = self.parentWidget()
        if view is not None and watched is view and event.type() == QEvent.Type.Resize:
            self.setGeometry(view.rect())
            self.picture.setGeometry(self.rect())
            self._arrange(view.width())
        return super().eventFilter(watched, event)

    def _arrange(self, width: int) -> None:
        """Arrange the buttons in a row or, in a narrow window, one below the other."""
        sides = 2 * _MARGIN + self.verticalScrollBar().sizeHint().width()
        widths = [[self.buttons[k].sizeHint().width() + _APART for k in r] for r in (_FIRST, _OWN)]
        fits, way = max(map(sum, widths)) + sides <= width, QBoxLayout.Direction
        for row in self._rows:
            row.setDirection(way.LeftToRight if fits else way.TopToBottom)
            row.setSpacing(_APART if fits else _APART // 3)


def _button(action: QAction, text: str) -> QPushButton:
    button = QPushButton(text)
    button.setIconSize(QSize(SIDE, SIDE))
    keys = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
    button.setToolTip(f"{action.statusTip()} ({keys})" if keys else action.statusTip())
    button.clicked.connect(lambda _=False: action.trigger())
    return button


def _short_path(path: Path) -> str:
    """Return the name and the folder of a file. '…' replaces the middle of a long path."""
    home, folder = Path.home(), path.parent
    parts = ("~", *folder.relative_to(home).parts) if folder.is_relative_to(home) else folder.parts
    if len(parts) > _PARTS:
        parts = (*parts[:2], "…", *parts[-2:])
    name = path.name if len(path.name) <= _LONGEST else f"{path.name[:_LONGEST]}…"
    return escape_menu_text(f"{name}   ({Path(*parts)})")
