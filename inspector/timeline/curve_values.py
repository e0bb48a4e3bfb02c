"""The numbers behind the curves: the signals after correction, and angles ready to be drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from inspector.session.opening import Analysed
from twistcore.chain import Chain, uncorrectable_joints
from twistcore.rotation import Array, multiply, quaternion_from_axis_angle, twist_angle, wrap

RELIABLE = 0.2  # ‖v⊥‖/‖v‖ below which the azimuth is shaded
_ZERO = 1e-9
_SAME_AXIS = 1.0 - 1e-12


@dataclass(frozen=True, eq=False)
class After:
    """θp, θc, Δθp, Δθc of the corrected chain, radians, each of shape (frames,)."""

    theta_p: Array
    theta_c: Array
    dtheta_p: Array
    dtheta_c: Array


class Corrected:
    """The signals of one chain after correction, from the offsets alone.

    A correction turns P back by the offset about its own axis and C on by the same, so θp loses
    the offset and the child's azimuth gains it: no quaternion of P or C is needed again. A chain
    above whose child is P turns P from the left; only there, only in the frames it corrects, is
    θp taken from quaternions anew.
    """

    def __init__(self, data: Analysed, chain: Chain) -> None:
        self._motion = data.motion
        self._chain = chain
        self._signals = data.signals[chain.name]
        skeleton = data.motion.skeleton
        others = [
            c for c in data.chains if c is not chain and not uncorrectable_joints(data.motion, c)
        ]
        self._fixed = bool(uncorrectable_joints(data.motion, chain))
        self._above = [c for c in others if chain.parent in skeleton.children[c.parent]]
        below = [c for c in others if c.parent == chain.child]
        self.exact = (
            chain.axis.ndim == 1
            and not any(c.parent == chain.parent for c in others)
            and all(_parallel(c.axis, chain.arm) for c in below)
        )
        defined = self._signals.azimuth_reliability > _ZERO
        self._defined = defined & np.roll(defined, 1)

    def after(self, offset: Callable[[str], Array]) -> After:
        """The signals after; offset: radians, (frames,), of a chain by name.

        Only where `exact`: an axis that varies, or a child that turns about another axis than its
        own bone, needs the whole motion (`Document.signals_after`).
        """
        own = np.zeros_like(self._signals.theta_p) if self._fixed else offset(self._chain.name)
        theta_p = self._signals.theta_p
        for chain in self._above:
            turned = offset(chain.name)
            at = np.flatnonzero(turned)
            if len(at):
                theta_p = theta_p.copy()
                axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
                ahead = quaternion_from_axis_angle(axis, turned[at])
                parent = self._motion.rotations[at, self._chain.parent]
                theta_p[at] = twist_angle(multiply(ahead, parent), self._chain.axis)
        theta_p = wrap(theta_p - own)
        step = np.diff(own, prepend=own[:1])
        dtheta_c = np.where(self._defined, wrap(self._signals.dtheta_c + step), 0.0)
        dtheta_c[:1] = 0.0
        return After(
            theta_p=theta_p,
            theta_c=np.cumsum(dtheta_c),
            dtheta_p=wrap(np.diff(theta_p, prepend=theta_p[:1])),
            dtheta_c=dtheta_c,
        )


def centre_of(angle: Array) -> float:
    """The direction round which an angle stays most of the time, radians; (frames,) -> number."""
    return float(np.angle(np.exp(1j * angle).sum())) if len(angle) else 0.0


def degrees_about(angle: Array, centre: float) -> tuple[Array, NDArray[np.int64]]:
    """An angle in degrees within half a turn of `centre`, (frames,), and its seams.

    A seam is a frame behind which it leaves on one side and comes in on the other. The line is
    broken there: a full turn is no movement and must not look like one. Real jumps are drawn.
    """
    y = np.degrees(centre + wrap(angle - centre))
    return y, np.flatnonzero(np.abs(np.diff(y)) > 180.0)


def thinned(
    y: Array, seams: NDArray[np.int64], first: float, last: float, pixels: int
) -> tuple[Array, Array]:
    """Points of a line over the frames in view: all of them, or the extremes of each pixel.

    y: a value a frame, NaN where nothing is drawn; the extremes pass NaN over, so that a short
    piece between gaps is still seen from afar. Returns x and y with NaN where the line is broken.
    """
    start, stop = max(0, int(first) - 1), min(len(y), int(last) + 3)
    step = (stop - start) // max(1, pixels)
    if step < 3:
        x, out = np.arange(start, stop, dtype=np.float64), y[start:stop]
        here = seams[(seams >= start) & (seams < stop - 1)]
        if len(here):
            x = np.insert(x, here - start + 1, here + 0.5)
            out = np.insert(out, here - start + 1, np.nan)
        return x, out
    start -= start % step  # bins stay where they are while the view moves: no shimmer
    bins = -(-(stop - start) // step)
    block = y[start : start + bins * step]
    if len(block) < bins * step:
        block = np.concatenate([block, np.full(bins * step - len(block), np.nan)])
    # A row a frame of every pixel: numpy compares whole rows at once, eight times as fast.
    block = np.ascontiguousarray(block.reshape(bins, step).T)
    ends = np.stack([np.fmin.reduce(block), np.fmax.reduce(block)], axis=1)
    at = (seams + 1 - start) // step
    ends[at[(at >= 0) & (at < bins)]] = np.nan
    x = start + step * (np.arange(bins) + 0.5) - 0.5
    return np.repeat(x, 2), ends.ravel()


def unreliable_spans(reliability: Array) -> Array:
    """Half-open spans [start, stop) in which the azimuth says nothing, integers, (spans, 2)."""
    low = np.concatenate([[False], reliability < RELIABLE, [False]])
    return np.flatnonzero(np.diff(low)).reshape(-1, 2)


def _parallel(axis: Array, arm: Array) -> bool:
    if axis.ndim != 1 or arm.ndim != 1:
        return False
    return bool(abs(axis @ arm) > _SAME_AXIS)
