"""The base class for dialogs that write a file."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from inspector.language import tr
from inspector.widgets.building import hbox, vbox
from inspector.widgets.file_dialog import ask_save_path
from twistcore.files.ordinary import path_exists


class WriteDialog(QDialog):
    """A dialog that writes a file. The text of its main button is the title of the dialog.

    A subclass adds its rows to `form`, including `where` (the path) and `replace` (a check box),
    and then calls `end_form`.
    """

    def __init__(self, title: str, path: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.path = QLineEdit(str(path))
        self.path.setMinimumWidth(self.fontMetrics().averageCharWidth() * 60)
        self.path.setAccessibleName(tr("File to write"))
        browse = QPushButton(tr("Browse…"))
        browse.clicked.connect(self._browse)
        self.where = hbox((self.path, 1), browse)
        self.replace = QCheckBox(tr("Replace the existing file"))
        self.form = QFormLayout()
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)

    def end_form(self) -> None:
        """Add the buttons below all rows.

        Call this method last, because the Tab key visits widgets in the order of their creation.
        """
        buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        self.do_it = buttons.button(QDialogButtonBox.StandardButton.Save)
        self.do_it.setText(self.windowTitle())
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        vbox(self.form, None, buttons, owner=self)

    def pattern(self) -> str:
        """Return the file name pattern for the file dialog."""
        return tr("All files (*)")

    def _browse(self) -> None:
        title = tr("{command} – save as", command=self.windowTitle())
        ask_save_path(self, title, self.pattern(), self._take, wanted=Path(self.path.text()))

    def _take(self, path: Path) -> None:
        self.path.setText(str(path))
        self.replace.setChecked(
            path_exists(path)
        )  # the file dialog has already asked about replacing
