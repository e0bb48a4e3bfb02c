"""The actions that add and remove chains of the clip."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QWidget

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.rig_profiles import load_rig_profile, rig_path, save_rig_profile
from inspector.widgets.message_bar import MessageBar
from inspector.window.chain_dialog import ChainDialog
from inspector.window.joint_names_dialog import JointNamesDialog
from twistcore.files.ordinary import path_exists
from twistcore.review import Decision
from twistcore.skeleton.rig import AS_FOUND, Rig


@dataclass(eq=False)
class ChainActions:
    """The actions that add and remove chains, set the roles of joints, and save both.

    Saved chains apply to all clips with the same skeleton.

    Attributes
    ----------
    dock
        The dock with the list of chains. Its title shows how many chains were changed.
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
            tr("Chains ({changed})", changed=_changes_text(rig)) if rig else tr("Chains")
        )

    @property
    def _rig(self) -> Rig:
        return self.document.review.state.rig if self.document.data else AS_FOUND

    def add_chain(self) -> None:
        """Open the dialog in which the user chooses the joints of a new chain."""
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
        """Open the dialog in which the user can change the role of each joint."""
        if not self._open():
            return
        if self.names is None:
            self.names = JointNamesDialog(self.document, self.window)
            self.names.chosen.connect(self._use_names)
            self.names.finished.connect(self._forget_names)
            self.names.show()
        self.names.raise_()
        self.names.activateWindow()

    def _forget_names(self) -> None:
        self.names = None

    def _use_names(self, rig: Rig) -> None:
        """Analyse the clip with the joint roles that the user has assigned.

        The roles are also saved for this skeleton.
        """
        if rig == self._rig:
            return
        message = tr(
            "From now on, clips with this skeleton open with these names, unless they have a "
            "session."
        )
        data = self.document.data
        if data is not None and self._keep(
            replace(load_rig_profile(data.motion)[0], names=rig.names)
        ):
            self.document.change_chains(rig, tr("Joint names"), message)
        else:
            self.document.change_chains(rig, tr("Joint names"))

    def remove_chain(self) -> None:
        """Remove the selected chain and its intervals, and show the number of removed intervals."""
        name, document = self.document.chain, self.document
        if not self._open() or not name:
            return
        own = document.review.state.of_chain(name)
        decided = sum(j.decision != Decision.UNDECIDED for j in own)
        label = translate_core_sentence(document.find_chain(name).label)
        message = tr(
            "{chain} was removed with {intervals}, {decided} of them decided. Undo restores them.",
            chain=label,
            intervals=plural("{n} interval", "{n} intervals", len(own)),
            decided=decided,
        )
        rig, what = self._rig.without(name), tr("Remove chain {name}", name=label)
        document.change_chains(rig, what, message if own else "")

    def restore_chains(self) -> None:
        """Restore the chains that the program finds automatically."""
        if self._open():
            self._change(
                AS_FOUND,
                tr("Restore detected chains"),
                tr("The detected chains are already in use."),
            )

    def use_rig(self) -> None:
        """Use the chains that the user has saved for this skeleton."""
        data = self.document.data
        if data is None or not self._open():
            return
        rig, trouble = load_rig_profile(data.motion)
        if trouble or not path_exists(rig_path(data.motion.skeleton)):
            nothing = tr("No rig profile is saved for this skeleton.")
            self.bar.show_message(trouble or nothing, bool(trouble))
        else:
            already = tr("The rig profile's chains are already in use.")
            self._change(rig, tr("Use the rig profile"), already)

    def _change(self, rig: Rig, what: str, already: str) -> None:
        if rig == self._rig:
            self.bar.show_message(already, False)
        else:
            self.document.change_chains(rig, what)

    def keep_rig(self) -> None:
        """Save the clip's chains for its skeleton.

        Other clips with this skeleton use these chains if they have no session yet.
        """
        rig = self._rig
        if not self._open() or not self._keep(rig):
            return
        which = tr("the detected chains")
        if rig:
            which = tr("these chains ({changed})", changed=_changes_text(rig))
        message = tr(
            "From now on, clips with this skeleton open with {chains}, unless they have a session.",
            chains=which,
        )
        self.bar.show_message(message, False)

    def _keep(self, rig: Rig) -> bool:
        """Write the rig profile of this skeleton. On failure, show a message and return False."""
        data = self.document.data
        assert data is not None
        try:
            save_rig_profile(rig, data.motion.skeleton, data.clip.name)
        except OSError as error:
            place = rig_path(data.motion.skeleton)
            message = tr(
                "The rig profile {file} could not be written ({why}).",
                file=place,
                why=translate_core_sentence(error.strerror),
            )
            self.bar.show_message(message, True)
            return False
        return True

    def _open(self) -> bool:
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
        return self.document.data is not None


def _changes_text(rig: Rig) -> str:
    """Return the user's changes to the automatic chains as text, such as '2 added, 1 removed'."""
    parts = (
        (tr("{n} added", n=len(rig.add)), rig.add),
        (tr("{n} removed", n=len(rig.remove)), rig.remove),
        (plural("{n} joint named", "{n} joints named", len(rig.names)), rig.names),
    )
    return ", ".join(text for text, some in parts if some)
