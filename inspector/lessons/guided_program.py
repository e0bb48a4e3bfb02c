"""What the tour and the exercise reach of the program, so that neither knows the window."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction

from inspector.lessons.guide_card import GuideCard
from inspector.lessons.interrupted_review import Aside
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.teaching.taught_frame import TaughtFrame
from inspector.viewport.viewport import Viewport


@dataclass(frozen=True, eq=False)
class GuidedProgram:
    """The parts that a guided page reads and drives.

    list_all: takes the filter off the list of intervals, its answer puts it back; show_intervals,
    show_teaching: bring the tab to the front; actions: by their ids.
    """

    document: Document
    taught: TaughtFrame
    viewport: Viewport
    settings: Settings
    guide: GuideCard
    aside: Aside
    actions: Mapping[str, QAction]
    list_all: Callable[[], Callable[[], None]]
    show_intervals: Callable[[], None]
    show_teaching: Callable[[], None]
