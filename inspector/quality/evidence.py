"""What is known of the quality of the open clip, computed off the GUI thread when it is seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.language import of_core, tr
from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.widgets.background import OneTask
from twistcore.analysis.quality.figure import FigureQuality, quality_before_and_after
from twistcore.analysis.quality.joint import SLIDE_SPEED, JointQuality, joint_quality
from twistcore.detection.cuts import leading_frames
from twistcore.quamo.track_clip import placed_joint
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import guess_up
from twistcore.skeleton.rotation import Array


@dataclass(frozen=True)
class Measure:
    """A column of the table and what its curve shows.

    decimals: of the table; level: drawn across the curve, or None.
    """

    name: str
    unit: str
    tip: str
    curve: str
    curve_unit: str
    decimals: int
    level: float | None = None
    seldom: bool = False


MEASURES = (
    Measure(
        tr("Jitter"),
        tr("°/frame³"),
        tr("Median size of the third difference of the joint's own rotation"),
        tr("jitter"),
        tr("°/frame³"),
        2,
    ),
    Measure(
        tr("Jumps"),
        "",
        tr(
            "Frames at which the written angles jump by 90° more than the joint turns, or its "
            "quaternion flips to the other hemisphere: the numbers jump, the pose does not"
        ),
        tr("written angles beyond the turn"),
        "°",
        0,
        90.0,
    ),
    Measure(
        tr("Peak"),
        "°/s",
        tr("Largest angular speed of the joint against its parent"),
        tr("angular speed"),
        "°/s",
        0,
    ),
    Measure(
        tr("Slide"),
        "%",
        tr("Share of frames in which a foot on the ground slides by 0.5 m/s or more"),
        tr("level speed while on the ground"),
        "m/s",
        1,
        SLIDE_SPEED,
        seldom=True,
    ),
)


@dataclass(frozen=True, eq=False)
class FigureEvidence:
    """The joints' evidence, and the whole figure's where the 24 joints are there.

    placed: the joint whose place is the figure's; None where no joint has one.
    """

    clip: object
    joints: JointQuality
    figure: FigureQuality | None
    placed: int | None

    def column(self, measure: int) -> Array:
        """A number a joint; NaN where there is none, (joints,)."""
        q = self.joints
        return (q.usual_jitter, q.jumps.astype(np.float64), q.top_speed, q.slides)[measure]

    def curve(self, measure: int, joint: int) -> Array:
        """(frames,), NaN where there is none."""
        q = self.joints
        values: Array = (q.jitter, q.excess, q.speed, q.slide)[measure][:, joint]
        return values


class QualityEvidence(QObject):
    """Evidence of the document's clip. Nothing is computed while nobody looks."""

    changed = Signal()

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._task = OneTask(self)
        self._watching = False
        self.known: FigureEvidence | None = None
        document.opened.connect(self._another)

    @property
    def running(self) -> bool:
        """Whether it is still to come."""
        return self._task.running

    def watch(self, on: bool) -> None:
        """Compute from now on, as somebody looks; what runs when nobody does any more is kept."""
        self._watching = on
        self._start()

    def stop(self) -> None:
        """Forget what is under way."""
        self._task.cancel()

    def _another(self) -> None:
        self.stop()
        self.known = None
        self.changed.emit()
        self._start()

    def _start(self) -> None:
        data = self._document.data
        if self._watching and data is not None and not self.running and self.known is None:
            self._task.run(lambda _: _work(data), self._take, self._fail)

    def _take(self, known: FigureEvidence) -> None:
        self.known = known
        self.changed.emit()

    def _fail(self, error: Exception) -> None:
        why = of_core(error)
        self._document.message.emit(tr("Quality cannot be told: {why}", why=why), True)


def _work(data: Analysed) -> FigureEvidence:
    up = int(np.argmax(guess_up(data.positions, find_chains(data.motion), data.motion.skeleton)))
    joints = joint_quality(data.clip, data.positions, up)
    # A T-pose in the first frames is no capture: the leap out of it is no jitter.
    capture = data.motion.sliced(leading_frames(data.motion), data.motion.frames)
    both = quality_before_and_after(capture, capture)
    return FigureEvidence(data.clip, joints, both[0] if both else None, placed_joint(data.motion))
