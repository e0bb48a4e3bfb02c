"""Run a lesson: show its pages, set up the program for each page, and check the tasks."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QPushButton

from inspector.language import tr
from inspector.lessons.guide_card import leave_button
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_checks import Visit, all_met, meet_all
from inspector.lessons.lesson_file import LessonFile, LessonPage
from inspector.lessons.lesson_text import formulas
from inspector.lessons.page_in_clip import lesson_page_chain
from inspector.lessons.scene_of_page import ViewBefore, show_lesson_place
from inspector.session.opening import Analysed, analyse_clip
from inspector.widgets.background import OneTask
from twistcore.formats.bvh import read_bvh
from twistcore.tuning import Profile

Clips = dict[tuple[Path, str], Analysed]  # keyed by the path in the lesson and the detector


def analyse_lesson_clips(lesson: LessonFile, folder: Path) -> Clips:
    """Write copies of a lesson's clips to `folder`, analyse the copies, and return them.

    Raises TwistError if a page does not fit its clip.
    """
    clips: Clips = {}
    for page in lesson.pages:
        place = page.place
        key = place.clip, place.detector
        if key not in clips:
            own = folder / str(len(clips))  # two clips may have the same file name
            own.mkdir(exist_ok=True)
            clip = read_bvh(Path(shutil.copy(place.clip, own)))
            clips[key] = analyse_clip(clip, Profile({}, place.detector))
        lesson_page_chain(lesson, page, clips[key])
    return clips


class LessonPlayer(QObject):
    """Guides the user through a lesson on copies of its clips. The user's own clip is put aside."""

    began = Signal()  # the first page is about to be shown
    turned = Signal()  # another page is shown
    ended = Signal()
    finished = Signal()  # the user has finished the last page; emitted after `ended`

    def __init__(self, program: GuidedProgram, parent: QObject) -> None:
        super().__init__(parent)
        self._program = program
        self._clips: Clips = {}
        self._visit = Visit(program, 0)
        self._view_before: ViewBefore | None = None  # the view before the lesson
        self._preparing = False  # while a page is being set up, its task is not checked
        self.pages: Sequence[LessonPage] = ()
        self.at = -1
        self._task = OneTask(self)
        self.back, self.show_me = QPushButton(tr("Back")), QPushButton(tr("Show me"))
        self.forward = QPushButton(tr("Next"))
        tip = tr("End the lesson. Your own clip comes back unchanged.")
        self.leave = leave_button(tip)
        for button, slot in (
            (self.back, lambda: self._turn(-1)),
            (self.show_me, self._show),
            (self.forward, lambda: self._turn(1)),
            (self.leave, self.end),
        ):
            button.clicked.connect(slot)
        document, taught = program.document, program.taught
        for signal in (document.frame_changed, document.intervals_changed, taught.changed):
            signal.connect(self._check)
        document.show_changed.connect(self._check)
        taught.lit_changed.connect(self._check)

    @property
    def running(self) -> bool:
        """Return True while a lesson is running or about to start."""
        return self.at >= 0 or self._task.running

    def begin(self, lesson: LessonFile, failed: Callable[[Exception], object]) -> None:
        """Read copies of the clips in the background, then show the first page.

        If a clip cannot be read, `failed` is called with the error.
        """
        folder = self._program.aside.folder()
        self.pages = lesson.pages
        self._program.guide.prepare([t for page in lesson.pages for t in formulas(page.body)])
        self._task.run(lambda _: analyse_lesson_clips(lesson, folder), self._ready, failed)

    def end(self) -> None:
        """End the lesson, and show the user's own clip again."""
        self._task.cancel()
        if self.at >= 0:
            self.at = -1
            self._program.taught.reset()
            self._program.taught.remove_highlight()
            self._program.taught.set_rows(())
            self.dim(on=False)
        if self._view_before is not None:
            self._view_before.restore()
            self._view_before = None
        self._clips = {}
        self.ended.emit()

    def dim(self, *, on: bool) -> None:
        """Dim the parts of the window that the user need not watch, or none if `on` is False."""
        shown = on and self.at >= 0
        self._program.dimming.watch(self.pages[self.at].place.watched if shown else ())

    def _ready(self, clips: Clips) -> None:
        self._clips = clips
        self._view_before = ViewBefore(self._program)
        self.began.emit()
        self._program.guide.set_buttons([self.back, self.show_me, self.forward], [], self.leave)
        self._go(0)

    def _turn(self, pages: int) -> None:
        if self.at >= 0:  # the buttons of the previous lesson may still be visible
            self._go(self.at + pages)

    def _go(self, at: int) -> None:
        if at >= len(self.pages):
            self.end()
            self.finished.emit()
            return
        self.at = at
        page = self.pages[at]
        heading = f"{at + 1} / {len(self.pages)}  {page.title}"
        self._program.guide.show_page(heading, page.body, page.task)
        self.back.setEnabled(at > 0)
        self.show_me.setEnabled(bool(page.done))
        self.forward.setText(tr("Next") if at + 1 < len(self.pages) else tr("Finish"))
        self._preparing = True
        data = self._clips[page.place.clip, page.place.detector]
        show_lesson_place(self._program, data, page.place)
        self.turned.emit()
        self._preparing = False
        self._visit = Visit(self._program, self._program.document.frame, page.place.chain)
        self._check()

    def _show(self) -> None:
        if self.at < 0:  # the user's own clip is still open
            return
        meet_all(self._visit, self.pages[self.at].done)
        taught = self._program.taught
        if taught.what_if.swing is not None or taught.what_if.bend is not None:
            self._program.viewport.focus_chain(self._program.settings.turn_ms)

    def _check(self, *_: object) -> None:
        guide = self._program.guide
        if self.at < 0 or self._preparing or guide.done:
            return
        done = self.pages[self.at].done
        if done and all_met(self._visit, done):
            guide.set_done(True)
