"""File dialogs that do not block the rest of the program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon, QPainter, QPalette
from PySide6.QtWidgets import QFileDialog, QToolButton, QWidget

_ARROWS = ("backButton", "forwardButton", "toParentButton")


def ask_files(
    parent: QWidget,
    title: str,
    pattern: str,
    then: Callable[[Sequence[Path]], object],
    *,
    folder: Path | None = None,
    several: bool = False,
) -> None:
    """Let the user choose an existing file or several files, and call `then` with their paths.

    `pattern` is the file filter, such as '*.json', and `folder` is the initial folder. If
    `several` is True, the user can choose more than one file.
    """
    mode = QFileDialog.FileMode
    dialog = _dialog(parent, title, pattern, mode.ExistingFiles if several else mode.ExistingFile)
    if folder is not None:
        dialog.setDirectory(str(folder))
    dialog.filesSelected.connect(lambda names: then([Path(name) for name in names]))
    dialog.open()


def ask_save_path(
    parent: QWidget,
    title: str,
    pattern: str,
    then: Callable[[Path], object],
    *,
    wanted: Path,
    suffix: str = "",
) -> None:
    """Let the user choose a file to write, and call `then` with its path.

    `wanted` is the proposed path. `suffix` is appended to a file name without a suffix.
    """
    dialog = _dialog(parent, title, pattern, QFileDialog.FileMode.AnyFile)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setDefaultSuffix(suffix)
    dialog.selectFile(str(wanted))
    dialog.fileSelected.connect(lambda name: then(Path(name)))
    dialog.open()


def ask_folder(parent: QWidget, title: str, then: Callable[[Path], object], *, start: Path) -> None:
    """Let the user choose an existing folder, and call `then` with its path.

    `start` is the folder that the dialog shows first.
    """
    dialog = _dialog(parent, title, "", QFileDialog.FileMode.Directory)
    dialog.setDirectory(str(start))
    dialog.setOption(QFileDialog.Option.ShowDirsOnly)
    dialog.fileSelected.connect(lambda name: then(Path(name)))
    dialog.open()


def _dialog(parent: QWidget, title: str, pattern: str, mode: QFileDialog.FileMode) -> QFileDialog:
    dialog = QFileDialog(parent, title, "", pattern)
    dialog.setFileMode(mode)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    _draw_arrows_as_text(dialog)
    return dialog


def _draw_arrows_as_text(dialog: QFileDialog) -> None:
    """Replace the arrow icons of Qt's file dialog with characters in the text colour.

    Qt's arrow icons are black and therefore invisible in a dark window.
    """
    for name in _ARROWS:
        button = dialog.findChild(QToolButton, name)
        if button is None:  # this is the desktop's own dialog
            return
        drawn = QIcon()
        for mode, group in (
            (QIcon.Mode.Normal, QPalette.ColorGroup.Active),
            (QIcon.Mode.Disabled, QPalette.ColorGroup.Disabled),
        ):
            picture = button.icon().pixmap(button.iconSize(), dialog.devicePixelRatioF())
            painter = QPainter(picture)
            painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_SourceIn)
            colour = dialog.palette().color(group, QPalette.ColorRole.ButtonText)
            painter.fillRect(picture.rect(), colour)
            painter.end()
            drawn.addPixmap(picture, mode)
        button.setIcon(drawn)
