"""The form in which a person says where to write a file, and what into it."""

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
from inspector.widgets.file_dialog import ask_where
from twistcore.files.ordinary import is_there


class WriteDialog(QDialog):
    """A form with a file's name; its button does what its title says.

    A kind of form adds its rows to `form`, `where` and `replace` among them, then ends it.
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
        """Below all rows the buttons: the tab key goes in the order of making."""
        buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        self.do_it = buttons.button(QDialogButtonBox.StandardButton.Save)
        self.do_it.setText(self.windowTitle())
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        vbox(self.form, None, buttons, owner=self)

    def pattern(self) -> str:
        """The files that a file dialog lists."""
        return tr("All files (*)")

    def _browse(self) -> None:
        title = tr("{command} to", command=self.windowTitle())
        ask_where(self, title, self.pattern(), self._take, wanted=Path(self.path.text()))

    def _take(self, path: Path) -> None:
        self.path.setText(str(path))
        self.replace.setChecked(is_there(path))  # the file dialog has asked already
