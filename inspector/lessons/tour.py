"""The guided tour: pages that drive the real program, each with something to do and a check."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QPushButton

from inspector.lessons.guide_card import leave_button
from inspector.lessons.guided_program import GuidedProgram
from inspector.session.opening import Analysed, analysed
from inspector.widgets.background import OneTask
from twistcore.bvh import read_bvh
from twistcore.detection import Kind
from twistcore.review import Decision

_CHAIN, _FRAME = "LeftForeArm", 90
_LIMB, _FLIPPED_FRAME = "RightUpLeg-RightFoot", 48
_FAR = 50  # frames
_NUDGED = np.radians(0.5)


@dataclass(frozen=True)
class Step:
    """name: of its page; prepare: before it; done: whether it was done; show: does it."""

    name: str
    prepare: Callable[[], None]
    done: Callable[[], bool]
    show: Callable[[], None]


class Tour(QObject):
    """Leads through the steps on copies of a sample clip and of one with a flip of a limb."""

    ended = Signal()

    def __init__(
        self, program: GuidedProgram, sample: Path, flipped: Path, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._program, self._clips = program, (sample, flipped)
        self._sample: Analysed | None = None
        self._flipped: Analysed | None = None
        self.at = -1
        self._from = 0
        self._preparing = False  # what prepares a step does not count as done by the person
        self._met: set[str] = set()
        self._task = OneTask(self)
        self.back, self.show_me = QPushButton("Back"), QPushButton("Show me")
        self.forward, self.leave = QPushButton("Next"), leave_button("the tour")
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
        taught.lit_changed.connect(self._check)
        self.steps = self._make_steps()

    @property
    def running(self) -> bool:
        """Whether the tour is on."""
        return self.at >= 0 or self._task.running

    def begin(self) -> None:
        """Read the copies in the background, then the first page."""
        folder = self._program.aside.folder()
        copies = [Path(shutil.copy(clip, folder)) for clip in self._clips]
        self._task.run(lambda _: [analysed(read_bvh(copy)) for copy in copies], self._ready)

    def end(self) -> None:
        """Back to the person's clip."""
        self._task.cancel()
        if self.at >= 0:
            self.at = -1
            self._program.taught.reset()
            self._program.taught.unlight()
        self.ended.emit()

    def _ready(self, clips: list[Analysed]) -> None:
        self._sample, self._flipped = clips
        self._program.guide.set_buttons([self.back, self.show_me, self.forward], [], self.leave)
        self._go(0)

    def _turn(self, pages: int) -> None:
        if self.at >= 0:  # while a tour is being prepared the buttons of the last one may show
            self._go(self.at + pages)

    def _go(self, at: int) -> None:
        if at >= len(self.steps):
            self.end()
            return
        self.at = at
        self._met.clear()
        step = self.steps[at]
        self._program.guide.show_page(step.name, f"{at + 1} / {len(self.steps)}  ")
        self.back.setEnabled(at > 0)
        self.forward.setText("Next" if at + 1 < len(self.steps) else "Finish")
        self._preparing = True
        step.prepare()
        self._preparing = False
        self._from = self._program.document.frame
        self._check()

    def _show(self) -> None:
        if self.at < 0:  # the clip is the person's own still
            return
        self.steps[self.at].show()
        if self._program.taught.what_if.changes:
            self._program.viewport.focus_chain(self._program.settings.turn_ms)

    def _check(self, *_: object) -> None:
        guide = self._program.guide
        if self.at < 0 or self._preparing or guide.done:
            return
        if self.steps[self.at].done():
            guide.set_done(True)

    # -- the steps ----------------------------------------------------------------------------

    def _make_steps(self) -> tuple[Step, ...]:
        taught, document = self._program.taught, self._program.document
        return (
            Step(
                "1-roll",
                self._to_start,
                lambda: abs(document.frame - self._from) >= _FAR,
                lambda: document.go_to(self._from + _FAR),
            ),
            Step("2-axis", self._to_lesson, lambda: taught.lit == "w", self._light),
            Step(
                "3-swing",
                self._to_lesson,
                lambda: (taught.what_if.swing or 0.0) >= np.radians(119.95),
                lambda: taught.alter(swing=np.radians(135.0)),
            ),
            Step(
                "4-twist",
                self._to_lesson,
                lambda: (
                    abs(taught.what_if.twist) >= np.radians(59.95) and not taught.what_if.counter
                ),
                lambda: taught.alter(twist=np.radians(75.0), counter=False),
            ),
            Step(
                "5-error",
                self._to_error,
                lambda: taught.what_if.counter and self._opposed(),
                lambda: taught.alter(counter=True),
            ),
            Step("6-singular", self._to_lesson, self._both_met, self._meet_both),
            Step("7-review", self._to_review, self._one_accepted, self._accept_one),
            Step("8-limb", self._to_limb, self._flip_accepted, self._accept_one),
        )

    def _to_start(self) -> None:
        self._program.show_intervals()
        self._to_place()

    def _to_lesson(self) -> None:
        self._program.show_teaching()
        self._to_place()

    def _to_place(self) -> None:
        self._show_clip(self._sample)
        self._look_at(_CHAIN, _FRAME)

    def _look_at(self, chain: str, frame: int) -> None:
        program = self._program
        program.document.select_chain(chain)
        program.document.go_to(frame)
        program.taught.reset()
        program.taught.unlight()
        program.viewport.focus_chain()

    def _show_clip(self, data: Analysed | None) -> None:
        """One of the two copies, if it is not the one that is seen."""
        if data is not None and self._program.document.data is not data:
            self._program.aside.show(data)

    def _to_error(self) -> None:
        self._to_lesson()
        self._program.taught.alter(twist=np.radians(75.0))

    def _to_review(self) -> None:
        self._show_clip(self._sample)
        self._program.taught.reset()
        self._program.show_intervals()

    def _to_limb(self) -> None:
        self._show_clip(self._flipped)
        self._program.show_intervals()
        document = self._program.document
        for judged in document.intervals:
            own = judged.interval
            if own.chain == _LIMB and own.start <= _FLIPPED_FRAME < own.stop:
                document.select_interval(judged.id)
        self._look_at(_LIMB, _FLIPPED_FRAME)

    def _light(self) -> None:
        if self._program.taught.lit != "w":
            self._program.taught.light("w")

    def _opposed(self) -> bool:
        quantities = self._program.taught.quantities
        return quantities is not None and quantities.strength >= np.radians(30.0)

    def _both_met(self) -> bool:
        """Each singularity was nudged, one after the other."""
        what_if = self._program.taught.what_if
        if abs(what_if.nudge) >= _NUDGED:
            if what_if.swing is not None and what_if.swing >= np.radians(178.0):
                self._met.add("swing")
            if what_if.bend is not None and what_if.bend <= np.radians(2.0):
                self._met.add("bend")
        return self._met == {"swing", "bend"}

    def _meet_both(self) -> None:
        self._program.taught.alter(swing=np.radians(179.0), nudge=np.radians(1.0))
        self._program.taught.alter(swing=None, bend=np.radians(1.0))

    def _one_accepted(self) -> bool:
        return any(j.decision == Decision.ACCEPTED for j in self._program.document.intervals)

    def _flip_accepted(self) -> bool:
        return any(
            j.decision == Decision.ACCEPTED and j.interval.kind == Kind.LIMB_FLIP
            for j in self._program.document.intervals
        )

    def _accept_one(self) -> None:
        if self._program.document.interval is None:
            self._program.actions["next_interval"].trigger()
        self._program.actions["accept"].trigger()
