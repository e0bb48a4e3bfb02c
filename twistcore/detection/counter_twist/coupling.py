"""Find the errors of all chains of a limb that explain the jumps in a frame [Method, step 4].

The errors with the lowest total cost are chosen. Costs belong to joints: the motion of joint j
appears in x of chain j, of which it is the parent, and in y of chain j−1, of which it is the child.
A *run* of neighbouring chains i…j, which all have an error, changes only the costs of the joints
i…j+1 (:mod:`twistcore.detection.limbs`). Two runs with an error-free chain between them have no
joint in common. Each run is therefore solved separately, and then the cheapest set of runs is
chosen. A run saves at most the costs of its joints without the run, and no joint costs as much as
an additional chain with an error. Only short runs in few positions must therefore be tried, and
their number is proportional to the length of the limb.
"""

from __future__ import annotations

import numpy as np

from twistcore.detection.counter_twist.best_runs import SAME, best_runs
from twistcore.detection.limbs import Image, Limbs
from twistcore.detection.prediction import Index
from twistcore.detection.robust_cost import CAP, residual_cost
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# Costs are negative log-likelihoods in nats. If a joint jumps alone, both x of its chain and y of
# the chain above jump, but the jump is counted only once.
JOINT_JUMP = 16.0
CHAIN_ACTIVE = 6.0  # cost of the first chain with an error
# Additional cost of each further chain with an error, because two errors seldom begin in the same
# frame. In a straight limb, two opposite errors do not rotate the joint between them, and so look
# like two natural jumps. Tuned on the false alarms of protocols with several injected errors.
ANOTHER_ACTIVE = 18.0
# If the usual residual of a joint is small, as at a hinge, a lone jump is rarer and costs
# log(HINGE / σ) more. Without this, two elbows with a σ of 0.005° in CMU clips remained wrong by
# 0.4° and 1.9°.
HINGE = float(np.radians(0.3))
_SWEEPS = 4  # sweeps of Gauss-Seidel; three chains converge to < 0.01° in three sweeps
_BLOCK = 1 << 16  # chains times frames in a block, so that memory does not grow with the clip


def remove_neighbour_errors(
    limbs: Limbs, t: Index, signals: Array, predicted: Array, sigma: Array
) -> Array:
    """Return the twist increments of chains without the effects of errors in neighbouring chains.

    All arrays except `t` are in radians and have the shape (2, n, m) for x and y of n chains.

    Parameters
    ----------
    limbs
        The limbs.
    t
        The m frames, as flat indices into (limbs, frames).
    signals, predicted
        The captured and the predicted increments in these frames.
    sigma
        The scales of their differences, at least `prediction.FLOOR`.
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
    """The signals of limbs in m frames, sorted by joint instead of by chain.

    For each joint, the signals are x of the chain below and y of the chain above. A joint at an end
    belongs to only one chain. The residual of the missing chain is 0.

    Attributes
    ----------
    limbs
        The limbs, of n chains each.
    t
        The frames, as flat indices into (limbs, frames), shape (m,).
    captured, predicted, sigma
        The captured and predicted increments and their scales, radians, shape (2, n + 1, m).
    rarer
        The additional cost of a lone jump, shape (2, n + 1, m).
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
    """Arrange values for x and y of chains, (2, n, m), by joint, (2, n + 1, m).

    `beyond` is the value for the missing chains at both ends of the limb.
    """
    out = np.empty((2, values.shape[1] + 1, values.shape[2]))
    out[0, :-1], out[1, 1:] = values
    out[0, -1] = out[1, 0] = beyond
    return out


def _joint_cost(residual: Array, sigma: Array, rarer: Array) -> Array:
    """Return the total cost of each joint's residuals, in nats, (joints, …).

    `residual`, `sigma` and `rarer` have the shape (2, joints, …). `rarer` is the additional cost of
    a lone jump.
    """
    cost_x, cost_y = residual_cost(wrap(residual) / sigma, CAP + rarer)
    together = cost_x + cost_y
    lone: Array = JOINT_JUMP + np.minimum(rarer[0], rarer[1])
    cheaper: Array = np.minimum(together, lone)
    return cheaper


def _explained(line: _Line) -> Array:
    """Return the twist increments of joints without the effects of errors, in radians.

    The shape is (2, n + 1, m).
    """
    frames = len(line.t)
    idle = saved = _joint_cost(line.captured - line.predicted, line.sigma, line.rarer)
    # A run that is chosen together with others must gain more than 0. The only run of a frame must
    # gain more than −ANOTHER_ACTIVE, because its first chain costs less, and more than any other
    # run of the frame.
    enough = np.full(frames, -ANOTHER_ACTIVE)
    found: list[tuple[Index, Index, Index, Array]] = []
    trials: list[Array] = []
    for length in range(1, len(line.limbs) + 1):
        saved = saved[:-1] + idle[length:]
        price = length * (CHAIN_ACTIVE + ANOTHER_ACTIVE)
        at = np.flatnonzero(saved > price + enough + SAME)
        if not len(at):
            break  # longer runs do not gain enough either: no joint costs as much as a chain
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
    """Find the errors in runs of `length` neighbouring chains that all have an error.

    Return the joints' twist increments without the effects of the errors, (2, length + 1, runs),
    and the costs of the remaining residuals, (runs,). `first` contains the first chain and `frame`
    the frame of each run, shape (runs,).
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
    """Runs of neighbouring chains that all have an error, each in one frame.

    Attributes
    ----------
    captured, predicted, sigma, rarer
        The values of :class:`_Line` for the joints of each run, shape (2, length + 1, runs).
    down, up
        Functions that return the effect of a chain's error on x of the next chain and on y of the
        previous chain.
    """

    down: Image
    up: Image
    captured: Array
    predicted: Array
    sigma: Array
    rarer: Array

    def solved(self, tip_first: bool) -> tuple[Array, Array]:
        """Return the twist increments without the effects of errors, and the costs of residuals.

        The costs have the shape (runs,). The iteration begins at the tip of the limb if `tip_first`
        is True, and at its root if it is False.
        """
        d = self._errors(tip_first)
        trial = self.captured.copy()
        trial[0, 1:], trial[1, :-1] = self.down(d), self.up(d)
        residual = trial - self.predicted
        residual[0, :-1] -= d
        residual[1, 1:] += d
        return trial, _joint_cost(residual, self.sigma, self.rarer).sum(axis=0)

    def _errors(self, tip_first: bool) -> Array:
        """Return the errors of the chains, in radians, (length, runs), by Gauss-Seidel iteration.

        In the first sweep, an error is estimated only from the signal in which all other errors of
        the run are already known.
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
