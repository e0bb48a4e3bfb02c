"""The dialog in which the user chooses the joints of a new chain."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QCompleter,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QWidget,
)

from inspector.language import tr, tr_as, translate_core_sentence
from inspector.session.document import Document
from inspector.widgets.building import use_secondary_text_colour, vbox
from twistcore.errors import TwistError
from twistcore.files.encoding import escape_control_characters
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rig import OwnChain, Rig

_NONE = "–"
_ROLES = (tr_as("joint", "Parent"), tr_as("joint", "Child"), tr_as("joint", "Grandchild"))
_TIPS = (
    tr("The joint whose twist may be wrong. The chain is named after this joint."),
    tr("The child, which counter-rotates wherever the parent's twist is wrong"),
    tr("Optional: a joint below the child, which shows the child's azimuth"),
)


class ChainDialog(QDialog):
    """A form to choose the parent, the child and, optionally, the grandchild of a new chain.

    Errors are shown immediately. The dialog is not modal, and closes when the clip is closed.
    """

    chosen = Signal(object, str)  # with the rig that includes the new chain, and the chain's name

    def __init__(self, document: Document, parent: QWidget) -> None:
        super().__init__(parent)
        self._document = document
        self._rig: Rig | None = None
        self.setWindowTitle(tr("Add chain"))
        self.joints = tuple(_joint_box(tip) for tip in _TIPS)
        self.limb = QCheckBox(
            tr("This is a limb: search for flips about the line from its first to its last joint")
        )
        self.status = use_secondary_text_colour(QLabel(wordWrap=True))
        self.status.setMinimumWidth(self.fontMetrics().averageCharWidth() * 60)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._add = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        self._add.setText(tr("Add chain"))
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        form = QFormLayout()
        for role, box in zip(_ROLES, self.joints, strict=True):
            form.addRow(role, box)
        form.addRow("", self.limb)
        vbox(form, self.status, None, self.buttons, owner=self)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._fill(0, [j for j, below in enumerate(self._skeleton.children) if below])
        for place, box in enumerate(self.joints):
            box.currentTextChanged.connect(lambda _, k=place: self._changed(k))
        self._start()
        self.limb.toggled.connect(lambda: self._changed(0))
        document.opened.connect(self.reject)
        document.chains_changed.connect(self._check)

    def _start(self) -> None:
        """Select the first joint that can be the parent of a new chain."""
        taken = self._document.review.state.tau
        parents = self.joints[0]
        names = [parents.itemText(k) for k in range(parents.count())]
        for name in [n for n in names if self._joint(n) not in taken] or names[:1]:
            with QSignalBlocker(parents):
                parents.setCurrentText(name)
            self._changed(0)
            if self._rig is not None:
                return

    @property
    def _skeleton(self) -> Skeleton:
        assert self._document.data is not None
        return self._document.data.motion.skeleton

    def _joint(self, seen: str) -> str:
        """Return a joint's name in the file, given its displayed name `seen`."""
        return next(
            (name for name in self._skeleton.names if escape_control_characters(name) == seen), seen
        )

    def _changed(self, place: int) -> None:
        """After a change in one joint list, update the lists below it.

        `place` is the number of the changed list: 0 for the parent, 1 for the child.
        """
        name = self._joint(self.joints[place].currentText())
        if place < 2 and name in self._skeleton.names:
            children = self._skeleton.children
            below = list(children[self._skeleton.index(name)])
            if place == 1 or self.limb.isChecked():
                for joint in below:
                    below.extend(children[joint])
            self._fill(place + 1, sorted(below))
            self._choose_first_good(place + 1)
            if place == 0:
                self._changed(1)
                return
        self._check()

    def _choose_first_good(self, place: int) -> None:
        """Select the first joint of a list that forms a valid chain with the joints above it.

        `place` is the number of the list: 0 for the parent, 1 for the child, 2 for the grandchild.
        """
        data, box = self._document.data, self.joints[place]
        assert data is not None
        above = [self._joint(upper.currentText()) for upper in self.joints[:place]]
        with QSignalBlocker(box):
            for k in range(box.count()):
                if (name := self._joint(box.itemText(k))) == _NONE or _is_chain(
                    data.motion, (*above, name)
                ):
                    box.setCurrentIndex(k)
                    return

    def _fill(self, place: int, joints: list[int]) -> None:
        box, names = (
            self.joints[place],
            [escape_control_characters(self._skeleton.names[j]) for j in joints],
        )
        with QSignalBlocker(box):
            box.clear()
            box.addItems([*names, _NONE] if place == 2 else names)

    def _own(self) -> OwnChain:
        texts = [self._joint(box.currentText().strip()) for box in self.joints]
        joints = tuple(t for k, t in enumerate(texts) if k < 2 or t not in ("", _NONE))
        return OwnChain(joints, self.limb.isChecked())

    def _check(self) -> None:
        data, own = self._document.data, self._own()
        if data is None:
            return
        try:
            self._rig = self._document.review.state.rig.with_chain(data.motion, own)
        except TwistError as error:
            self._rig = None
            self.status.setText(
                tr(
                    "These joints do not form a chain: {why}.",
                    why=translate_core_sentence(str(error)),
                )
            )
        else:
            joints = " → ".join(own.joints)
            self.status.setText(
                tr("The chain will be called {name}: {joints}.", name=own.name, joints=joints)
            )
        self._add.setEnabled(self._rig is not None)

    def accept(self) -> None:
        """Emit the rig that includes the new chain, and close the dialog."""
        if self._rig is not None:
            self.chosen.emit(self._rig, self._own().name)
            super().accept()


def _is_chain(motion: Motion, joints: tuple[str, ...]) -> bool:
    try:
        OwnChain(joints).made(motion)
    except TwistError:
        return False
    return True


def _joint_box(tip: str) -> QComboBox:
    """Return a combo box in which the user can choose a joint or type a part of its name."""
    box = QComboBox(editable=True)
    box.setToolTip(tip)
    box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
    completer = QCompleter(box.model(), box)
    completer.setFilterMode(Qt.MatchFlag.MatchContains)
    completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
    box.setCompleter(completer)
    return box
