"""`twistcore quamo refine`: a clip tracked or smoothed."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace

from twistcore.analysis import detect
from twistcore.bvh import Clip, read_bvh, write_bvh
from twistcore.chain import find_chains
from twistcore.cli.output import refuse_overwrite, tell_jumps
from twistcore.detection.cuts import leading_frames
from twistcore.errors import TwistError
from twistcore.quality.figure_quality import quality_before_and_after
from twistcore.quamo.network import read_network
from twistcore.quamo.npz_poses import read_poses
from twistcore.quamo.state_space import Gains
from twistcore.quamo.track_clip import chosen_joints, joints_of_24, track_by_hand, track_learned
from twistcore.quamo.tracker import snap_sentences
from twistcore.quamo.weights import weights_file


def refine(arguments: argparse.Namespace) -> int:
    """Track a clip and write it; warn where twist errors stand in it."""
    clip = _read(arguments)
    read = (arguments.clip, arguments.weights, arguments.template)
    refuse_overwrite([arguments.output], [path for path in read if path])
    motion = clip.motion
    unit = 1.0 if arguments.clip.suffix == ".npz" else arguments.unit  # poses are in metres
    how = f"{arguments.gains} gains"
    try:
        joints = chosen_joints(motion.skeleton, arguments.joints)
        first = leading_frames(motion)
        if arguments.gains == "learned":
            network = read_network(arguments.weights or weights_file())
            joints = joints_of_24(motion.skeleton, joints, strict=bool(arguments.joints))
            found = track_learned(
                motion, joints, network, unit=unit, place=arguments.root_position, first=first
            )
        else:
            gains = _hand_gains(arguments, motion.frame_time)
            how += f", κP {gains.kp:.4g}, κD {gains.kd:.3g}, κA {gains.ka:g}"
            found = track_by_hand(motion, joints, gains, place=arguments.root_position, first=first)
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    _warn_of_twist(clip, joints.tolist())
    tell_jumps(arguments.output, write_bvh(clip, found.motion, arguments.output))
    for sentence in snap_sentences(found.snapped, motion.skeleton.names):
        print(f"{arguments.clip}: {sentence}", file=sys.stderr)
    print(f"{arguments.output}: {len(joints)} joints tracked with {how}")
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
    if arguments.clip.suffix == ".npz":
        return read_poses(
            arguments.clip,
            template=arguments.template,
            unit=arguments.unit,
            fps=arguments.fps,
            up=arguments.up,
        )
    return read_bvh(arguments.clip, fps=arguments.fps)


def _hand_gains(arguments: argparse.Namespace, dt: float) -> Gains:
    given = {k: getattr(arguments, k) for k in ("kp", "kd", "ka")}
    return replace(Gains.by_hand(dt), **{k: v for k, v in given.items() if v is not None})


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
