"""What the window is made of, and the kinds of action that work on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow

from inspector.folder.folder_actions import FolderActions
from inspector.lessons.lesson_actions import LessonActions
from inspector.quality.quality_panel import QualityPanel
from inspector.recording.record_actions import RecordActions
from inspector.session.document import Document
from inspector.session.player import Player
from inspector.session.settings import Settings
from inspector.timeline.timeline import Timeline
from inspector.tuning.tuning_actions import TuningActions
from inspector.tuning.tuning_panel import TuningPanel
from inspector.video.video_actions import VideoActions
from inspector.video.video_panel import VideoPanel
from inspector.viewport.viewport import Viewport
from inspector.window.actions import Row
from inspector.window.chain_actions import ChainActions
from inspector.window.file_actions import FileActions
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_actions import ReviewActions
from inspector.window.usual_layout import UsualLayout


class Parts(QMainWindow):
    """The window, as actions know it; docks: by their object names."""

    docks: dict[str, QDockWidget]
    document: Document
    player: Player
    settings: Settings
    viewport: Viewport
    timeline: Timeline
    tuning: TuningPanel
    video: VideoPanel
    quality: QualityPanel
    presentation: Presentation
    usual_layout: UsualLayout
    program: ProgramActions
    files: FileActions
    review_actions: ReviewActions
    chain_actions: ChainActions
    tuning_actions: TuningActions
    lesson_actions: LessonActions
    record_actions: RecordActions
    video_actions: VideoActions
    folder_actions: FolderActions


@dataclass(frozen=True)
class ActionSpec(Row):
    """A row that does one thing; one of a group does it when it becomes the checked one."""

    do: Callable[[Parts], object] = field(kw_only=True)

    def connect(self, action: QAction, parts: Parts) -> None:
        """Let the action do it from now on."""
        if self.group:
            action.toggled.connect(lambda on: self.do(parts) if on else None)
        else:
            action.triggered.connect(lambda *_: self.do(parts))


@dataclass(frozen=True)
class Switch(Row):
    """A row that turns something on and off."""

    turn: Callable[[Parts, bool], object] = field(kw_only=True)
    checkable: ClassVar[bool] = True

    def connect(self, action: QAction, parts: Parts) -> None:
        """Let the action turn it from now on."""
        action.toggled.connect(lambda on: self.turn(parts, on))
