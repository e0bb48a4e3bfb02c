"""The errors that were drawn, one by one, and how far they tell what other draws would bring."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

_Z = 1.96  # of a band that holds in 95 of 100 draws
_TAIL = 0.025
_SAME_SIZE = 1e-9  # radians


@dataclass(frozen=True, eq=False)
class DrawnErrors:
    """Errors put into clips.

    size: the largest |δ| of each, radians, (errors,); frames: how many it has, (errors,); kind:
    equal for those of one protocol, (errors,); draw: equal for those that were in a clip together,
    (errors,); repaired: of its frames those that are repaired at every τ, (errors, n).
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
        """Some of them."""
        return DrawnErrors(*(values[chosen] for values in vars(self).values()))

    def from_size(self, smallest: float) -> DrawnErrors:
        """Those of at least that size, radians."""
        return self.of(self.size >= smallest - _SAME_SIZE)

    def between(self, below: int, share: float) -> DrawnErrors:
        """The same at one τ: a share of the way from a place of the grid to the next."""
        pair = self.repaired[:, below : below + 2]
        mixed = pair @ [1.0 - share, share] if pair.shape[1] > 1 else pair[:, 0]
        return replace(self, repaired=mixed[:, np.newaxis])

    @property
    def fsr(self) -> Array:
        """Share of the error frames that were repaired, 0…1, (n,); NaN where nothing was drawn."""
        frames = float(self.frames.sum())
        return self.repaired.sum(axis=0) / frames if frames else self._nothing

    @property
    def band(self) -> tuple[Array, Array]:
        """Where the FSR of all such errors lies, by these: 95 % confidence, (n,) each.

        Of each protocol by itself `_wilson`, then together as [Zou & Donner 2008] add bounds:
        how many frames each protocol has is no chance.
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
        """Wilson's bounds, which are right for few errors, too, and where all were repaired.

        Errors count by their frames. Where those of a draw fare alike, as one that is missed takes
        the next along, they are worth so many fewer.
        """
        p = self.fsr
        n = np.full(len(p), self.frames.sum() ** 2 / np.square(self.frames).sum())
        spread = self._spread(p)
        seen = (spread > 0.0) & (p > 0.0) & (p < 1.0)
        n[seen] = np.minimum(n[seen], np.maximum((p * (1.0 - p))[seen] / spread[seen], 1.0))
        middle = (p + _Z**2 / (2.0 * n)) / (1.0 + _Z**2 / n)
        half = _Z * np.sqrt(p * (1.0 - p) / n + _Z**2 / (4.0 * n**2)) / (1.0 + _Z**2 / n)
        return np.clip(middle - half, 0.0, p), np.clip(middle + half, p, 1.0)

    def _spread(self, p: Array) -> Array:
        """Variance of the FSR as the draws differ, (n,); 0 where there are not two."""
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


def rate_band(count: float) -> tuple[float, float]:
    """What a count of rare events may be a draw of: the mean's 95 % confidence (Poisson)."""
    from scipy.special import gammaincinv  # slow to load; only a curve needs it

    low = float(gammaincinv(count, _TAIL)) if count > 0.0 else 0.0
    return low, float(gammaincinv(count + 1.0, 1.0 - _TAIL))
