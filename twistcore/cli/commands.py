"""What each `twistcore` command does; the words are in cli.py."""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import sys
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.atomic import destination, is_stream, write_atomically
from twistcore.bvh import (
    Clip,
    EulerJump,
    changed_rotations,
    parse_bvh,
    patch_rotations,
    read_bvh,
    thinned,
    write_bvh,
)
from twistcore.chain import Chain, find_chains, uncorrectable_joints
from twistcore.detection import DETECTORS, Interval, resolve_tau
from twistcore.encoding import encoded, json_text
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import compare, difference_to_json
from twistcore.export.replay import accepted_motion, check_belongs
from twistcore.export.report import Report, check_report, write_report
from twistcore.processes import each, reason
from twistcore.refinement import children_off_axis
from twistcore.review import Decide, Decision, Review, read_session, start_review
from twistcore.signals import twist_signals
from twistcore.study.evaluation import (
    Sample,
    evaluation_to_json,
    evaluation_to_text,
    measure,
    summarise,
)
from twistcore.synthesis import (
    Truth,
    draw_errors,
    draw_targets,
    enrich,
    generator,
    inject,
    parse_protocol,
    prepare,
    read_truth,
    write_truth,
)
from twistcore.tuning import TauCurve, clip_curves, read_profile, tuned, write_profile

_SIGNAL_COLUMNS = (
    "chain",
    "frame",
    "theta_p_deg",
    "theta_c_deg",
    "dtheta_p_deg",
    "dtheta_c_deg",
    "m_deg",
    "swing_reliability",
    "azimuth_reliability",
)


def info(arguments: argparse.Namespace) -> int:
    """What a clip holds."""
    clip = read_bvh(arguments.clip)
    motion, chains = clip.motion, find_chains(clip.motion)
    document = {
        "schema": "twistcore.info/1",
        "clip": str(arguments.clip),
        "sha256": clip.sha256,
        "frames": motion.frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "joints": list(motion.skeleton.names),
        "channels": clip.values.shape[1],
        "height": motion.skeleton.height,
        "chains": [_chain_to_json(clip, chain) for chain in chains],
        "warnings": [*map(str, clip.warnings), *(w for chain in chains for w in chain.warnings)],
    }
    if arguments.json:
        print_json(document)
        return 0
    print(f"{arguments.clip}: {motion.frames} frames at {motion.fps:.6g} fps, ", end="")
    print(f"{len(motion.skeleton)} joints, {clip.values.shape[1]} channels")
    for entry in document["chains"]:
        note = f"   not correctable: {', '.join(u)}" if (u := entry["uncorrectable"]) else ""
        print(f"  {entry['label']:<16} {entry['parent']} → {entry['child']}{note}")
    if not chains:
        print("  no chain of parent, child and grandchild")
    for warning in document["warnings"]:
        print(f"  note: {warning}")
    return 0


def detect(arguments: argparse.Namespace) -> int:
    """Find intervals."""
    clip = read_bvh(arguments.clip, fps=arguments.fps)
    chains = _chosen_chains(clip, arguments.chain)
    tau, found = _detected(arguments, clip, chains)
    if arguments.json:
        print_json(_detection_to_json(arguments, clip, tau, found))
    else:
        for i in found:
            print(
                f"{i.chain:<20} {i.start:>7} – {i.stop:<7} {math.degrees(i.delta):>+9.2f}°"
                f"{'' if i.confidence is None else f'  {i.confidence:.2f}'}"
                f"{'  open' if i.open else ''}"
            )
            if arguments.explain:
                _explain(i)
        print(f"{len(found)} interval{'' if len(found) == 1 else 's'} in {len(chains)} chains")
    if _tell_no_chain(arguments.clip, chains):
        return 1
    return int(arguments.fail_over is not None and len(found) > arguments.fail_over)


def _explain(interval: Interval) -> None:
    for edge in (interval.evidence or {}).get("edges", ()):
        print(
            f"    frames {edge['start']}–{edge['stop']}: x {edge['residual_x_deg']:+.2f}° against "
            f"y {edge['residual_y_deg']:+.2f}°, agreement {edge['agreement']:.2f}, "
            f"jump {edge['jump_deg']:+.2f}° ± {edge['sigma_deg']:.3f}°"
        )
    print(f"    left over {math.degrees(interval.residual):+.3f}°")


def signals(arguments: argparse.Namespace) -> int:
    """Signals as CSV: one line a chain and frame, degrees."""
    refuse_overwrite([arguments.csv], [arguments.clip])
    clip = read_bvh(arguments.clip)
    chains = _chosen_chains(clip, arguments.chain)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_SIGNAL_COLUMNS)
    for chain in chains:
        s = twist_signals(clip.motion, chain)
        angles = np.degrees([s.theta_p, s.theta_c, s.dtheta_p, s.dtheta_c, s.strength]).T
        shares = np.stack([s.swing_reliability, s.azimuth_reliability], axis=1)
        for frame, row in enumerate(np.hstack([angles, shares]).tolist()):
            writer.writerow([chain.name, frame, *(f"{v:.6f}" for v in row)])
    write_atomically(arguments.csv, encoded(out.getvalue()))
    return _tell_no_chain(arguments.clip, chains)


def refine_clip(arguments: argparse.Namespace) -> int:
    """Write a corrected BVH, and a report if asked."""
    clip = read_bvh(arguments.clip, fps=arguments.fps)
    refuse_overwrite([arguments.output], [p for p in (arguments.clip, arguments.profile) if p])
    if arguments.report and arguments.report.exists() and not arguments.report.is_dir():
        raise TwistError(f"{arguments.report}: expected a folder for the report")
    if arguments.report:
        check_report(arguments.report, clip)
    chains = _chosen_chains(clip, arguments.chain)
    tau, found = _detected(arguments, clip, chains)
    state = start_review(arguments.method, tau, found, [c.name for c in chains])
    review = Review(state)
    wanted = tuple(
        j.id
        for j in state.intervals
        if (j.interval.confidence is None or j.interval.confidence >= arguments.min_confidence)
        and (arguments.include_open or not j.interval.open)
    )
    review.do(Decide(wanted, Decision.ACCEPTED))
    refined = accepted_motion(clip, chains, review.state)
    tell_jumps(arguments.output, write_bvh(clip, refined, arguments.output))
    if arguments.report:
        write_report(arguments.report, Report(clip, chains, review.state, refined))
    print(f"{arguments.output}: {len(wanted)} of {len(found)} intervals corrected")
    skipped = _tell_uncorrected(clip, chains, [review.state.find(i).interval for i in wanted])
    return int(skipped or bool(_tell_no_chain(arguments.clip, chains)))


def apply(arguments: argparse.Namespace) -> int:
    """Replay a session: the same bytes as the program's export."""
    session = read_session(arguments.session)
    clip = read_bvh(arguments.clip, fps=session.fps)
    refuse_overwrite([arguments.output], [arguments.clip, arguments.session])
    chains = find_chains(clip.motion)
    check_belongs(session, clip, chains)
    refined = accepted_motion(clip, chains, session.state)
    tell_jumps(arguments.output, write_bvh(clip, refined, arguments.output))
    chosen = session.state.chosen()
    print(f"{arguments.output}: {len(chosen)} of {len(session.state.intervals)} intervals applied")
    return int(_tell_uncorrected(clip, chains, chosen))


def inject_errors(arguments: argparse.Namespace) -> int:
    """Put errors into a clip and write their truth."""
    protocol = parse_protocol(arguments.protocol)
    clip = read_bvh(arguments.clip)
    refuse_overwrite([arguments.output, arguments.truth], [arguments.clip])
    every = find_chains(clip.motion)
    chains = [c for c in every if not uncorrectable_joints(clip.motion, c)]
    if not chains:
        raise TwistError(f"{arguments.clip}: no chain that a twist error could be put into")
    if protocol.rich:
        rich = enrich(clip.motion, chains)
        clip = parse_bvh(patch_rotations(clip, rich, changed_rotations(clip, rich)), clip.path)
    clip = thinned(clip, protocol.step)
    motion = clip.motion
    rng = generator(arguments.seed, arguments.clip.name)
    targets = draw_targets(chains, rng, protocol)
    errors = draw_errors(targets, motion.frames, rng, protocol, fps=motion.fps)
    write_bvh(clip, inject(motion, chains, errors), arguments.output)
    truth = Truth(
        arguments.clip.name,
        protocol.name,
        arguments.seed,
        motion.frames,
        motion.fps,
        errors,
    )
    write_truth(arguments.truth, truth)
    names = ", ".join(sorted({e.chain for e in errors}))
    print(f"{arguments.output}: {len(errors)} errors in {names or 'no chain'}, ", end="")
    print(f"protocol {protocol.name}, seed {arguments.seed}")
    if not errors and not protocol.clean:
        print(f"{arguments.clip}: too short for an error to be put in", file=sys.stderr)
        return 1
    return 0


def evaluate(arguments: argparse.Namespace) -> int:
    """Print the table of one or more refined clips."""
    counts = {len(arguments.truth), len(arguments.clean), len(arguments.refined)}
    if len(counts) != 1:
        raise TwistError("--truth, --clean and --refined: expected the same number of files")
    samples, problems = [], []
    for files in zip(arguments.truth, arguments.clean, arguments.refined, strict=True):
        try:
            samples.append(_measured(*files))
        except TwistError as error:
            problems.append(str(error))
    code = tell_problems(problems, len(samples))
    if not samples:
        return code
    table = summarise(samples)
    if arguments.json:
        print_json(evaluation_to_json(table))
    else:
        print(evaluation_to_text(table))
    return code


def _measured(truth: Path, clean: Path, refined: Path) -> Sample:
    source, known = read_bvh(clean).motion, read_truth(truth)
    chains = find_chains(source)
    base = prepare(source, chains, parse_protocol(known.protocol))
    try:
        return measure(known, base, read_bvh(refined).motion, chains)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{refined}: {error}") from None


def tune(arguments: argparse.Namespace) -> int:
    """Write a profile of τ per joint from a clip or all clips of a folder."""
    source: Path = arguments.source
    paths = sorted(source.glob("*.bvh")) if source.is_dir() else [source]
    if not paths:
        raise TwistError(f"{source}: expected a BVH or a folder with some")
    refuse_overwrite([arguments.output], paths)
    work = partial(clip_curves, method=arguments.method, seeds=arguments.seeds)
    found: dict[Path, dict[str, TauCurve]] = {}
    problems: list[str] = []
    for path, result in each(work, paths, arguments.workers):
        if isinstance(result, Exception):
            problems.append(reason(path, result))
        elif not result:
            problems.append(f"{path}: no chain that τ could be tuned on")
        else:
            found[path] = result
            print(f"{path.name}: done", file=sys.stderr)
    code = tell_problems(problems, len(found))
    if not found:
        return code
    curves: dict[str, TauCurve] = {}
    for path in sorted(found):  # whichever process was first: the same profile
        for name, curve in found[path].items():
            curves[name] = curves[name] + curve if name in curves else curve
    profile = {name: tuned(curve) for name, curve in curves.items()}
    write_profile(arguments.output, profile, source.name, arguments.method)
    for name, t in profile.items():
        print(
            f"{name:<20} τ {t.tau:6.2f}°   noise {t.noise:6.3f}°   FSR {t.fsr:6.2f} %   "
            f"{t.alarms_per_minute:.2f} false alarms a minute"
        )
    return code


def diff(arguments: argparse.Namespace) -> int:
    """Print what differs between two clips."""
    a, b = read_bvh(arguments.a), read_bvh(arguments.b)
    try:
        difference = compare(a.motion, b.motion)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{arguments.a}, {arguments.b}: {error}") from None
    if arguments.json:
        print_json(difference_to_json(difference, str(arguments.a), str(arguments.b)))
        return 0
    for j in difference.joints:
        print(f"{j.joint:<24} {j.start:>7} – {j.stop:<7} up to {j.max_degrees:8.3f}°")
    print(
        f"{len({j.joint for j in difference.joints})} joints rotate otherwise, in "
        f"{difference.frames} frames; joints move by at most "
        f"{difference.max_position_of_height:.1e} of the height"
    )
    return 0


def _chain_to_json(clip: Clip, chain: Chain) -> dict[str, Any]:
    names = clip.motion.skeleton.names
    return {
        "chain": chain.name,
        "label": chain.label,
        "parent": names[chain.parent],
        "child": names[chain.child],
        "grandchild": names[chain.grandchild] if chain.grandchild >= 0 else None,
        "uncorrectable": list(uncorrectable_joints(clip.motion, chain)),
        "off_axis": children_off_axis(clip.motion, chain),
    }


def _chosen_chains(clip: Clip, names: Sequence[str] | None) -> tuple[Chain, ...]:
    chains = find_chains(clip.motion)
    if not names:
        return chains
    known = {chain.name for chain in chains}
    for name in names:
        if name not in known:
            raise TwistError(
                f"{clip.path}: no chain {name!r}; expected one of {', '.join(sorted(known)) or '–'}"
            )
    return tuple(chain for chain in chains if chain.name in names)


def _detected(
    arguments: argparse.Namespace, clip: Clip, chains: Sequence[Chain]
) -> tuple[dict[str, float], list[Interval]]:
    analysis = DETECTORS[arguments.method].analyse(clip.motion, chains)
    tau = resolve_tau(analysis, chains, arguments.tau)
    if arguments.profile:
        profile = read_profile(arguments.profile)
        tau.update({name: t for name, t in profile.tau.items() if name in tau})
        if profile.method not in ("", arguments.method):
            print(
                f"{arguments.profile}: note: tuned for detector {profile.method}, "
                f"used with {arguments.method}",
                file=sys.stderr,
            )
    return tau, [i for c in chains for i in analysis.intervals(c.name, tau[c.name])]


def _detection_to_json(
    arguments: argparse.Namespace, clip: Clip, tau: dict[str, float], found: list[Interval]
) -> dict[str, Any]:
    chains = {chain.name: chain for chain in find_chains(clip.motion)}
    names = clip.motion.skeleton.names
    intervals = []
    for i in found:
        entry: dict[str, Any] = {
            "chain": i.chain,
            "parent": names[chains[i.chain].parent],
            "child": names[chains[i.chain].child],
            "start": i.start,
            "stop": i.stop,
            "delta_deg": math.degrees(i.delta),
            "confidence": i.confidence,
            "open": i.open,
        }
        if arguments.explain:
            entry["residual_deg"] = math.degrees(i.residual)
            entry["evidence"] = i.evidence
        intervals.append(entry)
    return {
        "schema": "twistcore.detection/1",
        "clip": str(arguments.clip),
        "frames": clip.motion.frames,
        "fps": clip.motion.fps,
        "method": arguments.method,
        "tau_deg": {name: math.degrees(t) for name, t in tau.items()},
        "intervals": intervals,
    }


def _tell_no_chain(clip: Path, chains: Sequence[Chain]) -> int:
    """1, with a sentence, where there was nothing to look at; else 0."""
    if not chains:
        print(f"{clip}: no chain of parent, child and grandchild", file=sys.stderr)
    return int(not chains)


def _tell_uncorrected(clip: Clip, chains: Sequence[Chain], chosen: Sequence[Interval]) -> bool:
    """Say what could not be corrected, or not without moving a helper joint; True if skipped."""
    skipped = False
    used = {interval.chain for interval in chosen}
    for chain in chains:
        if chain.name not in used:
            continue
        if joints := uncorrectable_joints(clip.motion, chain):
            skipped = True
            print(
                f"{clip.path}: {chain.name} was not corrected: {', '.join(joints)} "
                "without three rotation channels",
                file=sys.stderr,
            )
        for name, distance in children_off_axis(clip.motion, chain).items():
            share = 2.0 * distance / clip.motion.skeleton.height
            if share > 1e-6:
                print(
                    f"{clip.path}: {name} lies beside the axis of {chain.name} and follows it "
                    f"by up to {share:.1e} of the height",
                    file=sys.stderr,
                )
    return skipped


def tell_jumps(output: Path, jumps: Sequence[EulerJump]) -> None:
    """Say where a channel had to turn by more than 180° in one frame."""
    for jump in jumps[:10]:
        print(f"{output}: note: {jump}", file=sys.stderr)
    if len(jumps) > 10:
        print(f"{output}: note: {len(jumps) - 10} more such jumps", file=sys.stderr)


def tell_problems(problems: Sequence[str], done: int) -> int:
    """List what could not be processed beside so many that could; the exit code."""
    for problem in problems:
        print(problem, file=sys.stderr)
    return int(bool(problems)) if done else 2


def refuse_overwrite(outputs: Sequence[Path], sources: Iterable[Path]) -> None:
    """Before anything is written: every output has a folder and replaces no input or output.

    Links are followed. Raises TwistError, and OSError for what cannot be written at all.
    """
    for k, output in enumerate(outputs):
        end = destination(output)
        if any(_same(output, source) for source in sources):
            raise TwistError(f"{output}: expected another file than an input of this command")
        if any(end == destination(other) or _same(output, other) for other in outputs[:k]):
            raise TwistError(f"{output}: expected different files for different outputs")
        if not is_stream(output) and not end.parent.is_dir():
            raise TwistError(f"{output}: expected an existing folder to write into")


def _same(a: Path, b: Path) -> bool:
    return a.exists() and b.exists() and a.samefile(b)


def print_json(document: dict[str, Any]) -> None:
    """Write a JSON document to stdout; ValueError where a number is not finite."""
    text = json_text(document)
    if (sys.stdout.encoding or "utf-8").lower() != "utf-8":
        text = json.dumps(json.loads(text), indent=1)  # what it cannot write, escaped
    print(text)
