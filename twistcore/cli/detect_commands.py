"""Run `twistcore info` and `twistcore detect`, which print the properties and errors of clips."""

from __future__ import annotations

import argparse
import math
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.analysis.correction.twist_removal import children_off_axis
from twistcore.analysis.examination import unexamined_joints_by_body_part
from twistcore.cli.clip_inputs import (
    analyse_with_options,
    clip_name_for_messages,
    detect_in_analysis,
    failed_clips_to_json,
    read_clip_or_stdin,
    reading_assumption_sentences,
    reference_notes,
    run_on_clips_collecting_failures,
)
from twistcore.cli.interval_words import (
    error_kind_counts_text,
    note_sentences,
    nothing_examined_sentence,
    unexamined_limbs_text,
    unexamined_limbs_to_json,
)
from twistcore.cli.joint_table import print_joint_names, recognised_bones_to_json
from twistcore.cli.output import (
    count_with_noun,
    print_json,
    print_note,
    print_problem,
    print_result,
    print_step_duration,
    report_problems,
    terminal_text,
)
from twistcore.detection import Interval, Kind
from twistcore.detection.cuts import count_leading_rest_frames, count_trailing_rest_frames
from twistcore.export.detection_json import detection_tau_degrees, intervals_to_json
from twistcore.formats.clip import Clip
from twistcore.skeleton.chain import Chain, chain_warnings, uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.notes import NOT_EXAMINED
from twistcore.work.frozen import dataclass

Document = dict[str, Any]

_NAME = 20  # minimum width of the column with chains
_LABEL = 16  # minimum width of the column with labels
_LISTED = 4  # maximum number of joints of a body part that are listed by name


def info_command(arguments: argparse.Namespace) -> int:
    """Print all information about one clip, or a table with a row for each of several clips.

    Returns the exit code.
    """
    found, failed = run_on_clips_collecting_failures(arguments.clips, partial(_info_of, arguments))
    several = len(arguments.clips) > 1
    documents = [one.document for one in found]
    if documents and arguments.json:
        print_json(_together("twistcore.infos/1", documents, failed) if several else documents[0])
    elif several and documents:
        _say_rows(documents)
    elif documents:
        _say_info(found[0])
    blind = [sentence for one in found for sentence in one.not_examined]
    return report_problems([*blind, *(why for _, why in failed)], len(found))


def _together(
    schema: str, documents: Sequence[Document], failed: Sequence[tuple[str, str]]
) -> Document:
    """Combine the documents of several clips, and the failed clips, in one document."""
    return {"schema": schema, "clips": list(documents), "failed": failed_clips_to_json(failed)}


@dataclass(frozen=True)
class _Info:
    """The information about a clip that `info` prints.

    Attributes
    ----------
    document
        The information as a JSON document.
    partly
        Names of limbs in which a flip can be corrected only if it also rotated the limb's end.
    notes
        Sentences for the text output.
    not_examined
        A tuple with the reason, as a sentence, if nothing in the clip can be examined, or an empty
        tuple.
    """

    document: Document
    partly: Collection[str]
    notes: Sequence[str]
    not_examined: tuple[str, ...]


def _info_of(arguments: argparse.Namespace, path: Path) -> _Info:
    clip = read_clip_or_stdin(path, fps=arguments.fps)
    analysis = analyse_with_options(arguments, clip)
    of_reference = reference_notes(arguments, analysis)
    motion, chains = clip.motion, analysis.chains
    document: Document = {
        "schema": "twistcore.info/1",
        "clip": clip_name_for_messages(path),
        "format": clip.format,
        "sha256": clip.sha256,
        "frames": motion.frames,
        "declared_frames": clip.declared_frames,
        "missing_frames": clip.missing_frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "joints": list(motion.skeleton.names),
        "channels": clip.columns,
        "height": motion.skeleton.height,
        "people": list(analysis.people),
        "chains": [_chain_to_json(clip, chain) for chain in chains],
        "limbs": [_chain_to_json(clip, limb) for limb in analysis.limbs],
        "not_examined": analysis.not_examined or None,
        "unexamined": unexamined_limbs_to_json(analysis),
        "outside_chains": _outside(analysis),
        "leading_frames": count_leading_rest_frames(motion),
        "trailing_frames": count_trailing_rest_frames(motion),
        "warnings": [
            *map(str, clip.warnings),
            *map(str, (*analysis.notes, *of_reference)),
            *chain_warnings(chains),
        ],
    }
    if arguments.names:
        document["names"] = recognised_bones_to_json(analysis.body, analysis.rig.names)
    every = [x for x in analysis.limbs if not uncorrectable_joints(motion, x, carried=True)]
    partly = {x.name for x in every if uncorrectable_joints(motion, x)}
    limbs = set(map(str, analysis.unexamined))  # printed in separate lines
    own = {str(note) for note in analysis.notes if note.kind == NOT_EXAMINED} | limbs
    notes = [warning for warning in document["warnings"] if warning not in own]
    return _Info(
        document, partly, notes, nothing_examined_sentence(clip_name_for_messages(path), analysis)
    )


def _outside(analysis: ClipAnalysis) -> dict[str, list[str]]:
    found = unexamined_joints_by_body_part(analysis.body, analysis.chains_and_limbs)
    return {part: list(names) for part, names in found.items()}


def _say_info(info: _Info) -> None:
    document = info.document
    size = f"{document['frames']} frames at {document['fps']:.6g} fps"
    joints = f"{len(document['joints'])} joints, {document['channels']} channels"
    print_result(f"{document['clip']}: {size}, {joints}")
    if people := document["people"]:
        print_result(f"  {len(people)} people: {', '.join(map(terminal_text, people))}")
    entries = (*document["chains"], *document["limbs"])
    width = max([_LABEL, *(len(entry["label"]) for entry in entries)])
    chains = [terminal_text(entry.get("limb") or entry["chain"]) for entry in entries]
    broad = max([_NAME, *map(len, chains)])
    if entries:
        print_result(
            f"  {'name for --chain':<{broad}} {'chain or limb':<{width}} joints", head=True
        )
    for chain, entry in zip(chains, entries, strict=True):
        note = f"   not correctable: {', '.join(u)}" if (u := entry["uncorrectable"]) else ""
        if entry.get("limb") in info.partly:
            note = f"   not correctable if the end of the limb was kept: {', '.join(u)}"
        names = [entry[k] for k in ("parent", "child", "end") if k in entry]
        label = f"{entry['label']:<{width}}"
        print_result(f"  {chain:<{broad}} {label} {' → '.join(names)}{note}")
    for one in () if document["not_examined"] else document["unexamined"]:
        limb = f"{one['person']} · " if "person" in one else ""
        limb += one["limb"].capitalize()
        print_result(f"  {limb:<{width}} not examined: {one['why']}")
    if entries:
        parts = (f"{part} {_listed(names)}" for part, names in document["outside_chains"].items())
        print_result(f"  outside chains: {'; '.join(parts)}")
    print_joint_names(document.get("names", ()))
    for sentence in info.notes:
        print_result(f"  note: {sentence}")


def _listed(names: Sequence[str]) -> str:
    """Return the names as text, or the first name and the total number if there are many."""
    return ", ".join(names) if len(names) <= _LISTED else f"{names[0]} … ({len(names)} joints)"


def _say_rows(documents: Sequence[Document]) -> None:
    """Print one row for each clip. The name is in the last column because it may be long."""
    print_result(
        f"{'frames':>8} {'fps':>8} {'seconds':>9} {'joints':>6} {'channels':>8} {'chains':>6} "
        f"{'limbs':>5} {'unexamined':>10} {'notes':>5}  clip",
        head=True,
    )
    for d in documents:
        print_result(
            f"{d['frames']:>8} {d['fps']:>8.6g} {d['seconds']:>9.2f} {len(d['joints']):>6} "
            f"{d['channels']:>8} {len(d['chains']):>6} {len(d['limbs']):>5} "
            f"{len(d['unexamined']):>10} {len(d['warnings']):>5}  {d['clip']}"
        )
    for d in documents:
        if "names" in d:
            print_result(d["clip"], head=True)
            print_joint_names(d["names"])


def _chain_to_json(clip: Clip, chain: Chain) -> Document:
    """Return a chain or limb as JSON data, including the joints that cannot be corrected."""
    names, limb = clip.motion.skeleton.names, isinstance(chain, Limb)
    entry = {
        "limb" if limb else "chain": chain.name,
        "label": chain.label,
        "parent": names[chain.parent],
        "child": names[chain.child],
        "end" if limb else "grandchild": names[chain.grandchild] if chain.grandchild >= 0 else None,
        "uncorrectable": list(uncorrectable_joints(clip.motion, chain)),
    }
    if chain.person:
        entry["person"] = chain.person
    return entry if limb else entry | {"off_axis": children_off_axis(clip.motion, chain)}


def detect_command(arguments: argparse.Namespace) -> int:
    """Print the intervals of the clips and return the exit code."""
    several = len(arguments.clips) > 1
    found, failed = run_on_clips_collecting_failures(
        arguments.clips, partial(_detect_in, arguments, several=several)
    )
    counted, total = sum(count for count, *_ in found), sum(every for _, every, *_ in found)
    blind = sum(mute for *_, mute, _ in found)
    if found and arguments.json:
        documents = [document for *_, document in found]
        every = _together("twistcore.detections/1", documents, failed)
        print_json(every if several else documents[0])
    elif found and several:
        left_out = f"; {count_with_noun(blind, 'clip')} not examined" if blind else ""
        print_result(
            f"{count_with_noun(len(found), 'clip')}, "
            f"{count_with_noun(total, 'interval')}{left_out}",
            head=True,
        )
    code = report_problems([why for _, why in failed], len(found))
    over = int(arguments.fail_over is not None and counted > arguments.fail_over)
    return max(code, int(blind > 0), over)


def _detect_in(
    arguments: argparse.Namespace, path: Path, *, several: bool
) -> tuple[int, int, int, Document]:
    """Print the intervals of a clip, or return them in a document with --json.

    Returns
    -------
    counted
        Number of intervals for `--fail-over`. Capture faults count only if `--kinds` includes them.
    total
        Number of all intervals.
    blind
        1 if nothing could be examined, or 0.
    document
        The JSON document, empty without --json.
    """
    clip = read_clip_or_stdin(path, fps=arguments.fps)
    name, document = clip_name_for_messages(path), Document()
    notes, missing = reading_assumption_sentences(name, clip), clip.missing_frames
    warnings = list(map(str, clip.warnings))
    with print_step_duration(f"  {clip.path}: analysed and searched"):
        analysis = analyse_with_options(arguments, clip)
        del clip  # its text takes more memory than its motion
        of_reference = reference_notes(arguments, analysis)
        found = detect_in_analysis(arguments, analysis)
    for sentence in notes:
        print_note(sentence)
    blind = nothing_examined_sentence(name, found)
    if arguments.json:
        document = _detection_to_json(name, missing, warnings, found, explain=arguments.explain)
        document["notes"] += [note.to_json() for note in of_reference]
    else:
        if several:
            print_result(name, head=True)
        if not blind:
            _say_intervals(found, explain=arguments.explain)
    for sentence in blind:
        print_problem(sentence)
    if not arguments.json:
        for sentence in note_sentences(name, found, of_reference):
            print_note(sentence)
        if several:
            print_result()
    counted = sum(bool(arguments.kinds) or not i.kind.of_capture for i in found)
    return counted, len(found), len(blind), document


def _say_intervals(found: Detection, *, explain: bool) -> None:
    width = max([_NAME, *(len(terminal_text(i.joint or i.chain)) for i in found)])
    people = {chain.name: terminal_text(chain.person) for chain in found.chains_and_limbs}
    broad = max(map(len, people.values()), default=0)
    broad = max(broad, len("person")) + 1 if broad else 0
    if len(found):
        print_result(
            f"{'person' if broad else '':<{broad}}{'chain':<{width}} {'start':>7} – {'stop':<7} "
            f"{'δ':>10}  confidence",
            head=True,
        )
    for i in found:
        name = terminal_text(i.joint or i.chain)
        whose = f"{people[i.chain]:<{broad}}"
        print_result(
            f"{whose}{name:<{width}} {i.start:>7} – {i.stop:<7} {i.angle_text(2):>10}"
            f"{'' if i.confidence is None else f'  {i.confidence:.2f}'}"
            f"{'  open' if i.open else ''}{_kind(i)}"
        )
        if explain:
            _explain(i)
    if explain:
        _explain_peaks(found)
    helpers = sum(isinstance(c, Helper) for c in found.chains)
    where = count_with_noun(len(found.chains) - helpers, "chain")
    if helpers:
        where += f" and {count_with_noun(helpers, 'helper')}"
    if found.limbs and not found.chains:
        where = count_with_noun(len(found.limbs), "limb")
    if broad:
        where += f" of {count_with_noun(len({*people.values()}), 'person', 'people')}"
    left_out = unexamined_limbs_text(found.analysis.unexamined)
    print_result(
        f"{count_with_noun(len(found), 'interval')} in "
        f"{where}{error_kind_counts_text(found)}{left_out}"
    )


def _kind(interval: Interval) -> str:
    """Return the kind of an interval with details, or '' for a counter-twist."""
    if interval.kind == Kind.COUNTER_TWIST:
        return ""
    evidence = interval.evidence or {}
    if interval.kind == Kind.LONE_JUMP:
        turn = abs(evidence["turn_deg"])
        most = turn * evidence["limit_deg_s"] / evidence["speed_deg_s"]
        return (
            f"  {interval.kind}, {turn:.0f}° in one frame; no body turns by more than {most:.0f}°"
        )
    if interval.kind == Kind.NOISE_BURST:
        joints = [*map(terminal_text, evidence["joints"])]
        return f"  {interval.kind}{f' in {_listed(joints)}' if len(joints) > 1 else ''}"
    if interval.kind == Kind.FROZEN:
        return f"  {interval.kind}: {terminal_text(evidence['part'])} does not change at all"
    if interval.kind == Kind.LIMB_FLIP:
        return f"  {interval.kind}, end {'carried' if interval.carried else 'kept'}"
    return f"  {interval.kind}"


def _explain(interval: Interval) -> None:
    evidence = interval.evidence or {}
    _explain_signals(interval, evidence)
    for doubt in evidence.get("doubts", ()):
        print_result(f"    reason for doubt: {doubt}")


def _explain_signals(interval: Interval, evidence: Mapping[str, Any]) -> None:
    from twistcore.detection.soft_onset import describe_soft_onset  # only --explain needs it

    if onset := describe_soft_onset(interval):
        print_result(f"    {onset}, gain {evidence['gain']:.1f}".replace("−", "-"))
        return
    if interval.kind != Kind.COUNTER_TWIST or "transition" in evidence:
        own = {name: value for name, value in evidence.items() if name != "doubts"}
        for line in _in_words(own):
            print_result(f"    {line}")
        return
    for edge in evidence.get("edges", ()):
        print_result(
            f"    frames {edge['start']}–{edge['stop']}: Δθp {edge['residual_x_deg']:+.2f}°, "
            f"Δθc {edge['residual_y_deg']:+.2f}°, agreement {edge['agreement']:.2f}, "
            f"jump {edge['jump_deg']:+.2f}° ± {edge['sigma_deg']:.3f}°"
        )
    if (share := evidence.get("child_follows", 1.0)) < 1.0:
        print_result(f"    the child turns back by {share:.0%} of δ")
    print_result(f"    remaining offset {math.degrees(interval.residual):+.3f}°")


def _explain_peaks(found: Detection) -> None:
    """For each chain, print why peaks of the signal above τ did not become intervals."""
    from twistcore.analysis.why_not import why_peaks_lack_interval  # only --explain needs it

    for chain in found.chains_and_limbs:
        if reasons := why_peaks_lack_interval(found, chain.name):
            count = f"{len(reasons)} peak{'' if len(reasons) == 1 else 's'}"
            print_result(f"{chain.name:<20} {count} above τ without an interval")
            for reason in reasons:
                print_result(f"    {reason.text}")


def _peaks_to_json(found: Detection) -> list[Document]:
    from twistcore.analysis.why_not import why_peaks_lack_interval  # only --explain needs it

    names = found.analysis.motion.skeleton.names
    entries = []
    for chain in found.chains_and_limbs:
        own = {"chain": names[chain.parent]}
        own |= {"limb": chain.name} if isinstance(chain, Limb) else {}
        entries += [r.to_json() | own for r in why_peaks_lack_interval(found, chain.name)]
    return entries


def _in_words(evidence: Mapping[str, Any]) -> list[str]:
    """Return evidence as lines of text: one for plain values, and one for each item of a list."""
    parts, below = [], []
    for key, value in evidence.items():
        words = key.removesuffix("_deg").replace("_", " ")
        things = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(thing, Mapping) for thing in things):
            below += [f"{words}: {line}" for thing in things for line in _in_words(thing)]
            continue
        shown = (_shown(thing) + ("°" if key.endswith("_deg") else "") for thing in things)
        parts.append(f"{words} {', '.join(shown) or '–'}")
    return [", ".join(parts), *below] if parts else below


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else "–" if value is None else str(value)


def _detection_to_json(
    name: str, missing: int, warnings: list[str], found: Detection, *, explain: bool
) -> Document:
    motion = found.analysis.motion
    document = {
        "schema": "twistcore.detection/1",
        "clip": name,
        "frames": motion.frames,
        "missing_frames": missing,
        "fps": motion.fps,
        "method": found.method,
        "tau_deg": detection_tau_degrees(found),
        "intervals": intervals_to_json(found, explain=explain),
        "not_examined": found.not_examined or None,
        "unexamined": unexamined_limbs_to_json(found.analysis),
        "warnings": warnings,
        "notes": [note.to_json() for note in found.notes],
    }
    return document | {"peaks": _peaks_to_json(found)} if explain else document
