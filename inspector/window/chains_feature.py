"""The chains of the clip as a feature of the window."""

from __future__ import annotations

from PySide6.QtCore import Qt

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
)
from inspector.language import tr
from inspector.panels.chains_panel import ChainsPanel
from inspector.window.chain_actions import ChainActions


class Chains(FeatureParts):
    """The list of chains, and what its actions do."""

    def __init__(self, window: HostWindow) -> None:
        names = window.actions_by_id["joint_names"]
        self.chains = ChainsPanel(window.document, window.colours, names)

    def connect(self, window: HostWindow) -> None:
        """Let the list have its menu, and the title name what differs from the chains as found."""
        listed = [row.id for row in _ROWS if row is not None and row.in_list]
        self.chains.table.addActions([window.actions_by_id[name] for name in listed])
        self.chains.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.chain_actions = ChainActions(
            window.document, window.bar, window.docks["chains"], window
        )


# fmt: off
_ROWS: tuple[ActionRow[Chains] | None, ...] = (
    ActionSpec("add_chain", tr("Add chain…"), ("Ctrl+Shift+C",),
               tr("Two or three joints: of the spine, the neck, a finger"),
               needs="clip", in_list=True, do=lambda p: p.chain_actions.add_chain()),
    ActionSpec("remove_chain", tr("Remove chain"), (),
               tr("The selected chain and its intervals; undo brings them back"),
               needs="clip", in_list=True, do=lambda p: p.chain_actions.remove_chain()),
    ActionSpec("joint_names", tr("Joint names…"), (),
               tr("What each joint was taken for; an unknown hand or foot is named here"),
               needs="clip", do=lambda p: p.chain_actions.joint_names()),
    ActionSpec("restore_chains", tr("Chains as found"), (), tr("None added, none removed"),
               needs="clip", do=lambda p: p.chain_actions.restore_chains()),
    None,
    ActionSpec("keep_rig", tr("Save as rig profile"), (),
               tr("Clips of this skeleton that have no session open with these chains"),
               needs="clip", do=lambda p: p.chain_actions.keep_rig()),
    ActionSpec("use_rig", tr("Use the rig profile"), (),
               tr("The chains kept for this skeleton"),
               needs="clip", do=lambda p: p.chain_actions.use_rig()),
)
# fmt: on

feature = Feature(
    "chains",
    Chains,
    rows=(MenuRows("Chains", _ROWS),),
    panels=(DockPanel("chains", tr("Chains"), Area.LeftDockWidgetArea, lambda p: p.chains),),
)
