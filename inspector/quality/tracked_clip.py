"""Track the open clip with QuaMo in the background, when the user requests it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QObject, QTimer, Signal

from inspector.language import tr, translate_core_sentence
from inspector.quality.evidence import up_axis
from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.widgets.background import OneTask
from twistcore.analysis.correction.twist_removal import refine
from twistcore.analysis.quality.figure import FigureQuality, quality_before_and_after
from twistcore.analysis.quality.joint import JointQuality, joint_accelerations, joint_quality
from twistcore.detection import Interval
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.quamo.clip_tracking import Traces, track_motion_with_internal_values
from twistcore.review import Track, Tracking
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array
from twistcore.work.progress import Tell

_SETTLE_MS = 250  # wait until a series of decisions has ended before tracking again


@dataclass(frozen=True, eq=False)
class Result:
    """The result of tracking a clip.

    Attributes
    ----------
    wanted
        The tracking request.
    motion
        The tracked motion.
    rotations, positions
        The global rotations, (frames, joints, 4), and positions, (frames, joints, 3), after
        tracking.
    traces
        The internal values of the tracker in each step.
    accelerations
        The accelerations of the joints before and after tracking, (frames, joints) each, in m/s².
    joints
        The quality measures of the joints after tracking.
    quality
        The quality of the figure before and after tracking; None if it is not defined.
    """

    wanted: _Request
    motion: Motion
    rotations: Array
    positions: Array
    traces: Traces
    accelerations: tuple[Array, Array]
    joints: JointQuality
    quality: tuple[FigureQuality, FigureQuality] | None


@dataclass(frozen=True)
class _Request:
    data_id: int
    tracking: Tracking
    intervals: tuple[Interval, ...]


class Tracked(QObject):
    """Tracks the open clip with the settings in the review or in a new request.

    As in the 3D view, all intervals that are not rejected are corrected first.

    Attributes
    ----------
    result
        The result for the current review, or None if there is none yet.
    """

    changed = Signal()
    progress = Signal(float)

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self.result: Result | None = None
        self.asked: Tracking | None = None  # a request that is not part of the review yet
        self._task = OneTask(self)
        self._under_way: _Request | None = None
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settle.timeout.connect(self._start)
        document.opened.connect(self._reset)
        document.intervals_changed.connect(self._check)

    @property
    def running(self) -> bool:
        """True while tracking is running."""
        return self._task.running

    def ask(self, tracking: Tracking) -> None:
        """Start tracking. When the result is ready, the settings are stored in the review."""
        self.asked = tracking
        self._start()

    def cancel(self) -> None:
        """Cancel a new tracking request. The review keeps its previous tracking settings."""
        self.asked = None
        self._halt()
        self._start()
        self.changed.emit()

    def stop(self) -> None:
        """Remove the tracking from the review, in a step that can be undone."""
        if self._document.data is not None and self._document.review.state.tracking is not None:
            self._document.do(Track(None))

    def pose(self, frame: int) -> tuple[Array, Array] | None:
        """Return the tracked rotations and positions of a frame, or None if nothing is tracked.

        These are global rotations, (joints, 4), and positions, (joints, 3).
        """
        if self.result is None:
            return None
        return self.result.rotations[frame], self.result.positions[frame]

    def close(self) -> None:
        """Cancel all work, because the clip or the window is being closed."""
        self._settle.stop()
        self.asked = None
        self._halt()

    def _reset(self) -> None:
        self.close()
        self._hold(None)
        self._start()
        self.changed.emit()

    def _check(self) -> None:
        """Track again if neither the result nor the running tracking matches the current review."""
        wanted = self._request()
        if wanted is None:
            had = self.result is not None or self.running
            self._settle.stop()
            self._halt()
            self._hold(None)
            # Without tracking, this code runs at every step of τ, and nothing needs to be drawn
            if had:
                self.changed.emit()
        elif (self._under_way or (self.result and self.result.wanted)) != wanted:
            self._settle.start()

    def _request(self) -> _Request | None:
        data = self._document.data
        if data is None:
            return None
        state = self._document.review.state
        tracking = self.asked or state.tracking
        return _Request(id(data), tracking, state.chosen(undecided=True)) if tracking else None

    def _hold(self, result: Result | None) -> None:
        """Store a result, and show its motion in the 3D view. None removes the result."""
        self.result = result
        self._document.show_tracked(result.motion if result else None)

    def _halt(self) -> None:
        self._task.cancel()
        self._under_way = None

    def _start(self) -> None:
        self._settle.stop()
        wanted, data = self._request(), self._document.data
        if wanted is None or data is None or wanted == self._under_way:
            return
        if self.result is not None and self.result.wanted == wanted:
            return
        self._halt()
        self._under_way = wanted
        work = partial(_work, data, wanted)
        self._task.run(work, self._take, self._fail, self.progress.emit)
        self.changed.emit()

    def _take(self, result: Result) -> None:
        self._under_way = None
        self._hold(result)
        if self.asked is not None:
            asked, self.asked = self.asked, None
            self._document.do(Track(asked))
        self._check()
        self.changed.emit()

    def _fail(self, error: Exception) -> None:
        self._under_way = self.asked = None
        why = translate_core_sentence(error)
        message = tr("The joints could not be tracked: {why}.", why=why)
        self._document.message.emit(message, True)
        self.changed.emit()


def _work(data: Analysed, wanted: _Request, tell: Tell) -> Result:
    refined = refine(data.motion, data.chains_and_limbs, wanted.intervals)
    found, traces = track_motion_with_internal_values(refined, wanted.tracking, tell)
    tell(1.0)
    rotations, positions = forward_kinematics(found)
    joints = joint_quality(data.clip, positions, up_axis(data), found)
    before = joint_accelerations(refined, forward_kinematics(refined)[1])
    accelerations = before, joint_accelerations(refined, positions)
    first = count_leading_rest_frames(refined)
    given, made = (m.sliced(first, m.frames) for m in (refined, found))
    quality = quality_before_and_after(given, made)
    return Result(wanted, found, rotations, positions, traces, accelerations, joints, quality)
