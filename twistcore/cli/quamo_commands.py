"""Run `twistcore quamo refine`, which tracks or smooths a clip."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.quality.figure import quality_before_and_after
from twistcore.cli.interval_words import print_channel_jumps
from twistcore.cli.output import count_with_noun, print_note, print_remark, refuse_overwrite
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip, write_clip
from twistcore.formats.smpl.pose_files import is_pose_file
from twistcore.formats.smpl.poses_clip import read_smpl_poses_as_clip
from twistcore.quamo.bursts import (
    NoisySpan,
    noise_burst_cutoff,
    noise_burst_spans_to_smooth,
    smooth_noise_burst_spans,
)
from twistcore.quamo.network import read_network
from twistcore.quamo.spline import default_spline_cutoff
from twistcore.quamo.state_space import Gains
from twistcore.quamo.track_clip import (
    check_position_trackable,
    find_figure_position_joint,
    select_network_joints,
    select_writable_joints,
    smooth_captures_with_spline,
    track_with_hand_gains,
    track_with_network,
    untracked_rotating_and_moving_joints,
)
from twistcore.quamo.tracking_sentences import (
    SPLINE_WAY,
    capture_cuts_as_text,
    lost_tracking_sentences,
    tracking_lag_sentence,
    tracking_method_text,
)
from twistcore.quamo.weights import default_gain_network_path
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion

_NAMED = 6  # maximum number of joints that are listed by name


def quamo_refine_command(arguments: argparse.Namespace) -> int:
    """Track or smooth a clip, write it, and warn about twist errors in it. Return the exit code."""
    clip = _read(arguments)
    read = (arguments.clip, arguments.weights, arguments.template)
    refuse_overwrite([arguments.output], [path for path in read if path])
    motion = clip.motion
    method = _method(arguments)
    _refuse_of_other_method(arguments, method)
    if arguments.where == "noisy":
        return _smooth_bursts(arguments, clip)
    unit = 1.0 if is_pose_file(arguments.clip) else arguments.unit  # poses are in metres
    spline = method == "spline"
    gains = None if spline else _hand_gains(arguments, motion.frame_time)
    cutoff = arguments.cutoff or default_spline_cutoff(motion.frame_time)
    try:
        joints = select_writable_joints(motion.skeleton, arguments.joints)
        first, placed = count_leading_rest_frames(motion), find_figure_position_joint(motion)
        if arguments.root_position:
            check_position_trackable(motion)
        place = placed is not None and _wants_place(arguments, joints, placed)
        if spline:
            made = smooth_captures_with_spline(motion, joints, cutoff, place=place, first=first)
        else:
            if gains is None:
                network = read_network(arguments.weights or default_gain_network_path())
                joints = select_network_joints(
                    motion.skeleton, joints, strict=bool(arguments.joints)
                )
                track = partial(track_with_network, network=network, unit=unit)
            else:
                track = partial(track_with_hand_gains, gains=gains)
            found = track(motion, joints, causal=arguments.causal, place=place, first=first)
            made = found.motion
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    _warn_of_twist(clip, joints.tolist())
    print_channel_jumps(arguments.output, write_clip(clip, made, arguments.output))
    if not spline:
        for lost in lost_tracking_sentences(found, motion.skeleton.names, causal=arguments.causal):
            print_note(f"{arguments.clip}: {lost}")
    name = motion.skeleton.names[placed] if placed is not None else ""
    smoothed = f"smoothed with a spline, cut-off {cutoff:.2g} Hz"
    print_remark(
        f"{arguments.output}: {count_with_noun(len(joints), 'joint')}"
        f"{f' and the position of {name}' if place else ''} "
        f"{smoothed if spline else tracking_method_text(arguments.causal, gains)}"
    )
    turning, moving = untracked_rotating_and_moving_joints(
        motion, joints, placed if place else None
    )
    for names, what in ((() if arguments.joints else turning, ""), (moving, "the position of ")):
        if names:
            left = "was left unchanged" if len(names) == 1 else "were left unchanged"
            print_remark(f"  {what}{_listed(names)} {left}")
    way = tracking_lag_sentence(arguments.causal, gains, motion.frame_time, place=place)
    print_remark(f"  {SPLINE_WAY if spline else way}")
    if first:
        print_remark(f"  frames before {first} are not captured motion and were left unchanged")
    if not arguments.causal and (cut := capture_cuts_as_text(motion, first)):
        print_remark(f"  {cut}: motion is not smoothed across cuts")
    _tell_quality(motion, made, first, unit)
    return 0


def _smooth_bursts(arguments: argparse.Namespace, clip: Clip) -> int:
    """Smooth only the bursts of noise, write the clip, and return the exit code."""
    motion = clip.motion
    cutoff = arguments.cutoff or noise_burst_cutoff(motion.frame_time)
    first, names = count_leading_rest_frames(motion), motion.skeleton.names
    try:
        able = set(select_writable_joints(motion.skeleton, arguments.joints).tolist())
        spans = tuple(span for span in noise_burst_spans_to_smooth(motion) if span.joint in able)
        made = smooth_noise_burst_spans(motion, spans, cutoff, first=first)
    except TwistError as error:
        raise TwistError(f"{arguments.clip}: {error}") from None
    joints = sorted({span.joint for span in spans})
    _warn_of_twist(clip, joints, spans)
    print_channel_jumps(arguments.output, write_clip(clip, made, arguments.output))
    if not spans:
        print_remark(f"{arguments.output}: no burst of noise was found, so nothing was changed")
        return 0
    bursts: dict[tuple[int, int], list[str]] = {}
    for span in spans:
        bursts.setdefault((span.start, span.stop), []).append(names[span.joint])
    print_remark(
        f"{arguments.output}: {count_with_noun(len(bursts), 'burst')} of noise smoothed with a "
        "spline, "
        f"cut-off {cutoff:.2g} Hz; nothing else was changed"
    )
    for (start, stop), own in bursts.items():
        print_remark(f"  frames {start}–{stop}: {_listed(own)}")
    unit = 1.0 if is_pose_file(arguments.clip) else arguments.unit
    _tell_quality(motion, made, first, unit)
    return 0


def _tell_quality(motion: Motion, made: Motion, first: int, unit: float | None) -> None:
    """Print jitter, foot slide and deviation if the figure has the joints to measure them.

    `motion` and `made` are the motion before and after processing. Frames before `first` are
    ignored. `unit` is the length of a unit in metres.
    """
    given, made = (m.sliced(first, m.frames) for m in (motion, made))
    if measured := quality_before_and_after(given, made, unit):
        before, after = measured
        print_remark(
            f"  jitter {before.jitter:.2f} → {after.jitter:.2f} mm/frame³ at 25 Hz, foot slide "
            f"{before.foot_slide:.1f} → {after.foot_slide:.1f} %, deviation from the input "
            f"{after.deviation:.1f} mm (not an error: there is no ground truth)"
        )


def _read(arguments: argparse.Namespace) -> Clip:
    if is_pose_file(arguments.clip):
        clip = read_smpl_poses_as_clip(
            arguments.clip,
            template=arguments.template,
            unit=arguments.unit,
            fps=arguments.fps,
            up=arguments.up,
            person=arguments.person,
        )
        for warning in clip.warnings:
            print_note(f"{arguments.clip}: {warning}")
        return clip
    for name in ("template", "up", "person"):
        if getattr(arguments, name) is not None:
            raise TwistError(f"--{name} is only for pose files; leave it out for a BVH")
    return read_bvh(arguments.clip, fps=arguments.fps)


def _options_of_tracker(arguments: argparse.Namespace) -> list[str]:
    """Return the given options that apply only to the tracker."""
    names = ("gains", "weights", "kp", "kd", "ka")
    given = [name for name in names if getattr(arguments, name) is not None]
    return given + ["causal"] * arguments.causal


def _method(arguments: argparse.Namespace) -> str:
    """Return the chosen method.

    The default is the spline, or the tracker if one of its options is given.
    """
    chosen: str | None = arguments.method
    return chosen or ("quamo" if _options_of_tracker(arguments) else "spline")


def _refuse_of_other_method(arguments: argparse.Namespace, method: str) -> None:
    """Raise TwistError if an option does not apply to the method."""
    if method == "spline":
        for name in _options_of_tracker(arguments):
            raise TwistError(f"--{name} is only for the tracker; leave it out with --method spline")
        if arguments.where == "noisy" and arguments.root_position:
            raise TwistError("--root-position cannot be combined with --where noisy")
        return
    for name, given in (
        ("cutoff", arguments.cutoff is not None),
        ("where noisy", arguments.where == "noisy"),
    ):
        if given:
            raise TwistError(
                f"--{name} requires --method spline and cannot be combined with options of "
                "the tracker"
            )
    if arguments.weights is not None and arguments.gains != "learned":
        raise TwistError("--weights requires --gains learned")


def _hand_gains(arguments: argparse.Namespace, dt: float) -> Gains | None:
    """Return the gains set by hand, or None for learned gains. Raises TwistError if both are given.

    `dt` is the frame time in seconds.
    """
    given = {k: v for k in ("kp", "kd", "ka") if (v := getattr(arguments, k)) is not None}
    if arguments.gains == "learned":
        if given:
            raise TwistError(
                f"--{next(iter(given))} sets a gain by hand; leave it out with --gains learned"
            )
        return None
    return replace(Gains.by_hand(dt, causal=arguments.causal), **given)


def _wants_place(arguments: argparse.Namespace, joints: NDArray[np.int64], placed: int) -> bool:
    """Return True if the position is tracked.

    It is tracked on request and, by default, if all joints or the joint `placed` are tracked.
    """
    if arguments.root_position is not None:
        return bool(arguments.root_position)
    return not arguments.joints or placed in joints


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _warn_of_twist(clip: Clip, joints: Sequence[int], spans: Sequence[NoisySpan] = ()) -> None:
    """Print the number of twist errors in the tracked joints, because tracking would hide them.

    If `spans` are given, only errors at the ends of these spans count, since noise causes errors
    within the spans.
    """
    chains = [c for c in find_chains(clip.motion) if {c.parent, c.child} & set(joints)]
    if not chains:
        return
    edges = [edge for span in spans for edge in (span.start, span.stop)]
    if count := sum(
        not spans or any(found.start < edge < found.stop for edge in edges)
        for found in detect(clip, chains)
    ):
        print_note(
            f"{clip.path}: these joints have {count_with_noun(count, 'interval')} with twist "
            "errors; "
            "tracking would smear their edges without removing them, so run detect and refine "
            "first"
        )
