"""The parts of the program that lessons and exercises use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction

from inspector.lessons.guide_card import GuideCard
from inspector.lessons.interrupted_review import Aside
from inspector.lessons.watched_places import Dimming
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.teaching.taught_frame import TaughtFrame
from inspector.viewport.viewport import Viewport


@dataclass(frozen=True, eq=False)
class GuidedProgram:
    """The parts of the program that a lesson or an exercise reads and controls.

    Attributes
    ----------
    actions
        The actions of the program, keyed by id.
    list_all
        A function that clears the filter of the list of intervals, and returns a function that
        restores the filter.
    show_intervals, show_teaching
        Functions that bring the intervals tab or the teaching tab to the front.
    dimming
        Dims the parts of the window that the user need not watch.
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
    dimming: Dimming
