"""Check the results of third-party detectors.

A failure is reported as a TwistError whose one-sentence message names the detector.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from twistcore.detection.protocol import Analysis, Detector, DetectorInfo
from twistcore.errors import TwistError

if TYPE_CHECKING:
    from twistcore.detection.interval import Interval
    from twistcore.skeleton.chain import Chain
    from twistcore.skeleton.motion import Motion
    from twistcore.skeleton.rotation import Array
    from twistcore.work.progress import Tell


@contextmanager
def exceptions_as_twist_error(what: str) -> Iterator[None]:
    """Convert any exception in a `with` block to a TwistError whose message begins with `what`.

    A MemoryError is not converted.
    """
    try:
        yield
    except MemoryError:
        raise
    except TwistError as error:
        raise TwistError(f"{what}: {error}") from error
    except (Exception, SystemExit) as error:
        said = " ".join(str(error).split())
        name = type(error).__name__
        raise TwistError(f"{what} ({name}: {said})" if said else f"{what} ({name})") from error


class GuardedDetector:
    """A detector whose results are checked.

    Parameters
    ----------
    detector
        The detector.
    place
        The file and class from which the detector was loaded, or ''.
    """

    def __init__(self, detector: Detector, place: str = "") -> None:
        self.detector, self.place = detector, place

    @property
    def info(self) -> DetectorInfo:
        """The detector's description: its name and the texts that the program shows."""
        return self.detector.info

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> GuardedAnalysis:
        """Analyse chains of a motion as far as possible without a threshold τ.

        The strength, the automatic τ and the intervals at this τ are computed immediately for each
        chain, so that most failures occur in this method. Raises TwistError if the detector fails.
        """
        name = self.info.name
        with exceptions_as_twist_error(f"the detector {name!r} failed"):
            analysis = self.detector.analyse(motion, chains, tell)
        for method in ("automatic_tau", "strength", "intervals"):
            if not callable(getattr(analysis, method, None)):
                raise TwistError(
                    f"the detector {name!r}: expected an analysis with a method {method}"
                )
        guarded = GuardedAnalysis(name, analysis, motion.frames)
        for chain in chains:
            guarded.strength(chain.name)
            guarded.intervals(chain.name, guarded.automatic_tau(chain.name))
        return guarded


class GuardedAnalysis:
    """The analysis of a third-party detector. Its methods raise TwistError for invalid results."""

    def __init__(self, name: str, analysis: Analysis, frames: int) -> None:
        self._name, self.analysis, self._frames = name, analysis, frames
        self._strengths: dict[str, Array] = {}
        # `_explained` returns the same object each time, because callers cache results by interval.
        self._known: WeakKeyDictionary[Interval, Interval] = WeakKeyDictionary()

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ of a chain, in radians."""
        with exceptions_as_twist_error(f"the detector {self._name!r} failed on {chain}"):
            tau = float(self.analysis.automatic_tau(chain))
        if not 0.0 < tau <= math.pi:
            raise self._wrong(chain, "an automatic τ above 0 and up to π", f"{tau:g}")
        return tau

    def strength(self, chain: str) -> Array:
        """Return the strength of a chain, which is compared with τ, in radians ≥ 0, (frames,)."""
        import numpy as np  # imported here because listing the names does not need it

        if chain not in self._strengths:
            with exceptions_as_twist_error(f"the detector {self._name!r} failed on {chain}"):
                strength = np.asarray(self.analysis.strength(chain), dtype=np.float64)
            if strength.shape != (self._frames,):
                shape = f"{self._frames} numbers for the strength"
                raise self._wrong(chain, shape, str(strength.shape))
            if not (np.isfinite(strength) & (strength >= 0.0)).all():
                raise self._wrong(chain, "a strength of 0 or more in every frame", "others")
            self._strengths[chain] = strength
        return self._strengths[chain]

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at threshold τ in radians, sorted by start."""
        with exceptions_as_twist_error(f"the detector {self._name!r} failed on {chain}"):
            found = list(self.analysis.intervals(chain, tau))
        for one in found:
            self._check(chain, one)
        return tuple(map(self._explained, sorted(found, key=lambda i: (i.start, i.stop))))

    def __getattr__(self, name: str) -> Any:  # further methods of some analyses, such as `removed`
        return getattr(self.analysis, name)

    def _check(self, chain: str, found: Any) -> None:
        import numpy as np

        from twistcore.detection.interval import Interval

        if not isinstance(found, Interval):
            raise self._wrong(chain, "intervals", f"{found!r:.80}")
        if found.chain != chain:
            raise self._wrong(chain, "intervals of this chain", repr(found.chain))
        if not 0 <= found.start < found.stop <= self._frames:
            spans = f"{found.start}–{found.stop}"
            raise self._wrong(chain, f"intervals within {self._frames} frames", spans)
        offset = np.asarray(found.offset)
        if offset.shape != (found.frames,) or not np.isfinite(offset).all():
            raise self._wrong(chain, "a finite offset for each frame of an interval", "others")

    def _wrong(self, chain: str, expected: str, found: str) -> TwistError:
        return TwistError(
            f"the detector {self._name!r} on {chain}: expected {expected}, found {found}"
        )

    def _explained(self, found: Interval) -> Interval:
        from dataclasses import replace

        if found.explain is None:
            return found
        if found not in self._known:
            self._known[found] = replace(found, explain=_Reasons(self._name, found.explain))
        return self._known[found]


class _Reasons:
    """A callable that returns an interval's evidence, or the error message if this fails."""

    def __init__(self, name: str, explain: Callable[[], dict[str, Any]]) -> None:
        self._name, self._explain = name, explain

    def __call__(self) -> dict[str, Any]:
        try:
            return dict(self._explain())
        except Exception as error:
            return {"error": f"the detector {self._name!r} failed ({type(error).__name__})"}
