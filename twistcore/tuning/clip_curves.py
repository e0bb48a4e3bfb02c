"""All curves of a clip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from twistcore.analysis import ClipAnalysis, analyse
from twistcore.bvh import read_bvh
from twistcore.chain import Chain, uncorrectable_joints
from twistcore.detection import DEFAULT_METHOD
from twistcore.detection.cuts import leading_frames, trailing_frames
from twistcore.motion import Motion
from twistcore.rig import AS_FOUND, Rig
from twistcore.tuning.cleaning import Verdicts, cleaned
from twistcore.tuning.tau_curve import TauCurve, tau_curve

SEEDS = 3


@dataclass(frozen=True, eq=False)
class ClipTuning:
    """A clip without its own errors, analysed: ready for the curve of any of its chains.

    name: the clip's, it seeds the errors with `seeds`.
    """

    name: str
    clean: ClipAnalysis
    method: str
    seeds: Sequence[int]

    @property
    def names(self) -> tuple[str, ...]:
        """Chains that have a curve: those that can be corrected."""
        clean = self.clean
        return tuple(c.name for c in clean.chains if not uncorrectable_joints(clean.motion, c))

    def curve(self, chain: str) -> TauCurve:
        """What every τ costs one of `names`."""
        chosen = self.clean.chain(chain)
        return tau_curve(self.clean, chosen, name=self.name, method=self.method, seeds=self.seeds)


def clip_tuning(
    motion: Motion,
    name: str,
    *,
    method: str = DEFAULT_METHOD,
    seeds: Sequence[int] = range(SEEDS),
    verdicts: Verdicts | None = None,
    rig: Rig = AS_FOUND,
) -> ClipTuning:
    """Take a clip's own errors out and analyse the rest, without blends at its ends."""
    given = analyse(motion, analyse(motion, rig=rig).chains)
    clean = ClipAnalysis(*_capture(cleaned(given, verdicts), given.chains), name)
    clean.by(method)
    return ClipTuning(name, clean, method, seeds)


def _capture(motion: Motion, chains: Sequence[Chain]) -> tuple[Motion, tuple[Chain, ...]]:
    """Without blends at the ends; a lone T-pose in frame 0 holds no step and may stay."""
    first, stop = leading_frames(motion), motion.frames - trailing_frames(motion)
    first = first if first > 1 else 0
    if not first and stop == motion.frames:
        return motion, tuple(chains)
    return motion.sliced(first, stop), tuple(c.sliced(first, stop) for c in chains)


def clip_curves(
    path: Path, method: str, seeds: int = SEEDS, rig: Rig = AS_FOUND
) -> dict[str, TauCurve]:
    """The curves of all correctable chains of a clip, by name; raises TwistError."""
    motion = read_bvh(path).motion
    tuning = clip_tuning(motion, path.name, method=method, seeds=range(seeds), rig=rig)
    return {name: tuning.curve(name) for name in tuning.names}
