"""Run the benchmark for one clip, protocol, method and seed.

In a *pass*, errors are injected into one target, which is a chain, a limb, or a few chains.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import REPAIRED, ClipAnalysis
from twistcore.analysis.correction.joint_repairs import JointRepairs
from twistcore.analysis.correction.twist_removal import (
    automatic_corrections,
    offsets_by_chain,
    offsets_carried_to_child,
    remove_twist,
)
from twistcore.detection import DETECTORS, Kind
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, continuous_quaternion_signs, geodesic_angle
from twistcore.study.benchmark.baselines import BASELINES, Baseline, Gap
from twistcore.study.benchmark.clip_scene import CleanScene
from twistcore.study.benchmark.hinge import HINGE, benchmark_hinge_correction_offsets
from twistcore.study.benchmark.tally import (
    Key,
    Tallies,
    Tally,
    add_tallies,
    in_millionths,
    tally_error_angles,
)
from twistcore.study.evaluation import (
    COUNTED,
    DAMAGE,
    body_segment_of_chain,
    error_angle,
    joints_with_possible_errors,
    match_intervals,
)
from twistcore.synthesis import InjectedError, clip_random_generator, draw_errors, inject

Taus: TypeAlias = Mapping[str, float]
AUTOMATIC: Taus = MappingProxyType({})  # each chain has its automatic τ


def benchmark_method_names() -> tuple[str, ...]:
    """Return the names of all methods, in the order of the tables."""
    return (*DETECTORS.ready(), HINGE, *BASELINES)


@dataclass(frozen=True, eq=False)
class MethodResult:
    """The result of a method on a motion.

    Attributes
    ----------
    rotations
        The corrected rotations, shape (frames, joints, 4).
    found
        The detected intervals, keyed by chain name.
    """

    rotations: Array
    found: dict[str, list[Gap]]


@dataclass(frozen=True, eq=False)
class CleanRun:
    """The result of a method on a clean clip.

    Attributes
    ----------
    outcome
        The result.
    change
        Angle in radians by which the method rotated each joint, shape (frames, len(scene.joints)).
    """

    outcome: MethodResult
    change: Array


def apply_benchmark_method(
    method: str,
    motion: Motion,
    chains: Sequence[Chain],
    wrong: Sequence[InjectedError] = (),
    tau: Taus = AUTOMATIC,
    accepted: str = "",
) -> MethodResult:
    """Apply a method to a motion. Only joints of `chains` are changed.

    If the method is a detector, its automatic corrections are applied. If its analysis returns
    offsets, such as the paper's running sum, these offsets are removed instead.

    Parameters
    ----------
    method
        Name of the method.
    motion
        The motion.
    chains
        The chains, and also the limbs if the method should find limb flips.
    wrong
        The injected errors, which are passed to methods that are given the truth.
    tau
        τ in radians, keyed by chain name. Chains without a value have an automatic τ.
    accepted
        A kind of single-joint error, such as 'stretch'. All detections of this kind are corrected,
        as if a person had accepted them.
    """
    if method in BASELINES:
        return MethodResult(_filtered(BASELINES[method], motion, chains, wrong), {})
    bones = tuple(c for c in chains if not isinstance(c, Limb))
    if method == HINGE:
        return MethodResult(
            remove_twist(
                motion, bones, benchmark_hinge_correction_offsets(motion, bones)
            ).rotations,
            {},
        )
    clip = ClipAnalysis(motion, chains if DETECTORS.info(method).limb_flips else bones)
    given = {c.name: tau[c.name] for c in clip.chains_and_limbs if c.name in tau}
    also = {Kind(accepted)} if accepted else set()
    found_at = clip.detect(method, kinds={*REPAIRED, *also}, tau_radians=given)
    intervals, analysis = automatic_corrections(found_at), clip.by(method)
    if removed := getattr(analysis, "removed", None):
        offsets = {c.name: removed(c.name, found_at.tau[c.name]) for c in bones}
    else:
        offsets = offsets_by_chain(intervals, motion.frames)
    carried = offsets_carried_to_child(intervals, motion.frames)
    own = {motion.skeleton.names[c.child] for c in bones}
    single = [i.for_review for i in found_at if i.kind in also and i.joint in own]
    found: dict[str, list[Gap]] = {chain.name: [] for chain in chains}
    for i in (*intervals, *single):
        found.setdefault(i.chain, []).append((i.start, i.stop))
    refined = remove_twist(motion, chains, offsets, carried)
    return MethodResult(JointRepairs(single).applied(refined).rotations, found)


def _filtered(
    baseline: Baseline, motion: Motion, chains: Sequence[Chain], wrong: Sequence[InjectedError]
) -> Array:
    if baseline.oracle:
        rotations = motion.rotations
        for chain in chains:
            gaps = [(e.start, e.stop) for e in wrong if e.chain == chain.name]
            if gaps:
                joints = chain.changed_joints(motion.skeleton)
                rotations = _replaced(rotations, joints, baseline, motion.fps, gaps)
        return rotations
    bones = [c for c in chains if not isinstance(c, Limb)]
    return _replaced(motion.rotations, joints_with_possible_errors(bones), baseline, motion.fps, ())


def _replaced(
    rotations: Array,
    joints: Sequence[int] | NDArray[np.int64],
    baseline: Baseline,
    fps: float,
    gaps: Sequence[Gap],
) -> Array:
    joints = list(joints)
    q = continuous_quaternion_signs(rotations[:, joints])
    smooth = baseline.correct(q, fps, gaps)
    length = np.linalg.norm(smooth, axis=-1, keepdims=True)
    out = rotations.copy()
    out[:, joints] = np.where(length > 1e-9, smooth / np.maximum(length, 1e-9), q)
    return out


def run_on_clean_motion(scene: CleanScene, method: str, tau: Taus = AUTOMATIC) -> CleanRun:
    """Return the result of a method on the clean motion."""
    every, accepted = (*scene.chains, *scene.limbs), scene.protocol.single
    outcome = apply_benchmark_method(method, scene.motion, every, tau=tau, accepted=accepted)
    return CleanRun(outcome, _change(scene.motion.rotations, outcome.rotations, scene.joints))


def tally_clean_run(scene: CleanScene, method: str, clean: CleanRun) -> Tallies:
    """Count false alarms and unwanted changes in the clean clip, for each chain and limb.

    Unwanted changes are counted only if the protocol injects no errors. A chain that is not a
    target has an entry only if something was detected in it.
    """
    total: Tallies = {}
    counted: set[int] = set()
    for chain in (*scene.chains, *scene.limbs):
        tally = Tally(alarms=len(clean.outcome.found.get(chain.name, [])))
        if scene.protocol.clean:
            # A joint that two chains share is counted once, for the first chain.
            own = [j for j in joints_with_possible_errors([chain]).tolist() if j not in counted]
            counted.update(own)
            change = clean.change[:, np.isin(scene.joints, own)]
            large = change > DAMAGE
            tally += Tally(
                passes=int(chain in scene.targets),
                pairs=change.size,
                target_pairs=change.size,
                natural=int(large.sum()),
                natural_change=in_millionths(np.degrees(change[large]).sum()),
            )
        if chain in scene.targets or tally != Tally():
            add_tallies(total, {_key(scene, method, chain): tally})
    return total


def run_benchmark_passes(
    scene: CleanScene,
    method: str,
    seed: int,
    clean: CleanRun | None = None,
    tau: Taus = AUTOMATIC,
) -> Tallies:
    """Run all benchmark passes of a clip with one method and one seed.

    In each pass, only the group of chains that contains the targets is evaluated. Detectors and
    filters of single joints treat groups independently, so the results for other groups are the
    same as in the clean run.
    """
    clean = clean or run_on_clean_motion(scene, method, tau)
    total: Tallies = {}
    for index, targets in scene.passes():
        errors = draw_pass_errors(scene, index, targets, seed)
        if errors:
            add_tallies(total, _run_pass(scene, method, clean, targets, errors, tau))
    return total


def draw_pass_errors(
    scene: CleanScene, index: int, targets: Sequence[Chain], seed: int
) -> tuple[InjectedError, ...]:
    """Draw the random errors of a pass. They depend only on seed, clip name, pass and protocol."""
    rng = clip_random_generator(seed, scene.clip, index, zlib.crc32(scene.protocol.name.encode()))
    return draw_errors(scene.motion, targets, rng, scene.protocol, first=0)


def _run_pass(
    scene: CleanScene,
    method: str,
    clean: CleanRun,
    targets: Sequence[Chain],
    errors: Sequence[InjectedError],
    tau: Taus,
) -> Tallies:
    reach = _reach(scene, method, targets)
    dirty = inject(scene.motion, reach, errors)
    outcome = apply_benchmark_method(method, dirty, reach, errors, tau, scene.protocol.single)
    total: Tallies = {}
    first = _key(scene, method, targets[0])
    truth = _without_own_flips(scene, clean)
    wrong = np.zeros((dirty.frames, len(dirty.skeleton)), dtype=bool)
    for chain in targets:
        key = replace(first, side=chain.side, segment=body_segment_of_chain(chain))
        true = [e for e in errors if e.chain == chain.name]
        for e in true:
            wrong[e.start : e.stop, e.changed_joints(chain, dirty.skeleton)] = True
        counted = [e.start + np.flatnonzero(np.abs(e.offset) >= COUNTED) for e in true]
        rows = np.concatenate(counted) if counted else np.zeros(0, dtype=np.int64)
        source = scene.motion.rotations[rows]
        joints = true[0].measured_joints(chain) if true else (chain.parent,)
        before = error_angle(source, dirty.rotations[rows], joints)
        after = error_angle(truth[rows], outcome.rotations[rows], joints)
        add_tallies(total, {key: tally_error_angles(before, after)})
    for chain in reach:
        true = [e for e in errors if e.chain == chain.name]
        key = first
        if chain in targets:
            key = replace(first, side=chain.side, segment=body_segment_of_chain(chain))
        add_tallies(total, {key: _interval_tally(outcome, clean, chain, true)})
    damage = _damage_tally(scene, clean, reach, targets, dirty.rotations, outcome.rotations, wrong)
    add_tallies(total, {first: damage})
    audited = not any(chain.name in scene.eventful for chain in targets)
    return {replace(key, audited=audited): tally for key, tally in total.items()}


def _without_own_flips(scene: CleanScene, clean: CleanRun) -> Array:
    """Return the rotations that a perfect correction would produce.

    These are the rotations of the clean clip without its existing limb flips. If a method also
    corrects an existing flip, this therefore does not count as an error.
    """
    truth = scene.motion.rotations
    for limb in scene.limbs:
        for start, stop in clean.outcome.found.get(limb.name, ()):
            if truth is scene.motion.rotations:
                truth = truth.copy()
            joints = limb.changed_joints(scene.motion.skeleton)
            truth[start:stop, joints] = clean.outcome.rotations[start:stop, joints]
    return truth


def _reach(scene: CleanScene, method: str, targets: Sequence[Chain]) -> tuple[Chain, ...]:
    """Return the chains and limbs whose joints may be changed differently than in the clean run."""
    if method in BASELINES and BASELINES[method].whole_body:
        return (*scene.chains, *scene.limbs)
    # Errors in many chains at once may look like a cut, and the other foot or hand shows which roll
    # of a joint is right.
    if len(targets) > 2 or scene.protocol.single:
        return (*scene.chains, *scene.limbs)
    return next(group for group in scene.groups if targets[0] in group)


def _interval_tally(
    outcome: MethodResult, clean: CleanRun, chain: Chain, true: Sequence[InjectedError]
) -> Tally:
    """Count true and detected intervals.

    Detections that also occur in the clean clip are ignored.
    """
    if chain.name not in outcome.found:
        return Tally()
    found = outcome.found[chain.name]
    matched = match_intervals(found, [(e.start, e.stop) for e in true])
    others = [g for k, g in enumerate(found) if k not in matched]
    natural = match_intervals(others, clean.outcome.found[chain.name])
    return Tally(truths=len(true), found=len(found) - len(natural), matched=len(matched))


def _damage_tally(
    scene: CleanScene,
    clean: CleanRun,
    reach: Sequence[Chain],
    targets: Sequence[Chain],
    dirty: Array,
    refined: Array,
    wrong: NDArray[np.bool_],
) -> Tally:
    """Count the error-free pairs of joint and frame that the method changes by more than 1°.

    A pair counts as natural if the method changes it in the same way in the clean clip, and as
    damaged if not. `wrong` is a mask of the pairs with an error, (frames, joints).
    """
    near = np.isin(scene.joints, joints_with_possible_errors(reach))
    joints = scene.joints[near]
    change = _change(dirty, refined, joints)
    alike = _change(clean.outcome.rotations, refined, joints) <= DAMAGE
    large = (change > DAMAGE) & ~wrong[:, joints]
    damaged, natural = large & ~alike, large & alike
    away = clean.change[:, ~near]
    away = away[away > DAMAGE]
    pairs = len(dirty) * len(scene.joints) - int(wrong[:, scene.joints].sum())
    own = joints_with_possible_errors(targets)
    return Tally(
        passes=1,
        pairs=pairs,
        target_pairs=len(dirty) * len(own) - int(wrong[:, own].sum()),
        damaged=int(damaged.sum()),
        target_damaged=int(damaged[:, np.isin(joints, own)].sum()),
        damage=in_millionths(np.degrees(change[damaged]).sum()),
        natural=int(natural.sum()) + away.size,
        natural_change=in_millionths(np.degrees(change[natural]).sum() + np.degrees(away).sum()),
    )


def _change(before: Array, after: Array, joints: NDArray[np.int64]) -> Array:
    """Return the angle in radians between the rotations of some joints before and after a change.

    The shape is (frames, len(joints)).
    """
    p, q = before[:, joints], after[:, joints]
    out = np.zeros(p.shape[:-1])
    changed = (p != q).any(axis=-1)
    out[changed] = geodesic_angle(p[changed], q[changed])
    return out


def _key(scene: CleanScene, method: str, chain: Chain) -> Key:
    audited = chain.name not in scene.eventful
    return Key(scene.protocol.name, method, chain.side, body_segment_of_chain(chain), audited)
