"""What to export: where to, which intervals, and what is written beside it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QLabel, QWidget

from inspector.session.document import Document
from inspector.session.export_files import ExportChoice
from inspector.session.session_files import replay_path
from inspector.widgets.write_dialog import WriteDialog
from twistcore.refinement import SURE_ENOUGH
from twistcore.review import Decision
from twistcore.review.model import SEEN


class ExportDialog(WriteDialog):
    """A form; its `choice` is what is to be exported."""

    def __init__(self, document: Document, parent: QWidget | None = None) -> None:
        clip = document.data.clip.path if document.data else Path("clip.bvh")
        super().__init__("Export", clip.with_name(f"{clip.stem}_refined.bvh"), parent)
        told = Counter(j.verdict for j in document.intervals)
        words = [f"{told[v]} {v}" for v in (Decision.ACCEPTED, SEEN) if told[v] or v != SEEN]
        words += [f"{told[v]} {v}" for v in (Decision.REJECTED, Decision.UNDECIDED)]
        undecided = len(document.review.state.unasked()) if document.data else 0
        repairable = (j for j in document.intervals if j.interval.repairable)
        every = sum(j.decision == Decision.UNDECIDED for j in repairable)
        which = f"{undecided}" if undecided == every else f"{undecided} sure of {every}"
        self.undecided = QCheckBox(f"Correct the {which} undecided ones as well")
        self.undecided.setToolTip(
            f"Closed ones, with a confidence of {SURE_ENOUGH:.2f} or more if they have any"
        )
        self.undecided.setEnabled(undecided > 0)
        self.session = QCheckBox("Session beside it, to go on or to replay the export")
        self.report = QCheckBox("Report beside it (HTML, CSV, JSON, markers for Blender)")
        for beside in (self.session, self.report):
            beside.setChecked(True)
        self.warning = QLabel(wordWrap=True)
        note = "They are accepted in one step, which undo takes back."
        self.undecided.toggled.connect(lambda on: self.warning.setText(note if on else ""))
        form = self.form
        form.addRow("Write to", self.where)
        self.count = QLabel(", ".join(words))
        form.addRow("Intervals", self.count)
        tracking = document.review.state.tracking if document.data else None
        if tracking is not None:
            joints, gains = len(tracking.joints), "learned" if tracking.learned else "hand"
            count = tracking.joints[0] if joints == 1 else f"{joints} joints"
            form.addRow("Tracked", QLabel(f"{count} with QuaMo, {gains} gains, afterwards"))
        form.addRow("", self.undecided)
        form.addRow("", self.warning)
        form.addRow("", self.replace)
        form.addRow("With", self.session)
        form.addRow("", self.report)
        self.end_form()
        self.path.textChanged.connect(self._path_changed)
        self.session.toggled.connect(self._path_changed)
        self._path_changed()

    def _path_changed(self) -> None:
        path = Path(self.path.text()).expanduser()
        beside = self.session.isChecked() and replay_path(path).exists()
        self.replace.setChecked(False)  # what was said of another file
        self.replace.setVisible(path.exists() or beside)

    def choice(self) -> ExportChoice:
        """What the form says."""
        return ExportChoice(
            Path(self.path.text()).expanduser(),
            undecided=self.undecided.isChecked(),
            replace=self.replace.isChecked(),
            session=self.session.isChecked(),
            report=self.report.isChecked(),
        )

    def pattern(self) -> str:
        """Clips."""
        return "BVH (*.bvh)"
