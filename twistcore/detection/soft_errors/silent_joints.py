"""Find errors in chains with a silent joint, a joint that never twists naturally.

In some rigs, a joint such as an elbow has no freedom to twist. The level of such a joint, the sum
of its twist increments, is constant except during errors. Unlike the level of a joint at rest, it
is constant even while the other joint of the chain twists.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twistcore.detection.prediction import FLOOR, Mask
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array, multiply, normalise, quaternion_from_axis_angle

STILL = float(np.radians(2e-4))  # per frame; a joint that rotates less is still or only rounded
STANDS = float(np.radians(0.1))  # maximum variation of a constant level
# Minimum share of the frames with motion of the other joint in which a silent joint is still.
LEAST_STILL = 0.08
# A silent joint is still at times in at least LEAST_PARTS of PARTS equal parts of a clip. A joint
# that only rests for a while is still in one or two parts.
PARTS, LEAST_PARTS = 8, 4
# Minimum share of all frames at the most frequent level. It is low because errors of neighbouring
# chains may shift the level.
LEAST_STANDING = 0.03
# Minimum rotation of the other joint per frame, and minimum number of frames with such a rotation.
MOVES, FEWEST = float(np.radians(0.05)), 20
SMALLEST = float(np.radians(1.5))  # smaller errors are ignored
MOST = 200  # maximum number of errors in a limb
CERTAIN = 200.0  # nats: the gain of an error that a silent joint shows
SHORTEST = 8  # frames between two cuts; in a shorter segment, nothing is reported
# If a joint is still in at least this share of the frames, its rotations are errors or filled gaps.
MOSTLY = 0.75
# The other joint rotates back if the remaining rotations are at most this multiple of its own.
ANSWERED = 1.25
ALIKE = 0.05  # explanations whose remaining shares differ by less are considered equally good
# An explanation is clearly better than another if the ratio of the remaining rotations is less.
CLEARLY = 0.25
LEFT = 0.3  # maximum share of the silent joints' rotations that may remain after a correction
# P rotates farther than a silent C rotates back if the ratio of their rotations is between FARTHER
# and FARTHEST and nearly the same at the beginning and at the end (AS_MUCH), and if P rotates in
# step with C (OUT_OF_STEP).
FARTHER, FARTHEST, AS_MUCH, OUT_OF_STEP = 1.12, 1.0 / 0.3, 0.05, 0.1
BESIDE = 8  # minimum number of frames on either side that show P's natural motion


def accumulated_twist_if_silent(increments: Array, other: Array, cut: Mask) -> Array | None:
    """Return a joint's accumulated twist relative to its usual value, or None if it is not silent.

    The accumulated twist is called the joint's level. Its change across a cut is unknown, so the
    usual level is determined separately for each segment between cuts.

    Parameters
    ----------
    increments, other
        The twist increments of the joint and of the other joint of its chain, radians, (frames,).
    cut
        Mask of the cuts of the clip, shape (frames,).

    Returns
    -------
    ndarray, shape (frames,), or None
        The sum of the increments minus the usual level, radians.
    """
    moving = np.abs(other) > MOVES
    still = np.abs(increments) < STILL
    if moving.sum() < FEWEST or still[moving].mean() < LEAST_STILL:
        return None
    parts = [part.any() for part in np.array_split(still & moving, PARTS)]
    if sum(parts) < LEAST_PARTS:
        return None
    level = np.cumsum(increments)
    standing = 0
    for part in np.split(level, np.flatnonzero(cut)):
        if not len(part):
            continue
        order = np.sort(part)
        within = np.searchsorted(order, order + STANDS, side="right") - np.arange(len(order))
        densest = int(within.argmax())
        part -= median(order[densest : densest + int(within[densest])])
        standing += int(within[densest])
    return level if standing >= LEAST_STANDING * len(level) else None


def find_silent_joints(surprise: Surprise) -> dict[int, int]:
    """Return which joint of each chain is silent, so that it never twists naturally.

    The keys are the rows of the chains. The value is 1 if the parent is silent, and −1 if the child
    is. Chains without a silent joint are omitted. If a neighbouring chain shares the silent joint,
    the neighbouring chain must have a silent joint as well. If not, the errors of the two chains
    cannot be distinguished, and the chain is omitted.
    """
    many = surprise.limbs.count
    if surprise.limbs.step:  # with rounded angles, every joint appears to be still at times
        return {}
    still: dict[tuple[int, int], float] = {}
    for row in range(surprise.rows):
        for side, own, other in _both_ways(surprise, row):
            if accumulated_twist_if_silent(own, other, surprise.cut) is not None:
                still[row, side] = float((np.abs(own) < STILL).mean())
    answered = {at for at in still if _answered(*_both_ways(surprise, at[0])[at[1] < 0][1:])}
    found: dict[int, int] = {}
    for (row, side), share in still.items():
        # The same joint in the signals of the neighbouring chain.
        seen = {(row, side), (row - side * many, -side)} & answered
        if (seen or share >= MOSTLY) and share >= still.get((row, -side), 0.0):
            found[row] = side
    return {
        row: side
        for row, side in found.items()
        if (beside := row - side * many) in found or not 0 <= beside < surprise.rows
    }


def _both_ways(surprise: Surprise, row: int) -> tuple[tuple[int, Array, Array], ...]:
    """Return (side, own increments, other joint's increments) for both joints of a chain.

    The increments are twist increments in radians, (frames,). `side` is 1 for the parent and −1 for
    the child.
    """
    x, y = surprise.x[row], surprise.y[row]
    return (1, x, y), (-1, y, x)


def _answered(own: Array, other: Array) -> bool:
    """Return True if the other joint of a chain rotates back whenever a mostly still joint rotates.

    A joint that was held constant over gaps in the capture is also mostly still, but when it moves,
    the other joint does not rotate back. `own` and `other` contain the twist increments of the
    mostly still joint and of the other joint.
    """
    turns = np.abs(own) >= STILL
    return bool(np.abs(own + other)[turns].sum() <= ANSWERED * np.abs(other)[turns].sum())


def silent_joint_error_angles(surprise: Surprise, row: int, side: int) -> Array | None:
    """Return the twist error that a chain's silent joint shows in each frame, radians, (frames,).

    `side` is 1 if the parent is the silent joint, and −1 if the child is. The result is None if
    this joint is not silent.
    """
    x, y = surprise.x[row], surprise.y[row]
    level = (
        accumulated_twist_if_silent(x, y, surprise.cut)
        if side > 0
        else accumulated_twist_if_silent(y, x, surprise.cut)
    )
    return None if level is None else side * level


def extract_silent_joint_errors(surprise: Surprise, sides: dict[int, int]) -> list[SoftError]:
    """Find and remove the errors that the silent joints of a limb show, one at a time.

    `sides` is the result of :func:`find_silent_joints` for the rows of the limb. If several
    silent joints twist in the same frames, a single error may be the cause. The error whose removal
    leaves the least twist in the silent joints is therefore removed first.
    """
    found: list[SoftError] = []
    done: Mask = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    for _ in range(MOST):
        rivals = []
        for row, side in sides.items():
            level = silent_joint_error_angles(surprise, row, side)
            if level is None:
                continue
            for start, stop in silent_joint_error_ranges(
                np.where(done[row], 0.0, level), surprise.cut
            ):
                farther = _farther(surprise, row, start, stop) if side < 0 else 1.0
                offset = farther * level[start:stop]
                gain = CERTAIN
                error = SoftError(row, start, offset, gain, STANDS, 1.0 / farther, silent=True)
                rivals.append((_left(surprise, sides, error), error))
        if not rivals:
            break
        share, best = min(rivals, key=lambda r: (r[0], r[1].start, r[1].row))
        if share > LEFT:
            break
        best = _of_two_chains(surprise, sides, best, [e for v, e in rivals if v <= share + ALIKE])
        _remove(surprise, best)
        done[best.row, best.start : best.stop] = True
        found.append(best.trimmed())
    return found


def _farther(surprise: Surprise, row: int, start: int, stop: int) -> float:
    """Return the ratio of a parent's rotation to the opposite rotation of its silent child.

    The rotations are measured in and around frames [start, stop). A cubic polynomial, which
    estimates the natural motion of the parent, is removed from them first. The result is 1 if the
    ratio is unclear.
    """
    beside = max(BESIDE, (stop - start) // 2)
    low, high = max(start - beside, 1), min(stop + beside, surprise.frames)
    x, back = surprise.x[row, low:high], -surprise.y[row, low:high]
    on_the_way = np.arange(len(back)) <= np.abs(np.cumsum(back)).argmax()
    ways = np.stack([back * on_the_way, back * ~on_the_way])
    smooth = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, len(x)), 4))[0]
    x, ways = (v - (v @ smooth) @ smooth.T for v in (x, ways))
    gram = ways @ ways.T
    if np.linalg.cond(gram) > 1e6:
        return 1.0
    times = np.linalg.solve(gram, ways @ x).tolist()
    if np.linalg.norm(x - times @ ways) > OUT_OF_STEP * np.linalg.norm(x):
        return 1.0
    clear = min(times) >= FARTHER and max(times) <= min((1.0 + AS_MUCH) * min(times), FARTHEST)
    return float(np.mean(times)) if clear else 1.0


def _left(surprise: Surprise, sides: dict[int, int], error: SoftError) -> float:
    """Return the fraction of the silent joints' rotations that remains after removing an error."""
    before = _turned(surprise, sides, error)
    _remove(surprise, error)
    left = _turned(surprise, sides, error)
    _remove(surprise, replace(error, offset=-error.offset))
    return left / max(before, FLOOR)


def _of_two_chains(
    surprise: Surprise, sides: dict[int, int], best: SoftError, alike: list[SoftError]
) -> SoftError:
    """Choose among equally good errors by how well the chain's other joint rotates back.

    If two chains share a silent joint, this joint does not show which of the chains has the error.
    `alike` contains the candidates, including `best`. If no candidate is clearly better, `best` is
    returned.
    """
    answers = {
        e: _unanswered(surprise, e, sides[e.row])
        for e in alike
        if max(abs(e.start - best.start), abs(e.stop - best.stop)) <= BESIDE
    }
    other = min(answers, key=lambda e: answers[e])
    return other if answers[other] < CLEARLY * answers[best] else best


def _unanswered(surprise: Surprise, error: SoftError, side: int) -> float:
    """Return how far a chain's other joint fails to rotate back when its silent joint rotates.

    The result is relative to the rotations of the other joint. It is 0 if these rotations cancel
    the rotations of the silent joint. `side` is 1 if the parent is the silent joint, and −1 if the
    child is.
    """
    own, other = _both_ways(surprise, error.row)[side < 0][1:]
    at = slice(max(error.start, 1), error.stop + 1)
    left, turned = own[at] + other[at], other[at]
    return float(np.abs(left).sum() / max(np.abs(turned).sum(), FLOOR))


def _turned(surprise: Surprise, sides: dict[int, int], error: SoftError) -> float:
    at = slice(max(error.start, 1), error.stop + 1)
    rows = [r for r in surprise.neighbours(error.row) if r in sides]
    silent = [surprise.x[r, at] if sides[r] > 0 else surprise.y[r, at] for r in rows]
    return float(sum(np.abs(v).sum() for v in silent))


def _remove(surprise: Surprise, error: SoftError) -> None:
    surprise.remove_error(error.row, error.start, error.followed * error.offset)
    if error.followed < 1.0:
        k, i = divmod(error.row, surprise.limbs.count)
        at, axis = slice(error.start, error.stop), surprise.limbs.axes[k, i]
        rest = (error.followed - 1.0) * error.offset
        turn = quaternion_from_axis_angle(axis if axis.ndim == 1 else axis[at], rest)
        surprise.joints[k, i, at] = normalise(multiply(surprise.joints[k, i, at], turn))
    surprise.update_departures(error.row, error.start, error.stop)


def silent_joint_error_ranges(level: Array, cut: Mask) -> list[tuple[int, int]]:
    """Return the frame ranges [start, stop) in which a silent joint shows an error.

    `level` is the joint's accumulated twist relative to its usual value, in radians, (frames,). A
    range ends at a cut. Ranges in short segments between cuts, such as a T-pose at the start, are
    omitted.
    """
    off = np.flatnonzero(np.abs(level) > STANDS)
    if not len(off):
        return []
    runs = np.split(off, np.flatnonzero((np.diff(off) > 1) | cut[off[1:]]) + 1)
    cuts = np.flatnonzero(cut)
    spans = []
    for run in runs:
        before, behind = cuts[cuts <= run[0]], cuts[cuts > run[-1]]
        low = int(before[-1]) if len(before) else 0
        high = int(behind[0]) if len(behind) else len(level)
        start, stop = max(int(run[0]) - 2, low), min(int(run[-1]) + 3, high)
        if np.abs(level[start:stop]).max() > SMALLEST and high - low >= SHORTEST:
            spans.append((start, stop))
    return spans
