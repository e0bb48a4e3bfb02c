"""Search limbs for soft errors, and combine them with the intervals found between jumps."""

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
from twistcore.detection.soft_errors.natural_scale import unnaturally_large_twist_increments
from twistcore.detection.soft_errors.silent_joints import (
    STANDS,
    extract_silent_joint_errors,
    find_silent_joints,
    silent_joint_error_angles,
    silent_joint_error_ranges,
)
from twistcore.detection.soft_errors.soft_error import SoftError, mark_error_if_unsure
from twistcore.detection.soft_errors.soft_search import (
    SEED,
    Search,
    explain_seeds_within_budget,
    twist_departure_costs_per_span,
)
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

ROUNDS = 2  # rounds of the search
# The work allowed per frame and joint for the searches in a clip, and the minimum number of frames
# for which it is computed. The unit is a departure to which courses are fitted. With a budget, the
# time depends on the size of a clip, not on how jittery it is.
BUDGET, LEAST_FRAMES = 15.0, 50
NAMED = 5  # maximum number of frame ranges in a sentence
KNOWN_FIRST = 10.0  # nats by which soft errors must explain the motion better than known errors
# An unnatural departure at most this number of frames from a known interval makes it doubtful.
BESIDE = 2


@dataclass(frozen=True, eq=False)
class Known:
    """An interval that was found before the search for soft errors.

    Attributes
    ----------
    row
        The row of the chain.
    start
        The first frame.
    offset
        The twist error in each frame, radians.
    firm
        True for an error of a straight limb, which is replaced only if a silent joint explains the
        motion better.
    """

    row: int
    start: int
    offset: Array
    firm: bool = False

    @property
    def stop(self) -> int:
        """The frame after the interval's last frame."""
        return self.start + len(self.offset)


@dataclass(frozen=True, eq=False)
class Searched:
    """The result of a search for soft errors.

    Attributes
    ----------
    found
        The soft errors.
    replaced
        The intervals found before the search that the soft errors replace.
    left
        Mask of the frames that were not searched within the budget, shape (limbs, frames).
    """

    found: list[SoftError]
    replaced: list[Known]
    left: Mask


def soft_search_budget(frames: int, joints: int) -> float:
    """Return the work allowed for all searches in a clip, in the units of `Surprise.work`."""
    return BUDGET * joints * max(frames, LEAST_FRAMES)


def search_soft_errors(
    limbs: Limbs, fps: float, cut: Mask, known: Sequence[Known], budget: float = math.inf
) -> Searched:
    """Search limbs for soft errors.

    The known errors are removed first. Where the remaining motion is unnatural at any time scale,
    the known errors are restored, and soft errors are searched for instead.

    Parameters
    ----------
    limbs
        The limbs, all with the same number of chains.
    fps
        The frame rate.
    cut
        Mask of the cuts of the clip and of frame 0, shape (frames,).
    known
        The intervals that were found between jumps and in straight limbs.
    budget
        The maximum amount of work, in the units of `Surprise.work`.
    """
    left = np.zeros((limbs.count, limbs.frames), dtype=bool)
    surprise = Surprise(limbs, fps, cut, budget)
    captured = surprise.x, surprise.y
    if not surprise.spans:
        return Searched([], [], left)
    # Removing wrongly paired jumps would hide silent joints, so they are also searched for in the
    # captured motion, except in limbs with errors of a straight limb, in which the constant level
    # may be the error.
    straight = {k.row % limbs.count for k in known if k.firm}
    as_captured = {
        r: s for r, s in find_silent_joints(surprise).items() if r % limbs.count not in straight
    }
    for k in known:
        surprise.remove_error(k.row, k.start, k.offset)
    if known:
        _refresh(surprise)
    sides = as_captured | find_silent_joints(surprise)
    lively = np.array([r not in sides for r in range(surprise.rows)])
    unnatural = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for row, side in sides.items():
        level = silent_joint_error_angles(surprise, row, side)
        if level is None:
            unnatural[row] = True
            continue
        for start, stop in silent_joint_error_ranges(level, cut):
            unnatural[row, start:stop] = True
        for k in known if row % limbs.count not in straight else ():
            # A silent joint shows errors to a tenth of a degree, so an interval must be that exact.
            if k.row == row and np.abs(level[k.start : k.stop]).max() > STANDS:
                unnatural[row, k.start : k.stop] = True
    bad = np.zeros_like(unnatural)
    if lively.any():
        bad = unnaturally_large_twist_increments(surprise.x, surprise.y, fps, limbs.step)
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
        surprise.remove_error(k.row, k.start, -k.offset)
        bad[k.row, k.start : k.stop] = True
    _refresh(surprise)
    found: list[SoftError] = []
    limbs_left = sorted({r % limbs.count for r in np.flatnonzero(unnatural.any(axis=1)).tolist()})
    for i in limbs_left:
        found += extract_silent_joint_errors(
            surprise, {r: sides[r] for r in surprise.limb(i) if r in sides}
        )
    # A known interval is replaced if the silent joint of its chain is now still in its frames.
    standing = {
        r: v
        for r, s in sides.items()
        if (v := silent_joint_error_angles(surprise, r, s)) is not None
    }
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
        mark_error_if_unsure(
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
    """Return the soft errors that explain the motion better than known errors in the same frames.

    For each group of overlapping errors of a limb, either all soft errors or all known errors are
    chosen.
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
    surprise.remove_error(error.row, error.start, sign * error.offset)
    surprise.update_departures(error.row, error.start, error.stop)


def _stretches(errors: Sequence[SoftError | Known]) -> list[tuple[int, int]]:
    """Return the frame ranges [low, high) covered by groups of overlapping errors."""
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
    """Search the chains without silent joints. Return their soft errors and the unsearched frames.

    In the second of two rounds, the natural scales are measured without the errors found in the
    first. At least half of the budget is reserved for the second round, because errors that only
    the first round finds may be natural jitter.

    Parameters
    ----------
    surprise
        The limbs.
    bad
        Mask of the frames in which natural scales are not measured, (rows, frames). Changed in
        place.
    lively
        Mask of the rows to search.

    Returns
    -------
    found : list of SoftError
        The soft errors.
    left : ndarray, shape (limbs, frames)
        Mask of the frames that were not searched within the budget.
    """
    left = np.zeros((surprise.limbs.count, surprise.frames), dtype=bool)
    bad |= unnaturally_large_twist_increments(
        surprise.x, surprise.y, surprise.fps, surprise.limbs.step
    )
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
        explain_seeds_within_budget(list(searches.values()), surprise, share)
        found = [f for s in searches.values() for f in s.found]
        left[:] = False
        for i, s in searches.items():
            left[i] = s.left()
        if not found:
            break
    return found, left


def _refresh(surprise: Surprise) -> None:
    """Recompute the twist increments of all rows from the current rotations."""
    limbs = surprise.limbs.with_joints(surprise.joints)
    surprise.x, surprise.y = limbs.increments()
    surprise.x[:, surprise.cut] = surprise.y[:, surprise.cut] = 0.0


def _unnatural(surprise: Surprise) -> Mask:
    """Return a mask of the frames in spans with an unnaturally large departure, (rows, frames).

    A departure is the distance from the natural course over a span.
    """
    rows = np.arange(surprise.rows)
    out = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for k, a in enumerate(surprise.at):
        span = a.natural.span
        for row, position in np.argwhere(
            twist_departure_costs_per_span(surprise, k, rows) > SEED
        ).tolist():
            out[row, span.step * position : span.step * position + span.support] = True
    return out


def _near_has(surprise: Surprise, mask: Mask, row: int, low: int, high: int) -> bool:
    rows = sorted({r for near in surprise.neighbours(row) for r in surprise.neighbours(near)})
    return bool(mask[rows, max(low, 0) : high].any())


def _meets(surprise: Surprise, known: Known, found: SoftError) -> bool:
    same = known.row in surprise.neighbours(found.row)
    return same and known.start < found.stop and found.start < known.stop


def unsearched_frames_sentences(left: Mapping[str, Sequence[tuple[int, int]]]) -> tuple[str, ...]:
    """Return notes for the user about frames that were not searched for soft errors.

    `left` contains the frame ranges [low, high), keyed by chain name. Chains with the same ranges
    share a note.
    """
    chains: dict[tuple[tuple[int, int], ...], list[str]] = {}
    for name, spans in left.items():
        chains.setdefault(tuple(spans), []).append(name)
    said = []
    for spans, names in chains.items():
        frames = ", ".join(f"{low}–{high}" for low, high in spans[:NAMED])
        frames += " …" if len(spans) > NAMED else ""
        said.append(
            f"The program did not search for soft errors in frames {frames} "
            f"({', '.join(names)}), because the motion there is too irregular."
        )
    return tuple(said)


def soft_interval(chain: str, error: SoftError) -> Interval:
    """Return a soft error as an interval of the named chain."""
    return Interval(
        chain,
        error.start,
        error.stop,
        error.offset,
        confidence=soft_error_confidence_from_gain(error.gain),
        explain=partial(_evidence, error),
        followed=error.followed,
        open=error.unsure,
    )


def soft_error_confidence_from_gain(gain: float) -> float:
    """Return the probability that the correction of a soft error is right, 0…1, given its gain."""
    return 1.0 / (1.0 + math.exp(-max(-30.0, min(30.0, (gain - 80.0) / 12.0))))


def _evidence(error: SoftError) -> dict[str, Any]:
    """Return the evidence for a soft error, keyed by name, with angles in degrees."""
    return {
        "gain": error.gain,
        "follows": "a soft onset",
        "sigma_deg": math.degrees(error.sigma),
        "child_follows": error.followed,
        "silent_joint": error.silent,
    }
