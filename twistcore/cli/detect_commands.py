"""`twistcore info | detect | signals`: what is in a clip and what is wrong with it."""

from __future__ import annotations

import argparse
import csv
import io
import math
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from twistcore.analysis import ClipAnalysis, Detection, analyse
from twistcore.atomic import write_atomically
from twistcore.chain import Chain, uncorrectable_joints
from twistcore.cli.output import by_kind, print_json, refuse_overwrite, tell_no_chain
from twistcore.clip import Clip
from twistcore.detection import Interval, Kind
from twistcore.detection.cuts import border_notes, leading_frames, trailing_frames
from twistcore.encoding import encoded
from twistcore.errors import TwistError
from twistcore.export.detection_json import intervals_to_json, tau_to_json
from twistcore.formats import read_clip
from twistcore.limb import Limb
from twistcore.refinement import children_off_axis
from twistcore.review.soft_onset import soft_onset
from twistcore.rig import AS_FOUND, Rig, read_rig
from twistcore.tuning import read_profile
from twistcore.why_not import peaks_without_interval

_SIGNAL_COLUMNS = (
    "chain", "frame", "theta_p_deg", "theta_c_deg", "dtheta_p_deg", "dtheta_c_deg", "m_deg",
    "swing_reliability", "azimuth_reliability",
)  # fmt: skip


def info(arguments: argparse.Namespace) -> int:
    """What a clip holds."""
    clip = read_clip(arguments.clip, fps=arguments.fps)
    analysis = analysed(arguments, clip)
    motion, chains = clip.motion, analysis.chains
    document: dict[str, Any] = {
        "schema": "twistcore.info/1",
        "clip": str(arguments.clip),
        "format": clip.format,
        "sha256": clip.sha256,
        "frames": motion.frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "joints": list(motion.skeleton.names),
        "channels": clip.columns,
        "height": motion.skeleton.height,
        "chains": [_chain_to_json(clip, chain) for chain in chains],
        "limbs": [_chain_to_json(clip, limb) for limb in analysis.limbs],
        "leading_frames": leading_frames(motion),
        "trailing_frames": trailing_frames(motion),
        "warnings": [
            *map(str, clip.warnings),
            *border_notes(motion),
            *(w for chain in chains for w in chain.warnings),
        ],
    }
    if arguments.json:
        print_json(document)
        return 0
    print(f"{arguments.clip}: {motion.frames} frames at {motion.fps:.6g} fps, ", end="")
    print(f"{len(motion.skeleton)} joints, {clip.columns} channels")
    every = [x for x in analysis.limbs if not uncorrectable_joints(motion, x, carried=True)]
    partly = {x.name for x in every if uncorrectable_joints(motion, x)}
    for entry in (*document["chains"], *document["limbs"]):
        note = f"   not correctable: {', '.join(u)}" if (u := entry["uncorrectable"]) else ""
        if entry.get("limb") in partly:
            note = f"   correctable where its end was carried, not where kept: {', '.join(u)}"
        joints = [entry[k] for k in ("parent", "child", "end") if k in entry]
        print(f"  {entry['label']:<16} {' → '.join(joints)}{note}")
    if not chains:
        print("  no chain of parent, child and grandchild")
    for warning in document["warnings"]:
        print(f"  note: {warning}")
    return 0


def _chain_to_json(clip: Clip, chain: Chain) -> dict[str, Any]:
    """A chain, or a limb: its last joint is its end, and nothing hangs off its axis."""
    names, limb = clip.motion.skeleton.names, isinstance(chain, Limb)
    entry = {
        "limb" if limb else "chain": chain.name,
        "label": chain.label,
        "parent": names[chain.parent],
        "child": names[chain.child],
        "end" if limb else "grandchild": names[chain.grandchild] if chain.grandchild >= 0 else None,
        "uncorrectable": list(uncorrectable_joints(clip.motion, chain)),
    }
    return entry if limb else entry | {"off_axis": children_off_axis(clip.motion, chain)}


def detect(arguments: argparse.Namespace) -> int:
    """Find intervals."""
    clip = read_clip(arguments.clip, fps=arguments.fps)
    found = detected(arguments, clip)
    if arguments.json:
        print_json(_detection_to_json(arguments, clip, found))
    else:
        for i in found:
            name, degrees = i.joint or i.chain, math.degrees(i.shown)
            print(
                f"{name:<20} {i.start:>7} – {i.stop:<7} {degrees:>+9.2f}°"
                f"{'' if i.confidence is None else f'  {i.confidence:.2f}'}"
                f"{'  open' if i.open else ''}{_kind(i)}"
            )
            if arguments.explain:
                _explain(i)
        if arguments.explain:
            _explain_peaks(found)
        where = f"{len(found.chains)} chains"
        if found.limbs and not found.chains:
            where = f"{len(found.limbs)} limb{'' if len(found.limbs) == 1 else 's'}"
        print(f"{len(found)} interval{'' if len(found) == 1 else 's'} in {where}{by_kind(found)}")
    if tell_no_chain(arguments.clip, found.analysis.chains_and_limbs):
        return 1
    return int(arguments.fail_over is not None and len(found) > arguments.fail_over)


def _kind(interval: Interval) -> str:
    """What is wrong, where it is not the usual thing."""
    if interval.kind == Kind.COUNTER_TWIST:
        return ""
    if interval.kind == Kind.LONE_JUMP:
        evidence = interval.evidence or {}
        fast, most = evidence["speed_deg_s"], evidence["limit_deg_s"]
        return f"  {interval.kind}, {fast:,.0f}°/s where no body does {most:,.0f}"
    return f"  {interval.kind}, end {'carried' if interval.carried else 'kept'}"


def _explain(interval: Interval) -> None:
    evidence = interval.evidence or {}
    if told := soft_onset(interval):
        print(f"    {told}, gain {evidence['gain']:.1f}".replace("−", "-"))
        return
    if interval.kind != Kind.COUNTER_TWIST or "transition" in evidence:
        for line in _in_words(evidence):
            print(f"    {line}")
        return
    for edge in evidence.get("edges", ()):
        print(
            f"    frames {edge['start']}–{edge['stop']}: x {edge['residual_x_deg']:+.2f}° against "
            f"y {edge['residual_y_deg']:+.2f}°, agreement {edge['agreement']:.2f}, "
            f"jump {edge['jump_deg']:+.2f}° ± {edge['sigma_deg']:.3f}°"
        )
    if (share := evidence.get("child_follows", 1.0)) < 1.0:
        print(f"    the child turns back by {share:.0%} of it")
    print(f"    left over {math.degrees(interval.residual):+.3f}°")


def _explain_peaks(found: Detection) -> None:
    """What is past τ in no interval, by chain, and why."""
    for chain in found.chains_and_limbs:
        if reasons := peaks_without_interval(found, chain.name):
            count = f"{len(reasons)} peak{'' if len(reasons) == 1 else 's'}"
            print(f"{chain.name:<20} {count} past τ without an interval")
            for reason in reasons:
                print(f"    {reason.text}")


def _peaks_to_json(found: Detection) -> list[dict[str, Any]]:
    names = found.analysis.motion.skeleton.names
    entries = []
    for chain in found.chains_and_limbs:
        own = {"chain": names[chain.parent]}
        own |= {"limb": chain.name} if isinstance(chain, Limb) else {}
        entries += [r.to_json() | own for r in peaks_without_interval(found, chain.name)]
    return entries


def _in_words(evidence: Mapping[str, Any]) -> list[str]:
    """Evidence as lines: its numbers and texts in one, then one for each thing in its lists."""
    said, below = [], []
    for key, value in evidence.items():
        words = key.removesuffix("_deg").replace("_", " ")
        things = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(thing, Mapping) for thing in things):
            below += [f"{words}: {line}" for thing in things for line in _in_words(thing)]
            continue
        shown = (_shown(thing) + ("°" if key.endswith("_deg") else "") for thing in things)
        said.append(f"{words} {', '.join(shown) or '–'}")
    return [", ".join(said), *below] if said else below


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else "–" if value is None else str(value)


def _detection_to_json(
    arguments: argparse.Namespace, clip: Clip, found: Detection
) -> dict[str, Any]:
    document = {
        "schema": "twistcore.detection/1",
        "clip": str(arguments.clip),
        "frames": clip.motion.frames,
        "fps": clip.motion.fps,
        "method": found.method,
        "tau_deg": tau_to_json(found),
        "intervals": intervals_to_json(found, explain=arguments.explain),
    }
    return document | {"peaks": _peaks_to_json(found)} if arguments.explain else document


def signals(arguments: argparse.Namespace) -> int:
    """Signals as CSV: one line a chain and frame, degrees."""
    refuse_overwrite([arguments.csv], [p for p in (arguments.clip, arguments.rig) if p])
    clip = read_clip(arguments.clip, fps=arguments.fps)
    analysis = analysed(arguments, clip)
    if named := [limb for limb in analysis.limbs if limb.name in (arguments.chain or ())]:
        raise TwistError(f"{arguments.clip}: expected a chain, found the limb {named[0].name}")
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_SIGNAL_COLUMNS)
    for name, s in analysis.signals.items():
        angles = np.degrees([s.theta_p, s.theta_c, s.dtheta_p, s.dtheta_c, s.strength]).T
        shares = np.stack([s.swing_reliability, s.azimuth_reliability], axis=1)
        for frame, row in enumerate(np.hstack([angles, shares]).tolist()):
            writer.writerow([name, frame, *(f"{v:.6f}" for v in row)])
    write_atomically(arguments.csv, encoded(out.getvalue()))
    return tell_no_chain(arguments.clip, analysis.chains)


def analysed(arguments: argparse.Namespace, clip: Clip) -> ClipAnalysis:
    """The clip with the chains of --rig, or those of them that --chain names."""
    rig = chosen_rig(arguments)
    try:
        rig.chains(clip.motion)
    except TwistError as error:
        raise TwistError(f"{arguments.rig}: {error}, as {arguments.clip} has it") from None
    return analyse(clip, getattr(arguments, "chain", None), rig)


def chosen_rig(arguments: argparse.Namespace) -> Rig:
    """That of --rig."""
    return read_rig(arguments.rig) if arguments.rig else AS_FOUND


def detected(arguments: argparse.Namespace, clip: Clip) -> Detection:
    """The intervals by --chain, --kinds, --method, --tau and --profile, which goes before --tau."""
    analysis, method, kinds = analysed(arguments, clip), arguments.method, arguments.kinds
    if not arguments.profile:
        return analysis.detect(method, kinds=kinds, tau_radians=arguments.tau)
    profile = read_profile(arguments.profile)
    if profile.method not in ("", method):
        print(
            f"{arguments.profile}: note: tuned for detector {profile.method}, used with {method}",
            file=sys.stderr,
        )
    given = {} if arguments.tau is None else {c.name: arguments.tau for c in analysis.chains}
    given |= profile.of(analysis.chains_and_limbs)
    return analysis.detect(method, kinds=kinds, tau_radians=given)
