"""The cost of τ for the open clip, measured in the background and cached."""

from __future__ import annotations

import multiprocessing
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from operator import add

from PySide6.QtCore import QObject, QTimer, Signal

from inspector.language import chosen_language, tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.cost_worker import Capture, Request, measure_cost_curves
from inspector.tuning.wishes import Wishes
from twistcore.detection import DETECTORS
from twistcore.review import Decision, Judged, ReviewState
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.tuning import Cost, TauCurve, total_tuning_cost
from twistcore.tuning.listed_intervals import ListCounts, count_counter_twists_at_tau
from twistcore.tuning.verdicts_of import counter_twist_verdicts_of_review, is_judged_counter_twist

_POLL_MS = 30
_REMEMBERED = 12  # number of cached results; each belongs to a clip and a set of verdicts
_SETTLE_MS = 400  # time after the last verdict until a measurement starts

_Key = tuple[object, ...]


@dataclass(eq=False)
class _Measured:
    """The cost curves of a clip for one set of verdicts.

    Attributes
    ----------
    curves
        The curves, keyed by detector and chain.
    through
        The names of the detectors whose measurement is complete.
    capture
        The frames in which the cost is measured; None before the first measurement.
    """

    curves: dict[str, dict[str, TauCurve]] = field(default_factory=dict)
    through: set[str] = field(default_factory=set)
    capture: Capture | None = None


class Costs(QObject):
    """Measures the cost of τ in the open clip, for each detector and chain, and caches the results.

    A cost curve depends on the clip, the verdicts and the frames excluded from tuning. If one of
    these changes, a running measurement is stopped. The current detector is measured first, then
    the detectors requested with `needs`. Nothing is measured unless a view of the costs is visible.
    """

    changed = Signal()

    def __init__(self, document: Document, wishes: Wishes, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document, self._wishes = document, wishes
        self._cache: OrderedDict[_Key, _Measured] = OrderedDict()
        self._key: _Key | None = None
        self._others: frozenset[str] = frozenset()
        self._running: tuple[_Key, str] | None = None  # the key of the results, and the detector
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None
        self._watching = False
        self.trouble = ""
        self._poll = QTimer(self, interval=_POLL_MS)
        self._poll.timeout.connect(self._receive)
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settle.timeout.connect(self._start)
        document.opened.connect(self._stop_if_outdated)
        document.intervals_changed.connect(self._stop_if_outdated)
        document.chain_changed.connect(self._prefer)
        wishes.changed.connect(self._stop_if_outdated)
        # The values from which the key is computed. They are compared first, because computing the
        # key at every step of τ would be slow.
        self._judged: tuple[object, ...] | None = None
        # The counts of the current detector, keyed by capture, chain and τ.
        self._counted: dict[tuple[Capture | None, str, float], ListCounts] = {}
        self._stop_if_outdated()

    # -- what views read ----------------------------------------------------------------------

    @property
    def curves(self) -> Mapping[str, TauCurve]:
        """The measured curves of the current detector, keyed by chain."""
        return self.by(self._document.review.state.method) if self._document.data else {}

    def by(self, method: str) -> Mapping[str, TauCurve]:
        """Return the measured curves of a detector, keyed by chain."""
        return self._here.curves.get(method, {})

    @property
    def capture(self) -> Capture | None:
        """The frames in which the cost is measured, excluding blends at the ends of the clip.

        The value is None before the first measurement.
        """
        return self._here.capture

    def counts(self, method: str, chain: str, tau: float) -> ListCounts | None:
        """Return the number of intervals that a detector lists for a chain, or None if unknown.

        `tau` is the threshold in radians. For the current detector, the counts are exact. For other
        detectors, they are the counts at the nearest measured τ.
        """
        data, state = self._document.data, self._document.review.state
        if data is None or method != state.method or chain not in state.tau:
            curve = self.by(method).get(chain)
            return curve.counts_at(tau) if curve is not None else None
        key = self.capture, chain, tau
        if key not in self._counted:
            left_out = [*state.left_out]
            if (capture := self.capture) is not None:
                left_out += [(0, capture.first), (capture.stop, self._document.frames)]
            spans = [span for span in left_out if span[0] < span[1]]
            detector = self._document.detector
            counts = count_counter_twists_at_tau(
                detector, chain, tau, counter_twist_verdicts_of_review(state), spans
            )
            self._counted[key] = counts
        return self._counted[key]

    def cost(self, method: str, tau: Mapping[str, float]) -> tuple[Cost, ListCounts] | None:
        """Return the combined cost of several chains at their τ, and the listed interval counts.

        `tau` is in radians, keyed by chain. The detector lists intervals at these τ. Rejected
        intervals among them are counted as false alarms. Returns None if one of the chains has not
        been measured.
        """
        curves = self.by(method)
        counts = [self.counts(method, name, t) for name, t in tau.items() if name in curves]
        known = [count for count in counts if count is not None]
        if not tau or len(known) < len(tau):
            return None
        together = reduce(add, known)
        cost = total_tuning_cost([(curves[name], t) for name, t in tau.items()])
        return replace(cost, alarms=float(together.rejected)), together

    @property
    def _here(self) -> _Measured:
        return self._cache.get(self._key, _Measured()) if self._key else _Measured()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the chains whose costs can be measured."""
        data = self._document.data
        if data is None:
            return ()
        chains = (c for c in data.chains if not isinstance(c, Helper))
        return tuple(c.name for c in chains if not uncorrectable_joints(data.motion, c))

    def coming(self, method: str) -> bool:
        """Return True if some curves of a detector have not been measured yet."""
        return self.running and method in self._methods and bool(self._missing(method))

    def _missing(self, method: str) -> list[str]:
        known = self.by(method)
        through = method in self._here.through
        return [] if through else [name for name in self.names if name not in known]

    @property
    def running(self) -> bool:
        """True while curves are being measured."""
        return self._process is not None or self._settle.isActive()

    def needs(self, others: Iterable[str]) -> None:
        """Set the detectors to measure in addition to the current one."""
        others = frozenset(others)
        if others != self._others:
            self._others = others
            if self._running is not None and self._running[1] not in self._methods:
                self.stop()
            if self._watching:
                self._start()

    @property
    def _methods(self) -> tuple[str, ...]:
        own = self._document.review.state.method
        return own, *sorted(self._others - {own})

    # -- following the document ---------------------------------------------------------------

    def watch(self, on: bool) -> None:
        """Start measuring because a view of the costs is visible, or stop if `on` is False."""
        self._watching = on
        if on:
            self._stop_if_outdated()
            self._start()
        else:
            self.stop()

    def stop(self) -> None:
        """Stop the measuring process. The results so far stay available."""
        self._settle.stop()
        self._poll.stop()
        self._running = None
        if self._process is not None and self._pipe is not None:
            self._pipe.close()
            self._process.kill()
            self._process.join(1.0)
            if self._process.exitcode is not None:  # this may take longer on a busy machine
                self._process.close()
        self._process = self._pipe = None

    def _stop_if_outdated(self) -> None:
        """Stop the measurement if the clip, the verdicts or the settings have changed."""
        data = self._document.data
        if data is None:
            return
        state = self._document.review.state
        verdicts = _verdicts(state)
        draws = self._wishes.draws
        judged = (data.clip, state.method, state.rig, state.left_out, draws, verdicts)
        if judged == self._judged:
            return
        another = self._judged is None or self._judged[0] is not data.clip
        self._judged = judged
        self._counted.clear()
        spans = [
            (j.decision, j.interval.chain, j.interval.start, j.interval.stop) for j in verdicts
        ]
        offsets = [j.interval.offset.tobytes() for j in verdicts if j.decision == Decision.ACCEPTED]
        self._key = (data.clip.sha256, state.rig, state.left_out, draws, *spans, *offsets)
        if self._running is not None and (
            self._running[0] != self._key or self._running[1] not in self._methods
        ):
            self.stop()
        self.trouble = ""
        if self._watching:
            self._start() if another else self._settle.start()
        self.changed.emit()

    def _prefer(self) -> None:
        """Ask the process to measure the selected chain next."""
        if self._pipe is not None:
            try:
                self._pipe.send(self._document.chain)
            except OSError:
                return  # the process has just ended, which the timer will notice

    # -- the process --------------------------------------------------------------------------

    def _start(self) -> None:
        self._settle.stop()
        data = self._document.data
        if data is None or self._key is None or self._process is not None or self.trouble:
            return
        method = next((m for m in self._methods if self._missing(m)), "")
        if not method:
            return
        left = sorted(self._missing(method), key=lambda name: name != self._document.chain)
        state = self._document.review.state
        request = Request(
            path=data.clip.path,
            sha256=data.clip.sha256,
            method=method,
            verdicts=counter_twist_verdicts_of_review(state),
            wanted=tuple(left),
            rig=state.rig,
            left_out=state.left_out,
            draws=self._wishes.draws,
            detector=DETECTORS.place(method),
            language=chosen_language(),
        )
        # Spawn, because a fork of a program with threads and an X connection may hang.
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=measure_cost_curves, args=(theirs, request), daemon=True)
        try:
            process.start()
        except OSError as error:
            why = translate_core_sentence(error.strerror)
            self._fail(tr("The cost of τ cannot be measured ({why}).", why=why))
            self.changed.emit()
            return
        finally:
            theirs.close()
        self._process, self._pipe, self._running = process, ours, (self._key, method)
        self._poll.start()
        self.changed.emit()

    def _receive(self) -> None:
        """Receive results from the process. Without new results, this takes microseconds."""
        news = False
        try:
            while self._pipe is not None and self._pipe.poll():
                self._take(self._pipe.recv())
                news = True
        except (EOFError, OSError):
            self._fail(
                tr(
                    "The system stopped the measurement of τ's cost, perhaps because "
                    "memory ran out."
                )
            )
            news = True
        if news:
            self.changed.emit()

    def _take(self, answer: Capture | tuple[str, TauCurve] | str | None) -> None:
        if answer is None:
            if self._running is not None:
                key, method = self._running
                self._cache.setdefault(key, _Measured()).through.add(method)
            self.stop()
            self._start()  # measure the next detector
        elif isinstance(answer, str):
            self._fail(answer)
        else:
            assert self._running is not None
            key, method = self._running
            known = self._cache.setdefault(key, _Measured())
            if isinstance(answer, Capture):
                known.capture = answer
            else:
                known.curves.setdefault(method, {})[answer[0]] = answer[1]
            self._cache.move_to_end(key)
            while len(self._cache) > _REMEMBERED:
                self._cache.popitem(last=False)

    def _fail(self, why: str) -> None:
        self.stop()
        self.trouble = why


def _verdicts(state: ReviewState) -> tuple[Judged, ...]:
    """Return the verdicts on errors of chains, without the verdicts on limb flips."""
    return tuple(filter(is_judged_counter_twist, state.intervals))
