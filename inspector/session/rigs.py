"""Analyse the open clip with different sets of chains, in the background."""

from __future__ import annotations

from collections.abc import Callable

from inspector.language import tr
from inspector.session.clip_opener import ClipOpener
from inspector.session.opening import Analysed
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.review import ChangeChains, ReviewState
from twistcore.review.other_chains import chain_change_command
from twistcore.skeleton.rig import Rig
from twistcore.work.progress import Tell

_KEPT = 4  # maximum number of analyses, because each may take hundreds of megabytes


class Rigs:
    """A cache of analyses of the open clip, one for each recently used rig (set of chains)."""

    def __init__(self, opener: ClipOpener) -> None:
        self._opener = opener
        self._known: dict[Rig, ClipAnalysis] = {}
        self.present: ClipAnalysis | None = None

    def begin(self, data: Analysed) -> None:
        """Start with a newly opened clip, and discard all analyses of the previous clip."""
        self.present = data.analysis
        self._known = {data.analysis.rig: data.analysis}

    def take(self, rig: Rig) -> ClipAnalysis:
        """Make the stored analysis of a rig the current one, and return it."""
        self.present = self._known.pop(rig)
        self._known[rig] = self.present
        for oldest in list(self._known)[:-_KEPT]:
            del self._known[oldest]
        return self.present

    def known(self, rig: Rig) -> ClipAnalysis | None:
        """Return the stored analysis for a rig, or None if there is none."""
        return self._known.get(rig)

    def when_ready(self, state: ReviewState, then: Callable[[], object]) -> None:
        """Call `then` as soon as the clip has been analysed with the chains of `state`."""
        present = self.present
        assert present is not None
        known, method = self._known.get(state.rig), present.usable(state.method)
        if state.rig == present.rig or (known is not None and known.kept(method)):
            then()
            return
        self._opener.prepare(
            tr("Analysing the chains of {clip}", clip=present.name),
            lambda tell: self._made(present, state.rig, method, tell),
            lambda _: then(),
        )

    def change(
        self, state: ReviewState, rig: Rig, what: str, do: Callable[[ChangeChains], object]
    ) -> None:
        """Analyse the clip with a rig's chains, then call `do` with the command to use them.

        `what` is the name of the step in the undo history.
        """
        present = self.present
        assert present is not None

        def work(tell: Tell) -> ChangeChains:
            analysis = self._made(present, rig, present.usable(state.method), tell)
            return chain_change_command(present, analysis, state, what)

        self._opener.prepare(tr("Analysing the chains of {clip}", clip=present.name), work, do)

    def _made(self, present: ClipAnalysis, rig: Rig, method: str, tell: Tell) -> ClipAnalysis:
        """Return the clip's analysis with a rig, computing it if needed. Called in a thread."""
        known = self._known.get(rig)
        if known is None:
            known = present.with_rig(rig)
        known.by(method, tell)
        _ = known.signals, known.reliability, known.flips, known.jumps(method)
        if present is self.present:
            self._known[rig] = known
        return known
