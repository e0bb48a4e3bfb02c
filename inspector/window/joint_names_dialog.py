"""The dialog in which the user can see and change the role of each joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QWheelEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from inspector.language import plural, tr, tr_as, translate_core_sentence
from inspector.session.document import Document
from inspector.widgets.building import use_secondary_text_colour, vbox
from twistcore.analysis.examination import unexamined_limbs
from twistcore.errors import TwistError
from twistcore.files.encoding import escape_control_characters
from twistcore.skeleton.body import Body
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.joint_names import JointName
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rig import Rig

_JOINT, _TAKEN, _BY, _CHANGE = range(4)
_HEADS = (
    tr("Joint"),
    tr("Body part"),
    tr_as("what a joint is known by", "Recognised by"),
    tr("Change to"),
)
_INDENT = "\N{NO-BREAK SPACE}" * 2
_SIZE = 820, 620  # pixels
_CHOICES = {  # role of a joint in a rig file, and its text in the list
    "": tr_as("a joint", "as detected"),
    "left shoulder": tr("left shoulder (collar bone)"),
    "left arm": tr("left upper arm (Arm)"),
    "left forearm": tr("left forearm"),
    "left hand": tr("left hand"),
    "left upleg": tr("left thigh (UpLeg)"),
    "left leg": tr("left shin (Leg)"),
    "left foot": tr("left foot"),
    "left toe": tr("left toe"),
    "right shoulder": tr("right shoulder (collar bone)"),
    "right arm": tr("right upper arm (Arm)"),
    "right forearm": tr("right forearm"),
    "right hand": tr("right hand"),
    "right upleg": tr("right thigh (UpLeg)"),
    "right leg": tr("right shin (Leg)"),
    "right foot": tr("right foot"),
    "right toe": tr("right toe"),
    "helper": tr("twist bone"),
    "other": tr("not part of an arm or leg"),
    "unknown": tr_as("a joint", "unknown"),
}
# Role in a rig file, and its word in the names of chains
_SEGMENTS = {"forearm": "ForeArm", "upleg": "UpLeg"}
_PIECE = "piece of "
_UNNAMED = {  # joints of limbs whose names contain no body part
    "limb": tr_as("a joint", "limb"),
    "end": tr_as("a joint", "end of a limb"),
    "below the end": tr_as("a joint", "below the end of a limb"),
}
_ENTER = Qt.Key.Key_Return, Qt.Key.Key_Enter


class _Choice(QComboBox):
    """A drop-down list in which the user chooses the role of a joint."""

    reached = Signal()  # the list got the keyboard focus, so the table must scroll to its row

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Emit `reached`, so that the table scrolls to the row of this list."""
        super().focusInEvent(event)
        self.reached.emit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Ignore the mouse wheel, so that the table scrolls instead."""
        event.ignore()


class JointNamesDialog(QDialog):
    """A table of joints and their roles, with the resulting chains below.

    The dialog is not modal, and closes when the clip is closed.
    """

    chosen = Signal(object)  # with the rig that includes the new names

    def __init__(self, document: Document, parent: QWidget) -> None:
        super().__init__(parent)
        self._document = document
        self._rig: Rig | None = None
        self.setWindowTitle(tr("Joint names"))
        self.search = QLineEdit(clearButtonEnabled=True)
        self.search.setPlaceholderText(tr("Find a joint"))
        self.search.setAccessibleName(tr("Find a joint"))
        self.table = QTableWidget(0, len(_HEADS))
        self.table.setHorizontalHeaderLabels(list(_HEADS))
        self.table.setAccessibleName(tr("Joints and the body parts they were recognised as"))
        self.table.setTabKeyNavigation(False)  # Tab goes from list to list
        self.table.verticalHeader().hide()
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(_JOINT, QHeaderView.ResizeMode.Stretch)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.status = use_secondary_text_colour(QLabel(wordWrap=True))
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok
            | QDialogButtonBox.StandardButton.Cancel
            | QDialogButtonBox.StandardButton.Reset
        )
        self._use = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        self._use.setText(tr("Use these names"))
        reset = self.buttons.button(QDialogButtonBox.StandardButton.Reset)
        reset.setText(tr("Reset all"))
        reset.clicked.connect(self.reset)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        about = tr(
            "The program recognises arms and legs by the names of their joints or by the shape of "
            "the skeleton. If you name a hand or a foot, the program finds the joints above it. "
            "The names are saved for all clips with this skeleton."
        )
        top = use_secondary_text_colour(QLabel(about, wordWrap=True))
        vbox(top, self.search, (self.table, 1), self.status, self.buttons, owner=self)
        self.resize(*_SIZE)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.choices: dict[str, QComboBox] = {}
        # The names in the review, without changes made in the dialog
        self._known: Mapping[str, str] = {}
        self._fill()
        self.search.textChanged.connect(self._find)
        document.opened.connect(self.reject)
        document.chains_changed.connect(self._follow)
        self._check()
        self.search.setFocus()

    def _fill(self) -> None:
        data = self._document.data
        assert data is not None
        skeleton, chosen = data.motion.skeleton, self._document.review.state.rig.names
        self._known = chosen
        depth = [0] * len(skeleton)
        self.table.setRowCount(len(skeleton))
        for joint, name in enumerate(skeleton.names):
            parent = int(skeleton.parents[joint])
            depth[joint] = depth[parent] + 1 if parent >= 0 else 0
            item = QTableWidgetItem(_INDENT * depth[joint] + escape_control_characters(name))
            item.setToolTip(escape_control_characters(name))
            self.table.setItem(joint, _JOINT, item)
            choice = _Choice()
            choice.setAccessibleName(
                tr("Body part for {joint}", joint=escape_control_characters(name))
            )
            for key, words in _CHOICES.items():
                choice.addItem(words, key)
            choice.setCurrentIndex(max(0, choice.findData(chosen.get(name, ""))))
            choice.currentIndexChanged.connect(self._check)
            choice.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            choice.reached.connect(lambda row=joint: self.table.selectRow(row))
            self.table.setCellWidget(joint, _CHANGE, choice)
            self.choices[name] = choice

    @property
    def names(self) -> dict[str, str]:
        """The roles that the user has chosen, keyed by the name of the joint in the file."""
        chosen = {name: str(box.currentData()) for name, box in self.choices.items()}
        return {name: role for name, role in chosen.items() if role}

    def reset(self) -> None:
        """Restore the automatically detected roles of all joints."""
        self._choose({})

    def _choose(self, names: Mapping[str, str]) -> None:
        for name, box in self.choices.items():
            with QSignalBlocker(box):
                box.setCurrentIndex(max(0, box.findData(names.get(name, ""))))
        self._check()

    def _follow(self) -> None:
        """Show the review's joint roles after the review has changed, for example by undo."""
        chosen = self._document.review.state.rig.names
        if chosen != self._known:
            self._known = chosen
            self._choose(chosen)
        else:
            self._check()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Handle the Enter key.

        In the search line, Enter moves the focus to the first match. Elsewhere, it accepts the
        dialog.
        """
        if event.key() in _ENTER and self.focusWidget() is self.search:
            rows = range(self.table.rowCount())
            shown = [box for row, box in zip(rows, self.choices.values(), strict=True)
                     if not self.table.isRowHidden(row)]  # fmt: skip
            if shown:
                shown[0].setFocus(Qt.FocusReason.TabFocusReason)
            return
        super().keyPressEvent(event)

    def _find(self, text: str) -> None:
        for row, name in enumerate(self.choices):
            taken = self.table.item(row, _TAKEN)
            words = f"{escape_control_characters(name)} {taken.text() if taken else ''}".casefold()
            self.table.setRowHidden(row, text.casefold() not in words)

    def _check(self) -> None:
        """Update the table and the chain list to match the user's choices."""
        data = self._document.data
        if data is None:
            return
        names = self.names
        rig = self._document.review.state.rig.with_names(names)
        try:
            chains = [c for c in rig.chains(data.motion) if not isinstance(c, Limb)]
        except TwistError as error:  # added chains no longer fit
            self._rig = None
            self.status.setText(
                tr("These names cannot be used: {why}.", why=translate_core_sentence(str(error)))
            )
        else:
            self._rig = rig
            body = rig.body(data.motion)
            missing = unexamined_limbs(body, chains)
            text = _chain_counts(chains)
            if missing:
                text += " · " + " ".join(translate_core_sentence(str(limb)) for limb in missing)
            else:
                text += " · " + tr("all arms and legs are examined")
            self.status.setText(text)
            self._show(body, names, {c.parent: c for c in chains if isinstance(c, Helper)})
        self._use.setEnabled(self._rig is not None)

    def _show(self, body: Body, chosen: Mapping[str, str], helpers: Mapping[int, Helper]) -> None:
        """Fill the table with the role of each joint and the way in which it was recognised.

        Parameters
        ----------
        body
            The body parts recognised in the skeleton.
        chosen
            The roles that the user has chosen, keyed by joint name.
        helpers
            The twist bones, keyed by joint index.
        """
        by_shape = {j for line in body.lines if line.by_shape for j in line.joints}
        for joint, taken in enumerate(body.joint_roles):
            name, helper = body.names[joint], helpers.get(joint)
            by = tr_as("by", "its name") if name.roles or not taken else tr_as("by", "its position")
            if own := chosen.get(body.skeleton.names[joint], ""):
                by = tr_as("by", "you")
                side, _, part = own.partition(" ")
                taken = f"{side.title()} {_SEGMENTS.get(part, part.title())}" if part else ""
            elif joint in by_shape or (helper is not None and not name.helper):
                by = tr_as("by", "the skeleton's shape")
            words = _limb_joint_text(taken) if taken else _other_joint_text(name)
            if helper is not None and helper.segment:
                bone = translate_core_sentence(f"{helper.side} {helper.segment}")
                words = tr("twist bone of {bone}", bone=bone)
            known = taken or helper or name.helper or name.other or name.trunk
            self.table.setItem(joint, _TAKEN, QTableWidgetItem(words))
            self.table.setItem(joint, _BY, QTableWidgetItem(by if known else ""))

    def accept(self) -> None:
        """Emit the rig with the new roles, and close the dialog."""
        if self._rig is not None:
            self.chosen.emit(replace(self._rig))
            super().accept()


def _chain_counts(chains: Sequence[Chain]) -> str:
    """Return the number of chains and twist bones as text: '10 chains, 12 twist bones'."""
    helpers = sum(isinstance(chain, Helper) for chain in chains)
    text = plural("{n} chain", "{n} chains", len(chains) - helpers)
    return f"{text}, {plural('{n} twist bone', '{n} twist bones', helpers)}" if helpers else text


def _limb_joint_text(taken: str) -> str:
    """Return the displayed name of the joint role `taken`, which belongs to an arm or a leg."""
    whole = taken.removeprefix(_PIECE)
    words = _UNNAMED.get(whole) or translate_core_sentence(whole)
    return words if whole == taken else tr("piece of {bone}", bone=words)


def _other_joint_text(name: JointName) -> str:
    """Return the displayed name of the joint role `name`, which is not part of an arm or leg."""
    if name.helper:
        return tr("twist bone")
    if name.other:
        return tr("head, finger or prop")
    return tr("trunk") if name.trunk else tr_as("a joint", "unknown")
