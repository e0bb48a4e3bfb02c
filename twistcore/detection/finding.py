"""Finders: functions that search for the kinds of errors that detectors do not find."""

from __future__ import annotations

from collections.abc import Callable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, TypeVar

from twistcore.detection.guarded import exceptions_as_twist_error
from twistcore.detection.interval import Interval
from twistcore.detection.kind import Kind
from twistcore.errors import TwistError
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion

Found = Mapping[str, Sequence[Interval]]
Frames = Callable[[int, int], Motion]  # function that returns the frames [start, stop) of a motion
Known = TypeVar("Known")


@dataclass(frozen=True, eq=False)
class KindSearch:
    """The input of a finder: a clip, with its known errors and automatic corrections.

    Parameters
    ----------
    motion : Motion
        The clip as it was captured.
    chains : tuple of Chain
        The chains of all limbs. Each error belongs to one of them.
    chosen : tuple of Chain
        The chains for which to report errors: all or some of `chains`.
    whole : bool
        True if `chains` contains all chains of the clip. If False, joints outside `chains` are not
        searched.
    named : tuple of Chain
        All chains, twist bones and limbs to which known errors may belong.
    errors : callable
        Function that returns the known errors: the intervals of all correctable kinds at the
        automatic τ.
    corrected : callable
        Function without arguments that returns a function that computes frames of the corrected
        motion, or None if there are no automatic corrections.
    without : callable, optional
        Function that takes a list of errors and returns a function that computes frames of the
        motion without these errors.
    captured : KindSearch, optional
        The same input without known errors and corrections, or None if this input has none.
    """

    motion: Motion
    chains: tuple[Chain, ...]
    chosen: tuple[Chain, ...]
    whole: bool = True
    named: tuple[Chain, ...] = ()
    errors: Callable[[], Sequence[Interval]] = tuple
    corrected: Callable[[], Frames | None] = lambda: None
    without: Callable[[Sequence[Interval]], Frames] | None = None
    captured: KindSearch | None = None
    _kept: MutableMapping[Any, Any] = field(default_factory=dict)

    def corrected_motion(self) -> Motion:
        """Return the motion after all automatic corrections. The result is cached."""
        return self.once(_corrected)

    def joint_of(self, interval: Interval) -> int:
        """Return the index of an interval's joint.

        Raises KeyError if the clip has no joint with that name.
        """
        return self.motion.skeleton.index(interval.joint)

    def once(self, work: Callable[[KindSearch], Known]) -> Known:
        """Return `work(self)`. The result is computed once and shared by the finders of all kinds.

        Callers must not change the result, and the result must not depend on `chosen`.
        """
        if work not in self._kept:
            self._kept.setdefault(work, work(self))
        known: Known = self._kept[work]
        return known


def _corrected(search: KindSearch) -> Motion:
    frames = search.corrected()
    return search.motion if frames is None else frames(0, search.motion.frames)


Finder = Callable[[KindSearch], Found]


def finder_of(kind: Kind) -> Finder:
    """Return the function that finds errors of the given kind.

    Raises TwistError if the function cannot be loaded.
    """
    module, _, name = kind.info.find.partition(":")
    with exceptions_as_twist_error(
        f"the search for the error kind {kind.value!r} cannot be loaded"
    ):
        finder: Finder = getattr(import_module(module), name)
    return finder


def intervals_of_kind(kind: Kind, search: KindSearch) -> dict[str, tuple[Interval, ...]]:
    """Return the intervals of a kind, keyed by the name of each chosen chain, sorted by start.

    Raises TwistError if the kind's finder fails or returns impossible intervals.
    """
    finder, frames = finder_of(kind), search.motion.frames
    with exceptions_as_twist_error(f"the search for the error kind {kind.value!r} failed"):
        found = finder(search)
        for name, own in found.items():
            for one in own:
                if (one.chain, one.kind) != (name, kind):
                    raise TwistError(
                        f"expected {name} to find only intervals of its own kind, found {one!r}"
                    )
                if not 0 <= one.start < one.stop <= frames:
                    raise TwistError(
                        f"expected intervals inside the clip ({frames} frames), found {one!r}"
                    )
    chosen = (chain.name for chain in search.chosen)
    return {n: tuple(sorted(found.get(n, ()), key=lambda i: (i.start, i.stop))) for n in chosen}
