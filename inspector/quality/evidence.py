"""Compute quality measures of the open clip in the background, such as jitter and foot slide."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.widgets.background import OneTask
from twistcore.analysis.quality.figure import FigureQuality, quality_before_and_after
from twistcore.analysis.quality.joint import SLIDE_SPEED, JointQuality, joint_quality
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.quamo.track_clip import find_figure_position_joint
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import guess_up
from twistcore.skeleton.rotation import Array


@dataclass(frozen=True)
class Measure:
    """A quality measure, shown as a column of the table and as a curve.

    Attributes
    ----------
    name, unit, tip
        The heading of the column, its unit and its tool tip.
    curve, curve_unit
        The title of the curve and its unit.
    decimals
        The number of decimals in the table.
    level
        The value of a horizontal line in the plot, or None.
    seldom
        True if only few frames have a value, as for foot slide.
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
        tr(
            "How much the joint trembles: the median size of the third difference of its "
            "local rotation"
        ),
        tr("jitter"),
        tr("°/frame³"),
        2,
    ),
    Measure(
        tr("Jumps"),
        "",
        tr(
            "Frames in which the file's numbers jump although the pose does not: the angles change "
            "by over 90° more than the joint turns, or the quaternion flips sign"
        ),
        tr("how much more the angles change than the joint turns"),
        "°",
        0,
        90.0,
    ),
    Measure(
        tr("Peak"),
        "°/s",
        tr("Largest angular speed of the joint relative to its parent"),
        tr("angular speed"),
        "°/s",
        0,
    ),
    Measure(
        tr("Slide"),
        "%",
        tr("Share of frames in which a foot on the ground slides at 0.5 m/s or more"),
        tr("horizontal speed while on the ground"),
        "m/s",
        1,
        SLIDE_SPEED,
        seldom=True,
    ),
)


def quality_measure_by_joint(q: JointQuality, measure: int) -> Array:
    """Return a quality measure for each joint, (joints,). Undefined values are NaN.

    `measure` is an index of MEASURES.
    """
    return (q.usual_jitter, q.jumps.astype(np.float64), q.top_speed, q.slides)[measure]


def quality_measure_by_frame(q: JointQuality, measure: int, joint: int) -> Array:
    """Return a quality measure of one joint for each frame, (frames,). Undefined values are NaN.

    `measure` is an index of MEASURES, and `joint` the index of the joint.
    """
    values: Array = (q.jitter, q.excess, q.speed, q.slide)[measure][:, joint]
    return values


@dataclass(frozen=True, eq=False)
class FigureEvidence:
    """Quality measures of all joints and, for figures with QuaMo's 24 joints, of the whole figure.

    Attributes
    ----------
    placed
        The index of the joint that stores the position of the figure, or None.
    """

    joints: JointQuality
    figure: FigureQuality | None
    placed: int | None

    def curve(self, measure: int, joint: int) -> Array:
        """Return a quality measure of one joint for each frame, (frames,).

        See :func:`quality_measure_by_frame`.
        """
        return quality_measure_by_frame(self.joints, measure, joint)


class QualityEvidence(QObject):
    """Computes quality measures of the open clip while the quality tab is visible."""

    changed = Signal()

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._task = OneTask(self)
        self._watching = False
        self.known: FigureEvidence | None = None
        document.opened.connect(self._reset)

    @property
    def running(self) -> bool:
        """True while quality measures are being computed."""
        return self._task.running

    def watch(self, on: bool) -> None:
        """Start computing quality measures of opened clips, or stop doing so if `on` is False.

        A computation that is already running continues.
        """
        self._watching = on
        self._start()

    def stop(self) -> None:
        """Cancel the running computation."""
        self._task.cancel()

    def _reset(self) -> None:
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
        why = translate_core_sentence(error)
        message = tr("The quality of the clip could not be computed: {why}", why=why)
        self._document.message.emit(message, True)


def up_axis(data: Analysed) -> int:
    """Return the index of the coordinate axis that points up: 0, 1 or 2."""
    up = guess_up(data.positions, find_chains(data.motion), data.motion.skeleton)
    return int(np.argmax(up))


def _work(data: Analysed) -> FigureEvidence:
    joints = joint_quality(data.clip, data.positions, up_axis(data))
    # A T-pose in the first frames was not captured, so the jump after it is not jitter.
    capture = data.motion.sliced(count_leading_rest_frames(data.motion), data.motion.frames)
    both = quality_before_and_after(capture, capture)
    return FigureEvidence(
        joints, both[0] if both else None, find_figure_position_joint(data.motion)
    )
