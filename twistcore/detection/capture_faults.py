"""Convert capture faults (noise bursts and frozen limbs) to intervals of chains."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from twistcore.detection.all_joints.body_steps import BodyStep
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.frozen_frames import frozen_spans
from twistcore.detection.interval import Interval, Kind, create_interval_without_offset
from twistcore.detection.noise_bursts import NoiseBurst, noise_bursts
from twistcore.skeleton.chain import Chain, chain_limb_name
from twistcore.skeleton.joint_owners import chain_of_joint
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.runs import group_overlapping_spans

_APART = 0.1  # seconds; bursts of a chain that are closer than this are merged
_PART_OF_STEP = 8.0  # an error that is larger than the body step by this factor is not part of it


def find_bursts(search: KindSearch) -> Found:
    """Return the noise bursts of a clip, keyed by chain name."""
    bursts = noise_bursts(search.motion)
    return burst_intervals(search.motion, search.chains, bursts, search.chosen)


def find_frozen(search: KindSearch) -> Found:
    """Return the frozen frames of each limb, keyed by the name of the limb's first chosen chain."""
    return frozen_intervals(search.motion, search.chains, search.chosen)


def burst_intervals(
    motion: Motion,
    chains: Sequence[Chain],
    bursts: Iterable[NoiseBurst],
    chosen: Sequence[Chain] | None = None,
) -> dict[str, tuple[Interval, ...]]:
    """Return intervals for the noise bursts of joints, keyed by chain name and sorted by start.

    Overlapping and nearly overlapping bursts of a chain are merged into one interval. Its `joint`
    is the noisiest joint, and its `residual` is the σ of that joint's noise about each axis, in
    radians. The offset is 0, because a noise burst is not corrected.

    Parameters
    ----------
    motion
        The clip.
    chains
        All chains of the clip.
    bursts
        The noise bursts. Bursts of joints outside the chosen chains are ignored.
    chosen
        The chains for which to return intervals, by default all. The burst of a joint belongs to
        the joint's own chain or, if that chain is not chosen, to the first chosen chain that
        contains the joint.
    """
    chosen, apart = chains if chosen is None else chosen, 1 + int(_APART * motion.fps)
    own: dict[str, list[NoiseBurst]] = {chain.name: [] for chain in chosen}
    theirs = {j: c for j, c in chain_of_joint(chains).items() if c.name in own}
    owner = chain_of_joint(chosen) | theirs
    for burst in sorted(bursts, key=lambda b: (b.start, b.stop, b.joint)):
        if burst.joint in owner:
            own[owner[burst.joint].name].append(burst)
    return {
        name: tuple(
            _burst(name, b, motion.skeleton.names) for b in group_overlapping_spans(found, apart)
        )
        for name, found in own.items()
    }


def bursts_outside_chains(
    chains: Sequence[Chain], bursts: Iterable[NoiseBurst]
) -> tuple[NoiseBurst, ...]:
    """Return the noise bursts of joints that belong to no chain."""
    owner = chain_of_joint(chains)
    return tuple(burst for burst in bursts if burst.joint not in owner)


def frozen_intervals(
    motion: Motion, chains: Sequence[Chain], chosen: Sequence[Chain] | None = None
) -> dict[str, tuple[Interval, ...]]:
    """Return intervals for the frozen frames of limbs, keyed by chain name.

    The intervals of a limb belong to its first chosen chain. `chains` contains all chains of the
    limbs, and `chosen` the chains for which to return intervals, by default all.
    """
    chosen = chains if chosen is None else chosen
    first: dict[str, Chain] = {}
    for chain in chosen:
        if limb := chain_limb_name(chain):
            first.setdefault(limb, chain)
    found: dict[str, list[Interval]] = {chain.name: [] for chain in chosen}
    for limb, start, stop in frozen_spans(motion, chains):
        if limb not in first:
            continue
        chain = first[limb]
        joint = motion.skeleton.names[chain.parent]
        evidence = {"joint": joint, "part": limb, "seconds": (stop - start) / motion.fps}
        found[chain.name].append(
            create_interval_without_offset(Kind.FROZEN, chain.name, start, stop, 0.0, evidence)
        )
    return {name: tuple(own) for name, own in found.items()}


def is_at_body_step(steps: Iterable[BodyStep], interval: Interval, person: str) -> bool:
    """Return True if an interval begins or ends where the body of the named person jumps.

    An interval with an offset many times as large as this body step is not regarded as part of it.
    """
    edges, largest = {interval.start, interval.stop}, abs(math.degrees(interval.largest))
    return any(
        step.person == person
        and largest < _PART_OF_STEP * step.degrees
        and not edges.isdisjoint(range(step.start, step.stop))
        for step in steps
    )


def _burst(chain: str, span: Sequence[NoiseBurst], names: Sequence[str]) -> Interval:
    most = max(span, key=lambda b: b.degrees)
    evidence = {
        "joint": names[most.joint],
        "joints": sorted({names[b.joint] for b in span}),
        "sigma_deg": most.degrees,
    }
    start, stop = min(b.start for b in span), max(b.stop for b in span)
    sigma = math.radians(most.degrees)
    return create_interval_without_offset(Kind.NOISE_BURST, chain, start, stop, sigma, evidence)


def frozen_spans_sentence(spans: int) -> str:
    """Return a sentence with the number of frozen spans, or '' if there are none."""
    if not spans:
        return ""
    if spans == 1:
        return (
            "In one span of frames, the values of a limb do not change at all (kind "
            "'frozen frames')."
        )
    return (
        f"In {spans} spans of frames, the values of a limb do not change at all (kind "
        "'frozen frames')."
    )
