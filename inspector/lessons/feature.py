"""Lessons and exercises, as a feature of the window."""

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
)
from inspector.language import tr, tr_as
from inspector.lessons.guide_card import GuideCard
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.interrupted_review import Aside
from inspector.lessons.lesson_actions import LessonActions
from inspector.lessons.watched_places import Dimming
from inspector.teaching.feature import feature as teaching


class Lessons(FeatureParts):
    """The card that shows the pages of lessons, and the actions of the Teach menu."""

    def __init__(self, window: HostWindow) -> None:
        self.guide = GuideCard(window.part(teaching).typesetter, window.colours)

    def connect(self, window: HostWindow) -> None:
        """Connect the lessons to the parts of the window that they control."""
        docks, taught = window.docks, window.part(teaching)

        def show_intervals() -> None:
            docks["intervals"].raise_()
            # In a presentation, this hides no other tab
            if window.actions_by_id["presentation"].isChecked():
                docks["teaching"].hide()

        program = GuidedProgram(
            document=window.document,
            taught=taught.taught,
            viewport=window.viewport,
            settings=window.settings,
            guide=self.guide,
            aside=Aside(window.document),
            actions=window.actions_by_id,
            list_all=window.intervals.list_all,
            show_intervals=show_intervals,
            show_teaching=taught.show,
            dimming=Dimming(window),
        )
        self.lesson_actions = LessonActions(program, docks["guide"], window)

    def close(self) -> None:
        """Close the window "Why quaternions" if it is open."""
        if (trackers := self.lesson_actions.five_trackers) is not None:
            trackers.close()


# fmt: off
_ROWS: tuple[ActionRow[Lessons] | None, ...] = (
    ActionSpec("tour", tr("Tour"), (), tr("A guided tour of swing, twist and their errors"),
               do=lambda p: p.lesson_actions.tour()),
    ActionSpec("open_lesson", tr("Open lesson…"), (),
               tr("Open your own lesson, a Markdown file"),
               do=lambda p: p.lesson_actions.open_lesson()),
    ActionSpec("export_page", tr("Export lesson as web page…"), (),
               tr("Write one HTML file with text, sliders and the 3D figure, for any browser"),
               do=lambda p: p.lesson_actions.export_page()),
    ActionSpec("copy_place", tr("Copy this view for a lesson"), (),
               tr(
                   "Copy the clip, frame, chain, camera and what-if values as settings for a "
                   "lesson page"),
               do=lambda p: p.lesson_actions.copy_place()),
    ActionSpec("exercise", tr("Exercise"), (), tr("Find hidden errors and get a score"),
               do=lambda p: p.lesson_actions.exercise()),
    None,
    ActionSpec("why_quaternions", tr("Why quaternions"), (),
               tr("See how five trackers follow one joint through ±180°"),
               do=lambda p: p.lesson_actions.why_quaternions()),
    None,
)
# fmt: on

feature = Feature(
    "lessons",
    Lessons,
    rows=(MenuRows("Teach", _ROWS),),
    panels=(
        DockPanel(
            "guide",
            tr_as("of a lesson", "Guide"),
            Area.LeftDockWidgetArea,
            lambda p: p.guide,
            shown=False,
            empty_at_start=True,
        ),
    ),
)
