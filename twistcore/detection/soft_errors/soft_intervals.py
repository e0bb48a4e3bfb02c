"""Soft errors beside the intervals that jumps were paired into."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.interval import Interval
from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import Mask
from twistcore.detection.soft_errors.natural_scale import unlikely_increments
from twistcore.detection.soft_errors.silent_joints import (
    STANDS,
    off_runs,
    silent_errors,
    silent_level,
    silent_sides,
)
from twistcore.detection.soft_errors.soft_error import SoftError, judged
from twistcore.detection.soft_errors.soft_search import SEED, Search, gains, search_all
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

ROUNDS = 2
# Of the searches of a clip, for each frame of each joint, of so many frames at least: departures
# that courses are fitted to. So the cost of a clip goes by its size, not by how restless it is.
BUDGET, LEAST_FRAMES = 15.0, 100
NAMED = 5  # of the spans that were not looked at
KNOWN_FIRST = 10.0  # nats by which jumps may explain a stretch less
BESIDE = 2  # frames around an interval in which a departure puts it in doubt


@dataclass(frozen=True, eq=False)
class Known:
    """An interval that is known: offset of P from frame `start` on, radians.

    firm: of a straight limb, doubted only where a silent joint tells better.
    """

    row: int
    start: int
    offset: Array
    firm: bool = False

    @property
    def stop(self) -> int:
        """The frame behind it."""
        return self.start + len(self.offset)


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search of limbs comes to.

    found: soft errors; replaced: the known intervals that they stand in for; left: frames of limbs
    at which it did not look, since its budget was spent, (limbs, frames).
    """

    found: list[SoftError]
    replaced: list[Known]
    left: Mask


def soft_errors(
    limbs: Limbs, fps: float, cut: Mask, known: Sequence[Known]
) -> tuple[list[SoftError], list[Known]]:
    """Soft errors, and the known intervals that they stand in for."""
    searched = search(limbs, fps, cut, known)
    return searched.found, searched.replaced


def budget_of(frames: int, joints: int) -> float:
    """The work that the searches of a clip may take in all, as `Surprise.work` counts it."""
    return BUDGET * joints * max(frames, LEAST_FRAMES)


def search(
    limbs: Limbs, fps: float, cut: Mask, known: Sequence[Known], budget: float = math.inf
) -> Searched:
    """Search limbs for soft errors; budget: the work that it may take.

    What is known is taken out; where something is left at any time scale that natural motion does
    not do, what was known there is doubted and all is explained anew.
    """
    left = np.zeros((limbs.count, limbs.frames), dtype=bool)
    surprise = Surprise(limbs, fps, cut, budget)
    captured = surprise.x, surprise.y
    if not surprise.spans:
        return Searched([], [], left)
    # Jumps paired wrongly hide that a joint is silent; but where the limb is straight for most of
    # the time the level that stands is the error.
    straight = {k.row % limbs.count for k in known if k.firm}
    as_captured = {
        r: s for r, s in silent_sides(surprise).items() if r % limbs.count not in straight
    }
    for k in known:
        surprise.take_out(k.row, k.start, k.offset)
    if known:
        _refresh(surprise)
    sides = as_captured | silent_sides(surprise)
    lively = np.array([r not in sides for r in range(surprise.rows)])
    unnatural = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for row, side in sides.items():
        level = silent_level(surprise, row, side)
        if level is None:
            unnatural[row] = True
            continue
        for start, stop in off_runs(level, cut):
            unnatural[row, start:stop] = True
        for k in known if row % limbs.count not in straight else ():
            # Where a silent joint tells to a tenth of a degree, about right is not enough.
            if k.row == row and np.abs(level[k.start : k.stop]).max() > STANDS:
                unnatural[row, k.start : k.stop] = True
    bad = np.zeros_like(unnatural)
    if lively.any():
        bad = unlikely_increments(surprise.x, surprise.y, fps, limbs.step)
        surprise.measure(bad)
        unnatural |= _unnatural(surprise) & lively[:, None]
    if not unnatural.any():
        return Searched([], [], left)
    silent = {r % limbs.count for r in sides}
    doubted = [
        k
        for k in known
        if (not k.firm or k.row % limbs.count in silent)
        and _near_has(surprise, unnatural, k.row, k.start - BESIDE, k.stop + BESIDE)
    ]
    for k in doubted:
        surprise.take_out(k.row, k.start, -k.offset)
        bad[k.row, k.start : k.stop] = True
    _refresh(surprise)
    found: list[SoftError] = []
    limbs_left = sorted({r % limbs.count for r in np.flatnonzero(unnatural.any(axis=1)).tolist()})
    for i in limbs_left:
        found += silent_errors(surprise, {r: sides[r] for r in surprise.limb(i) if r in sides})
    # Where a silent joint now stands still, nothing else is wrong there.
    standing = {r: v for r, s in sides.items() if (v := silent_level(surprise, r, s)) is not None}
    replaced = [
        k
        for k in doubted
        if k.row in standing and np.abs(standing[k.row][k.start : k.stop]).max() <= STANDS
    ]
    doubted = [k for k in doubted if k not in replaced]
    if lively.any():
        firm = [k for k in known if k.firm and k not in doubted]
        soft, left = _lively_errors(surprise, bad, lively)
        soft = [f for f in soft if not any(_meets(surprise, k, f) for k in firm)]
        found += _better(surprise, doubted, soft)
    last = surprise.rows - limbs.count
    found = [
        judged(
            f,
            captured[0][f.row],
            captured[1][f.row],
            cut,
            sides.get(f.row, 0),
            last=f.row >= last,
        )
        for f in found
    ]
    replaced += [k for k in doubted if any(_meets(surprise, k, f) for f in found)]
    return Searched(found, replaced, left)


def _better(
    surprise: Surprise, doubted: Sequence[Known], found: Sequence[SoftError]
) -> list[SoftError]:
    """Of soft errors those that explain more than what was known in their place.

    What meets, in a limb, stands or falls together: a stretch is explained by the one or the other.
    """
    out: list[SoftError] = []
    for limb in range(surprise.limbs.count):
        rows = surprise.limb(limb)
        news = [f for f in found if f.row in rows]
        olds = [k for k in doubted if k.row in rows]
        for low, high in _stretches([*news, *olds]):
            here = [f for f in news if low <= f.start < high]
            there = [k for k in olds if low <= k.start < high]
            if here and there:
                margin = (high - low) // 2 + 8
                window = max(low - margin, 0), min(high + margin, surprise.frames)
                left = sum(surprise.of(r, *window) for r in rows)
                for f in here:
                    _move(surprise, f, -1.0)
                for k in there:
                    _move(surprise, k, 1.0)
                if sum(surprise.of(r, *window) for r in rows) < left + KNOWN_FIRST:
                    continue
            out += here
    return out


def _move(surprise: Surprise, error: SoftError | Known, sign: float) -> None:
    surprise.take_out(error.row, error.start, sign * error.offset)
    surprise.look_again(error.row, error.start, error.stop)


def _stretches(errors: Sequence[SoftError | Known]) -> list[tuple[int, int]]:
    """Frames [low, high) of errors that meet."""
    out: list[tuple[int, int]] = []
    for e in sorted(errors, key=lambda e: e.start):
        if out and e.start < out[-1][1]:
            out[-1] = out[-1][0], max(out[-1][1], e.stop)
        else:
            out.append((e.start, e.stop))
    return out


def _lively_errors(
    surprise: Surprise, bad: Mask, lively: NDArray[np.bool_]
) -> tuple[list[SoftError], Mask]:
    """Soft errors of chains whose joints both twist, and what is left of :class:`Searched`.

    The second round, from scales without what the first one found, has what that left of the
    budget, half of it or more: without it what is restless by nature is taken for errors.
    """
    left = np.zeros((surprise.limbs.count, surprise.frames), dtype=bool)
    bad |= unlikely_increments(surprise.x, surprise.y, surprise.fps, surprise.limbs.step)
    joints = surprise.joints.copy()
    found: list[SoftError] = []
    for turn in range(ROUNDS):
        if turn:
            surprise.joints[...] = joints
            _refresh(surprise)
            bad[:] = False
            for f in found:
                bad[f.row, f.start : f.stop] = True
        surprise.measure(bad)
        rows = np.flatnonzero(_unnatural(surprise).any(axis=1) & lively).tolist()
        searches = {
            i: Search(surprise, [r for r in surprise.limb(i) if lively[r]])
            for i in sorted({r % surprise.limbs.count for r in rows})
        }
        share = surprise.budget / ROUNDS
        if turn + 1 == ROUNDS:
            share = surprise.budget - surprise.work
        search_all(list(searches.values()), surprise, share)
        found = [f for s in searches.values() for f in s.found]
        left[:] = False
        for i, s in searches.items():
            left[i] = s.left()
        if not found:
            break
    return found, left


def _refresh(surprise: Surprise) -> None:
    """Increments of all rows from the rotations as they are."""
    limbs = surprise.limbs.with_joints(surprise.joints)
    surprise.x, surprise.y = limbs.increments()
    surprise.x[:, surprise.cut] = surprise.y[:, surprise.cut] = 0.0


def _unnatural(surprise: Surprise) -> Mask:
    """Frames under a span that departs too far, (rows, frames)."""
    rows = np.arange(surprise.rows)
    out = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for k, a in enumerate(surprise.at):
        span = a.natural.span
        for row, position in np.argwhere(gains(surprise, k, rows) > SEED).tolist():
            out[row, span.step * position : span.step * position + span.support] = True
    return out


def _near_has(surprise: Surprise, mask: Mask, row: int, low: int, high: int) -> bool:
    rows = sorted({r for near in surprise.beside(row) for r in surprise.beside(near)})
    return bool(mask[rows, max(low, 0) : high].any())


def _meets(surprise: Surprise, known: Known, found: SoftError) -> bool:
    same = known.row in surprise.beside(found.row)
    return same and known.start < found.stop and found.start < known.stop


def left_sentences(left: Mapping[str, Sequence[tuple[int, int]]]) -> tuple[str, ...]:
    """What a search did not look at, a sentence for chains with the same frames [low, high)."""
    chains: dict[tuple[tuple[int, int], ...], list[str]] = {}
    for name, spans in left.items():
        chains.setdefault(tuple(spans), []).append(name)
    said = []
    for spans, names in chains.items():
        frames = ", ".join(f"{low}–{high}" for low, high in spans[:NAMED])
        frames += " …" if len(spans) > NAMED else ""
        said.append(
            f"Soft errors were not looked for in frames {frames} ({', '.join(names)}), "
            "because the motion is too restless there."
        )
    return tuple(said)


def soft_interval(chain: str, error: SoftError) -> Interval:
    """The interval of a soft error in a chain."""
    return Interval(
        chain,
        error.start,
        error.stop,
        error.offset,
        confidence=confidence(error.gain),
        explain=partial(_told, error),
        followed=error.followed,
        open=error.unsure,
    )


def confidence(gain: float) -> float:
    """Probability that the repair is right, 0…1."""
    return 1.0 / (1.0 + math.exp(-max(-30.0, min(30.0, (gain - 80.0) / 12.0))))


def _told(error: SoftError) -> dict[str, Any]:
    """Why it was found; degrees."""
    return {
        "gain": error.gain,
        "follows": "a soft onset",
        "sigma_deg": math.degrees(error.sigma),
        "child_follows": error.followed,
        "silent_joint": error.silent,
    }
