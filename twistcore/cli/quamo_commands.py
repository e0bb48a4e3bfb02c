"""`twistcore quamo refine`: track or smooth a clip."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.quality.figure import quality_before_and_after
from twistcore.cli.interval_words import tell_jumps
from twistcore.cli.output import count_of, note, refuse_overwrite, remark
from twistcore.detection.cuts import leading_frames
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip, write_clip
from twistcore.quamo.network import read_network
from twistcore.quamo.pieces import cuts_behind
from twistcore.quamo.pose_files import holds_poses
from twistcore.quamo.poses_clip import read_poses
from twistcore.quamo.response import overshoots, response_words, steady_lags
from twistcore.quamo.spline import usual_cutoff
from twistcore.quamo.state_space import Gains
from twistcore.quamo.track_clip import (
    TrackedMotion,
    check_place,
    chosen_joints,
    joints_of_24,
    placed_joint,
    smooth_clip,
    track_by_hand,
    track_learned,
    untracked_names,
)
from twistcore.quamo.tracker import apart_sentence, frames_listed, snap_sentences
from twistcore.quamo.weights import weights_file
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion

_NAMED = 6  # joints that are listed by name
_SPLINE_WAY = (
    "a spline needs the whole clip: every frame depends on later ones; no lag; motion faster than "
    "the cut-off is flattened"
)


def quamo_refine_command(arguments: argparse.Namespace) -> int:
    """Track or smooth a clip, write it, and warn about twist errors in it."""
    clip = _read(arguments)
    read = (arguments.clip, arguments.weights, arguments.template)
    refuse_overwrite([arguments.output], [path for path in read if path])
    motion = clip.motion
    unit = 1.0 if holds_poses(arguments.clip) else arguments.unit  # poses are in metres
    _refuse_of_other_method(arguments)
    gains = _hand_gains(arguments, motion.frame_time)
    spline = arguments.method == "spline"
    cutoff = arguments.cutoff or usual_cutoff(motion.frame_time)
    try:
        joints = chosen_joints(motion.skeleton, arguments.joints)
        first, placed = leading_frames(motion), placed_joint(motion)
        if arguments.root_position:
            check_place(motion)
        place = placed is not None and _wants_place(arguments, joints, placed)
        if spline:
            made = smooth_clip(motion, joints, cutoff, place=place, first=first)
        else:
            if gains is None:
                network = read_network(arguments.weights or weights_file())
                joints = joints_of_24(motion.skeleton, joints, strict=bool(arguments.joints))
                track = partial(track_learned, network=network, unit=unit)
            else:
                track = partial(track_by_hand, gains=gains)
            found = track(motion, joints, causal=arguments.causal, place=place, first=first)
            made = found.motion
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    _warn_of_twist(clip, joints.tolist())
    tell_jumps(arguments.output, write_clip(clip, made, arguments.output))
    if not spline:
        _warn_of_lost(arguments, found, motion.skeleton.names)
    name = motion.skeleton.names[placed] if placed is not None else ""
    remark(
        f"{arguments.output}: {len(joints)} joint{'' if len(joints) == 1 else 's'}"
        f"{f' and the position of {name}' if place else ''} "
        f"{_how(arguments, gains, cutoff)}"
    )
    turning, moving = untracked_names(motion, joints, placed if place else None)
    for names, what in ((() if arguments.joints else turning, ""), (moving, "the position of ")):
        if names:
            left = "was left as it is" if len(names) == 1 else "were left as they are"
            remark(f"  {what}{_listed(names)} {left}")
    way = _way(arguments.causal, gains, motion.frame_time, place=place)
    remark(f"  {_SPLINE_WAY if spline else way}")
    if first:
        remark(f"  frames before {first} are not captured motion and were left as they are")
    if not arguments.causal and (cut := _cut_words(motion, first)):
        remark(f"  {cut}: not smoothed across")
    given, made = (m.sliced(first, m.frames) for m in (motion, made))
    if measured := quality_before_and_after(given, made, unit):
        before, after = measured
        remark(
            f"  jitter {before.jitter:.2f} → {after.jitter:.2f} mm/frame³ at 25 Hz, foot slide "
            f"{before.foot_slide:.1f} → {after.foot_slide:.1f} %, deviation from the input "
            f"{after.deviation:.1f} mm (not an error: there is no ground truth)"
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
            note(f"{arguments.clip}: {warning}")
        return clip
    for name in ("template", "up", "person"):
        if getattr(arguments, name) is not None:
            raise TwistError(f"--{name} is only for files of poses; leave it out for a BVH")
    return read_bvh(arguments.clip, fps=arguments.fps)


def _refuse_of_other_method(arguments: argparse.Namespace) -> None:
    """Raise TwistError if an option is given that belongs to another --method."""
    if arguments.method != "spline":
        if arguments.cutoff is not None:
            raise TwistError("--cutoff requires --method spline")
        if arguments.weights is not None and arguments.gains != "learned":
            raise TwistError("--weights requires --gains learned")
        return
    given = {"gains": arguments.gains == "learned", "causal": arguments.causal}
    given |= {k: getattr(arguments, k) is not None for k in ("weights", "kp", "kd", "ka")}
    for name in (name for name, is_given in given.items() if is_given):
        raise TwistError(f"--{name} is only for the tracker; leave it out with --method spline")


def _hand_gains(arguments: argparse.Namespace, dt: float) -> Gains | None:
    """Return the gains given on the command line, or None for learned gains."""
    given = {k: v for k in ("kp", "kd", "ka") if (v := getattr(arguments, k)) is not None}
    if arguments.gains == "learned":
        if given:
            raise TwistError(
                f"--{next(iter(given))} sets a gain by hand; leave it out with --gains learned"
            )
        return None
    return replace(Gains.by_hand(dt, causal=arguments.causal), **given)


def _wants_place(arguments: argparse.Namespace, joints: NDArray[np.int64], placed: int) -> bool:
    """Return True if the position is tracked: on request, for all joints, or for the root."""
    if arguments.root_position is not None:
        return bool(arguments.root_position)
    return not arguments.joints or placed in joints


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _cut_words(motion: Motion, first: int) -> str:
    """Return text such as 'cut at frame 120' or 'cuts at frames 120, 300–305', or ''.

    The last frame of a range is exclusive.
    """
    cut = np.zeros(motion.frames, dtype=np.bool_)
    cut[cuts_behind(motion, first)] = True
    return f"cut{'' if cut.sum() == 1 else 's'} at {frames_listed(cut)}" if cut.any() else ""


def _how(arguments: argparse.Namespace, gains: Gains | None, cutoff: float) -> str:
    if arguments.method == "spline":
        return f"smoothed by a spline, cut-off {cutoff:.2g} Hz"
    how = f"tracked {'causally' if arguments.causal else 'both ways'} with "
    if gains is None:
        return how + "learned gains"
    return how + f"hand gains, κP {gains.kp:.4g}, κD {gains.kd:.3g}, κA {gains.ka:g}"


def _way(causal: bool, gains: Gains | None, dt: float, *, place: bool) -> str:
    """Describe which frames the tracking needs, and by how much its result lags."""
    if not causal:
        return "tracking both ways needs the whole clip: every frame depends on later ones; no lag"
    if gains is None:
        return "causal: a frame waits 40 ms for the next sample of 25 Hz, and lags a little more"
    words = "causal: no frame depends on a later one"
    what = ("a joint", "the position")[: 1 + place]
    for name, late, over in zip(what, steady_lags(gains, dt), overshoots(gains, dt), strict=False):
        words += f"; {response_words(name, late, over)}"
    return words


def _warn_of_lost(
    arguments: argparse.Namespace, found: TrackedMotion, names: Sequence[str]
) -> None:
    """Print the frames in which the tracker did not follow its input."""
    said = [*snap_sentences(found.snapped, names, causal=arguments.causal)]
    if apart := apart_sentence(found.apart, names):
        said.append(apart)
    for sentence in said:
        note(f"{arguments.clip}: {sentence}")


def _warn_of_twist(clip: Clip, joints: Sequence[int]) -> None:
    """Print how many twist errors the tracked joints have, since tracking would hide them."""
    chains = [c for c in find_chains(clip.motion) if {c.parent, c.child} & set(joints)]
    if not chains:
        return
    if count := len(detect(clip, chains)):
        note(
            f"{clip.path}: these joints have {count_of(count, 'interval')} with twist errors; "
            "tracking smears the edges of errors and does not remove them, so detect and refine "
            "first"
        )
