"""A folder of clips, as a feature of the window."""

from __future__ import annotations

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
    Tick,
)
from inspector.folder.clips_panel import ClipsPanel
from inspector.folder.folder_actions import FolderActions
from inspector.folder.informative_intervals import InformativeIntervals
from inspector.folder.informative_step import InformativeStep
from inspector.folder.queue import FolderQueue
from inspector.folder.remembered_folders import NEXT_AFTER_EXPORT
from inspector.language import tr


class Folder(FeatureParts):
    """The queue of clips to analyse, the panel that lists the clips, and the folder's actions."""

    def __init__(self, window: HostWindow) -> None:
        self.queue = FolderQueue(parent=window)
        self.informative = InformativeIntervals(self.queue, window.document, window)
        self.clips = ClipsPanel(self.queue, window.document, window.colours, self.informative)
        self.informative_step = InformativeStep(self.informative, self.queue, window)
        self.clips.chosen.connect(window.open_path)

    def connect(self, window: HostWindow) -> None:
        """Create the actions that save the table of listed clips and the report."""
        listed, save = self.clips.listed, window.save_quietly
        self.folder_actions = FolderActions(self.queue, listed, window.bar, save, window)
        listing = window.docks["clips"].toggleViewAction()
        listing.setEnabled(False)
        self.queue.changed.connect(lambda: listing.setEnabled(self.queue.folder is not None))

    def close(self) -> None:
        """Stop the processes that analyse clips."""
        self.queue.close()


# fmt: off
_FILE: tuple[ActionRow[Folder] | None, ...] = (
    ActionSpec("save_clip_table", tr("Save the table of clips…"), (),
               tr("Save the table of the listed clips as a CSV file"),
               do=lambda p: p.folder_actions.save_clip_table()),
    ActionSpec("write_report", tr("Write the batch report"), (),
               tr(
                   "Write the report for a folder made by `twistcore batch`, including your "
                   "decisions"),
               do=lambda p: p.folder_actions.write_report()),
)
_GO: tuple[ActionRow[Folder] | None, ...] = (
    ActionSpec("next_informative", tr("Next informative interval"), ("Ctrl+Shift+M",),
               tr(
                   "Go to the automatic correction whose verdict will reveal most about the "
                   "others"),
               do=lambda p: p.informative_step.next()),
)
# fmt: on

feature = Feature(
    "folder",
    Folder,
    rows=(
        MenuRows("File", _FILE, after="export_at_once"),
        MenuRows("Go", _GO, after="next_faint"),
    ),
    panels=(
        DockPanel(
            "clips",
            tr("Clips"),
            Area.LeftDockWidgetArea,
            lambda p: p.clips,
            shown=False,
            empty_at_start=True,
            before="chains",
        ),
    ),
    settings=(Tick(NEXT_AFTER_EXPORT.name, tr("Open the folder's next clip after an export")),),
)
