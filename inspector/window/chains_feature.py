"""The list of chains and its actions, as a feature of the window."""

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
    """The panel with the list of chains, and its actions."""

    def __init__(self, window: HostWindow) -> None:
        names = window.actions_by_id["joint_names"]
        self.chains = ChainsPanel(window.document, window.colours, names)

    def connect(self, window: HostWindow) -> None:
        """Build the actions and the context menu for the list of chains."""
        listed = [row.id for row in _ROWS if row is not None and row.in_list]
        self.chains.table.addActions([window.actions_by_id[name] for name in listed])
        self.chains.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.chain_actions = ChainActions(
            window.document, window.bar, window.docks["chains"], window
        )


# fmt: off
_ROWS: tuple[ActionRow[Chains] | None, ...] = (
    ActionSpec("add_chain", tr("Add chain…"), ("Ctrl+Shift+C",),
               tr("Choose two or three joints, for example of the spine, the neck or a finger"),
               needs="clip", in_list=True, do=lambda p: p.chain_actions.add_chain()),
    ActionSpec("remove_chain", tr("Remove chain"), (),
               tr("Remove the selected chain and its intervals; undo restores them"),
               needs="clip", in_list=True, do=lambda p: p.chain_actions.remove_chain()),
    ActionSpec("joint_names", tr("Joint names…"), (),
               tr(
                   "See which body part each joint was recognised as, and name an unknown hand "
                   "or foot"
               ),
               needs="clip", do=lambda p: p.chain_actions.joint_names()),
    ActionSpec("restore_chains", tr("Restore detected chains"), (),
               tr("Undo all chain additions, removals and renames"),
               needs="clip", do=lambda p: p.chain_actions.restore_chains()),
    None,
    ActionSpec("keep_rig", tr("Save as rig profile"), (),
               tr("Use these chains for all clips with this skeleton that have no session"),
               needs="clip", do=lambda p: p.chain_actions.keep_rig()),
    ActionSpec("use_rig", tr("Use the rig profile"), (),
               tr("Use the chains that are saved for this skeleton"),
               needs="clip", do=lambda p: p.chain_actions.use_rig()),
)
# fmt: on

feature = Feature(
    "chains",
    Chains,
    rows=(MenuRows("Chains", _ROWS),),
    panels=(DockPanel("chains", tr("Chains"), Area.RightDockWidgetArea, lambda p: p.chains),),
)
