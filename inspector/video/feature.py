"""The witness video (a video of the same take) as a feature of the window."""

from __future__ import annotations

from pathlib import Path

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
    Switch,
)
from inspector.language import tr
from inspector.video.video_actions import VideoActions
from inspector.video.video_panel import VideoPanel
from inspector.video.video_reader import SUFFIXES


class Video(FeatureParts):
    """The witness video feature: the panel with the open clip's video, and the actions."""

    def __init__(self, window: HostWindow) -> None:
        colours, actions = window.colours, window.actions_by_id
        self.video = VideoPanel(window.document, colours, window.settings, actions)

    def connect(self, window: HostWindow) -> None:
        """Create the actions, and show the dock whenever a clip with a known video is opened."""
        dock = window.docks["video"]
        self.video_actions = VideoActions(window.document, self.video, dock, window)
        self.video.restored.connect(self.video_actions.show_dock)

    def take(self, path: Path) -> bool:
        """Show a dropped video next to the open clip. Return False if the file is not a video."""
        if is_video := path.suffix.lower() in SUFFIXES:
            self.video_actions.show_video(path)
        return is_video

    def close(self) -> None:
        """Close the video file."""
        self.video.close_file()


# fmt: off
_FILE: tuple[ActionRow[Video] | None, ...] = (
    None,
    ActionSpec("open_video", tr("Open witness video…"), ("Ctrl+Shift+V",),
               tr("Show a video of the same take next to the 3D view"),
               needs="clip", do=lambda p: p.video_actions.open_video()),
    ActionSpec("close_video", tr("Close the video"), (), tr("Remove the video from this clip"),
               needs="clip", do=lambda p: p.video_actions.close_video()),
)
_GO: tuple[ActionRow[Video] | None, ...] = (
    None,
    Switch("hold_video", tr("Hold the video"), ("W",),
           tr("Pause the video, move the playhead to the same moment, then release the video"),
           turn=lambda p, on: p.video.set_hold(on)),
)
# fmt: on

feature = Feature(
    "video",
    Video,
    rows=(
        MenuRows("File", _FILE, after="export_at_once"),
        MenuRows("Go", _GO, after="normal_speed"),
    ),
    panels=(
        DockPanel(
            "video",
            tr("Video"),
            Area.BottomDockWidgetArea,
            lambda p: p.video,
            shown=False,
            before="chains",
        ),
    ),
)
