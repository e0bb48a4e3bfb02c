"""Count the user's verdicts in the open clip and its folder, in the background."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.session.session_files import find_existing_sessions, modified_ns
from inspector.tuning.remembered_profiles import Performers
from inspector.tuning.wishes import Wishes
from inspector.widgets.background import OneTask
from twistcore.errors import TwistError
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.review import ReviewState
from twistcore.tuning.common_tau import CommonTau, common_tau
from twistcore.tuning.learned_profile import LearnedProfile, learned_profile
from twistcore.tuning.verdict_curve import Suggestion, VerdictCurve, tau_curve_from_verdicts
from twistcore.tuning.verdicts_of import JudgedClip, judged_clip_from_review, read_judged_clip
from twistcore.work.progress import Tell

CLIP, FOLDER, RIG = tr("This clip"), tr("Folder"), tr("This rig")
_SETTLE_MS = 400  # time after the last verdict until verdicts are counted

# Keyed by session, its time, and the performer
_Known = dict[tuple[Path, int, str], JudgedClip | str]


@dataclass(frozen=True, eq=False)
class Scope:
    """A group of verdicts on the intervals of some clips, for one chain or for all chains.

    Attributes
    ----------
    name
        The name of the group.
    clips
        The clips with their verdicts.
    curve
        Precision and recall over τ.
    found
        The suggested τ if the group is about all chains, or None.
    suggestion
        The suggested τ if the group is about one chain, or None.
    chain
        The name of the chain, or '' for all chains.
    """

    name: str
    clips: tuple[JudgedClip, ...]
    curve: VerdictCurve
    found: CommonTau | None = None
    suggestion: Suggestion | None = None
    chain: str = ""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Verdict counts for the open clip and its folder, with suggestions learned from them.

    Attributes
    ----------
    scopes
        The groups of verdicts: first the groups about all chains, in order of increasing size, then
        one group for each chain.
    learnt
        The learned profiles, keyed by the name of their group.
    skipped
        The reasons why clips of the folder were skipped.
    """

    scopes: tuple[Scope, ...]
    learnt: Mapping[str, LearnedProfile]
    skipped: tuple[str, ...] = ()


class VerdictEvidence(QObject):
    """Counts the verdicts in the open clip and its folder while a view of them is visible."""

    changed = Signal()

    def __init__(self, document: Document, wishes: Wishes, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document, self._wishes = document, wishes
        self.performers = Performers()
        self.present: Evidence | None = None
        self.trouble = ""
        self._cache: _Known = {}
        self._state: tuple[object, ...] = ()
        self._watching = False
        self._task = OneTask(self)
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._settle.timeout.connect(self._start)
        document.opened.connect(self._forget)
        document.intervals_changed.connect(self._check)
        wishes.changed.connect(self._check)

    @property
    def running(self) -> bool:
        """True while verdicts are being counted."""
        return self._task.running or self._settle.isActive()

    @property
    def _terms(self) -> tuple[float, float]:
        """The settings for suggestions: the cost of a false alarm, and the smallest error to find.

        The cost is a share of the errors, and the smallest error is in radians.
        """
        return self._wishes.points / 100.0, math.radians(self._wishes.smallest_degrees)

    def watch(self, on: bool) -> None:
        """Start counting because a view of the verdicts is visible, or stop if `on` is False."""
        self._watching = on
        if on:
            self._check()
        else:
            self._settle.stop()
            self._task.cancel()
            self._state = ()

    def count_again(self) -> None:
        """Count the verdicts again, because the performer of the clip has changed."""
        self._state = ()
        self._check()

    def _forget(self) -> None:
        self.present, self._state, self.trouble = None, (), ""
        self._check()
        self.changed.emit()

    def _check(self) -> None:
        data = self._document.data
        if data is None or not self._watching:
            return
        state = self._document.review.state
        here = data.clip, state.method, state.rig, dict(state.tau), state.left_out
        now = (*here, self._terms, state.intervals)
        if now != self._state:
            self._state = now
            self._task.cancel()
            self._settle.start()
            self.changed.emit()

    def _start(self) -> None:
        data = self._document.data
        if data is None or not self._watching:
            return
        state = self._document.review.state
        work = partial(_counted, data, state, self._terms, self.performers, dict(self._cache))
        self._task.run(work, self._take, self._fail)
        self.changed.emit()

    def _take(self, result: tuple[Evidence, _Known]) -> None:
        self.present, self._cache = result
        self.trouble = ""
        self.changed.emit()

    def _fail(self, error: object) -> None:
        why = translate_core_sentence(error)
        self.trouble = tr("The verdicts cannot be counted ({why}).", why=why)
        self.changed.emit()


def _counted(
    data: Analysed,
    state: ReviewState,
    wanted: tuple[float, float],
    performers: Performers,
    known: _Known,
    tell: Tell,
) -> tuple[Evidence, _Known]:
    """Count the verdicts. Return the result and a cache for the next count.

    Called in a thread.
    """
    own = judged_clip_from_review(data.analysis, state, performers.of(data.clip.path))
    others, skipped, still = [], [], _Known()
    folder = clip_paths_in_folder(data.clip.path.parent)
    for k, path in enumerate(folder):
        tell(k / len(folder))
        if path == data.clip.path or not (sessions := find_existing_sessions(path)):
            continue
        key = sessions[0], modified_ns(sessions[0]), performers.of(path)
        if key not in known:
            try:
                known[key] = read_judged_clip(path, sessions[0], key[2])
            except TwistError as error:
                known[key] = translate_core_sentence(error)
        judged = still[key] = known[key]
        if isinstance(judged, str):
            skipped.append(judged)
        elif judged.method != state.method:
            other = tr("{clip} was reviewed with another detector", clip=path.name)
            skipped.append(other)
        else:
            others.append(judged)
    clips = (own, *others)
    scopes = tuple(_scopes(own, clips, wanted))
    learnt = {
        s.name: learned_profile(s.clips, s.found)
        for s in scopes
        if s.found is not None and s.found.common is not None and any(c.verdicts for c in s.clips)
    }
    return Evidence(scopes, learnt, tuple(skipped)), still


def _scopes(
    own: JudgedClip, clips: Sequence[JudgedClip], wanted: tuple[float, float]
) -> Iterator[Scope]:
    rig = tuple(c for c in clips if c.rig == own.rig)
    groups: dict[str, tuple[JudgedClip, ...]] = {CLIP: (own,)}
    if own.performer:
        name = tr("Performer {who}", who=own.performer)
        groups[name] = tuple(c for c in rig if c.performer == own.performer)
    groups |= {RIG: rig, FOLDER: tuple(clips)}
    for name, some in groups.items():
        found = common_tau(some, *wanted)
        yield Scope(name, some, tau_curve_from_verdicts(some), found)
    for chain in dict.fromkeys(v.chain for c in rig for v in c.verdicts):
        curve = tau_curve_from_verdicts(rig, chain)
        suggestion = curve.suggested(*wanted)
        yield Scope(chain, rig, curve, suggestion=suggestion, chain=chain)
