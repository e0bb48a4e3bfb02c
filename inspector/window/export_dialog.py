"""What to export: where to, which intervals, and what is written beside it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QCheckBox, QLabel, QWidget

from inspector.session.document import Document
from inspector.session.export_files import (
    ExportChoice,
    check_targets,
    replaced,
    to_look_at,
    uncorrected,
)
from inspector.widgets.background import OneTask
from inspector.widgets.write_dialog import WriteDialog
from twistcore.errors import TwistError
from twistcore.export.exports_beside import EXPORT_MARK
from twistcore.file_marks import file_mark
from twistcore.refinement import SURE_ENOUGH
from twistcore.review import Decision
from twistcore.review.model import APPLIED, SEEN


class ExportDialog(WriteDialog):
    """A form; its `choice` is what is to be exported."""

    def __init__(self, document: Document, parent: QWidget | None = None) -> None:
        super().__init__("Export", document.proposed(f"{EXPORT_MARK}.{_format(document)}"), parent)
        self._document = document
        self._look = OneTask(self)  # at long files that are there
        self._then: Callable[[], object] = lambda: None
        self.finished.connect(self._look.cancel)
        document.opened.connect(self.reject)  # what it says is of the clip that was open
        told = Counter(j.verdict for j in document.intervals)
        words = [
            f"{told[v]} {v}"
            for v in (Decision.ACCEPTED, SEEN, APPLIED)
            if told[v] or v == "accepted"
        ]
        words += [f"{told[v]} {v}" for v in (Decision.REJECTED, Decision.UNDECIDED)]
        undecided = len(document.review.state.unasked()) if document.data else 0
        repairable = (j for j in document.intervals if j.interval.repairable)
        every = sum(j.decision == Decision.UNDECIDED for j in repairable)
        total = told[Decision.UNDECIDED]  # jumps among them, of which nothing is taken out
        which = f"{undecided} repairable of {total}" if every < total else f"{undecided}"
        which = which if undecided == every else f"{undecided} sure of {total}"
        ones = "one" if which.split()[-1] == "1" else "ones"
        self.undecided = QCheckBox(f"Correct the {which} undecided {ones} as well")
        self.undecided.setToolTip(
            f"Closed ones, with a confidence of {SURE_ENOUGH:.2f} or more if they have any"
        )
        self.undecided.setEnabled(undecided > 0)
        self.session = QCheckBox("Session beside it, to go on or to replay the export")
        self.report = QCheckBox("Report beside it (HTML, CSV, JSON, markers for Blender)")
        for beside in (self.session, self.report):
            beside.setChecked(True)
        self.warning, self.obstacle = QLabel(wordWrap=True), QLabel(wordWrap=True)
        self.replaces = QLabel(wordWrap=True)
        note = "In one step, which undo takes back; the report says that they were applied "
        note += "automatically, not that you accepted them."
        self.warning.setText(note)
        self.warning.hide()
        self.undecided.toggled.connect(self.warning.setVisible)
        form = self.form
        form.addRow("Write to", self.where)
        self.count = QLabel(", ".join(words))
        form.addRow("Intervals", self.count)
        if document.data is not None and (stuck := uncorrected(document)):
            form.addRow("", QLabel(stuck, wordWrap=True))
        tracking = document.review.state.tracking if document.data else None
        if tracking is not None:
            way = "causally" if tracking.causal else "both ways"
            gains = "learned" if tracking.learned else "hand"
            how = f"{tracking.what} with QuaMo, {way}, {gains} gains, afterwards"
            form.addRow("Tracked", QLabel(how))
        form.addRow("", self.undecided)
        form.addRow("", self.warning)
        form.addRow("With", self.session)
        form.addRow("", self.report)
        form.addRow("Replaces", self.replaces)
        form.addRow("", self.replace)
        form.addRow("", self.obstacle)
        self.end_form()
        self.path.textChanged.connect(self._path_changed)
        self.replace.toggled.connect(self._see_whether_it_can)
        for beside in (self.session, self.report):
            beside.toggled.connect(self._path_changed)
        self._path_changed()

    def _path_changed(self) -> None:
        with QSignalBlocker(self.replace):
            self.replace.setChecked(False)  # what was said of another file
        self._look.cancel()
        if long := to_look_at(self.choice(), self._document.exported):
            names = ", ".join(path.name for path in long)
            self.replaces.setText(f"{names}: being looked at …")
            self.replace.hide()
            self.obstacle.hide()
            self.do_it.setEnabled(False)
            self._look.run(lambda _: _take_marks(long), lambda _: self._seen())
        else:
            self._seen()

    @property
    def looking(self) -> bool:
        """Whether long files that are there are still being read."""
        return self._look.running

    def when_seen(self, then: Callable[[], object]) -> None:
        """Do it once it is known what is there."""
        if self.looking:
            self._then = then
        else:
            then()

    def _seen(self) -> None:
        there = replaced(self.choice(), self._document.exported)
        foreign = [path for path, ours in there.items() if not ours]
        lines = [
            f"{path.name} ({'written by this program' if ours else 'not ours, or changed since'})"
            for path, ours in there.items()
        ]
        self.replaces.setText("\n".join(lines) or "nothing: all files are new")
        self.replace.setVisible(bool(foreign))
        self._see_whether_it_can()
        then, self._then = self._then, lambda: None
        then()

    def _see_whether_it_can(self) -> None:
        """The button works where nothing is in the way; else a sentence says what is."""
        why = ""
        document = self._document
        if (data := document.data) is not None:
            try:
                check_targets(self.choice(), data.clip, document.exported, document.keeper.files)
            except TwistError as error:
                why = str(error)
        if why and self.replace.isVisibleTo(self) and not self.replace.isChecked():
            why = "Tick Replace, or choose another name."
        self.obstacle.setText(why)
        self.obstacle.setVisible(bool(why))
        self.do_it.setEnabled(not why)

    def choice(self) -> ExportChoice:
        """What the form says."""
        return ExportChoice(
            self._document.folder.absolute() / Path(self.path.text()).expanduser(),
            undecided=self.undecided.isChecked(),
            replace=self.replace.isChecked(),
            session=self.session.isChecked(),
            report=self.report.isChecked(),
        )

    def pattern(self) -> str:
        """Clips of the format of this one."""
        ending = _format(self._document)
        return f"{ending.upper()} (*.{ending})"


def _format(document: Document) -> str:
    return document.data.clip.format if document.data is not None else "bvh"


def _take_marks(files: Iterable[Path]) -> None:
    for path in files:
        with suppress(OSError):  # gone meanwhile
            file_mark(path)
