"""Run the commands that study QuaMo: `twistcore quamo noise | evaluate | ablation | train`."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from twistcore.cli.interval_words import print_channel_jumps
from twistcore.cli.output import (
    print_json,
    print_note,
    print_progress,
    print_remark,
    print_result_lines,
    refuse_overwrite,
    report_problems,
)
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.formats.smpl.skeleton import (
    find_network_joints,
    metres_per_unit,
    smpl_joint_positions,
)
from twistcore.quamo.network import VARIANTS, Network, read_network, write_gain_network_weights
from twistcore.quamo.resample import interpolate_poses_at_times, network_sample_times
from twistcore.quamo.weights import FINAL, WEIGHTS, gain_network_file_name
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.pose_errors import pose_metrics
from twistcore.study.quamo.sequences import HELD_OUT, Sequence24, read_cmu_bvh_sequence_folder
from twistcore.synthesis import clip_random_generator


def quamo_noise_command(arguments: argparse.Namespace) -> int:
    """Write a clip with synthetic noise, print the noise level, and return the exit code."""
    clip = read_bvh(arguments.clip)
    refuse_overwrite([arguments.output], [arguments.clip])
    motion = clip.motion
    try:
        topology = find_network_joints(motion.skeleton)
        unit = metres_per_unit(motion.skeleton, arguments.unit)
        if motion.positioned != (int(topology.joints[0]),):
            raise TwistError("expected only the root to have position channels")
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    first = count_leading_rest_frames(motion)
    part = motion.sliced(first, motion.frames)
    q, r = topology.reduced(part.rotations), part.positions[:, 0]
    wanted = Noise(LEVELS[arguments.level], arguments.systematic, arguments.bursts)
    rng = clip_random_generator(arguments.seed, arguments.clip.name)
    q_hat, r_hat = add_pose_noise(q, r, wanted, rng, unit=unit, dt=motion.frame_time)
    rotations, positions = motion.rotations.copy(), motion.positions.copy()
    rotations[first:] = topology.restored(q_hat, part.rotations)
    positions[first:, 0] = r_hat
    dirty = replace(motion, rotations=rotations, positions=positions)
    times = network_sample_times(len(q), motion.frame_time)
    found, truth = (
        1000.0
        * unit
        * smpl_joint_positions(topology.offsets, *interpolate_poses_at_times(a, b, times))
        for a, b in ((q_hat, r_hat), (q, r))
    )
    measured = pose_metrics(found, truth)
    print_channel_jumps(arguments.output, write_clip(clip, dirty, arguments.output))
    if arguments.json:
        print_json(
            {
                "schema": "twistcore.quamo-noise/1",
                "clip": str(arguments.clip),
                "level": arguments.level,
                "systematic": arguments.systematic,
                "seed": arguments.seed,
                "errors_mm": vars(measured),
            }
        )
        return 0
    print_remark(
        f"{arguments.output}: synthetic noise, level {arguments.level}, seed {arguments.seed}: "
        f"MPJPE {measured.mpjpe:.1f} mm, Accel {measured.accel:.1f} mm/frame² at 25 Hz"
    )
    return 0


def quamo_evaluate_command(arguments: argparse.Namespace) -> int:
    """Print the results for held-out subjects and return the exit code."""
    from twistcore.study.quamo.report import evaluation_report

    return _report(arguments, evaluation_report, ("full",))


def quamo_ablation_command(arguments: argparse.Namespace) -> int:
    """Compare training steps, representations and integrators, and return the exit code."""
    from twistcore.study.quamo.report import ablation_report

    return _report(arguments, ablation_report, tuple(VARIANTS))


def _report(arguments: argparse.Namespace, make: Any, variants: Sequence[str]) -> int:
    clips, problems = read_cmu_bvh_sequence_folder(arguments.folder)
    code = report_problems(problems, len(clips))
    sequences = tuple(s for s in clips if s.subject in HELD_OUT)
    if not sequences:
        raise TwistError(
            f"{arguments.folder}: expected clips of the subjects {', '.join(HELD_OUT)}, with "
            "CMU's names (such as 05_02.bvh)"
        )
    weights = arguments.weights or WEIGHTS
    networks = {v: _held_out_networks(weights, v, sequences) for v in variants}
    if not any(networks.values()):
        print_note(
            f"{weights} contains no network for a held-out subject, so the table has no row for "
            "learned gains; set --weights to a folder with files such as "
            f"{gain_network_file_name('full', HELD_OUT[0])} (included only in the source, in "
            "assets/quamo)"
        )
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    report = make(sequences, networks, seeds, print_progress)
    if arguments.json:
        print_json(report.document)
    else:
        print_result_lines(report.markdown)
    return code


def _held_out_networks(
    folder: Path, variant: str, sequences: Sequence[Sequence24]
) -> Mapping[str, Network]:
    """Return the networks in a folder, keyed by the subject that was held out in training."""
    subjects = sorted({s.subject for s in sequences})
    paths = {s: folder / gain_network_file_name(variant, s) for s in subjects}
    return {s: read_network(p) for s, p in paths.items() if p.exists()}


def quamo_train_command(arguments: argparse.Namespace) -> int:
    """Train and write a network for each held-out subject, or continue an interrupted run."""
    from twistcore.study.quamo import training
    from twistcore.study.quamo.torch_model import import_torch

    sequences, problems = read_cmu_bvh_sequence_folder(arguments.folder)
    code = report_problems(problems, len(sequences))
    if not sequences:
        return code
    subjects = arguments.hold_out or [*HELD_OUT, FINAL]
    known = {s.subject for s in sequences}
    for subject in subjects:
        if subject not in known | {FINAL}:
            raise TwistError(
                f"{arguments.folder}: there is no clip of the subject {subject!r}; choose "
                f"from {', '.join(sorted(known))} or {FINAL!r}"
            )
    given = {k: getattr(arguments, k) for k in ("epochs", "width")}
    settings = training.TrainingSettings(
        variant=arguments.variant,
        seed=arguments.seed,
        **{k: v for k, v in given.items() if v is not None},
    )
    import_torch()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for subject in subjects:
        path = arguments.output / gain_network_file_name(arguments.variant, subject, arguments.seed)
        if path.exists():
            print_note(f"{path}: already exists; skipped")
            continue
        used = [s for s in sequences if s.subject != subject]
        begin = time.perf_counter()
        network = training.train(
            used,
            settings,
            checkpoint=path.with_suffix(".checkpoint"),
            compiled=arguments.compile,
            tell=partial(_progress_of_clip, path.stem),
        )
        minutes = (time.perf_counter() - begin) / 60.0
        made_of = json.dumps({"clips": [s.name for s in used], "settings": vars(settings)})
        write_gain_network_weights(replace(network, note=made_of), path)
        print_remark(f"{path}: {len(used)} clips, {settings.epochs} epochs, {minutes:.1f} minutes")
    return code


def _progress_of_clip(name: str, sentence: str) -> None:
    print_progress(f"{name}: {sentence}")
