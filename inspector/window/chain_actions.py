"""What the actions on the set of chains do."""

from __future__ import annotations

from dataclasses import dataclass, field

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QWidget

from inspector.session.document import Document
from inspector.session.rig_profiles import keep_rig, kept_rig, rig_path
from inspector.widgets.message_bar import MessageBar
from inspector.window.chain_dialog import ChainDialog
from twistcore.review import Decision
from twistcore.rig import AS_FOUND, Rig


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

    def __post_init__(self) -> None:
        for signal in (self.document.opened, self.document.chains_changed):
            signal.connect(self._retitle)

    def _retitle(self) -> None:
        rig = self._rig
        self.dock.setWindowTitle(f"Chains ({rig.summary()})" if rig else "Chains")

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
        self.document.change_chains(rig, f"Add chain {name}")

    def remove_chain(self) -> None:
        """Take the selected chain away, and say what goes with it."""
        name, document = self.document.chain, self.document
        if not self._open() or not name:
            return
        own = document.review.state.of_chain(name)
        decided = sum(j.decision != Decision.UNDECIDED for j in own)
        label = document.find_chain(name).label
        count = "1 interval" if len(own) == 1 else f"{len(own)} intervals"
        told = f"{label} is gone, and so is what was found in it: {count}, {decided} decided. "
        rig, what = self._rig.without(name), f"Remove chain {label}"
        document.change_chains(rig, what, f"{told}Undo brings all back." if own else "")

    def restore_chains(self) -> None:
        """The chains that are found, and no others."""
        if self._open():
            self._change(AS_FOUND, "Chains as found", "These are the chains as found.")

    def use_rig(self) -> None:
        """The chains that are kept for this skeleton."""
        data = self.document.data
        if data is None or not self._open():
            return
        rig, told = kept_rig(data.motion)
        if told or not rig_path(data.motion.skeleton).exists():
            self.bar.show_message(told or "Nothing is kept for this skeleton.", bool(told))
        else:
            self._change(rig, "Use the rig profile", "These are the chains of the rig profile.")

    def _change(self, rig: Rig, what: str, already: str) -> None:
        if rig == self._rig:
            self.bar.show_message(already, False)
        else:
            self.document.change_chains(rig, what)

    def keep_rig(self) -> None:
        """Keep the chains for all clips of this skeleton that have no session yet."""
        data, rig = self.document.data, self._rig
        if data is None or not self._open():
            return
        try:
            keep_rig(rig, data.motion.skeleton, data.clip.name)
        except OSError as error:
            place = rig_path(data.motion.skeleton)
            self.bar.show_message(f"{place}: not written ({error.strerror}).", True)
            return
        which = f"these chains ({rig.summary()})" if rig else "the chains as found"
        told = f"Clips of this skeleton that have no session open with {which} from now on."
        self.bar.show_message(told, False)

    def _open(self) -> bool:
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
        return self.document.data is not None
