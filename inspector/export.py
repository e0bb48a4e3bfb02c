"""Exporting: the corrected BVH, and beside it the session and a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QLabel, QWidget

from inspector.document import Document
from inspector.keeping import SESSION_SUFFIX
from inspector.write_dialog import WriteDialog
from twistcore.bvh import Clip, write_bvh
from twistcore.chain import Chain, uncorrectable_joints
from twistcore.compare import compare
from twistcore.errors import TwistError
from twistcore.progress import Tell, nobody
from twistcore.report import Report, write_report
from twistcore.review import Decision, ReviewState, accepted_motion, write_session


@dataclass(frozen=True)
class ExportChoice:
    """What a person asked for."""

    path: Path
    undecided: bool = False
    replace: bool = False
    session: bool = True
    report: bool = True


@dataclass(frozen=True, eq=False)
class Export:
    """What is written, whatever the person does meanwhile; left_out: what cannot be corrected."""

    choice: ExportChoice
    clip: Clip
    chains: tuple[Chain, ...]
    state: ReviewState
    left_out: str


def prepare(document: Document, choice: ExportChoice) -> Export:
    """Accept what is to be accepted and keep the review as it is now.

    Raises TwistError where the source, or a file that is none of ours, would be overwritten.
    """
    data = document.data
    assert data is not None
    clip = data.clip
    if choice.path.exists() and clip.path.exists() and choice.path.samefile(clip.path):
        raise TwistError(f"{choice.path}: choose another name; the source is never overwritten.")
    if choice.path.exists() and choice.path not in document.exported and not choice.replace:
        raise TwistError(f"{choice.path}: there is such a file already; choose another name.")
    if choice.undecided:
        # One step of the history: so the session says what the export did, and replays it.
        document.accept_undecided()
    document.exported.add(choice.path)
    return Export(choice, clip, tuple(data.chains), document.review.state, uncorrected(document))


def write(export: Export, tell: Tell = nobody) -> str:
    """Correct, track and write everything chosen; returns the sentence that says what was changed.

    tell: called with the share of the tracking that is done. Raises OSError where the disk says no.
    """
    choice, clip, state = export.choice, export.clip, export.state
    refined = accepted_motion(clip, export.chains, state, tell=tell)
    jumps = write_bvh(clip, refined, choice.path)
    if choice.session:
        write_session(choice.path.with_name(choice.path.stem + SESSION_SUFFIX), clip, state)
    if choice.report:
        write_report(choice.path.parent, Report(clip, export.chains, state, refined))
    change = compare(clip.motion, refined)
    if not change.joints:
        why = export.left_out or "nothing was accepted."
        return f"{choice.path.name}: written byte for byte as the source; {why}"
    largest = max(j.max_degrees for j in change.joints)
    joints = len({j.joint for j in change.joints})
    return (
        f"{choice.path.name}: {change.frames} frames of {joints} joints changed by up to "
        f"{largest:.1f}°; no joint moved by more than {change.max_position_of_height:.0e} "
        f"of the height; every other byte is the source's. {export.left_out}"
        + (f" {len(jumps)} channel steps of more than 180° stay: {jumps[0]}." if jumps else "")
    ).strip()


def uncorrected(document: Document) -> str:
    """A sentence about accepted intervals that cannot be corrected, or ''."""
    assert document.data is not None
    motion = document.data.motion
    accepted = {i.chain for i in document.review.state.chosen()}
    stuck = [
        f"{c.label} ({', '.join(joints)})"
        for c in document.data.chains
        if c.name in accepted and (joints := uncorrectable_joints(motion, c))
    ]
    if not stuck:
        return ""
    return f"Not corrected, for want of three rotation channels: {'; '.join(stuck)}."


class ExportDialog(WriteDialog):
    """Where to, and what goes with it."""

    def __init__(self, document: Document, parent: QWidget | None = None) -> None:
        clip = document.data.clip.path if document.data else Path("clip.bvh")
        super().__init__("Export", clip.with_name(f"{clip.stem}_refined.bvh"), parent)
        intervals = document.intervals
        accepted = sum(j.decision == Decision.ACCEPTED for j in intervals)
        rejected = sum(j.decision == Decision.REJECTED for j in intervals)
        undecided = len(intervals) - accepted - rejected
        self.undecided = QCheckBox(f"Correct the {undecided} undecided ones as well")
        self.undecided.setEnabled(undecided > 0)
        self.session = QCheckBox("Session beside it, to go on or to replay the export")
        self.session.setChecked(True)
        self.report = QCheckBox("Report beside it (HTML, CSV, JSON, markers for Blender)")
        self.report.setChecked(True)
        self.warning = QLabel()
        self.warning.setWordWrap(True)
        self.undecided.toggled.connect(
            lambda on: self.warning.setText(
                "They are accepted in one step, which undo takes back." if on else ""
            )
        )
        form = self.form
        form.addRow("Write to", self.where)
        form.addRow(
            "Intervals", QLabel(f"{accepted} accepted, {rejected} rejected, {undecided} undecided")
        )
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
        self._path_changed()

    def _path_changed(self) -> None:
        self.replace.setVisible(Path(self.path.text()).expanduser().exists())

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
