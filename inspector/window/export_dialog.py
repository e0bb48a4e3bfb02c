"""The export dialog, in which the user chooses the path, the intervals and additional files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QCheckBox, QLabel, QWidget

from inspector.language import plural, tr, tr_as, translate_core_sentence
from inspector.session.document import Document
from inspector.session.examined import one_line_summary, reason_unexamined, unexamined_sentences
from inspector.session.export_files import (
    ExportChoice,
    check_targets,
    files_replaced_by_export,
    files_to_hash,
    uncorrected_warning,
)
from inspector.widgets.background import OneTask
from inspector.widgets.write_dialog import WriteDialog
from twistcore.analysis.correction.twist_removal import SURE_ENOUGH
from twistcore.errors import TwistError
from twistcore.export.exported_clips import EXPORT_MARK
from twistcore.files.marks import cached_sha256
from twistcore.review import Decision, Tracking
from twistcore.review.interrupted_export import interrupted_exports
from twistcore.review.model import APPLIED, SEEN

_VERDICTS = {
    Decision.ACCEPTED: tr_as("decision", "accepted"),
    SEEN: tr_as("decision", "seen"),
    APPLIED: tr_as("decision", "applied automatically"),
    Decision.REJECTED: tr_as("decision", "rejected"),
    Decision.UNDECIDED: tr_as("decision", "undecided"),
}


class ExportDialog(WriteDialog):
    """A form with the options of an export."""

    def __init__(self, document: Document, parent: QWidget | None = None) -> None:
        proposed = document.proposed(f"{EXPORT_MARK}.{_format(document)}")
        super().__init__(tr_as("do", "Export"), proposed, parent)
        self._document = document
        self._look = OneTask(self)  # hashes large files that would be replaced
        self._then: Callable[[], object] = lambda: None
        self.finished.connect(self._look.cancel)
        document.opened.connect(self.reject)  # close the form when another clip is opened
        counts = Counter(j.verdict for j in document.intervals)
        words = [
            f"{counts[v]} {_VERDICTS[v]}"
            for v in (Decision.ACCEPTED, SEEN, APPLIED)
            if counts[v] or v == "accepted"
        ]
        words += [f"{counts[v]} {_VERDICTS[v]}" for v in (Decision.REJECTED, Decision.UNDECIDED)]
        undecided = len(document.review.state.automatic_ids()) if document.data else 0
        repairable = (j for j in document.intervals if j.interval.repairable)
        every = sum(j.decision == Decision.UNDECIDED for j in repairable)
        total = counts[Decision.UNDECIDED]  # including jumps, which cannot be corrected
        self.undecided = QCheckBox(_undecided_text(undecided, every, total))
        self.undecided.setToolTip(
            tr(
                "Correct the intervals with a confidence of {confidence:.2f} or more, "
                "except open intervals, whose joint or side is uncertain",
                confidence=SURE_ENOUGH,
            )
        )
        self.undecided.setEnabled(undecided > 0)
        self.session = QCheckBox(tr("Session file, to continue the review or repeat the export"))
        self.report = QCheckBox(tr("Report (HTML, CSV, JSON and markers for Blender)"))
        for beside in (self.session, self.report):
            beside.setChecked(True)
        self.warning, self.obstacle = QLabel(wordWrap=True), QLabel(wordWrap=True)
        self.replaces = QLabel(wordWrap=True)
        note = tr(
            "Undo once to remove all these corrections. The report lists them as automatic "
            "corrections, not as accepted by you."
        )
        self.warning.setText(note)
        self.warning.hide()
        self.undecided.toggled.connect(self.warning.setVisible)
        self.undecided.toggled.connect(self._grow)
        form = self.form
        form.addRow(tr("Write to"), self.where)
        self.count = QLabel(", ".join(words))
        form.addRow(tr("Intervals"), self.count)
        blind = not document.intervals and reason_unexamined(document.data)
        if said := blind or one_line_summary(unexamined_sentences(document.data)):
            form.addRow("", QLabel(said, wordWrap=True))
        if document.data is not None and (stuck := uncorrected_warning(document)):
            form.addRow("", QLabel(stuck, wordWrap=True))
        tracking = document.review.state.tracking if document.data else None
        if tracking is not None:
            how = _tracking_words(tracking)
            form.addRow(tr("Tracked"), QLabel(how))
        form.addRow("", self.undecided)
        form.addRow("", self.warning)
        form.addRow(tr_as("export", "With"), self.session)
        form.addRow("", self.report)
        form.addRow(tr_as("export", "Replaces"), self.replaces)
        form.addRow("", self.replace)
        form.addRow("", self.obstacle)
        self.end_form()
        self.path.textChanged.connect(self._path_changed)
        self.replace.toggled.connect(self._check_obstacles)
        for beside in (self.session, self.report):
            beside.toggled.connect(self._path_changed)
        self._path_changed()

    def _path_changed(self) -> None:
        with QSignalBlocker(self.replace):
            self.replace.setChecked(False)  # the user ticked this box for another file
        self._look.cancel()
        if long := files_to_hash(self.choice(), self._document.exported):
            names = ", ".join(path.name for path in long)
            self.replaces.setText(tr("Checking {files} …", files=names))
            self.replace.hide()
            self.obstacle.hide()
            self.do_it.setEnabled(False)
            self._look.run(lambda _: _hash_files(long), lambda _: self._show_replaced())
        else:
            self._show_replaced()

    @property
    def looking(self) -> bool:
        """True while the dialog reads existing files at the target path."""
        return self._look.running

    def when_checked(self, then: Callable[[], object]) -> None:
        """Call `then` as soon as the dialog has found the files that the export would replace."""
        if self.looking:
            self._then = then
        else:
            then()

    def _show_replaced(self) -> None:
        there = files_replaced_by_export(self.choice(), self._document.exported)
        foreign = [path for path, ours in there.items() if not ours]
        data = self._document.data
        interrupted = data is not None and bool(interrupted_exports(data.clip.path))
        whose = (
            tr("perhaps left by an interrupted export")
            if interrupted
            else tr("not written by this program, or changed later"),
            tr("written by this program"),
        )
        lines = [f"{path.name} ({whose[ours]})" for path, ours in there.items()]
        self.replaces.setText("\n".join(lines) or tr("nothing, because all files are new"))
        self.replace.setVisible(bool(foreign))
        self._check_obstacles()
        then, self._then = self._then, lambda: None
        then()

    def _check_obstacles(self) -> None:
        """Enable the Export button, or show why the export is not possible."""
        why = ""
        document = self._document
        if (data := document.data) is not None:
            try:
                check_targets(self.choice(), data.clip, document.exported, document.keeper.files)
            except TwistError as error:
                why = translate_core_sentence(str(error))
        if why and self.replace.isVisibleTo(self) and not self.replace.isChecked():
            why = tr("Tick 'Replace the existing file', or choose another name.")
        self.obstacle.setText(why)
        self.obstacle.setVisible(bool(why))
        self.do_it.setEnabled(not why)
        self._grow()

    def _grow(self) -> None:
        """Make the dialog high enough for new rows. Qt would not count the lines of long texts."""
        if self.isVisible():
            self.resize(self.size().expandedTo(self.sizeHint()))

    def choice(self) -> ExportChoice:
        """Return the chosen export options."""
        return ExportChoice(
            self._document.folder.absolute() / Path(self.path.text()).expanduser(),
            undecided=self.undecided.isChecked(),
            replace=self.replace.isChecked(),
            session=self.session.isChecked(),
            report=self.report.isChecked(),
        )

    def pattern(self) -> str:
        """Return the file name pattern for clips in this clip's format."""
        ending = _format(self._document)
        return f"{ending.upper()} (*.{ending})"


def _tracking_words(tracking: Tracking) -> str:
    """Return a description of the tracking filter that is applied after the correction."""
    joints = translate_core_sentence(tracking.what)
    if tracking.spline:
        return tr(
            "{joints} with the spline after the correction (cut-off {cutoff:.1f} Hz)",
            joints=joints,
            cutoff=tracking.cutoff,
        )
    return tr(
        "{joints} with QuaMo after the correction ({way}, {gains} gains)",
        joints=joints,
        way=tr("causally") if tracking.causal else tr("both ways"),
        gains=tr_as("gains", "learned") if tracking.learned else tr_as("gains", "hand-set"),
    )


def _undecided_text(sure: int, repairable: int, total: int) -> str:
    """Return the label of the check box that includes undecided intervals in the correction."""
    if sure != repairable:
        return plural(
            "Also correct {sure} of {n} undecided interval (the confident ones)",
            "Also correct {sure} of {n} undecided intervals (the confident ones)",
            total,
            sure=sure,
        )
    if repairable < total:
        return plural(
            "Also correct {sure} of {n} undecided interval (the correctable ones)",
            "Also correct {sure} of {n} undecided intervals (the correctable ones)",
            total,
            sure=sure,
        )
    return plural(
        "Also correct {n} undecided interval", "Also correct {n} undecided intervals", sure
    )


def _format(document: Document) -> str:
    return document.data.clip.format if document.data is not None else "bvh"


def _hash_files(files: Iterable[Path]) -> None:
    for path in files:
        with suppress(OSError):  # the file was deleted in the meantime
            cached_sha256(path)
