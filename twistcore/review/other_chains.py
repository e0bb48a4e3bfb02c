"""Change the chains of a review, and repeat the detection in the affected chains."""

from __future__ import annotations

import math

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import Interval
from twistcore.review.commands import ChangeChains
from twistcore.review.model import ReviewState


def chain_change_command(
    before: ClipAnalysis, after: ClipAnalysis, state: ReviewState, what: str = ""
) -> ChangeChains:
    """Return the command that changes a review from one set of chains to another.

    A chain in both analyses keeps its τ, but an automatic τ is computed again. Detection is also
    repeated in neighbours of an added or removed chain, since the errors of neighbouring chains are
    explained together.

    Parameters
    ----------
    before, after
        The analyses of the clip with the old and the new chains.
    state
        The state of the review.
    what
        The command's name in the undo menu.
    """
    method = before.usable(state.method)
    old, new = before.detector(method), after.detector(method)
    there = {c.name for c in before.chains_and_limbs} & state.tau.keys()
    tau: dict[str, float] = {}
    again: list[str] = []
    found: list[Interval] = []
    for name in (c.name for c in after.chains_and_limbs):
        stays = name in there and before.rig.own(name) == after.rig.own(name)
        tau[name] = new.automatic_tau(name)
        if stays and not _was_automatic(state.tau[name], old.automatic_tau(name), tau[name]):
            tau[name] = state.tau[name]
        intervals = new.intervals(name, tau[name])
        if not (stays and _alike(intervals, old.intervals(name, state.tau[name]))):
            again.append(name)
            found += intervals
    moved = _new_first_chains(before, after, state)
    return ChangeChains(after.rig, tau, tuple(again), tuple(found), what, moved)


def _new_first_chains(
    before: ClipAnalysis, after: ClipAnalysis, state: ReviewState
) -> dict[str, str]:
    """Return each person's new first chain, keyed by the earlier one.

    The result contains only chains under which decided errors of the whole body are listed.
    """
    decided = {
        j.interval.chain for j in state.intervals if j.kept and j.interval.kind.info.whole_body
    }
    if not decided:
        return {}
    first, now = (
        {chain.person: chain.name for chain in reversed(analysis.search("").chosen)}
        for analysis in (before, after)
    )
    return {
        name: now[person]
        for person, name in first.items()
        if name in decided and now.get(person, name) != name
    }


def _was_automatic(tau: float, before: float, now: float) -> bool:
    """Return True if `tau` was the automatic τ before, and the automatic τ has changed since."""
    return math.isclose(tau, before) and not math.isclose(before, now)


def _alike(some: tuple[Interval, ...], others: tuple[Interval, ...]) -> bool:
    """Return True if a session file would have the same entries for both tuples of intervals."""
    return len(some) == len(others) and all(
        (a.start, a.stop, a.confidence, a.open, a.kind, a.carried)
        == (b.start, b.stop, b.confidence, b.open, b.kind, b.carried)
        and np.array_equal(a.offset, b.offset)
        for a, b in zip(some, others, strict=True)
    )
