"""Measure how well injected errors were corrected, and what else was changed [Choi26 §4.2]."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import ClipMismatchError
from twistcore.files.document_values import format_value_for_message
from twistcore.skeleton.chain import SEGMENTS, Chain
from twistcore.skeleton.limb import Limb, find_limbs
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, geodesic_angle
from twistcore.synthesis import SUCCESS, Truth, inject

DAMAGE = float(np.radians(1.0))
# Frames with a smaller offset are neither error frames nor clean frames. They occur where a
# filtered or drifting error begins or crosses 0, but not with level shifts.
COUNTED = float(np.radians(0.5))
_ORDER = (*SEGMENTS, "whole arm", "whole leg")


@dataclass(frozen=True, eq=False)
class ErrorFrames:
    """The errors of one chain in its error frames.

    Attributes
    ----------
    side, segment
        Side and segment of the chain.
    before, after
        Errors before and after the correction, radians in [0, π], shape (error frames,).
    """

    side: str
    segment: str
    before: Array
    after: Array


@dataclass(frozen=True, eq=False)
class Sample:
    """The measurements of one clip.

    Attributes
    ----------
    errors
        The errors of each chain.
    clean_change
        Changes of all clean (joint, frame) pairs, radians, shape (pairs,).
    """

    errors: tuple[ErrorFrames, ...]
    clean_change: Array


@dataclass(frozen=True)
class EvaluationRow:
    """The measurements of one body segment. The fields are named as in the JSON document.

    Attributes
    ----------
    side, segment
        Side and segment.
    frames
        Number of error frames.
    mae_before_deg, mae_after_deg
        Mean error before and after the correction, degrees.
    rmse_before_deg, rmse_after_deg
        Root mean square error before and after the correction, degrees.
    rer_percent
        Share of the error that remains [Choi26 §4.2.2].
    fsr_percent
        Share of error frames that are repaired [Choi26 §4.2.1].
    """

    side: str
    segment: str
    frames: int
    mae_before_deg: float = 0.0
    mae_after_deg: float = 0.0
    rmse_before_deg: float = 0.0
    rmse_after_deg: float = 0.0
    rer_percent: float = 0.0
    fsr_percent: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """The evaluation of one or more clips.

    Attributes
    ----------
    rows
        A row for each side and segment.
    overall
        The row for all error frames.
    damage_share
        Percentage of clean (joint, frame) pairs that changed by more than 1°.
    damage_mean
        Mean change of clean pairs, degrees.
    """

    rows: tuple[EvaluationRow, ...]
    overall: EvaluationRow
    damage_share: float
    damage_mean: float


def measure_corrected_clip(
    truth: Truth, clean: Motion, refined: Motion, chains: Sequence[Chain]
) -> Sample:
    """Compare a corrected clip with its clean source.

    The clip with errors is reconstructed from the clean clip and the truth, so that only changes
    made by the correction count as damage.

    Parameters
    ----------
    truth
        The injected errors.
    clean, refined
        The clean and the corrected motion.
    chains
        The chains of the clip, from which its limbs are found.

    Raises
    ------
    ClipMismatchError
        If the clips and the truth do not belong together.
    """
    if clean.frames != refined.frames or clean.frames != truth.frames:
        raise ClipMismatchError(
            f"expected three versions of the same clip, but the truth has {truth.frames} "
            f"frames, the clean clip {clean.frames} and the refined clip {refined.frames}"
        )
    if clean.skeleton.names != refined.skeleton.names:
        raise ClipMismatchError("the clean and the refined clip have different skeletons")
    every = (*chains, *find_limbs(clean, chains))
    by_name = {chain.name: chain for chain in every}
    unknown = sorted({e.chain for e in truth.errors} - by_name.keys())
    if unknown:
        raise ClipMismatchError(
            f"the truth file has a chain {format_value_for_message(unknown[0])}, which the clip "
            "does not have"
        )
    dirty = inject(clean, every, truth.errors)
    wrong = np.zeros((clean.frames, len(clean.skeleton)), dtype=bool)
    frames_of: dict[tuple[str, tuple[int, ...]], set[int]] = {}
    for error in truth.errors:
        chain = by_name[error.chain]
        counted = error.start + np.flatnonzero(np.abs(error.offset) >= COUNTED)
        measured = chain.name, error.measured_joints(chain)
        frames_of.setdefault(measured, set()).update(counted.tolist())
        wrong[error.start : error.stop, error.changed_joints(chain, clean.skeleton)] = True
    errors = []
    for (name, turned), frames in frames_of.items():
        chain, at = by_name[name], sorted(frames)
        errors.append(
            ErrorFrames(
                chain.side,
                body_segment_of_chain(chain),
                error_angle(clean.rotations[at], dirty.rotations[at], turned),
                error_angle(clean.rotations[at], refined.rotations[at], turned),
            )
        )
    joints = joints_with_possible_errors(every)
    change = geodesic_angle(dirty.rotations[:, joints], refined.rotations[:, joints])
    return Sample(tuple(errors), change[~wrong[:, joints]])


def error_angle(clean: Array, other: Array, joints: Sequence[int]) -> Array:
    """Return the largest angle between the rotations of some joints in two clips, in each frame.

    `clean` and `other` have the shape (frames, joints, 4). The result is in radians, (frames,).
    """
    at = list(joints)
    return np.asarray(geodesic_angle(clean[:, at], other[:, at]).max(axis=1))


def summarise_samples(samples: Iterable[Sample]) -> Evaluation:
    """Return the evaluation of any number of clips. All error frames have the same weight."""
    samples = tuple(samples)
    every = [e for sample in samples for e in sample.errors]
    places = sorted(
        {(e.side, e.segment) for e in every}, key=lambda p: (p[0], body_segment_sort_key(p[1]))
    )
    rows = tuple(
        _row(*place, [e for e in every if (e.side, e.segment) == place]) for place in places
    )
    change = np.concatenate([s.clean_change for s in samples]) if samples else np.zeros(0)
    return Evaluation(
        rows=rows,
        overall=_row("", "Overall", every),
        damage_share=100.0 * float((change > DAMAGE).mean()) if len(change) else 0.0,
        damage_mean=float(np.degrees(change.mean())) if len(change) else 0.0,
    )


def joints_with_possible_errors(chains: Sequence[Chain]) -> NDArray[np.int64]:
    """Return the sorted indices of the joints that errors can rotate.

    These are the parents and children of chains, and the first joints and ends of limbs.
    """
    ends = {(c.parent, c.end if isinstance(c, Limb) else c.child) for c in chains}
    return np.array(sorted({joint for pair in ends for joint in pair}), dtype=np.int64)


def body_segment_of_chain(chain: Chain) -> str:
    """Return a chain's body segment for tables, such as 'Leg', or 'whole leg' for a limb."""
    if isinstance(chain, Limb) and chain.segment:
        return f"whole {chain.part.removeprefix(chain.side).strip()}"
    return chain.segment or chain.name


def body_segment_sort_key(segment: str) -> tuple[int, str]:
    """Return a key that sorts segments: first SEGMENTS, then whole limbs, then others by name."""
    return _ORDER.index(segment) if segment in _ORDER else len(_ORDER), segment


def _row(side: str, segment: str, errors: Sequence[ErrorFrames]) -> EvaluationRow:
    before = np.degrees(np.concatenate([e.before for e in errors])) if errors else np.zeros(0)
    after = np.degrees(np.concatenate([e.after for e in errors])) if errors else np.zeros(0)
    if not len(before):
        return EvaluationRow(side, segment, 0)
    mae_before, mae_after = float(before.mean()), float(after.mean())
    return EvaluationRow(
        side=side,
        segment=segment,
        frames=len(before),
        mae_before_deg=mae_before,
        mae_after_deg=mae_after,
        rmse_before_deg=float(np.sqrt((before**2).mean())),
        rmse_after_deg=float(np.sqrt((after**2).mean())),
        rer_percent=100.0 * mae_after / mae_before if mae_before else 0.0,
        fsr_percent=100.0 * float((after <= SUCCESS * before).mean()),
    )


def evaluation_to_json(evaluation: Evaluation) -> dict[str, Any]:
    """Return the evaluation as a JSON document, in degrees and per cent."""
    return {
        "schema": "twistcore.evaluation/1",
        "rows": [vars(row) for row in evaluation.rows],
        "overall": vars(evaluation.overall),
        "clean_damage_percent": evaluation.damage_share,
        "clean_change_mean_deg": evaluation.damage_mean,
    }


def evaluation_to_text(evaluation: Evaluation) -> str:
    """Return the evaluation as a text table in the layout of [Choi26 Table 2].

    The overall row is the last one.
    """
    head = f"{'Side':<6} {'Segment':<12} {'Frames':>7} {'MAE before':>11} {'MAE after':>10} "
    head += f"{'RMSE after':>11} {'RER %':>7} {'FSR %':>7}"
    lines = [head, "-" * len(head)]
    lines += [
        f"{r.side:<6} {r.segment:<12} {r.frames:>7} {r.mae_before_deg:>10.2f}° "
        f"{r.mae_after_deg:>9.2f}° {r.rmse_after_deg:>10.2f}° {r.rer_percent:>7.2f} "
        f"{r.fsr_percent:>7.2f}"
        for r in (*evaluation.rows, evaluation.overall)
    ]
    lines.append(
        f"Clean-frame damage: {evaluation.damage_share:.3f} % of the clean (joint, frame) pairs "
        f"changed by more than 1°; mean change {evaluation.damage_mean:.4f}°."
    )
    return "\n".join(lines)


def match_intervals(
    found: Sequence[tuple[int, int]], true: Sequence[tuple[int, int]]
) -> dict[int, int]:
    """Match intervals one to one. Return the matched indices as {index in found: index in true}.

    Intervals are [start, stop). Two match if their intersection over union is at least 0.5. The
    pairs with the largest overlap are matched first.
    """
    if not found or not true:
        return {}
    f, t = np.array(found)[:, None], np.array(true)[None]
    shared = np.minimum(f[..., 1], t[..., 1]) - np.maximum(f[..., 0], t[..., 0])
    overlap = shared / (np.maximum(f[..., 1], t[..., 1]) - np.minimum(f[..., 0], t[..., 0]))
    matched: dict[int, int] = {}
    for flat in np.argsort(-overlap, axis=None, kind="stable"):
        i, j = (int(k) for k in np.unravel_index(flat, overlap.shape))
        if overlap[i, j] < 0.5:
            break
        if i not in matched and j not in matched.values():
            matched[i] = j
    return matched
