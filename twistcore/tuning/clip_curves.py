"""All curves of a clip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.detection import DEFAULT_METHOD
from twistcore.detection.cuts import leading_frames, trailing_frames
from twistcore.formats.reading import read_clip
from twistcore.review import read_session
from twistcore.review.left_out import joined_spans
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.own_words import with_own_words
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.tuning.cleaning import AUDITOR, Verdicts, cleaned
from twistcore.tuning.injected_curve import Span, tau_curve
from twistcore.tuning.tau_curve import TauCurve
from twistcore.tuning.verdicts_of import of_this_version, of_what_is_there, said_in
from twistcore.work.frozen import dataclass

SEEDS = 3


@dataclass(frozen=True, eq=False)
class ClipTuning:
    """A clip without its own errors, analysed: ready for the curve of any of its chains.

    name: the clip's, it seeds the errors with `seeds`; first: the frame of the clip as given that
    `clean` begins with; left_out: half-open spans of the clip as given in which nothing counts,
    blends at its ends among them.
    """

    name: str
    clean: ClipAnalysis
    method: str
    seeds: Sequence[int]
    first: int = 0
    left_out: tuple[Span, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Chains that have a curve: those that can be corrected."""
        clean = self.clean
        return tuple(c.name for c in clean.chains if not uncorrectable_joints(clean.motion, c))

    def curve(self, chain: str) -> TauCurve:
        """What every τ costs one of `names`."""
        here = [(start - self.first, stop - self.first) for start, stop in self.left_out]
        frames = self.clean.motion.frames
        return tau_curve(
            self.clean,
            self.clean.chain(chain),
            name=self.name,
            method=self.method,
            seeds=self.seeds,
            left_out=[(max(a, 0), b) for a, b in here if b > 0 and a < frames],
        )


def clip_tuning(
    motion: Motion,
    name: str,
    *,
    method: str = DEFAULT_METHOD,
    seeds: Sequence[int] = range(SEEDS),
    verdicts: Verdicts | None = None,
    rig: Rig = AS_FOUND,
    left_out: Sequence[Span] = (),
) -> ClipTuning:
    """Take a clip's own errors out and analyse the rest, without blends at its ends.

    left_out: half-open spans in which no false alarm counts and no error is put in, besides.
    """
    given = analyse(motion, analyse(motion, rig=rig).chains)
    without = cleaned(given, verdicts)
    first, stop = capture(without)
    chains = tuple(c for c in given.chains if not isinstance(c, Helper))
    if (first, stop) != (0, motion.frames):
        without = without.sliced(first, stop)
        chains = tuple(c.sliced(first, stop) for c in chains)
    clean = ClipAnalysis(without, chains, name)
    for detector in (method, AUDITOR):  # before a clip is split into chains
        clean.by(detector)
    ends = [span for span in ((0, first), (stop, motion.frames)) if span[0] < span[1]]
    return ClipTuning(name, clean, method, seeds, first, joined_spans([*ends, *left_out]))


def capture(motion: Motion) -> Span:
    """First frame and stop without blends at the ends.

    A lone T-pose in frame 0 holds no step and may stay.
    """
    first, stop = leading_frames(motion), motion.frames - trailing_frames(motion)
    return first if first > 1 else 0, stop


def clip_curves(
    path: Path,
    method: str,
    seeds: int = SEEDS,
    rig: Rig = AS_FOUND,
    session: Path | None = None,
    words: Mapping[str, Any] | None = None,
) -> dict[str, TauCurve]:
    """The curves of all correctable chains of a clip, by name; raises TwistError.

    None where nothing was looked at: where all frames are left out every τ would cost the same.
    session: of this clip, whose chains, verdicts and frames left out are taken, as the window does;
    words: a person's, for joints, as :func:`twistcore.skeleton.joint_names.read_words` has them.
    """
    clip = read_clip(path)
    rig = with_own_words(rig, clip.motion, words)
    verdicts, left_out = Verdicts(), tuple[Span, ...]()
    if session is not None:
        kept = read_session(session)
        of_this_version(clip, kept)
        of_what_is_there(clip, kept)
        rig, left_out = kept.state.rig, kept.state.left_out
        verdicts = said_in(kept.state)
    tuning = clip_tuning(
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
