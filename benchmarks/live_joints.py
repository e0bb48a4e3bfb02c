"""Measure how much worse detection gets if both joints of a chain twist.

    python -m benchmarks.live_joints FOLDER [--protocol …]…

Before errors are injected, one joint of every chain keeps only a share of its captured twist. At a
share of 0, it does not twist at all, like one joint in every chain of the CMU rig. The other
joint's twist, the speed, the frame rate and the errors stay the same. For each clip, protocol and
share, the table shows the share of repaired error frames (FSR) in per cent, and the median of σ,
the noise with which a jump of the counter-rotation d is compared.

--edges-known passes the frames of all edges to the detector's first pass, so that it does not treat
them as motion. If this finds more errors, the detector had mistaken the missed ones for motion.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from unittest.mock import patch

import numpy as np

from twistcore.detection.counter_twist import counter_rotation
from twistcore.detection.detectors.consistency import ConsistencyDetector
from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import Mask
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.study.benchmark.clip_scene import CleanScene, make_clean_scene
from twistcore.study.benchmark.passes import apply_benchmark_method, draw_pass_errors
from twistcore.synthesis import SUCCESS, InjectedError, inject, parse_protocol

METHOD = "consistency"
SETTINGS = (("parent", 1.0), ("parent", 0.5), ("parent", 0.25), ("parent", 0.0), ("child", 0.0))


def quietened(motion: Motion, chains: Sequence[Chain], joint: str, share: float) -> Motion:
    """Return the motion with the twist of all parents, or of all children, reduced to a share.

    Δθp depends only on a chain's parent and Δθc only on its child, and both are sums of twists
    about the bone. Reducing one of them therefore does not change Δθp and Δθc of other chains.
    """
    rotations = motion.rotations.copy()
    for chain in chains:
        q_p, q_c = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
        x, y = twist_increments(q_p, q_c, chain.axis)
        of_joint = x if joint == "parent" else y
        turn = quaternion_from_axis_angle(chain.axis, (share - 1.0) * np.cumsum(of_joint))
        if joint == "parent":
            rotations[:, chain.parent] = multiply(rotations[:, chain.parent], turn)
        else:
            rotations[:, chain.child] = multiply(turn, rotations[:, chain.child])
    return motion.with_rotations(normalise(rotations))


@contextmanager
def known_edges(chains: Sequence[Chain], errors: Sequence[InjectedError]) -> Iterator[None]:
    """Pass the frames at the edges of one limb's errors to the first pass of the detector.

    While the block runs, the detector does not treat these frames as natural motion.
    """
    usual = counter_rotation._coarsely_good
    rows = {chain.name: row for row, chain in enumerate(chains)}

    def told(signals: Array, live: Mask, half: int, limbs: Limbs) -> Mask:
        good = usual(signals, live, half, limbs)
        for e in errors:
            steps = np.diff(np.concatenate([[0.0], e.offset, [0.0]])) != 0.0
            at = e.start + np.flatnonzero(steps)
            good[rows[e.chain], at[at < good.shape[1]]] = False
        return good

    with patch.object(counter_rotation, "_coarsely_good", told):
        yield


def success(scene: CleanScene, seeds: Sequence[int], edges_known: bool) -> float:
    """Return the percentage of repaired error frames (FSR) over all chains of a scene.

    Errors are injected into one chain at a time.
    """
    frames = repaired = 0
    for seed in seeds:
        for index, targets in scene.passes():
            errors = draw_pass_errors(scene, index, targets, seed)
            group = next(group for group in scene.groups if targets[0] in group)
            limb = [c for c in group if c in scene.chains]
            dirty = inject(scene.motion, limb, errors)
            with known_edges(limb, errors) if edges_known else nullcontext():
                refined = apply_benchmark_method(METHOD, dirty, limb).rotations
            parents = {chain.name: chain.parent for chain in limb}
            for e in errors:
                rows, p = e.start + np.flatnonzero(e.offset), parents[e.chain]
                truth = scene.motion.rotations[rows, p]
                before = geodesic_angle(truth, dirty.rotations[rows, p])
                after = geodesic_angle(truth, refined[rows, p])
                frames += len(rows)
                repaired += int((after <= SUCCESS * before).sum())
    return 100.0 * repaired / max(frames, 1)


def sigma(scene: CleanScene) -> float:
    """Return the median of σ of the counter-rotation over frames and chains, in degrees."""
    analysis = ConsistencyDetector().analyse(scene.motion, scene.chains)
    of_chains = [c.limb.sigma[c.row] for c in analysis.chains.values()]
    return float(np.degrees(np.median(of_chains)))


def main() -> None:
    """Measure every clip and print its rows of the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--protocol", nargs="+", default=["H3-4", "H6"])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--edges-known", action="store_true", help="the first pass knows the edges")
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    print(f"| clip | Hz | row | {' | '.join(f'{j} × {s:g}' for j, s in SETTINGS)} |")
    print("|---" * (3 + len(SETTINGS)) + "|")
    for path in clip_paths_in_folder(arguments.folder, below=True, suffixes=BVH):
        plain = make_clean_scene(path.name, read_bvh(path).motion, parse_protocol("P0"))
        for row in arguments.protocol:
            cells = []
            for joint, share in SETTINGS:
                motion = quietened(plain.motion, plain.chains, joint, share)
                scene = make_clean_scene(path.name, motion, parse_protocol(row))
                fsr = success(scene, seeds, arguments.edges_known)
                cells.append(f"{fsr:.2f} (σ {sigma(scene):.3f}°)")
            print(f"| {path.stem} | {scene.motion.fps:.0f} | {row} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
