"""Compute the τ curve of a chain by injecting errors into a clip and detecting them at every τ."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from functools import reduce
from operator import add, is_

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import DEFAULT_METHOD, Analysis, Interval
from twistcore.files.encoding import encode_utf8
from twistcore.skeleton.chain import Chain, group_connected_chains
from twistcore.skeleton.rotation import Array, wrap
from twistcore.synthesis import (
    SUCCESS,
    InjectedError,
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
)
from twistcore.tuning.cleaning import AUDITOR
from twistcore.tuning.drawn_errors import DrawnErrors
from twistcore.tuning.tau_curve import TauCurve

Span = tuple[int, int]  # frames [start, stop)

# The grid is fine where a suggested τ usually lies, and coarser elsewhere.
_BELOW, _ABOVE = (0.1, 0.2, 0.35), (37.0, 45.0, 56.0, 69.0, 85.0, 104.0, 127.0, 152.0, 180.0)
GRID = np.radians([*_BELOW, *np.geomspace(0.5, 30.0, 42), *_ABOVE])
PROTOCOLS = ("P0", "H6")  # errors as in the paper, and small ones, which limit τ


def injected_tau_curve(
    clip: ClipAnalysis,
    chain: Chain,
    *,
    name: str,
    method: str = DEFAULT_METHOD,
    seeds: Sequence[int] = (0, 1, 2),
    protocols: Sequence[str] = PROTOCOLS,
    left_out: Sequence[Span] = (),
    rejected: Sequence[Span] = (),
) -> TauCurve:
    """Return the τ curve of one chain in a clip without existing errors.

    A frame counts as repaired only if it is corrected automatically. The clip's noise is always
    measured by the default detector, since the automatic τ of the paper's detector is the same in
    every clip.

    Parameters
    ----------
    clip
        The analysis of the clip.
    chain
        The chain.
    name
        The clip's name. Together with the chain's name, it seeds the random errors.
    method
        The detector for which τ is tuned.
    seeds
        Seeds of the injected errors, one for each draw.
    protocols
        The protocols from which errors are drawn.
    left_out
        Half-open spans of frames in which alarms do not count and no errors are injected.
    rejected
        Spans of intervals that a person rejected. Alarms in these spans are counted by the caller.
    """
    motion, chains, clean = clip.motion, clip.chains, clip.by(method)

    def applied(analysis: Analysis, tau: float) -> tuple[Interval, ...]:
        return automatic_corrections(analysis.intervals(chain.name, tau))

    def counts(found: Interval | InjectedError) -> bool:
        return not any(found.start < stop and start < found.stop for start, stop in left_out)

    def unjudged(found: Interval) -> bool:
        return counts(found) and not any(found.start < b and a < found.stop for a, b in rejected)

    alarms = np.array([sum(map(unjudged, applied(clean, t))) for t in GRID], dtype=float)
    limb = next(limb for limb in group_connected_chains(motion.skeleton, chains) if chain in limb)
    drawn: list[DrawnErrors] = []
    for seed in seeds:
        for kind, protocol in enumerate(map(parse_protocol, protocols)):
            words = (zlib.crc32(encode_utf8(text)) for text in (protocol.name, chain.name))
            rng = clip_random_generator(seed, name, *words)
            errors = [e for e in draw_errors(motion, [chain], rng, protocol) if counts(e)]
            if errors:
                dirty = ClipAnalysis(inject(motion, limb, errors), limb).by(method)
                found = [applied(dirty, t) for t in GRID]
                drawn.append(_drawn(errors, kind, found, motion.frames))
    out = sum(min(stop, motion.frames) - max(start, 0) for start, stop in left_out)
    together = reduce(add, drawn) if drawn else None
    return TauCurve(
        GRID,
        together.repaired.sum(axis=0) if together else np.zeros(len(GRID)),
        int(together.frames.sum()) if together else 0,
        alarms,
        (motion.frames - out) * motion.frame_time / 60.0,
        (clip.by(AUDITOR).automatic_tau(chain.name),),
        together,
        (clean.automatic_tau(chain.name),),
    )


def _drawn(
    errors: Sequence[InjectedError],
    kind: int,
    found: Sequence[Sequence[Interval]],
    frames: int,
) -> DrawnErrors:
    """Return the errors of one draw, including the number of repaired frames at every τ.

    `kind` is the index of the protocol, `found` contains the corrected intervals for every τ, and
    `frames` is the number of frames of the clip.
    """
    truth, which = np.zeros(frames), np.full(frames, -1)
    for k, error in enumerate(errors):
        truth[error.start : error.stop] = error.offset
        which[error.start : error.stop] = k
    wrong = which >= 0
    repaired = np.zeros((len(errors), len(found)))
    before: Sequence[Interval] | None = None
    for n, intervals in enumerate(found):
        if before is not None and _same(intervals, before):  # common for neighbouring τ
            repaired[:, n] = repaired[:, n - 1]
            continue
        before = intervals
        good = _repaired(intervals, truth)[wrong]
        repaired[:, n] = np.bincount(which[wrong], good, minlength=len(errors))
    return DrawnErrors(
        np.array([float(np.abs(e.offset).max()) for e in errors]),
        np.bincount(which[wrong], minlength=len(errors)).astype(float),
        np.full(len(errors), kind),
        np.zeros(len(errors), dtype=int),
        repaired,
    )


def _same(some: Sequence[Interval], others: Sequence[Interval]) -> bool:
    return len(some) == len(others) and all(map(is_, some, others))


def _repaired(found: Sequence[Interval], truth: Array) -> NDArray[np.bool_]:
    """Return a mask, shape (frames,), of the frames in which at most a fifth of the error remains.

    `truth` is the injected offset in radians, shape (frames,).
    """
    offset = np.zeros(len(truth))
    for interval in found:
        offset[interval.start : interval.stop] += interval.offset
    repaired: NDArray[np.bool_] = np.abs(wrap(truth - offset)) <= SUCCESS * np.abs(wrap(truth))
    return repaired
