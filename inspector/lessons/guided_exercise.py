"""The exercise: hidden errors in a borrowed clip, the ordinary review, and a score."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QSpinBox

from inspector.bundled import EXERCISE_PAGE
from inspector.lessons.guide_card import leave_button
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_file import body_and_task
from inspector.session.opening import Analysed, analysed
from inspector.widgets.background import OneTask
from inspector.widgets.signed_numbers import signed
from twistcore.bvh import read_bvh, write_bvh
from twistcore.chain import find_chains
from twistcore.detection import Interval
from twistcore.review import Review
from twistcore.study.exercise import Score, decoys, hide_errors, score
from twistcore.synthesis import InjectedError

KINDS = ("Judge", "Find")


def exercise_page() -> tuple[str, str, str]:
    """Title, text and task."""
    head, _, text = EXERCISE_PAGE.read_text(encoding="utf-8").partition("\n")
    return (head.removeprefix("# ").strip(), *body_and_task(text.splitlines()))


def make_exercise(
    clip: Path, folder: Path, seed: int, kind: str
) -> tuple[Analysed, tuple[InjectedError, ...]]:
    """A copy of a clip with hidden errors, as a review to begin with; safe in any thread."""
    source = read_bvh(clip)
    motion, chains = source.motion, find_chains(source.motion)
    dirty, errors = hide_errors(motion, chains, seed)
    path = folder / f"exercise_{seed}.bvh"
    write_bvh(source, dirty, path)
    data = analysed(read_bvh(path))
    listed: list[Interval] = []
    if kind == "Judge":
        listed = [Interval(e.chain, e.start, e.stop, e.offset) for e in errors]
        listed += decoys(motion, chains, errors, seed)
    found = replace(data.analysis.detect(), intervals=tuple(listed))
    return replace(data, review=Review.of(found)), errors


class Exercise(QObject):
    """Leads through an exercise."""

    ended = Signal()

    def __init__(self, program: GuidedProgram, clips: tuple[Path, ...], parent: QObject) -> None:
        """`clips`: of which the seed chooses one."""
        super().__init__(parent)
        self._program, self._clips = program, clips
        self.running = False
        self._errors: tuple[InjectedError, ...] = ()
        self._task = OneTask(self)
        self.result: Score | None = None
        self.kind, self.seed = QComboBox(), QSpinBox()
        self.kind.addItems(KINDS)
        self.kind.setToolTip("Judge a list, or find the errors yourself")
        self.seed.setRange(1, 9999)
        self.seed.setToolTip("The same seed hides the same errors")
        self.seed_label = QLabel("Seed")
        self.start = QPushButton("Start")
        self.score_button = QPushButton("Score")
        self.leave = leave_button("the exercise")
        self.start.clicked.connect(self._start)
        self.score_button.clicked.connect(self.show_score)
        self.leave.clicked.connect(self.end)
        program.document.intervals_changed.connect(self._judged)

    def begin(self) -> None:
        """The page with its controls; nothing is opened yet."""
        self.running = True
        self.result = None
        self._errors = ()
        guide = self._program.guide
        guide.set_buttons(
            [self.start, self.score_button], [self.kind, self.seed_label, self.seed], self.leave
        )
        guide.show_page(*exercise_page())
        self.score_button.setEnabled(False)

    def end(self) -> None:
        """Back to the person's clip."""
        self._task.cancel()
        self.running = False
        self.ended.emit()

    def _start(self) -> None:
        folder, seed = self._program.aside.folder(), self.seed.value()
        clip, kind = self._clips[seed % len(self._clips)], self.kind.currentText()
        self.start.setEnabled(False)
        self._task.run(lambda _: make_exercise(clip, folder, seed, kind), self._ready)

    def _ready(self, made: tuple[Analysed, tuple[InjectedError, ...]]) -> None:
        data, self._errors = made
        self.result = None
        self.start.setEnabled(True)
        self.start.setText("Start anew")
        self.score_button.setEnabled(True)
        self._program.guide.show_page(*exercise_page())
        self._program.aside.show(data)
        self._program.show_intervals()
        self._judged()

    def _judged(self) -> None:
        if self.running and self._errors and self.result is None:
            intervals = self._program.document.intervals
            judged = len(intervals) - score(self._errors, intervals).left
            count = f"{judged} of {len(intervals)} judged"
            self._program.guide.set_task(f"{count}. Press *Score* when you are done.")

    def show_score(self) -> None:
        """What the verdicts come to, with links to what was missed or judged wrongly."""
        guide = self._program.guide
        self.result = result = score(self._errors, self._program.document.intervals)
        guide.show_text(score_text(result))
        total, wrong = len(self._errors), result.false_verdicts
        guide.set_task(
            f"{len(result.hits)} of {total} found, {wrong} false verdict{'s' * (wrong != 1)}."
        )
        guide.set_done(True)

    def go_to(self, address: str) -> None:
        """Follow a link of the score: chain and frame."""
        chain, _, frame = address.removeprefix("at:").rpartition("/")
        if self.running and chain:
            document = self._program.document
            document.select_chain(chain)
            document.go_to(int(frame))
            self._program.viewport.focus_chain()


def score_text(result: Score) -> str:
    """The score as Markdown."""
    lines = [
        f"**Hits {len(result.hits)}** · **misses {len(result.misses)}** · "
        f"**false verdicts {result.false_verdicts}**",
        "",
    ]
    for title, rows in (
        ("Found", result.hits),
        ("Missed", result.misses),
        ("Rejected, but an error", result.false_rejected),
        ("Accepted, but natural", result.false_accepted),
    ):
        if rows:
            lines += [f"{title}:", ""]
            lines += [_row(r) for r in rows]
            lines.append("")
    if result.left:
        lines.append(f"{result.left} intervals have no verdict.")
    return "\n".join(lines)


def _row(found: InjectedError | Interval) -> str:
    largest = found.offset[int(np.argmax(np.abs(found.offset)))]
    degrees = f"{signed(np.degrees(largest), 0)}°"
    place = f"{found.chain}, frames {found.start} to {found.stop - 1}, {degrees}"
    return f"- [{place}](at:{found.chain}/{found.start})"
