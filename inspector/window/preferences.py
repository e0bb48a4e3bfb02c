"""The preferences dialog, with settings such as the reviewer's name and the shortcuts."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QSpinBox,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from inspector.feature import Tick
from inspector.language import languages, tr, tr_as
from inspector.session.settings import STEPS, Settings
from inspector.widgets.building import vbox
from inspector.window.actions import Menus, key_text, rows

_AUTOSAVE = Tick(
    "autosave",
    tr("Save sessions automatically"),
    tr("Save one minute after the last change, and when another clip is opened"),
)
_FRAME = 60  # pixels for the title bar and a margin at the edges of the screen


class Preferences(QDialog):
    """A form for the settings. The settings change only when the user accepts the form."""

    def __init__(
        self, settings: Settings, menus: Menus, ticks: Sequence[Tick], parent: QWidget
    ) -> None:
        """Build the form. `ticks` describes the check boxes for on/off settings of features."""
        super().__init__(parent)
        self._settings, self._rows = settings, tuple(rows(menus))
        self.setWindowTitle(tr("Preferences"))
        hint = tr("Your name, saved with every decision")
        self.reviewer = QLineEdit(settings.reviewer, placeholderText=hint)
        self.first = QComboBox()
        self.first.addItems(["0", "1"])
        self.first.setCurrentIndex(settings.first_frame)
        self.step = QSpinBox(
            minimum=STEPS[0], maximum=STEPS[1], value=settings.step, suffix=tr(" frames")
        )
        self.boxes = {tick.name: _box(tick, settings) for tick in (_AUTOSAVE, *ticks)}
        self.language = QComboBox()
        self.language.addItem(tr_as("language", "System"), "system")
        for code, name in languages().items():
            self.language.addItem(name, code)
        self.language.setCurrentIndex(max(self.language.findData(settings.language), 0))
        form = QFormLayout()
        form.addRow(tr("Reviewer"), self.reviewer)
        form.addRow(tr("Count frames from"), self.first)
        form.addRow(tr("Ctrl+← and Ctrl+→ move by"), self.step)
        for box in self.boxes.values():
            form.addRow("", box)
        form.addRow(tr("Language (after a restart)"), self.language)
        self.keys = QTableWidget(len(self._rows), 2)
        self.keys.setHorizontalHeaderLabels([tr("Action"), tr("Key")])
        self.keys.setAccessibleName(tr("Actions and their keys"))
        self.keys.verticalHeader().hide()
        header = self.keys.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.resizeSection(1, 230)
        self.edits: dict[str, QKeySequenceEdit] = {}
        for place, row in enumerate(self._rows):
            item = QTableWidgetItem(row.text)
            item.setFlags(Qt.ItemFlag.ItemIsEnabled)
            self.keys.setItem(place, 0, item)
            keys = settings.keys.get(row.id, list(row.keys))
            edit = QKeySequenceEdit(QKeySequence(keys[0] if keys else ""))
            edit.setClearButtonEnabled(True)
            edit.setAccessibleName(tr("Key for {action}", action=row.text))
            edit.setMaximumSequenceLength(1)
            edit.keySequenceChanged.connect(self._check)
            self.edits[row.id] = edit
            self.keys.setCellWidget(place, 1, edit)
        self.conflict = QLabel(wordWrap=True)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        vbox(form, (self.keys, 1), self.conflict, self.buttons, owner=self)
        self.resize(560, min(640, self.screen().availableSize().height() - _FRAME))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)

    def accept(self) -> None:
        """Store the values of the form in the settings."""
        settings = self._settings
        settings.reviewer = self.reviewer.text().strip()
        settings.first_frame = self.first.currentIndex()
        settings.step = self.step.value()
        for name, box in self.boxes.items():
            settings.put(name, box.isChecked())
        settings.language = self.language.currentData()
        changed = {}
        for row in self._rows:
            key = self.edits[row.id].keySequence().toString()
            first = QKeySequence(row.keys[0]).toString() if row.keys else ""
            if key != first:
                changed[row.id] = [key] if key else []
        settings.keys = changed
        super().accept()

    def _check(self) -> None:
        used: dict[str, list[str]] = {}
        for row in self._rows:
            key = self.edits[row.id].keySequence().toString()
            if key:
                used.setdefault(key, []).append(row.text)
        twice = [
            f"{key_text(key)}: {', '.join(names)}" for key, names in used.items() if len(names) > 1
        ]
        text = tr("These keys are assigned twice: {keys}", keys="; ".join(twice))
        self.conflict.setText(text if twice else "")
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setEnabled(not twice)


def _box(tick: Tick, settings: Settings) -> QCheckBox:
    box = QCheckBox(tick.text)
    box.setChecked(settings.value(tick.name))
    box.setToolTip(tick.tip)
    return box
