"""Process a clip and return its result document and, if requested, the corrected clip."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import ALL_KINDS, Detection, analyse
from twistcore.analysis.clip_severity import measure_clip_severity
from twistcore.analysis.quality.figure import measure_body_motion_quality
from twistcore.batch.parameters import Parameters
from twistcore.detection import Kind
from twistcore.export.detection_json import detection_tau_degrees, intervals_to_json
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.clip import Clip, create_file_patch_for_motion
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import chain_warnings
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.own_words import add_user_joint_words
from twistcore.skeleton.rig import AS_FOUND, rig_from_json
from twistcore.skeleton.rotation import largest_and_rms_angle_degrees

SCHEMA = "twistcore.batch_clip/1"


def process_clip(path: Path, parameters: Parameters) -> tuple[Clip, dict[str, Any], bytes | None]:
    """Detect errors in a clip and, if requested, correct it.

    Returns
    -------
    clip
        The clip.
    document
        The result. It does not contain the clip's name, so equal files have equal documents.
    corrected
        The bytes of the corrected clip, or None if no correction is requested.

    Raises
    ------
    TwistError
        If the clip cannot be read or analysed.
    """
    clip = read_clip(path, fps=parameters.fps)
    found = _detected(clip, parameters)
    document = _document(clip, found)
    if not parameters.refine:
        return clip, document, None
    refined, applied, left = _refined(clip, found, parameters)
    corrected = create_file_patch_for_motion(clip, refined).data
    document["warnings"] += left
    document["applied"], document["uncorrected"] = applied, left
    document["left"] = document["intervals"]
    if corrected != clip.data:
        # Examine a BVH file as written, with rounded values. For other formats, examine the motion.
        bvh = clip.format == "bvh"
        after = parse_bvh(corrected, path, fps=parameters.fps) if bvh else refined
        document["left"] = intervals_to_json(_detected(after, parameters))
    return clip, document, corrected


def _detected(clip: Clip | Motion, parameters: Parameters) -> Detection:
    rig = AS_FOUND if parameters.rig is None else rig_from_json(parameters.rig)
    motion = clip.motion if isinstance(clip, Clip) else clip
    rig = add_user_joint_words(rig, motion, parameters.joint_names)
    analysis = analyse(clip, list(parameters.chains) or None, rig, parameters.people or None)
    kinds = [Kind(kind) for kind in parameters.kinds] or ALL_KINDS
    for_all = None if parameters.tau_deg is None else math.radians(parameters.tau_deg)
    tau = analysis.tau_of(for_all, parameters.profile_rad or {})
    return analysis.detect(parameters.method, kinds=kinds, tau_radians=tau)


def _document(clip: Clip, found: Detection) -> dict[str, Any]:
    motion, chains = clip.motion, found.chains_and_limbs
    wrong = np.zeros(motion.frames, dtype=np.bool_)
    offsets = [np.zeros(0)]
    for interval in found:
        if interval.repairable:
            wrong[interval.start : interval.stop] = True
            offsets.append(interval.offset)
    largest, rms = largest_and_rms_angle_degrees(np.concatenate(offsets))
    counts = Counter(interval.kind for interval in found)
    quality = measure_body_motion_quality(motion)
    return {
        "schema": SCHEMA,
        "sha256": clip.sha256,
        "format": clip.format,
        "frames": motion.frames,
        "missing_frames": clip.missing_frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "joints": len(motion.skeleton),
        "method": found.method,
        "tau_deg": detection_tau_degrees(found),
        "intervals": intervals_to_json(found),
        "counts": {kind.value: counts[kind] for kind in Kind},
        "affected_frames": int(wrong.sum()),
        "severity": measure_clip_severity(found),
        "degrees": {"max": largest, "rms": rms},
        "chains": [chain.name for chain in chains],
        "unchecked": found.not_examined,
        "unexamined": [limb.to_json() for limb in found.analysis.unexamined],
        "warnings": [
            *map(str, clip.warnings),
            *map(str, found.notes),
            *chain_warnings(found.chains),
        ],
        "applied": None,
        "uncorrected": None,
        "left": None,
        "quality": {k: v for k, v in asdict(quality).items() if v is not None} if quality else {},
    }


def _refined(clip: Clip, found: Detection, parameters: Parameters) -> tuple[Motion, int, list[str]]:
    """Return the corrected motion, the number of corrected intervals, and a list of messages.

    Each message names a chain that was not corrected, and gives the reason.
    """
    from twistcore.review import Review
    from twistcore.review.replay import (
        accepted_motion,
        correctable_intervals,
        uncorrected_chain_sentences,
    )

    chains, review = found.chains_and_limbs, Review.of(found)
    review.accept(parameters.min_confidence, include_open=parameters.include_open)
    refined = accepted_motion(clip, chains, review.state)
    applied = correctable_intervals(clip.motion, chains, review.accepted)
    return (
        refined,
        len(applied),
        list(uncorrected_chain_sentences(clip.motion, chains, review.accepted)),
    )
