"""Create a profile from verdicts: a τ for each chain, its evidence, and the learned confidence."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.tuning.common_tau import CommonTau
from twistcore.tuning.learned_confidence import (
    ENOUGH,
    LearnedConfidence,
    Reliability,
    confidence_reliability_by_bin,
    cross_validated_confidence,
    fit_confidence_to_verdicts,
    verdicts_with_confidence,
)
from twistcore.tuning.profile import Profile, TauReasons, write_profile
from twistcore.tuning.tau_curve import Tuned
from twistcore.tuning.verdicts_of import JudgedClip


@dataclass(frozen=True, eq=False)
class LearnedProfile:
    """A profile learned from verdicts, with its evidence.

    Parameters
    ----------
    profile
        The profile.
    reasons
        The evidence for each chain's τ, keyed by chain name.
    apart
        Names of the chains that need their own τ.
    before
        Reliability of the detector's confidences, or None if there are too few verdicts.
    after
        Reliability of the learned confidences, on verdicts that were not used for learning, or
        None.
    held_out
        A word for the groups of verdicts that were held out for testing, such as 'clips'.
    """

    profile: Profile
    reasons: Mapping[str, TauReasons]
    apart: Collection[str]
    before: Reliability | None = None
    after: Reliability | None = None
    held_out: str = "clips"

    def write(self, path: Path, source: str) -> None:
        """Write the profile with its evidence. Raises OSError.

        `source` is the name of the folder with the sessions. It is written as a comment.
        """
        nan = math.nan
        tau = {n: Tuned(math.degrees(t), nan, nan, nan) for n, t in self.profile.tau.items()}
        sessions = f"{source}'s sessions"
        own, reasons = self.profile, self.reasons
        write_profile(path, tau, sessions, own.method, whose=own, verdicts=reasons)

    def confidence_sentence(self) -> str:
        """Return a sentence about the confidence's calibration error before and after learning."""
        if self.before is None or self.after is None:
            return (
                f"The confidence is the detector's own, because at least {ENOUGH} verdicts "
                "are needed to learn one."
            )
        after, before = 100 * self.after.error, 100 * self.before.error
        return (
            f"The learned confidence is off by {after:.1f} points on {self.held_out} held-out "
            f"verdicts; the detector's own is off by {before:.1f} points."
        )


def learned_profile(clips: Sequence[JudgedClip], found: CommonTau) -> LearnedProfile:
    """Return a profile with a τ for every reviewed chain.

    `found` contains the common τ and the chains that need their own τ. The rig and the performer
    are included if they are the same in all clips.
    """
    assert found.common is not None
    names = sorted({name for clip in clips for name in clip.reviewed})
    known = {c.chain: c for c in found.chains}
    reasons = {}
    for name in names:
        chain = known.get(name)
        errors, natural = chain.curve.counts if chain else (0, 0)
        own = chain.own if chain and chain.apart and chain.own else found.common
        reasons[name] = TauReasons(errors, natural, math.degrees(own.low), math.degrees(own.high))
    tau = {name: found.tau(name) or found.common.tau for name in names}
    confidence, before, after = fit_confidence_and_reliabilities(clips)
    methods, rigs, performers = ({getattr(c, k) for c in clips} for k in _WHOSE)
    profile = Profile(tau, _only(methods), _only(rigs), _only(performers), confidence)
    apart = {c.chain for c in found.chains if c.apart}
    apart_by = (
        "clips"
        if len(np.unique(verdicts_with_confidence(clips).clip)) > 1
        else "verdicts on the only clip"
    )
    return LearnedProfile(profile, reasons, apart, before, after, apart_by)


_WHOSE = "method", "rig", "performer"


def _only(values: set[str]) -> str:
    return next(iter(values)) if len(values) == 1 else ""


def fit_confidence_and_reliabilities(
    clips: Sequence[JudgedClip],
) -> tuple[LearnedConfidence | None, Reliability | None, Reliability | None]:
    """Return the learned confidence, and the reliability before and after learning.

    All three are None if there are too few verdicts. The reliability after learning is measured on
    clips, or on parts of a single clip, that were not used for learning.
    """
    given = verdicts_with_confidence(clips)
    if len(given) < ENOUGH:
        return None, None, None
    before = confidence_reliability_by_bin(given.confidence, given.accepted)
    return (
        fit_confidence_to_verdicts(given),
        before,
        confidence_reliability_by_bin(cross_validated_confidence(given), given.accepted),
    )
