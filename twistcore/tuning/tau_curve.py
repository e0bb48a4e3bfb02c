"""What every τ costs a chain, and the τ that this speaks for."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis import ClipAnalysis
from twistcore.chain import Chain, limbs
from twistcore.detection import DEFAULT_METHOD, Analysis, Interval
from twistcore.encoding import encoded
from twistcore.refinement import applied_unasked
from twistcore.rotation import Array, wrap
from twistcore.synthesis import (
    SUCCESS,
    InjectedError,
    draw_errors,
    generator,
    inject,
    parse_protocol,
)

GRID = np.radians(np.geomspace(0.5, 30.0, 42))
PROTOCOLS = ("P0", "H6")  # the paper's sizes and small ones: the large alone say nothing about τ
SMALLEST_ERROR = float(np.radians(2.0))  # of H6: a larger τ passes errors over that are looked for
ALARM_PRICE = 0.05  # share of the error frames that one false alarm a clip or minute may cost
LOSS_ALLOWED = 0.001  # what a larger τ, safer against noise, may cost besides


@dataclass(frozen=True, eq=False)
class TauCurve:
    """What every τ of a grid costs a chain; counts, so that curves of many clips add.

    tau: radians, (n,); repaired: error frames repaired by 80 % or more, (n,); errors: error frames
    in all; alarms: intervals applied in the cleaned clips, (n,); minutes: their length; noise: the
    detectors' own τ, radians, one for every clip.
    """

    tau: Array
    repaired: Array
    errors: int
    alarms: Array
    minutes: float
    noise: tuple[float, ...]

    @property
    def fsr(self) -> Array:
        """Share of the error frames that were repaired, 0…1, (n,)."""
        share: Array = self.repaired / max(self.errors, 1)
        return share

    @property
    def alarms_per_minute(self) -> Array:
        """False alarms per minute of clip, (n,)."""
        rate: Array = self.alarms / max(self.minutes, 1e-9)
        return rate

    @property
    def floor(self) -> float:
        """The clips' own noise, radians: the median of the detector's automatic τ."""
        return float(np.median(self.noise)) if self.noise else 0.0

    def __add__(self, other: TauCurve) -> TauCurve:
        return TauCurve(
            self.tau,
            self.repaired + other.repaired,
            self.errors + other.errors,
            self.alarms + other.alarms,
            self.minutes + other.minutes,
            self.noise + other.noise,
        )

    def suggested(self) -> float:
        """τ in radians: what it loses, and its false alarms at their price, are least.

        An alarm costs a person a key, a missed error is never seen: so an alarm a clip (or a minute
        of a longer one) is worth 5 points of FSR, and no τ passes half of the errors over for the
        sake of one alarm. Among equals the largest up to the size of the smallest errors looked
        for: what was drawn here says little about those between. Never below the clips' own noise.
        """
        usable = np.flatnonzero(self.tau >= self.floor)
        if not len(usable):
            return self.floor
        clips = max(self.minutes, len(self.noise), 1e-9)
        cost = (1.0 - self.fsr + ALARM_PRICE * self.alarms / clips)[usable]
        good = usable[cost <= cost.min() + LOSS_ALLOWED]
        modest = good[self.tau[good] <= SMALLEST_ERROR]
        return float(self.tau[modest[-1] if len(modest) else good[0]])

    def at(self, tau: float) -> tuple[float, float]:
        """FSR, 0…1, and false alarms at τ radians, from the neighbours on the grid."""
        place = np.log(self.tau)
        x = math.log(min(max(tau, self.tau[0]), self.tau[-1]))
        return float(np.interp(x, place, self.fsr)), float(np.interp(x, place, self.alarms))


@dataclass(frozen=True)
class Tuned:
    """A chain's τ with the reasons for it; degrees, per cent; NaN where not measured."""

    tau: float
    noise: float
    fsr: float
    alarms_per_minute: float


def tuned(curve: TauCurve, tau: float | None = None) -> Tuned:
    """The suggestion of a curve, or a τ in radians, with what it costs."""
    tau = curve.suggested() if tau is None else tau
    fsr, alarms = curve.at(tau)
    return Tuned(
        tau=math.degrees(tau),
        noise=math.degrees(curve.floor),
        fsr=100.0 * fsr,
        alarms_per_minute=alarms / max(curve.minutes, 1e-9),
    )


def tau_curve(
    clip: ClipAnalysis,
    chain: Chain,
    *,
    name: str,
    method: str = DEFAULT_METHOD,
    seeds: Sequence[int] = (0, 1, 2),
    protocols: Sequence[str] = PROTOCOLS,
) -> TauCurve:
    """The curve of one chain in one clip without errors of its own.

    name: the clip's; with the chain's name it seeds the errors. Of what is found, what would be
    applied unasked counts.
    """
    motion, chains, clean = clip.motion, clip.chains, clip.by(method)
    alarms = np.array([len(_applied(clean, chain, t)) for t in GRID], dtype=float)
    limb = next(limb for limb in limbs(motion.skeleton, chains) if chain in limb)
    repaired = np.zeros(len(GRID))
    total = 0
    for seed in seeds:
        for protocol in map(parse_protocol, protocols):
            words = (zlib.crc32(encoded(text)) for text in (protocol.name, chain.name))
            rng = generator(seed, name, *words)
            errors = draw_errors(motion, [chain], rng, protocol)
            if not errors:
                continue
            dirty = ClipAnalysis(inject(motion, limb, errors), limb).by(method)
            truth, wrong = _truth(errors, motion.frames)
            total += int(wrong.sum())
            repaired += [_repaired(_applied(dirty, chain, t), truth, wrong) for t in GRID]
    noise = (clean.automatic_tau(chain.name),)
    minutes = motion.frames * motion.frame_time / 60.0
    return TauCurve(GRID, repaired, total, alarms, minutes, noise)


def _applied(analysis: Analysis, chain: Chain, tau: float) -> tuple[Interval, ...]:
    return applied_unasked(analysis.intervals(chain.name, tau))


def _truth(errors: Sequence[InjectedError], frames: int) -> tuple[Array, NDArray[np.bool_]]:
    truth, wrong = np.zeros(frames), np.zeros(frames, dtype=bool)
    for error in errors:
        truth[error.start : error.stop] = error.offset
        wrong[error.start : error.stop] = True
    return truth, wrong


def _repaired(found: Sequence[Interval], truth: Array, wrong: NDArray[np.bool_]) -> int:
    """Error frames in which at most a fifth of the error is left."""
    offset = np.zeros(len(truth))
    for interval in found:
        offset[interval.start : interval.stop] += interval.offset
    left = np.abs(wrap(truth - offset))[wrong]
    return int((left <= SUCCESS * np.abs(wrap(truth[wrong]))).sum())
