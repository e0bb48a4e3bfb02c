"""Simulate a reviewer who knows the injected errors, for the benchmarks of learning.

In each clip, some chains get errors (P0 and the small errors of H6) and others get decoys: small
counter-twists that this reviewer considers natural motion. The detector lists its candidates at 0.3
of its automatic τ, so that they include false alarms. The reviewer accepts an error that is found
and corrected, and rejects decoys and all other intervals.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.calibration import LOWEST, right
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision, Judged, start_review
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.synthesis import (
    InjectedError,
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)
from twistcore.tuning.verdicts_of import JudgedClip, Verdict, judged_clip_from_review

ERRORS = ("P0", "H6")
DECOYS = "H6"
HARDER = ("P0", "P0", "H1", "rich+H1")  # protocols that make clips harder before the injection
WRONG = 0.1  # share of the listed intervals that are not errors
ACCEPTED, NATURAL, DECOY = "accepted", "natural", "decoy"


@dataclass(frozen=True, eq=False)
class Reviewed:
    """A clip that the simulated reviewer has judged.

    Attributes
    ----------
    clip
        The verdicts on the clip.
    about
        The kind of each verdict's interval: ACCEPTED, NATURAL or DECOY.
    """

    clip: JudgedClip
    about: tuple[str, ...]

    def keep(self, which: Sequence[int]) -> Reviewed:
        """Return the clip with only the verdicts at these indices."""
        verdicts = tuple(self.clip.verdicts[k] for k in which)
        return Reviewed(replace(self.clip, verdicts=verdicts), tuple(self.about[k] for k in which))


def reviewed(path: Path, seed: int, harder: str = "") -> Reviewed:
    """Inject errors and decoys into a clip, and review it.

    About a quarter of the injected twists are decoys.

    Parameters
    ----------
    path
        The clip.
    seed
        The seed of the errors.
    harder
        The protocol that makes the motion harder before the injection. By default, it is drawn at
        random.
    """
    motion = read_bvh(path).motion
    chains = analyse(motion).chains
    rng = clip_random_generator(seed, path.name, 17)
    drawn = HARDER[int(rng.integers(len(HARDER)))]
    motion = prepare_clean_motion_for_injection(motion, chains, parse_protocol(harder or drawn))
    chains = analyse(motion).chains
    free = [c for c in chains if not uncorrectable_joints(motion, c)]
    order = rng.permutation(len(free))
    errors: list[InjectedError] = []
    decoys: list[InjectedError] = []
    taken: set[int] = set()
    for k in order.tolist():
        joints = {free[k].parent, free[k].child}
        if joints & taken:
            continue  # an error in a neighbouring chain would also appear in this one
        taken |= joints
        wrong = len(decoys) < len(errors) / 3
        name = DECOYS if wrong else ERRORS[len(taken) // 2 % len(ERRORS)]
        drawn = draw_errors(motion, [free[k]], rng, parse_protocol(name))
        (decoys if wrong else errors).extend(drawn)
    dirty = ClipAnalysis(inject(motion, chains, errors + decoys), chains, path.name)
    return _judged(dirty, errors, decoys)


def _judged(
    dirty: ClipAnalysis, errors: Sequence[InjectedError], decoys: Sequence[InjectedError]
) -> Reviewed:
    detector = dirty.by()
    tau = {c.name: LOWEST * detector.automatic_tau(c.name) for c in dirty.chains}
    found = [i for name, t in tau.items() for i in detector.intervals(name, t) if not i.open]
    state = start_review("consistency", tau, found, tau)
    judged = []
    for j in state.intervals:
        said = Decision.ACCEPTED if right(j.interval, errors) else Decision.REJECTED
        judged.append(replace(j, decision=said, reviewer="simulated"))
    clip = judged_clip_from_review(dirty, state.with_intervals(judged))
    return Reviewed(clip, tuple(_about(v, decoys) for v in clip.verdicts))


def _about(verdict: Verdict, decoys: Sequence[InjectedError]) -> str:
    if verdict.error:
        return ACCEPTED
    near = any(
        d.chain == verdict.chain and d.start < verdict.stop and verdict.start < d.stop
        for d in decoys
    )
    return DECOY if near else NATURAL


def reviewed_folder(paths: Sequence[Path], seed: int, harder: str = "") -> list[Reviewed]:
    """Review all clips in a folder."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(partial(reviewed, seed=seed, harder=harder), paths))


def sampled(
    clips: Sequence[Reviewed],
    kinds: Sequence[str],
    rng: np.random.Generator,
    most: int | None = None,
    mistaken: float = 0.0,
) -> list[JudgedClip]:
    """Return a sample of the verdicts on clips, a tenth of them on intervals that are not errors.

    Parameters
    ----------
    clips
        The reviewed clips.
    kinds
        The kinds of intervals that are not errors.
    rng
        The source of random numbers.
    most
        The maximum number of verdicts.
    mistaken
        The share of verdicts that are reversed.
    """
    every = [(k, n, about) for k, c in enumerate(clips) for n, about in enumerate(c.about)]
    good = [(k, n) for k, n, about in every if about == ACCEPTED]
    bad = [(k, n) for kind in kinds for k, n, about in every if about == kind]
    if len(kinds) > 1:  # draw equal numbers of each kind
        parts = [[(k, n) for k, n, about in every if about == kind] for kind in kinds]
        least = min(map(len, parts))
        bad = [p[i] for p in parts for i in rng.permutation(len(p))[:least]]
    whole = min(len(good) / (1 - WRONG), len(bad) / WRONG, most or np.inf)
    wrong, fine = round(WRONG * whole), round((1 - WRONG) * whole)
    chosen = [good[k] for k in rng.permutation(len(good))[:fine]]
    chosen += [bad[k] for k in rng.permutation(len(bad))[:wrong]]
    out = []
    for k, clip in enumerate(clips):
        kept = clip.keep(sorted(n for c, n in chosen if c == k)).clip
        out.append(replace(kept, verdicts=tuple(_said(v, rng, mistaken) for v in kept.verdicts)))
    return [clip for clip in out if clip.verdicts]


def _said(verdict: Verdict, rng: np.random.Generator, mistaken: float) -> Verdict:
    return replace(verdict, error=verdict.error != (rng.random() < mistaken))


__all__ = ["DECOY", "NATURAL", "Judged", "Reviewed", "reviewed_folder", "sampled"]
