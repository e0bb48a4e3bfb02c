"""Asking for files; the window goes on while the dialog is open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QWidget


def ask_files(
    parent: QWidget,
    title: str,
    pattern: str,
    then: Callable[[Sequence[Path]], object],
    *,
    folder: Path | None = None,
    several: bool = False,
) -> None:
    """Ask for a file that is there, or for several; `then` gets what was chosen."""
    mode = QFileDialog.FileMode
    dialog = _dialog(parent, title, pattern, mode.ExistingFiles if several else mode.ExistingFile)
    if folder is not None:
        dialog.setDirectory(str(folder))
    dialog.filesSelected.connect(lambda names: then([Path(name) for name in names]))
    dialog.open()


def ask_where(
    parent: QWidget,
    title: str,
    pattern: str,
    then: Callable[[Path], object],
    *,
    wanted: Path,
    suffix: str = "",
) -> None:
    """Ask where to write, `wanted` to begin with; suffix: given to a name without one."""
    dialog = _dialog(parent, title, pattern, QFileDialog.FileMode.AnyFile)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setDefaultSuffix(suffix)
    dialog.selectFile(str(wanted))
    dialog.fileSelected.connect(lambda name: then(Path(name)))
    dialog.open()


def _dialog(parent: QWidget, title: str, pattern: str, mode: QFileDialog.FileMode) -> QFileDialog:
    dialog = QFileDialog(parent, title, "", pattern)
    dialog.setFileMode(mode)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    return dialog
