"""Sort a folder's automatic corrections by how informative a verdict on each would be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import QueuedClip
from inspector.language import plural, tr
from inspector.session.document import Document
from inspector.session.session_files import find_existing_sessions, modified_ns
from inspector.widgets.background import OneTask
from twistcore.errors import TwistError
from twistcore.review import read_session
from twistcore.tuning.stated_precision import (
    ENOUGH_STATED,
    AutomaticCorrection,
    StatedPrecision,
    estimate_unjudged_precision,
    representative_judging_order,
    verdicts_on_automatic_corrections,
)
from twistcore.work.progress import Tell

_SETTLE_MS = 400  # time after the last verdict or result until sessions are read

_Verdicts = tuple[bool | None, ...]
# Keyed by the session's path, its time, and the corrections, which a new analysis may change.
_Known = dict[tuple[Path, int, tuple[AutomaticCorrection, ...]], _Verdicts]


@dataclass(frozen=True)
class Informative:
    """An automatic correction in a clip, with its verdict.

    The verdict is True if the correction is right, False if it is wrong, and None if nobody has
    judged it yet.
    """

    path: Path
    correction: AutomaticCorrection
    verdict: bool | None


class InformativeIntervals(QObject):
    """Orders a folder's automatic corrections, and estimates how many of them are right.

    The first corrections in the order are those whose verdicts would reveal most about the
    remaining ones. Sessions are read in the background after the whole folder has been analysed.
    After :meth:`look`, the signal `found` is emitted with the next correction to judge, or None.
    """

    changed = Signal()
    found = Signal(object)  # with an Informative, or None

    def __init__(
        self, queue: FolderQueue, document: Document, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._queue, self._document = queue, document
        self.ordered: tuple[Informative, ...] = ()
        self.stated: StatedPrecision | None = None
        self._cache: _Known = {}
        self._asked = False
        self._task = OneTask(self)
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settle.timeout.connect(self._start)
        for signal in (queue.changed, queue.finished, document.intervals_changed):
            signal.connect(self._wait)

    @property
    def verdicts(self) -> int:
        """The number of automatic corrections with a verdict."""
        return sum(one.verdict is not None for one in self.ordered)

    def look(self) -> None:
        """In the background, find the next correction to judge, and emit `found` with it."""
        self._asked = True
        self._start()

    def words(self) -> str:
        """Return a sentence about the estimated precision of the corrections without a verdict."""
        if (stated := self.stated) is not None:
            return tr(
                "About {share:.0f} % of the {left} automatic corrections without a verdict are "
                "right (likely {low:.0f}–{high:.0f} %, estimated from {n} verdicts).",
                share=100.0 * stated.share,
                left=stated.left,
                low=100.0 * stated.low,
                high=100.0 * stated.high,
                n=stated.verdicts,
            )
        missing = ENOUGH_STATED - self.verdicts
        if not self.verdicts or len(self.ordered) <= ENOUGH_STATED or missing <= 0:
            return ""
        return plural(
            "After {n} more verdict, you can see how reliable the automatic corrections are.",
            "After {n} more verdicts, you can see how reliable the automatic corrections are.",
            missing,
        )

    def _wait(self) -> None:
        if self._queue.folder is None or self._queue.running:
            self._show()
        else:
            self._settle.start()

    def _start(self) -> None:
        self._settle.stop()
        if self._queue.folder is None or self._queue.running:
            self._show()
            self._answer()
            return
        data = self._document.data
        clips = sorted((c for c in self._queue.clips.values() if c.automatic), key=lambda c: c.path)
        own = {
            c.path: verdicts_on_automatic_corrections(c.automatic, self._document.review.state)
            for c in clips
            if data is not None and c.path == data.clip.path
        }
        self._task.run(partial(_judged, clips, own, dict(self._cache)), self._take)

    def _take(self, result: tuple[tuple[Informative, ...], StatedPrecision | None, _Known]) -> None:
        ordered, stated, self._cache = result
        self._show(ordered, stated)
        self._answer()

    def _show(
        self, ordered: tuple[Informative, ...] = (), stated: StatedPrecision | None = None
    ) -> None:
        self.ordered, self.stated = ordered, stated
        self.changed.emit()

    def _answer(self) -> None:
        if self._asked:
            self._asked = False
            self.found.emit(next((one for one in self.ordered if one.verdict is None), None))


def _judged(
    clips: Sequence[QueuedClip], own: Mapping[Path, _Verdicts], known: _Known, tell: Tell
) -> tuple[tuple[Informative, ...], StatedPrecision | None, _Known]:
    """Return the sorted corrections, the estimated precision, and a new cache of verdicts.

    `own` contains the verdicts on the open clip, whose session file may be older than its review.
    `known` is the previous cache.
    """
    rows: list[Informative] = []
    still = _Known()
    for k, clip in enumerate(clips):
        tell(k / len(clips))
        verdicts = own.get(clip.path, (None,) * len(clip.automatic))
        if clip.path not in own and (sessions := find_existing_sessions(clip.path)):
            key = sessions[0], modified_ns(sessions[0]), clip.automatic
            if key not in known:
                try:
                    known[key] = verdicts_on_automatic_corrections(
                        clip.automatic, read_session(sessions[0]).state
                    )
                except TwistError:  # the table already shows that the clip cannot be read
                    known[key] = verdicts
            verdicts = still[key] = known[key]
        rows += (
            Informative(clip.path, *pair) for pair in zip(clip.automatic, verdicts, strict=True)
        )
    confidence = np.array([one.correction.confidence for one in rows])
    stated = estimate_unjudged_precision(confidence, [one.verdict for one in rows])
    return tuple(rows[k] for k in representative_judging_order(confidence)), stated, still
