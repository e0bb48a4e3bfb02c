"""From the bytes of a clip to its result document, and to its corrected bytes where asked."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis import ALL_KINDS, Detection, analyse
from twistcore.batch.how_bad import severity, unchecked
from twistcore.batch.parameters import Parameters
from twistcore.bvh import Clip, changed_rotations, parse_bvh, patch_rotations
from twistcore.chain import uncorrectable_joints
from twistcore.detection import Kind
from twistcore.detection.cuts import border_notes
from twistcore.errors import TwistError
from twistcore.export.detection_json import intervals_to_json, tau_to_json
from twistcore.quality.figure_quality import figure_quality
from twistcore.rig import AS_FOUND, rig_from_json

SCHEMA = "twistcore.batch_clip/1"


def processed(
    data: bytes, name: str, parameters: Parameters
) -> tuple[dict[str, Any], bytes | None]:
    """The document of a clip, without its name, and its corrected bytes or None; raises TwistError.

    A pure function: the same bytes give the same document in every process.
    """
    clip = parse_bvh(data, name, fps=parameters.fps)
    found = _detected(clip, parameters)
    document = _document(clip, found)
    if not parameters.refine:
        return document, None
    corrected, applied, skipped = _corrected(clip, found, parameters)
    document["warnings"] += skipped
    document["applied"] = applied
    if corrected == data:
        document["left"] = document["intervals"]
    else:
        again = parse_bvh(corrected, name, fps=parameters.fps)
        document["left"] = intervals_to_json(_detected(again, parameters))
    return document, corrected


def _detected(clip: Clip, parameters: Parameters) -> Detection:
    rig = AS_FOUND if parameters.rig is None else rig_from_json(parameters.rig)
    analysis = analyse(clip, list(parameters.chains) or None, rig)
    kinds = [Kind(kind) for kind in parameters.kinds] or ALL_KINDS
    tau: float | Mapping[str, float] | None = None
    if parameters.tau_deg is not None:
        tau = math.radians(parameters.tau_deg)
    if parameters.profile_rad is not None:
        given = {} if tau is None else {c.name: tau for c in analysis.chains}
        names = {c.name for c in analysis.chains_and_limbs}
        tau = given | {k: v for k, v in parameters.profile_rad.items() if k in names}
    return analysis.detect(parameters.method, kinds=kinds, tau_radians=tau)


def _document(clip: Clip, found: Detection) -> dict[str, Any]:
    motion, chains = clip.motion, found.chains_and_limbs
    wrong = np.zeros(motion.frames, dtype=np.bool_)
    offsets = [np.zeros(0)]
    for interval in found:
        if interval.repairable:
            wrong[interval.start : interval.stop] = True
            offsets.append(np.degrees(np.abs(interval.offset)))
    degrees = np.concatenate(offsets)
    counts = Counter(interval.kind for interval in found)
    quality = figure_quality(motion)
    return {
        "schema": SCHEMA,
        "sha256": clip.sha256,
        "format": Path(clip.name).suffix.lower().removeprefix(".") or "bvh",
        "frames": motion.frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "joints": len(motion.skeleton),
        "method": found.method,
        "tau_deg": tau_to_json(found),
        "intervals": intervals_to_json(found),
        "counts": {kind.value: counts[kind] for kind in Kind},
        "affected_frames": int(wrong.sum()),
        "severity": severity(found, motion.frames),
        "degrees": {
            "max": float(degrees.max(initial=0.0)),
            "rms": float(np.sqrt(np.mean(degrees**2))) if len(degrees) else 0.0,
        },
        "chains": [chain.name for chain in chains],
        "unchecked": "" if len(found) else unchecked(motion, chains),
        "warnings": [
            *map(str, clip.warnings),
            *border_notes(motion),
            *(warning for chain in found.chains for warning in chain.warnings),
        ],
        "applied": None,
        "left": None,
        "quality": {k: v for k, v in asdict(quality).items() if v is not None} if quality else {},
    }


def _corrected(
    clip: Clip, found: Detection, parameters: Parameters
) -> tuple[bytes, int, list[str]]:
    """The corrected bytes, how many intervals are out of them, and what could not be corrected."""
    from twistcore.export.replay import accepted_motion
    from twistcore.review import Review

    chains, review = found.chains_and_limbs, Review.of(found)
    review.accept(parameters.min_confidence, include_open=parameters.include_open)
    refined = accepted_motion(clip, chains, review.state)
    used = {interval.chain for interval in review.accepted}
    skipped = {
        chain.name: f"{chain.name} was not corrected: {', '.join(joints)} "
        "without three rotation channels"
        for chain in chains
        if chain.name in used and (joints := uncorrectable_joints(clip.motion, chain))
    }
    applied = sum(interval.chain not in skipped for interval in review.accepted)
    data = patch_rotations(clip, refined, changed_rotations(clip, refined))
    return data, applied, list(skipped.values())
