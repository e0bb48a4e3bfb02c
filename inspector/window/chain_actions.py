"""What the actions on the set of chains do."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QWidget

from inspector.language import plural, tr
from inspector.session.document import Document
from inspector.session.rig_profiles import keep_rig, kept_rig, rig_path
from inspector.widgets.message_bar import MessageBar
from inspector.window.chain_dialog import ChainDialog
from inspector.window.joint_names_dialog import JointNamesDialog
from twistcore.files.ordinary import is_there
from twistcore.review import Decision
from twistcore.skeleton.rig import AS_FOUND, Rig


@dataclass(eq=False)
class ChainActions:
    """Chains added, removed and kept for all clips of a skeleton.

    dock: that of the list of chains, whose title says what is otherwise than found.
    """

    document: Document
    bar: MessageBar
    dock: QDockWidget
    window: QWidget
    dialog: ChainDialog | None = field(default=None, init=False)
    names: JointNamesDialog | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        for signal in (self.document.opened, self.document.chains_changed):
            signal.connect(self._retitle)

    def _retitle(self) -> None:
        rig = self._rig
        self.dock.setWindowTitle(
            tr("Chains ({changed})", changed=_changed(rig)) if rig else tr("Chains")
        )

    @property
    def _rig(self) -> Rig:
        return self.document.review.state.rig if self.document.data else AS_FOUND

    def add_chain(self) -> None:
        """Ask for joints, beside the window."""
        if not self._open():
            return
        if self.dialog is None:
            self.dialog = ChainDialog(self.document, self.window)
            self.dialog.chosen.connect(self._add)
            self.dialog.finished.connect(self._forget_dialog)
            self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()
        self.dialog.joints[0].setFocus(Qt.FocusReason.OtherFocusReason)

    def _forget_dialog(self) -> None:
        self.dialog = None

    def _add(self, rig: Rig, name: str) -> None:
        self.document.change_chains(rig, tr("Add chain {name}", name=name))

    def joint_names(self) -> None:
        """Show what each joint was taken for, next to the window, and let a person change it."""
        if not self._open():
            return
        if self.names is None:
            self.names = JointNamesDialog(self.document, self.window)
            self.names.chosen.connect(self._name)
            self.names.finished.connect(self._forget_names)
            self.names.show()
        self.names.raise_()
        self.names.activateWindow()

    def _forget_names(self) -> None:
        self.names = None

    def _name(self, rig: Rig) -> None:
        """Use names of joints, and keep them for this skeleton."""
        if rig == self._rig:
            return
        told = tr("Clips of this skeleton that have no session open with these names from now on.")
        data = self.document.data
        if data is not None and self._keep(replace(kept_rig(data.motion)[0], names=rig.names)):
            self.document.change_chains(rig, tr("Joint names"), told)
        else:
            self.document.change_chains(rig, tr("Joint names"))

    def remove_chain(self) -> None:
        """Take the selected chain away, and say what goes with it."""
        name, document = self.document.chain, self.document
        if not self._open() or not name:
            return
        own = document.review.state.of_chain(name)
        decided = sum(j.decision != Decision.UNDECIDED for j in own)
        label = document.find_chain(name).label
        told = tr(
            "{chain} is gone, and so is what was found in it: {intervals}, {decided} decided. "
            "Undo brings all back.",
            chain=label,
            intervals=plural("{n} interval", "{n} intervals", len(own)),
            decided=decided,
        )
        rig, what = self._rig.without(name), tr("Remove chain {name}", name=label)
        document.change_chains(rig, what, told if own else "")

    def restore_chains(self) -> None:
        """The chains that are found, and no others."""
        if self._open():
            self._change(AS_FOUND, tr("Chains as found"), tr("These are the chains as found."))

    def use_rig(self) -> None:
        """The chains that are kept for this skeleton."""
        data = self.document.data
        if data is None or not self._open():
            return
        rig, told = kept_rig(data.motion)
        if told or not is_there(rig_path(data.motion.skeleton)):
            self.bar.show_message(told or tr("Nothing is kept for this skeleton."), bool(told))
        else:
            already = tr("These are the chains of the rig profile.")
            self._change(rig, tr("Use the rig profile"), already)

    def _change(self, rig: Rig, what: str, already: str) -> None:
        if rig == self._rig:
            self.bar.show_message(already, False)
        else:
            self.document.change_chains(rig, what)

    def keep_rig(self) -> None:
        """Keep the chains for all clips of this skeleton that have no session yet."""
        rig = self._rig
        if not self._open() or not self._keep(rig):
            return
        which = tr("the chains as found")
        if rig:
            which = tr("these chains ({changed})", changed=_changed(rig))
        told = tr(
            "Clips of this skeleton that have no session open with {chains} from now on.",
            chains=which,
        )
        self.bar.show_message(told, False)

    def _keep(self, rig: Rig) -> bool:
        """Write the rig of this skeleton; False, with a message, where that fails."""
        data = self.document.data
        assert data is not None
        try:
            keep_rig(rig, data.motion.skeleton, data.clip.name)
        except OSError as error:
            place = rig_path(data.motion.skeleton)
            told = tr("{file}: not written ({why}).", file=place, why=error.strerror)
            self.bar.show_message(told, True)
            return False
        return True

    def _open(self) -> bool:
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
        return self.document.data is not None


def _changed(rig: Rig) -> str:
    """In how far the chains are otherwise than found: '2 added, 1 removed'."""
    parts = (
        (tr("{n} added", n=len(rig.add)), rig.add),
        (tr("{n} removed", n=len(rig.remove)), rig.remove),
        (tr("{n} named", n=len(rig.names)), rig.names),
    )
    return ", ".join(said for said, some in parts if some)
