"""`twistcore quamo refine | noise | evaluate | ablation | train`."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis import detect
from twistcore.bvh import Clip, read_bvh, write_bvh
from twistcore.chain import find_chains
from twistcore.cli.output import print_json, refuse_overwrite, tell_jumps, tell_problems
from twistcore.detection.cuts import leading_frames
from twistcore.errors import TwistError
from twistcore.quality.figure_quality import quality_before_and_after
from twistcore.quamo.network import Network, read_network, write_network
from twistcore.quamo.pose_files import holds_poses
from twistcore.quamo.poses_clip import read_poses
from twistcore.quamo.resample import resampled, sample_times
from twistcore.quamo.response import lags, overshoots
from twistcore.quamo.state_space import Gains
from twistcore.quamo.topology import find_topology, metres_per_unit, places_24
from twistcore.quamo.track_clip import (
    chosen_joints,
    joints_of_24,
    placed_joint,
    track_by_hand,
    track_learned,
)
from twistcore.quamo.tracker import snap_sentences
from twistcore.quamo.weights import FINAL, WEIGHTS, weights_file, weights_name
from twistcore.study.quamo.noise import LEVELS, Noise, noisy
from twistcore.study.quamo.pose_errors import errors
from twistcore.study.quamo.sequences import HELD_OUT, Sequence24, read_folder
from twistcore.synthesis import generator


def refine(arguments: argparse.Namespace) -> int:
    """Track a clip and write it; warn where twist errors stand in it."""
    clip = _read(arguments)
    read = (arguments.clip, arguments.weights, arguments.template)
    refuse_overwrite([arguments.output], [path for path in read if path])
    motion = clip.motion
    unit = 1.0 if holds_poses(arguments.clip) else arguments.unit  # poses are in metres
    gains = _hand_gains(arguments, motion.frame_time)
    try:
        joints = chosen_joints(motion.skeleton, arguments.joints)
        first, placed = leading_frames(motion), placed_joint(motion)
        place = placed is not None and _wants_place(arguments, joints, placed)
        if gains is None:
            network = read_network(arguments.weights or weights_file())
            joints = joints_of_24(motion.skeleton, joints, strict=bool(arguments.joints))
            track = partial(track_learned, network=network, unit=unit)
        else:
            track = partial(track_by_hand, gains=gains)
        found = track(motion, joints, causal=arguments.causal, place=place, first=first)
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    _warn_of_twist(clip, joints.tolist())
    tell_jumps(arguments.output, write_bvh(clip, found.motion, arguments.output))
    for sentence in snap_sentences(found.snapped, motion.skeleton.names):
        print(f"{arguments.clip}: {sentence}", file=sys.stderr)
    name = motion.skeleton.names[placed] if placed is not None else ""
    print(
        f"{arguments.output}: {len(joints)} joint{'' if len(joints) == 1 else 's'}"
        f"{f' and the place of {name}' if place else ''} "
        f"tracked {'causally' if arguments.causal else 'both ways'} with {_told(gains)}"
    )
    if name and not place:
        print(f"  the place of {name} was left as it is")
    print(f"  {_way(arguments.causal, gains, motion.frame_time, place=place)}")
    if first:
        print(f"  frames before {first} are no capture and were left as they are")
    given, made = (m.sliced(first, m.frames) for m in (motion, found.motion))
    if measured := quality_before_and_after(given, made, unit):
        before, after = measured
        print(
            f"  jitter {before.jitter:.2f} → {after.jitter:.2f} mm/frame³ at 25 Hz, foot slide "
            f"{before.foot_slide:.1f} → {after.foot_slide:.1f} %, deviation from the input "
            f"{after.deviation:.1f} mm (no error: there is no truth to compare with)"
        )
    return 0


def _read(arguments: argparse.Namespace) -> Clip:
    if holds_poses(arguments.clip):
        clip = read_poses(
            arguments.clip,
            template=arguments.template,
            unit=arguments.unit,
            fps=arguments.fps,
            up=arguments.up,
            person=arguments.person,
        )
        for warning in clip.warnings:
            print(f"{arguments.clip}: {warning}", file=sys.stderr)
        return clip
    return read_bvh(arguments.clip, fps=arguments.fps)


def _hand_gains(arguments: argparse.Namespace, dt: float) -> Gains | None:
    """Gains of hands as the command line has them; None for learned ones."""
    given = {k: v for k in ("kp", "kd", "ka") if (v := getattr(arguments, k)) is not None}
    if arguments.gains == "learned":
        if given:
            raise TwistError(
                f"--{next(iter(given))} is a gain of hands: expected none with --gains learned"
            )
        return None
    return replace(Gains.by_hand(dt, causal=arguments.causal), **given)


def _wants_place(arguments: argparse.Namespace, joints: NDArray[np.int64], placed: int) -> bool:
    """As asked for; else with all joints, or where the joint that has the place is named."""
    if arguments.root_position is not None:
        return bool(arguments.root_position)
    return not arguments.joints or placed in joints


def _told(gains: Gains | None) -> str:
    if gains is None:
        return "learned gains"
    return f"hand gains, κP {gains.kp:.4g}, κD {gains.kd:.3g}, κA {gains.ka:g}"


def _way(causal: bool, gains: Gains | None, dt: float, *, place: bool) -> str:
    """What the direction of tracking asks for, and what it does not do."""
    if not causal:
        return "both ways needs the whole clip: every frame depends on later ones; no lag"
    if gains is None:
        return "causal: a frame waits 40 ms for the next sample of 25 Hz, and lags a little more"
    words = "causal: no frame depends on a later one"
    what = ("a joint", "the place")[: 1 + place]
    for name, late, over in zip(what, lags(gains, dt), overshoots(gains, dt), strict=False):
        words += (
            f"; {name} lags {1000.0 * late:.0f} ms and overshoots a step by {100.0 * over:.0f} %"
        )
    return words


def _warn_of_twist(clip: Clip, joints: Sequence[int]) -> None:
    """Say how many twist errors the raw clip shows in these joints: tracking would hide them."""
    chains = [c for c in find_chains(clip.motion) if {c.parent, c.child} & set(joints)]
    if not chains:
        return
    if count := len(detect(clip, chains)):
        print(
            f"{clip.path}: {'an interval' if count == 1 else f'{count} intervals'} of twist errors "
            "found in these joints; tracking smears their edges and does not remove them: detect "
            "and refine first",
            file=sys.stderr,
        )


def noise(arguments: argparse.Namespace) -> int:
    """Write a clip with synthetic noise and say how large it came out."""
    clip = read_bvh(arguments.clip)
    refuse_overwrite([arguments.output], [arguments.clip])
    motion = clip.motion
    try:
        topology = find_topology(motion.skeleton)
        unit = metres_per_unit(motion.skeleton, arguments.unit)
        if motion.positioned != (int(topology.joints[0]),):
            raise TwistError("expected positions of the root alone")
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    first = leading_frames(motion)
    part = motion.sliced(first, motion.frames)
    q, r = topology.reduced(part.rotations), part.positions[:, 0]
    wanted = Noise(LEVELS[arguments.level], arguments.systematic, arguments.bursts)
    rng = generator(arguments.seed, arguments.clip.name)
    q_hat, r_hat = noisy(q, r, wanted, rng, unit=unit, dt=motion.frame_time)
    rotations, positions = motion.rotations.copy(), motion.positions.copy()
    rotations[first:] = topology.restored(q_hat, part.rotations)
    positions[first:, 0] = r_hat
    dirty = replace(motion, rotations=rotations, positions=positions)
    times = sample_times(len(q), motion.frame_time)
    found, truth = (
        1000.0 * unit * places_24(topology.offsets, *resampled(a, b, times))
        for a, b in ((q_hat, r_hat), (q, r))
    )
    measured = errors(found, truth)
    tell_jumps(arguments.output, write_bvh(clip, dirty, arguments.output))
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
    print(
        f"{arguments.output}: synthetic noise, level {arguments.level}, seed {arguments.seed}: "
        f"MPJPE {measured.mpjpe:.1f} mm, Accel {measured.accel:.1f} mm/frame² at 25 Hz"
    )
    return 0


def evaluate(arguments: argparse.Namespace) -> int:
    """Print the tables of held-out subjects."""
    from twistcore.study.quamo.quamo_report import evaluation_report

    return _report(arguments, evaluation_report, ("full",))


def ablation(arguments: argparse.Namespace) -> int:
    """Print steps of the method, representations and integration."""
    from twistcore.quamo.network import VARIANTS
    from twistcore.study.quamo.quamo_report import ablation_report

    return _report(arguments, ablation_report, tuple(VARIANTS))


def _report(arguments: argparse.Namespace, make: Any, variants: Sequence[str]) -> int:
    clips, problems = read_folder(arguments.folder)
    code = tell_problems(problems, len(clips))
    sequences = tuple(s for s in clips if s.subject in HELD_OUT)
    if not sequences:
        raise TwistError(
            f"{arguments.folder}: expected clips of the subjects {', '.join(HELD_OUT)}, named as "
            "by CMU (05_02.bvh)"
        )
    networks = {v: _held_out_networks(arguments.weights or WEIGHTS, v, sequences) for v in variants}
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    report = make(sequences, networks, seeds, partial(print, file=sys.stderr))
    if arguments.json:
        print_json(report.document)
    else:
        print(report.markdown, end="")
    return code


def _held_out_networks(
    folder: Path, variant: str, sequences: Sequence[Sequence24]
) -> Mapping[str, Network]:
    """A network by subject, trained without it, of those that are in the folder."""
    subjects = sorted({s.subject for s in sequences})
    paths = {s: folder / weights_name(variant, s) for s in subjects}
    return {s: read_network(p) for s, p in paths.items() if p.exists()}


def train(arguments: argparse.Namespace) -> int:
    """Train one network for each held-out subject and write weights; continues what was begun."""
    from twistcore.study.quamo import training
    from twistcore.study.quamo.torch_model import import_torch

    sequences, problems = read_folder(arguments.folder)
    code = tell_problems(problems, len(sequences))
    if not sequences:
        return code
    subjects = arguments.hold_out or [*HELD_OUT, FINAL]
    known = {s.subject for s in sequences}
    for subject in subjects:
        if subject not in known | {FINAL}:
            raise TwistError(
                f"{arguments.folder}: no clip of subject {subject!r}; expected some of "
                f"{', '.join(sorted(known))} or {FINAL!r}"
            )
    given = {k: getattr(arguments, k) for k in ("epochs", "width")}
    settings = training.Settings(
        variant=arguments.variant,
        seed=arguments.seed,
        **{k: v for k, v in given.items() if v is not None},
    )
    import_torch()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for subject in subjects:
        path = arguments.output / weights_name(arguments.variant, subject, arguments.seed)
        if path.exists():
            print(f"{path}: is there already")
            continue
        used = [s for s in sequences if s.subject != subject]
        begin = time.perf_counter()
        network = training.train(
            used,
            settings,
            checkpoint=path.with_suffix(".checkpoint"),
            compiled=arguments.compile,
            tell=partial(print, f"{path.stem}:", file=sys.stderr, flush=True),
        )
        minutes = (time.perf_counter() - begin) / 60.0
        note = json.dumps({"clips": [s.name for s in used], "settings": vars(settings)})
        write_network(replace(network, note=note), path)
        print(f"{path}: {len(used)} clips, {settings.epochs} epochs, {minutes:.1f} minutes")
    return code
