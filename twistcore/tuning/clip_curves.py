"""Compute the τ curves of a clip's chains. A τ curve contains the cost of every τ in a grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.detection import DEFAULT_METHOD
from twistcore.formats.reading import read_clip
from twistcore.review import read_session
from twistcore.review.left_out import joined_spans
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.own_words import add_user_joint_words
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.tuning.cleaning import (
    AUDITOR,
    Verdicts,
    span_without_rest_pose,
    unjudged_certain_errors,
    without_known_errors,
)
from twistcore.tuning.injected_curve import GRID, Span, injected_tau_curve
from twistcore.tuning.listed_intervals import ListCounts, count_counter_twists_at_tau
from twistcore.tuning.tau_curve import TauCurve
from twistcore.tuning.verdicts_of import (
    check_session_detector_and_chains,
    check_session_matches_clip,
    counter_twist_verdicts_of_review,
)
from twistcore.work.frozen import dataclass

SEEDS = 3


@dataclass(frozen=True, eq=False)
class ClipTuning:
    """A clip without its existing errors, from which the τ curves of its chains are computed.

    Parameters
    ----------
    name
        The clip's name. Together with `seeds`, it determines the injected errors.
    clean
        The analysis of the clip without its existing errors and without the blends at its ends.
    method
        The detector for which τ is tuned.
    seeds
        Seeds of the injected errors, one for each draw.
    first
        The frame of the original clip at which `clean` begins.
    left_out
        Half-open spans of the original clip that are not used, including the blends at its ends.
    given
        The analysis of the original clip, used to count the intervals that the detector lists at
        each τ. None if there is no review.
    verdicts
        A person's verdicts on the intervals of `given`.
    presumed
        The spans (chain, start, stop) of intervals without a verdict that are almost certainly
        errors.
    """

    name: str
    clean: ClipAnalysis
    method: str
    seeds: Sequence[int]
    first: int = 0
    left_out: tuple[Span, ...] = ()
    given: ClipAnalysis | None = None
    verdicts: Verdicts = Verdicts()
    presumed: tuple[tuple[str, int, int], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the chains that have a curve, namely all correctable chains."""
        clean = self.clean
        return tuple(c.name for c in clean.chains if not uncorrectable_joints(clean.motion, c))

    def curve(self, chain: str) -> TauCurve:
        """Return the τ curve of the chain with the given name, which must be in `names`."""
        spans = [(start, stop) for name, start, stop in self.verdicts.natural if name == chain]
        curve = injected_tau_curve(
            self.clean,
            self.clean.chain(chain),
            name=self.name,
            method=self.method,
            seeds=self.seeds,
            left_out=self._in_clean(self.left_out),
            rejected=self._in_clean(spans),
        )
        if self.given is None:
            return curve
        counts = self._counts(chain)
        return replace(curve, alarms=curve.alarms + counts.rejected, counts=counts)

    def _in_clean(self, spans: Sequence[Span]) -> list[Span]:
        """Convert spans of the original clip to frames of `clean`, and drop spans outside it."""
        here = [(start - self.first, stop - self.first) for start, stop in spans]
        return [(max(a, 0), b) for a, b in here if b > 0 and a < self.clean.motion.frames]

    def _counts(self, chain: str) -> ListCounts:
        """Count the intervals that the detector lists for a chain at every τ of the grid."""
        assert self.given is not None
        detector = self.given.detector(self.method)
        by_tau = [
            count_counter_twists_at_tau(detector, chain, t, self.verdicts, self.left_out)
            for t in GRID
        ]
        return ListCounts(
            *(np.array([getattr(c, k) for c in by_tau], float) for k in vars(by_tau[0]))
        )


def prepare_clip_tuning(
    motion: Motion,
    name: str,
    *,
    method: str = DEFAULT_METHOD,
    seeds: Sequence[int] = range(SEEDS),
    verdicts: Verdicts | None = None,
    rig: Rig = AS_FOUND,
    left_out: Sequence[Span] = (),
) -> ClipTuning:
    """Remove a clip's existing errors and the blends at its ends, and analyse the rest.

    A blend leads from or to a T-pose. If `verdicts` is not None, the curves also count the
    intervals that the detector lists at each τ. In the half-open spans `left_out`, false alarms do
    not count and no errors are injected.
    """
    whole = analyse(motion, rig=rig)
    given = analyse(motion, whole.chains)
    without = without_known_errors(given, verdicts)
    presumed = unjudged_certain_errors(given, verdicts or Verdicts())
    first, stop = span_without_rest_pose(without)
    chains = tuple(c for c in given.chains if not isinstance(c, Helper))
    if (first, stop) != (0, motion.frames):
        without = without.sliced(first, stop)
        chains = tuple(c.sliced(first, stop) for c in chains)
    clean = ClipAnalysis(without, chains, name)
    for detector in (method, AUDITOR):  # check before a clip is split into chains
        clean.by(detector)
    ends = [span for span in ((0, first), (stop, motion.frames)) if span[0] < span[1]]
    return ClipTuning(
        name,
        clean,
        method,
        seeds,
        first,
        joined_spans([*ends, *left_out]),
        None if verdicts is None else whole,
        verdicts or Verdicts(),
        tuple((i.chain, i.start, i.stop) for i in presumed),
    )


def clip_tau_curves(
    path: Path,
    method: str,
    seeds: int = SEEDS,
    rig: Rig = AS_FOUND,
    session: Path | None = None,
    words: Mapping[str, Any] | None = None,
) -> dict[str, TauCurve]:
    """Return the τ curves of all correctable chains of a clip, keyed by chain name.

    Parameters
    ----------
    path
        The clip.
    method
        The detector for which τ is tuned.
    seeds
        Number of draws of injected errors.
    rig
        The user's changes to the chains. If there is a session, its rig is used instead.
    session
        A session of this clip. Its chains, verdicts and excluded frames are used, as in the window.
    words
        The user's words for joints, from
        :func:`twistcore.skeleton.joint_names.read_joint_vocabulary_file`.

    Returns
    -------
    dict
        The curves. Empty if all frames are excluded, since every τ would then cost the same.

    Raises
    ------
    TwistError
        If the clip or the session cannot be read, or if they do not belong together.
    """
    clip = read_clip(path)
    rig = add_user_joint_words(rig, clip.motion, words)
    verdicts, left_out = None, tuple[Span, ...]()
    if session is not None:
        kept = read_session(session)
        check_session_matches_clip(clip, kept)
        check_session_detector_and_chains(clip, kept)
        rig, left_out = kept.state.rig, kept.state.left_out
        verdicts = counter_twist_verdicts_of_review(kept.state)
    tuning = prepare_clip_tuning(
        clip.motion,
        path.name,
        method=method,
        seeds=range(seeds),
        verdicts=verdicts,
        rig=rig,
        left_out=left_out,
    )
    curves = {name: tuning.curve(name) for name in tuning.names}
    return {name: curve for name, curve in curves.items() if curve.minutes or curve.errors}
