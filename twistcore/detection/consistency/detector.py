"""The computations of the consistency detector [Method].

The detector itself is declared in `detectors/consistency.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from twistcore.detection.consistency.chain_analysis import (
    ChainAnalysis,
    ConsistencyAnalysis,
    FixedInterval,
    automatic_tau,
)
from twistcore.detection.consistency.notated import (
    NotatedAnalysis,
    has_priority_in_interval_overlap,
)
from twistcore.detection.consistency.pieces import detrended_twist_increments
from twistcore.detection.counter_twist.counter_rotation import CounterRotation, counter_rotation
from twistcore.detection.counter_twist.edges import find_interval_edges_and_steps
from twistcore.detection.counter_twist.pairing import (
    edge_pair_table,
    running_counter_rotation_sums,
)
from twistcore.detection.cuts import find_cuts, segments_between
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.limbs import Limbs
from twistcore.detection.noise_bursts import largest_joint_and_ancestor_noise
from twistcore.detection.prediction import Mask
from twistcore.detection.soft_errors import (
    Known,
    SoftError,
    search_soft_errors,
    soft_interval,
    soft_search_budget,
)
from twistcore.detection.straight_limbs import (
    Jumps,
    StraightError,
    find_straight_limb_errors,
    remove_twist_errors,
    straight_limb_interval,
)
from twistcore.skeleton.chain import Chain, group_chains_by_person
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.notation import Keys, find_keys_of_linear_motion, without_repeated_frames
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array, conjugate, multiply, quaternion_from_axis_angle
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress, stage_progress

LONG = 20_000  # frames; in longer clips, limbs are analysed one at a time


def analyse_counter_twists_of_chains(
    motion: Motion, chains: Sequence[Chain], tell: Tell | None = None, effort: float = 1.0
) -> ConsistencyAnalysis | NotatedAnalysis:
    """Analyse chains of a motion, before a threshold τ is chosen.

    `tell` is called with the progress, from 0 to 1. `effort` limits the work of the search for soft
    errors, as a fraction of the usual limit.
    """
    tell = tell or ignore_progress
    if (held := without_repeated_frames(motion)) is not None:
        own = [c.at(held.first) for c in chains]
        return NotatedAnalysis(held, _analysed(held.motion, own, tell, effort))
    if (keys := find_keys_of_linear_motion(motion)) is not None:
        return _by_keys(motion, chains, keys, tell, effort)
    return _analysed(motion, chains, tell, effort)


def _by_keys(
    motion: Motion, chains: Sequence[Chain], keys: Keys, tell: Tell, effort: float
) -> NotatedAnalysis:
    """Analyse a clip with linear keys, between which joints rotate at constant speed.

    First, all frames are searched for jumps, and the clear errors are removed. Then only the keys
    are analysed.
    """
    fine = _analysed(motion, chains, stage_progress(tell, 0.0, 0.5), effort, keys)
    rotations = motion.rotations.copy()
    for chain in chains:
        for i in fine.intervals(chain.name, fine.automatic_tau(chain.name)):
            if has_priority_in_interval_overlap(i):
                at = slice(i.start, i.stop)
                axis = chain.axis if chain.axis.ndim == 1 else chain.axis[at]
                turn = quaternion_from_axis_angle(axis, i.offset)
                rotations[at, chain.parent] = multiply(rotations[at, chain.parent], conjugate(turn))
                rotations[at, chain.child] = multiply(turn, rotations[at, chain.child])
    kept = keys.alone(motion.with_rotations(rotations))
    own = [c.at(kept.first) for c in chains]
    coarse = _analysed(kept.motion, own, stage_progress(tell, 0.5, 1.0), effort)
    return NotatedAnalysis(kept, coarse, fine)


def _analysed(
    motion: Motion, chains: Sequence[Chain], tell: Tell, effort: float, keys: Keys | None = None
) -> ConsistencyAnalysis:
    """Analyse chains of a motion without held frames.

    `effort` has the same meaning as in :func:`analyse_counter_twists_of_chains`. If the linear keys
    `keys` are given, only jumps are searched for, not errors of straight limbs or soft errors.
    """
    cut = find_cuts(motion)
    segments = segments_between(cut, motion.fps)
    cut[:1] = True
    out: dict[str, ChainAnalysis] = {}
    searched: list[_Softened] = []
    people = group_chains_by_person(chains)
    joints = _joints_by_person(motion.skeleton, people)
    # Analyse one person at a time, so that the result does not depend on the selection of people.
    for person, own in people.items():
        for lines in _alike(_lines(own)):
            count = sum(map(len, lines))
            budget = effort * count / len(own) * soft_search_budget(motion.frames, joints[person])
            share = stage_progress(tell, len(out) / len(chains), (len(out) + count) / len(chains))
            found = _line_analyses(lines, motion, cut, segments, keys, budget, share)
            searched.append(found)
            out |= {c.name: c for c in found.chains()}
    pieces = {c.name: detrended_twist_increments(motion, c) for c in chains if not c.ends}
    noise = {
        person: largest_joint_and_ancestor_noise(
            motion, {j for c in of for j in (c.parent, c.child)}
        )
        for person, of in people.items()
    }
    witnesses = {c.name: ChainSignals.of(motion, c, noise[c.person]) for c in chains}
    analysis = ConsistencyAnalysis(out, cut, pieces, witnesses)
    for found in searched:
        if found.errors and (given_up := found.given_up(analysis)):
            out |= {c.name: c for c in found.chains(given_up)}
    return ConsistencyAnalysis(out, cut, pieces, witnesses)


def _joints_by_person(skeleton: Skeleton, people: Mapping[str, Sequence[Chain]]) -> dict[str, int]:
    """Return the number of joints of each person, keyed by the person's name.

    If no person has a name, the only key is '', with the number of all joints.
    """
    if not any(people):
        return dict.fromkeys(people, len(skeleton))
    joints = {
        person: len({j for c in of for j in (c.parent, c.child)}) for person, of in people.items()
    }
    joints |= {person.name: len(person.joints) for person in find_people(skeleton)}
    return joints


@dataclass(frozen=True, eq=False)
class _Softened:
    """The analyses of several limbs with the same number of chains, and their soft errors.

    Attributes
    ----------
    plain
        The analyses of the chains without soft errors, one for each row.
    count
        The number of limbs.
    errors
        The soft errors, each with its interval.
    replaced
        The intervals between jumps that soft errors replace.
    """

    plain: Sequence[ChainAnalysis]
    count: int
    errors: Sequence[tuple[SoftError, FixedInterval]] = ()
    replaced: Sequence[Known] = ()

    def chains(self, given_up: Mapping[int, bool] = MappingProxyType({})) -> list[ChainAnalysis]:
        """Return the analyses of the chains with soft errors.

        `given_up` is the result of :meth:`given_up`. By default, all soft errors are used.
        """
        if not self.errors and not self.replaced:
            return list(self.plain)
        instead: dict[int, list[tuple[int, int]]] = {c.row: [] for c in self.plain}
        stand = [e for k, (e, _) in enumerate(self.errors) if k not in given_up]
        for e in stand:
            for row in (e.row - self.count, e.row, e.row + self.count):
                if row in instead:
                    instead[row].append((e.start, e.stop))
        for k in self.replaced:
            once = any(_meets(self.count, k, e) for e, _ in self.errors)
            if not once or any(_meets(self.count, k, e) for e in stand):
                instead[k.row].append((k.start, k.stop))
        kept = [own for k, own in enumerate(self.errors) if not given_up.get(k)]
        return [
            c.with_soft([own for e, own in kept if e.row == c.row], instead[c.row])
            for c in self.plain
        ]

    def given_up(self, analysis: ConsistencyAnalysis) -> dict[int, bool]:
        """Return the soft errors that must not replace intervals between jumps, keyed by index.

        The value is True if the soft error is omitted, because an overlapping interval between
        jumps is more certain. The value is False if the soft error is kept, but is judged to be
        natural motion (see :meth:`ConsistencyAnalysis.taken_for_motion`).
        """
        out = {}
        for k, (error, own) in enumerate(self.errors):
            judged, motion = analysis.with_evidence(own.interval)
            if motion:
                out[k] = False
            elif not has_priority_in_interval_overlap(judged) and any(
                self._has_clearer_interval(analysis, c, error) for c in self.plain
            ):
                out[k] = True
        return out

    def _has_clearer_interval(
        self, analysis: ConsistencyAnalysis, chain: ChainAnalysis, error: SoftError
    ) -> bool:
        """Return True if a chain has a clear interval between jumps that overlaps a soft error.

        Only the chain of the soft error and its neighbours are considered.
        """
        if abs(chain.row - error.row) not in (0, self.count):
            return False
        found = chain.intervals(chain.automatic_tau())
        near = (i for i in found if i.start < error.stop and error.start < i.stop)
        return any(has_priority_in_interval_overlap(analysis.with_evidence(i)[0]) for i in near)


def _meets(count: int, known: Known, error: SoftError) -> bool:
    """Return True if an interval and a soft error of the same or neighbouring chains overlap.

    `count` is the number of limbs.
    """
    near = abs(known.row - error.row) in (0, count)
    return near and known.start < error.stop and error.start < known.stop


def _line_analyses(
    lines: list[list[Chain]],
    motion: Motion,
    cut: Mask,
    segments: Sequence[tuple[int, int]],
    keys: Keys | None,
    budget: float,
    tell: Tell,
) -> _Softened:
    """Search limbs for jumps, then for errors of straight limbs, and then for soft errors.

    All limbs have the same number of chains.

    Parameters
    ----------
    lines
        The chains of each limb, from :func:`_lines`.
    motion
        The motion.
    cut
        Mask of the cuts and of frame 0, shape (frames,).
    segments
        The result of :func:`segments_between`.
    keys
        The linear keys. If they are given, only jumps are searched for.
    budget
        The work allowed for the search for soft errors.
    tell
        The function to call with the progress.
    """
    fps, limbs = motion.fps, _limbs(lines, motion, keys)
    strung = [c for same in zip(*lines, strict=True) for c in same]
    jumps = find_jumps(limbs, fps, cut, segments, tell)
    straight = {}
    for row, chain in enumerate(strung if keys is None else ()):
        by_itself = partial(_by_itself, limbs, jumps, row)
        if found := find_straight_limb_errors(motion, chain, jumps[row], by_itself):
            straight[row] = found
    if straight:  # the error of a chain also has an effect on the signals of its neighbours
        jumps = find_jumps(
            remove_twist_errors(limbs, {r: s.offset for r, s in straight.items()}),
            fps,
            cut,
            segments,
            tell,
        )
    analyses = []
    for row, chain in enumerate(strung):
        own: Jumps = jumps[row]
        standing: tuple[FixedInterval, ...] = ()
        if row in straight:
            own = straight[row].leaves(own)
            standing = tuple(_fixed_straight(chain.name, e) for e in straight[row].errors)
        analyses.append(
            ChainAnalysis(
                chain.name,
                fps,
                own.counter,
                row,
                own.edges,
                own.step,
                own.tables,
                standing,
                rounded=limbs.step > 0.0,
            )
        )
    if keys is not None:
        return _Softened(analyses, limbs.count)
    return _with_soft(limbs, fps, cut, analyses, budget)


def _by_itself(limbs: Limbs, jumps: Sequence[Jumps], row: int) -> tuple[Array, Array]:
    """Return a chain's twist increments x and y, without the effects of errors in its neighbours.

    `jumps` contains the jumps of all chains, and `row` is the row of the chain.
    """
    beside = (r for r in (row - limbs.count, row + limbs.count) if 0 <= r < len(jumps))
    images = {r: offset for r in beside if (offset := jumps[r].offset()).any()}
    if not images:
        return jumps[row].counter.x[row], jumps[row].counter.y[row]
    x, y = remove_twist_errors(limbs, images).increments()
    return x[row], y[row]


def _with_soft(
    limbs: Limbs, fps: float, cut: Mask, chains: list[ChainAnalysis], budget: float
) -> _Softened:
    """Search for soft errors in addition to the intervals at the automatic τ.

    The search assumes that every child rotated back by the whole error. If a child clearly rotated
    back by only a part of an error, the remaining part is removed first, so that it is not found as
    a separate error. If a soft error replaces the interval of this error, the child's share is no
    longer known, and the search is repeated without removing that part.
    """
    jumps = [
        (c.row, i, any(i is s.interval for s in c.fixed))
        for c in chains
        for i in c.intervals(c.automatic_tau())
        if not i.open
    ]
    known = [Known(row, i.start, i.offset, firm) for row, i, firm in jumps]
    short = {
        k: (row, i.start, (i.followed - 1.0) * i.offset)
        for k, (row, i, _) in zip(known, jumps, strict=True)
        if i.followed < 1.0
    }
    while True:
        turned = limbs.turned(list(short.values())) if short else limbs
        searched = search_soft_errors(turned, fps, cut, known, budget)
        soft, replaced = searched.found, searched.replaced
        if short.keys().isdisjoint(replaced):
            break
        short = {k: turn for k, turn in short.items() if k not in replaced}
    chains = [
        replace(c, left=tuple(runs_of_true(at)))
        if (at := searched.left[c.row % limbs.count]).any()
        else c
        for c in chains
    ]
    names = {c.row: c.name for c in chains}
    errors = [(e, _fixed_soft(names[e.row], e)) for e in soft]
    return _Softened(chains, limbs.count, errors, replaced if soft else ())


def _fixed_straight(chain: str, error: StraightError) -> FixedInterval:
    # The peak, the middle of the transition, may be outside the interval.
    peak = min(max(error.peak, error.start), error.stop - 1)
    return FixedInterval(straight_limb_interval(chain, error), error.strength, peak)


def _fixed_soft(chain: str, error: SoftError) -> FixedInterval:
    steepest = int(np.abs(np.diff(error.offset, prepend=0.0)).argmax())
    size = float(np.abs(error.offset).max())
    return FixedInterval(soft_interval(chain, error), size, error.start + steepest)


def find_jumps(
    limbs: Limbs, fps: float, cut: Mask, segments: Sequence[tuple[int, int]], tell: Tell
) -> list[Jumps]:
    """Return the jumps of limbs, one item for each chain.

    `cut` is the mask of the cuts and of frame 0, shape (frames,), and `segments` is the result of
    :func:`segments_between`. `tell` is called with the progress.
    """
    counter = _counter_rotation(limbs, fps, cut, tell)
    out = []
    for row in range(len(counter.x)):
        tell(1.0)
        edges, step = find_interval_edges_and_steps(counter, row)
        sums = running_counter_rotation_sums(counter, row, step)
        tables = tuple(edge_pair_table(edges, sums, low, high) for low, high in segments)
        out.append(Jumps(counter, row, edges, step, tables, automatic_tau(counter, row), fps))
    return out


def _counter_rotation(limbs: Limbs, fps: float, cut: Mask, tell: Tell) -> CounterRotation:
    """Return the counter-rotation of all limbs.

    In a long clip, one limb is analysed at a time to save memory.
    """
    if limbs.count == 1 or limbs.frames < LONG:
        return counter_rotation(limbs, fps, cut, tell)
    parts = [
        vars(
            counter_rotation(
                limbs.only(i),
                fps,
                cut,
                stage_progress(tell, i / limbs.count, (i + 1.0) / limbs.count),
            )
        )
        for i in range(limbs.count)
    ]
    shape = len(limbs) * limbs.count, limbs.frames
    together = {}
    for name in list(parts[0]):
        together[name] = np.stack([p.pop(name) for p in parts], axis=1).reshape(shape)
    return CounterRotation(**together)


def _lines(chains: Sequence[Chain]) -> list[list[Chain]]:
    """Arrange chains in lines, so that the child of each chain is the parent of the next."""
    left = list(chains)
    lines: list[list[Chain]] = []
    while left:
        line = [next((c for c in left if not any(o.child == c.parent for o in left)), left[0])]
        left.remove(line[0])
        while follower := next((c for c in left if c.parent == line[-1].child), None):
            line.append(follower)
            left.remove(follower)
        lines.append(line)
    return lines


def _alike(lines: list[list[Chain]]) -> list[list[list[Chain]]]:
    """Group lines of chains by their length and by whether a bone axis varies over time."""
    kinds: dict[tuple[int, bool], list[list[Chain]]] = {}
    for line in lines:
        kinds.setdefault((len(line), any(c.axis.ndim > 1 for c in line)), []).append(line)
    return list(kinds.values())


def _limbs(lines: list[list[Chain]], motion: Motion, keys: Keys | None = None) -> Limbs:
    """Return limbs with the rotations of their joints, their bone axes and the clip's linear keys.

    `lines` contains the chains of each limb. All limbs have the same number of chains.
    """
    parents = [[line[0].parent for line in lines]]
    children = [[c.child for c in same] for same in zip(*lines, strict=True)]
    joints = motion.rotations.transpose(1, 0, 2)[np.array(parents + children)]
    varying = any(c.axis.ndim > 1 for line in lines for c in line)
    shape = (motion.frames, 3) if varying else (3,)
    axes = [[np.broadcast_to(c.axis, shape) for c in same] for same in zip(*lines, strict=True)]
    return Limbs(joints, np.array(axes), motion.angle_step, keys)
