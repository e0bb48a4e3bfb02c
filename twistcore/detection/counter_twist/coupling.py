"""Solve chains that share a joint together, frame by frame [Method, step 4].

In every frame with a jump, the errors of chains are found that explain the jump at the lowest cost.

Costs are assigned to joints: the motion of joint j appears in x of chain j and in y of chain j−1. A
*run* of neighbouring chains with errors, i…j, changes only the costs of joints i…j+1
(:mod:`twistcore.detection.limbs`), and two runs with an error-free chain between them have no joint
in common. So each run is solved separately, and then the cheapest set of runs along the line is
chosen. A run saves at most its joints' costs without the run, and no joint costs as much as one
more chain with an error. Therefore only short runs in few positions need to be tried, and their
number is proportional to the length of the line.
"""

from __future__ import annotations

import numpy as np

from twistcore.detection.counter_twist.best_runs import SAME, best_runs
from twistcore.detection.limbs import Image, Limbs
from twistcore.detection.prediction import Index
from twistcore.detection.robust_cost import CAP, residual_cost
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# Costs are negative log likelihoods. x of chain k and y of chain k−1 belong to the motion of one
# joint: if both jump and no error explains it, this joint jumped alone, which is counted once.
JOINT_JUMP = 16.0
CHAIN_ACTIVE = 6.0
# Two errors seldom begin in the same frame, and two opposite ones in a straight limb do not
# turn the joint between them: they look like two natural jumps. Tuned on false alarms of rich
# protocols.
ANOTHER_ACTIVE = 18.0
# A joint that jumps alone may turn to any angle, and the caps express how rare that is compared
# with the usual residual. If the usual residual is small, as at a hinge, a jump is even rarer and
# costs log(HINGE / σ) more. Measured on CMU: elbows with σ 0.005° remained wrong by 0.4° and 1.9°
# at a cost of 14 nats.
HINGE = float(np.radians(0.3))
_SWEEPS = 4  # sweeps of Gauss-Seidel; three chains converge to < 0.01° in three sweeps
_BLOCK = 1 << 16  # chains times frames in a block, so that memory does not grow with the clip


def explain_frames(limbs: Limbs, t: Index, signals: Array, predicted: Array, sigma: Array) -> Array:
    """Return the increments x and y at frames `t` without the effects of neighbours' errors.

    `signals`, `predicted`, `sigma` and the result are in radians and have the shape (2, n, len(t)).
    `sigma` must not be below `prediction.FLOOR`.
    """
    clean = np.empty_like(signals)
    size = max(1, _BLOCK // len(limbs))
    for begin in range(0, len(t), size):
        at = slice(begin, begin + size)
        joints = _explained(_line(limbs, t[at], *(v[..., at] for v in (signals, predicted, sigma))))
        clean[0, :, at], clean[1, :, at] = joints[0, :-1], joints[1, 1:]
    return clean


@dataclass(frozen=True, eq=False)
class _Line:
    """The signals of limbs at frames `t`, sorted by joint instead of by chain.

    For each joint, these are x of the chain below and y of the chain above.

    A joint at an end belongs to only one chain. The residual of the missing chain is 0.

    Attributes
    ----------
    captured, predicted, sigma
        In radians, shape (2, n + 1, len(t)).
    rarer
        The extra cost of a lone jump, above the caps.
    """

    limbs: Limbs
    t: Index
    captured: Array
    predicted: Array
    sigma: Array
    rarer: Array


def _line(limbs: Limbs, t: Index, signals: Array, predicted: Array, sigma: Array) -> _Line:
    rarer = np.maximum(np.log(HINGE / sigma), 0.0)
    return _Line(
        limbs, t, _by_joint(signals, 0.0), _by_joint(predicted, 0.0),
        _by_joint(sigma, 1.0), _by_joint(rarer, np.inf),
    )  # fmt: skip


def _by_joint(values: Array, beyond: float) -> Array:
    """Convert x and y of chains, (2, n, frames), to values of joints, (2, n + 1, frames).

    `beyond` is the value for the missing chains at the ends.
    """
    out = np.empty((2, values.shape[1] + 1, values.shape[2]))
    out[0, :-1], out[1, 1:] = values
    out[0, -1] = out[1, 0] = beyond
    return out


def _joint_cost(residual: Array, sigma: Array, rarer: Array) -> Array:
    """Return the cost of the residuals at each joint, (2, joints, …) → (joints, …).

    `rarer` is the additional cost of a lone jump.
    """
    cost_x, cost_y = residual_cost(wrap(residual) / sigma, CAP + rarer)
    together = cost_x + cost_y
    lone: Array = JOINT_JUMP + np.minimum(rarer[0], rarer[1])
    cheaper: Array = np.minimum(together, lone)
    return cheaper


def _explained(line: _Line) -> Array:
    """Return the joints' increments without the effects of errors, (2, n + 1, frames)."""
    frames = len(line.t)
    idle = saved = _joint_cost(line.captured - line.predicted, line.sigma, line.rarer)
    # Together with other runs, a run may be chosen if it gains more than 0. Alone, it may be chosen
    # if it gains more than −ANOTHER_ACTIVE, because the first chain costs less, and more than any
    # other run of its frame.
    enough = np.full(frames, -ANOTHER_ACTIVE)
    found: list[tuple[Index, Index, Index, Array]] = []
    trials: list[Array] = []
    for length in range(1, len(line.limbs) + 1):
        saved = saved[:-1] + idle[length:]
        price = length * (CHAIN_ACTIVE + ANOTHER_ACTIVE)
        at = np.flatnonzero(saved > price + enough + SAME)
        if not len(at):
            break  # longer runs are not worth their cost either: no joint costs as much as a chain
        first, frame = np.divmod(at, frames)
        trial, cost = _solved(line, first, length, frame)
        gain = saved.ravel()[at] - price - cost
        np.maximum.at(enough, frame, np.minimum(gain, 0.0))
        found.append((frame, first, first + length, gain))
        trials.append(trial)
    clean = line.captured.copy()
    if not found:
        return clean
    frame, first, last, gain = (np.concatenate(v) for v in zip(*found, strict=True))
    chosen = best_runs(frame, first, last, gain, ANOTHER_ACTIVE)
    begin = 0
    for trial in trials:
        own = chosen[(begin <= chosen) & (chosen < begin + trial.shape[2])]
        joint = first[own] + np.arange(trial.shape[1])[:, None]
        clean[:, joint, frame[own]] = trial[..., own - begin]
        begin += trial.shape[2]
    return clean


def _solved(line: _Line, first: Index, length: int, frame: Index) -> tuple[Array, Array]:
    """Solve runs of `length` chains; return the increments of their joints and the remaining cost.

    `first` contains the first chain and `frame` the frame of each run, shape (runs,). The
    increments have the shape (2, length + 1, runs), and the cost has the shape (runs,).
    """
    at = (first + np.arange(length + 1)[:, None]) * len(line.t) + frame
    arrays = line.captured, line.predicted, line.sigma, line.rarer
    some = (v.reshape(2, -1)[:, at] for v in arrays)
    runs = _Runs(*line.limbs.images(first, length, line.t[frame]), *some)
    trial, cost = runs.solved(tip_first=False)
    if length > 1:
        other, its_cost = runs.solved(tip_first=True)
        better = its_cost < cost - SAME
        trial[..., better], cost[better] = other[..., better], its_cost[better]
    return trial, cost


@dataclass(frozen=True, eq=False)
class _Runs:
    """Runs of chains with an error, each at one frame.

    Attributes
    ----------
    captured, predicted, sigma, rarer
        The values of :class:`_Line` for the joints of each run, shape (2, length + 1, runs).
    down, up
        Functions for the effects of an error on the chains below and above.
    """

    down: Image
    up: Image
    captured: Array
    predicted: Array
    sigma: Array
    rarer: Array

    def solved(self, tip_first: bool) -> tuple[Array, Array]:
        """Return the increments without the effects of the errors, and the cost of the residuals.

        The cost has the shape (runs,). The iteration begins at the tip of the limb if `tip_first`
        is True, and at its root if not.
        """
        d = self._errors(tip_first)
        trial = self.captured.copy()
        trial[0, 1:], trial[1, :-1] = self.down(d), self.up(d)
        residual = trial - self.predicted
        residual[0, :-1] -= d
        residual[1, 1:] += d
        return trial, _joint_cost(residual, self.sigma, self.rarer).sum(axis=0)

    def _errors(self, tip_first: bool) -> Array:
        """Return the errors d of the chains, (length, runs).

        The first sweep uses only signals that no error of the run has changed yet.
        """
        (x, y), (px, py) = self.captured, self.predicted
        variance = self.sigma * self.sigma
        weight = variance[0, :-1] / (variance[0, :-1] + variance[1, 1:])
        d = np.zeros_like(weight)
        last = len(d) - 1
        for sweep in range(_SWEEPS if last else 1):
            for k in range(last, -1, -1) if tip_first else range(last + 1):
                rx = wrap((self.down(d[k - 1], k - 1) if k else x[0]) - px[k])
                ry = wrap((self.up(d[k + 1], k + 1) if k < last else y[-1]) - py[k + 1])
                if sweep == 0 and not tip_first and k < last:
                    d[k] = rx
                elif sweep == 0 and tip_first and k:
                    d[k] = -ry
                else:
                    d[k] = wrap(rx - wrap(rx + ry) * weight[k])
        return d
