"""Store how well each injected error is repaired, and compute the FSR and its uncertainty.

FSR is the share of error frames that are repaired. Errors that are injected together form a draw.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

_Z = 1.96  # for a 95 % confidence band
_TAIL = 0.025
_SAME_SIZE = 1e-9  # radians


@dataclass(frozen=True, eq=False)
class DrawnErrors:
    """Errors injected into clips, with the number of frames repaired at every τ of a grid.

    Parameters
    ----------
    size
        The largest |δ| of each error, radians, shape (errors,).
    frames
        Number of frames of each error, shape (errors,).
    kind
        Index of the protocol from which each error was drawn, shape (errors,).
    draw
        Index of the draw to which each error belongs, shape (errors,). Errors injected together
        form a draw.
    repaired
        Number of repaired frames of each error at each of n values of τ, shape (errors, n).
    """

    size: Array
    frames: Array
    kind: NDArray[np.int_]
    draw: NDArray[np.int_]
    repaired: Array

    def __add__(self, other: DrawnErrors) -> DrawnErrors:
        behind = other.draw + (self.draw.max() + 1 if len(self.draw) else 0)
        pairs = zip(vars(self).values(), vars(replace(other, draw=behind)).values(), strict=True)
        return DrawnErrors(*(np.concatenate(pair) for pair in pairs))

    def of(self, chosen: NDArray[np.bool_]) -> DrawnErrors:
        """Return the errors selected by the mask `chosen`, shape (errors,)."""
        return DrawnErrors(*(values[chosen] for values in vars(self).values()))

    def from_size(self, smallest: float) -> DrawnErrors:
        """Return the errors whose size is at least `smallest`, in radians."""
        return self.of(self.size >= smallest - _SAME_SIZE)

    def between(self, below: int, share: float) -> DrawnErrors:
        """Return the errors at a single τ between grid point `below` and the next one.

        The numbers of repaired frames are interpolated. `share` is the distance from grid point
        `below`, as a fraction of the step to the next grid point.
        """
        pair = self.repaired[:, below : below + 2]
        mixed = pair @ [1.0 - share, share] if pair.shape[1] > 1 else pair[:, 0]
        return replace(self, repaired=mixed[:, np.newaxis])

    @property
    def fsr(self) -> Array:
        """Return the fraction of repaired error frames, 0…1, shape (n,), or NaN without errors."""
        frames = float(self.frames.sum())
        return self.repaired.sum(axis=0) / frames if frames else self._nothing

    @property
    def band(self) -> tuple[Array, Array]:
        """Return the lower and upper 95 % confidence limits of :attr:`fsr`, each of shape (n,).

        Wilson bounds are computed for each protocol and combined as in [Zou & Donner 2008], since
        the number of frames of each protocol is fixed.
        """
        if not self.frames.sum():
            return self._nothing, self._nothing
        down, up = np.zeros(self.repaired.shape[1]), np.zeros(self.repaired.shape[1])
        for kind in np.unique(self.kind):
            some = self.of(self.kind == kind)
            low, high = some._wilson()
            weight = float(some.frames.sum() / self.frames.sum())
            down += (weight * (some.fsr - low)) ** 2
            up += (weight * (high - some.fsr)) ** 2
        return np.maximum(self.fsr - np.sqrt(down), 0.0), np.minimum(self.fsr + np.sqrt(up), 1.0)

    def _wilson(self) -> tuple[Array, Array]:
        """Return the Wilson bounds of :attr:`fsr`, which are valid even for few errors.

        Each error is weighted by its number of frames. If the errors of a draw tend to be repaired
        or missed together, the effective number of errors is reduced accordingly.
        """
        p = self.fsr
        n = np.full(len(p), self.frames.sum() ** 2 / np.square(self.frames).sum())
        spread = self._variance_between_draws(p)
        seen = (spread > 0.0) & (p > 0.0) & (p < 1.0)
        n[seen] = np.minimum(n[seen], np.maximum((p * (1.0 - p))[seen] / spread[seen], 1.0))
        middle = (p + _Z**2 / (2.0 * n)) / (1.0 + _Z**2 / n)
        half = _Z * np.sqrt(p * (1.0 - p) / n + _Z**2 / (4.0 * n**2)) / (1.0 + _Z**2 / n)
        return np.clip(middle - half, 0.0, p), np.clip(middle + half, p, 1.0)

    def _variance_between_draws(self, p: Array) -> Array:
        """Return the variance of :attr:`fsr` (`p`) between draws, (n,), or 0 for a single draw."""
        _, which = np.unique(self.draw, return_inverse=True)
        draws = int(which.max()) + 1
        if draws < 2:
            return np.zeros(len(p))
        off = np.zeros((draws, len(p)))
        np.add.at(off, which, self.repaired - np.outer(self.frames, p))
        spread: Array = draws / (draws - 1) * np.square(off).sum(axis=0) / self.frames.sum() ** 2
        return spread

    @property
    def _nothing(self) -> Array:
        return np.full(self.repaired.shape[1], np.nan)


def poisson_confidence_interval(count: float) -> tuple[float, float]:
    """Return the 95 % confidence interval of the mean of a Poisson-distributed count."""
    from scipy.special import gammaincinv  # slow to load; only needed for a curve

    low = float(gammaincinv(count, _TAIL)) if count > 0.0 else 0.0
    return low, float(gammaincinv(count + 1.0, 1.0 - _TAIL))
