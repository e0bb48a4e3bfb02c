"""Convert the report on a clip to a JSON document, and its intervals to CSV."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, field
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.twist_removal import children_off_axis, joints_lacking_channels
from twistcore.detection import Interval, Kind
from twistcore.export.compare import Difference, compare_motions, joint_position_change_to_json
from twistcore.files.encoding import csv_text
from twistcore.files.version import __version__
from twistcore.formats.clip import Clip
from twistcore.quamo.track_clip import find_figure_position_joint
from twistcore.quamo.tracking_settings import tracking_to_json
from twistcore.report.changes import MeasureSum, sum_correction_effects_on_measures
from twistcore.review.model import APPLIED, SEEN, Decision, Judged, ReviewState
from twistcore.review.replay import (
    uncorrected_and_moved_joint_sentences,
    unknown_error_kind_sentences,
)
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notes import NOT_EXAMINED, Note
from twistcore.work.frozen import dataclass

SCHEMA = "twistcore.report/1"
_TRACKED = "tracking"  # a reason why a joint moved
NOT_CORRECTABLE = "not correctable"  # verdict on an accepted interval that is still in the clip
# The value of each column for an interval, as a function of the interval and the frame rate. The
# report fills in `decision` and `stuck`.
_COLUMNS: Mapping[str, Callable[[Judged, float], Any]] = {
    "id": lambda j, _: j.id,
    "chain": lambda j, _: j.interval.chain,
    "start": lambda j, _: j.interval.start,
    "stop": lambda j, _: j.interval.stop,
    "frames": lambda j, _: j.interval.frames,
    "start_s": lambda j, fps: round(j.interval.start / fps, 4),
    "delta_deg": lambda j, _: round(float(np.degrees(j.reported.size)), 4),
    "confidence": lambda j, _: j.interval.confidence,
    "open": lambda j, _: j.interval.open,
    "decision": lambda *_: "",
    "reviewer": lambda j, _: j.reviewer,
    "decided_at": lambda j, _: j.decided_at,
    "note": lambda j, _: j.note,
    "kind": lambda j, _: j.interval.kind.value,
    "end": lambda j, _: _end(j),
    "joint": lambda j, _: j.interval.joint,
    "speed_deg_s": lambda j, fps: _speed(j.interval, fps),
    "stuck": lambda *_: "",
    "reason": lambda j, _: j.reason,
}


@dataclass(frozen=True, eq=False)
class Report:
    """The data of a report on a clip.

    Attributes
    ----------
    clip
        The clip before the correction.
    chains
        The examined chains and limbs.
    state
        The state of the review.
    refined
        The corrected motion.
    name
        Name of the report's files. By default, it is the name of the clip's file.
    files
        SHA-256 of other files written with the report, keyed by name.
    by, at
        The person who requested the report, and the time (ISO 8601).
    analysis
        An existing analysis of the clip with these chains, or None.
    written
        The file with the corrected clip, which is compared with the source, or None.
    parameters
        The processing parameters.
    left
        Intervals in the corrected clip, as in `detect --json`. By default, they are detected.
    """

    clip: Clip
    chains: Sequence[Chain]
    state: ReviewState
    refined: Motion
    name: str = ""
    files: Mapping[str, str] = field(default_factory=dict)
    by: str = ""
    at: str = field(default_factory=lambda: datetime.now(UTC).isoformat(timespec="seconds"))
    analysis: ClipAnalysis | None = None
    written: Path | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    left: Sequence[Mapping[str, Any]] | None = None

    @cached_property
    def analysed(self) -> ClipAnalysis:
        """Return `analysis`, or a new analysis of the clip with `chains`."""
        return self.analysis or ClipAnalysis(
            self.clip.motion, self.chains, self.clip.name, self.state.rig
        )

    @property
    def not_examined(self) -> str:
        """Return the reason why nothing in the clip could be examined, or ''."""
        return "" if self.state.intervals else self.analysed.not_examined

    @property
    def notes(self) -> tuple[Note, ...]:
        """Return notes about the analysis of the clip."""
        notes = self.analysed.notes
        return tuple(n for n in notes if n.kind != NOT_EXAMINED or self.not_examined)

    @cached_property
    def stuck(self) -> Mapping[int, tuple[str, ...]]:
        """Return the joints that prevent the correction of intervals, keyed by interval id.

        These joints do not have three rotation channels.
        """
        by_name, motion = {chain.name: chain for chain in self.chains}, self.clip.motion
        found = {
            j.id: joints_lacking_channels(motion, by_name[j.interval.chain], [j.interval])
            for j in self.state.intervals
            if j.counts and j.interval.chain in by_name
        }
        return {k: joints for k, joints in found.items() if joints}

    @property
    def applied(self) -> tuple[Interval, ...]:
        """Return the accepted intervals that could be corrected."""
        return tuple(
            j.interval for j in self.state.intervals if j.corrects and j.id not in self.stuck
        )

    @cached_property
    def protected(self) -> tuple[MeasureSum, ...]:
        """Return how the corrections changed each protected measure (:class:`MeasureSum`)."""
        finds = [j.interval for j in self.state.intervals if j.interval.repairable]
        return sum_correction_effects_on_measures(
            self.clip.motion, self.chains, self.applied, finds
        )

    @property
    def not_corrected(self) -> tuple[str, ...]:
        """Return sentences about accepted intervals that could not be corrected.

        The sentences do not contain folder names.
        """
        sentences, _ = uncorrected_and_moved_joint_sentences(
            self.clip, self.chains, self.state.chosen()
        )
        sentences += unknown_error_kind_sentences(self.clip, self.state)
        return tuple(sentence.removeprefix(f"{self.clip.path}: ") for sentence in sentences)

    def verdict(self, judged: Judged) -> str:
        """Return the verdict to show, or 'not correctable' for an accepted interval in `stuck`."""
        if judged.decision == Decision.ACCEPTED and judged.id in self.stuck:
            return NOT_CORRECTABLE
        return judged.verdict


def report_to_json(report: Report) -> dict[str, Any]:
    """Return the report as a JSON document, in degrees, seconds and frames.

    Some keys are:

    - tracking: the joints tracked after the correction and the settings, as in a session, or null
    - changed: the frames in which any rotation or position channel differs, the joints whose
      rotations differ, and the joints that moved, with the distance and the reason
    - protected: the changes of the measures that a correction must not make worse
    """
    motion, state = report.clip.motion, report.state
    difference = compare_motions(motion, report.refined)
    return {
        "schema": SCHEMA,
        "program": f"twistcore {__version__}",
        "written_at": report.at,
        "written_by": report.by,
        "clip": report.clip.name,
        "sha256": report.clip.sha256,
        "frames": motion.frames,
        "missing_frames": report.clip.missing_frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "method": state.method,
        "decisions": {
            verdict: sum(report.verdict(j) == verdict for j in state.intervals)
            for verdict in (*(d.value for d in Decision), SEEN, APPLIED, NOT_CORRECTABLE)
        },
        "reviewers": _reviewers(state),
        "chains": [
            {
                "chain": chain.name,
                "label": chain.label,
                "kind": (Kind.LIMB_FLIP if isinstance(chain, Limb) else Kind.COUNTER_TWIST).value,
                "tau_deg": float(np.degrees(state.tau[chain.name])),
                "intervals": len(state.of_chain(chain.name)),
                "warnings": list(chain.warnings),
            }
            for chain in report.chains
            if chain.name in state.tau
        ],
        "not_examined": report.not_examined or None,
        "unexamined": [limb.to_json() for limb in report.analysed.unexamined],
        "intervals": [_row(j, report) for j in state.intervals],
        "tracking": state.tracking and tracking_to_json(state.tracking),
        "changed": {
            "frames": _frames_changed(report, difference),
            "joints": sorted({j.joint for j in difference.joints}),
            "max_deg": max((j.max_degrees for j in difference.joints), default=0.0),
            "max_position_of_height": difference.max_position_of_height,
            "moved": [
                joint_position_change_to_json(move) | {"why": _why_moved(report, move.joint)}
                for move in difference.moved
            ],
            "rest_of_height": difference.rest_of_height,
        },
        "protected": [asdict(one) for one in report.protected],
        "warnings": [
            *map(str, (*report.clip.warnings, *report.notes)),
            *report.not_corrected,
        ],
    }


def _reviewers(state: ReviewState) -> list[dict[str, Any]]:
    """Return each reviewer's number of decisions, and the times of the first and the last one.

    Decisions without a reviewer's name are counted under the name ''.
    """
    by_name: dict[str, list[str]] = {}
    for judged in state.intervals:
        if judged.decision != Decision.UNDECIDED and (judged.reviewer or judged.decided_at):
            by_name.setdefault(judged.reviewer, []).append(judged.decided_at)
    return [
        {
            "reviewer": name,
            "decisions": len(times),
            "first": min(filter(None, times), default=""),
            "last": max(times),
        }
        for name, times in sorted(by_name.items())
    ]


def intervals_csv(report: Report) -> str:
    """Return the intervals as CSV, one per line, in degrees and seconds.

    The column `tracked_after` has the joints of the interval's chain that were tracked after the
    correction.
    """
    rows = [
        _row(j, report) | {"tracked_after": _tracked(j, report)} for j in report.state.intervals
    ]
    return csv_text((*_COLUMNS, "tracked_after"), rows)


def _tracked(judged: Judged, report: Report) -> str:
    tracking, names = report.state.tracking, report.clip.motion.skeleton.names
    chain = next((c for c in report.chains if c.name == judged.interval.chain), None)
    if tracking is None or chain is None:
        return ""
    ends = (chain.parent, chain.end if isinstance(chain, Limb) else chain.child)
    return " ".join(names[j] for j in ends if names[j] in tracking.joints)


def _end(judged: Judged) -> str:
    """Return 'carried' if an error also rotated the limb's end or the joints below, else 'kept'.

    The result is '' for kinds of errors without this distinction.
    """
    interval = judged.interval
    if interval.kind == Kind.LIMB_FLIP or (judged.corrects and interval.kind.info.below):
        return "carried" if interval.carried else "kept"
    return ""


def _speed(interval: Interval, fps: float) -> float | None:
    """Return the speed of a lone jump in degrees per second, or None for other kinds of errors."""
    if interval.kind != Kind.LONE_JUMP:
        return None
    return round(abs(float(np.degrees(interval.size))) * fps, 1)


def _frames_changed(report: Report, difference: Difference) -> int:
    """Return the number of frames in which rotations or positions differ."""
    turned = {t for j in difference.joints for t in range(j.start, j.stop)}
    before, after = report.clip.motion.positions, report.refined.positions
    placed = np.flatnonzero((before != after).any(axis=(1, 2)))
    return len(turned.union(placed.tolist()))


def _replaced_positions(report: Report) -> list[str]:
    """Return phrases such as 'the position of Hips' for joints with changed position channels."""
    motion = report.clip.motion
    other = (motion.positions != report.refined.positions).any(axis=(0, 2))
    joints = np.array(motion.positioned, dtype=np.intp)[other]
    return [f"the position of {motion.skeleton.names[j]}" for j in joints]


def _ancestors(report: Report, joint: str) -> set[int]:
    """Return the indices of all ancestors of a joint."""
    skeleton, above = report.clip.motion.skeleton, set[int]()
    parent = int(skeleton.parents[skeleton.index(joint)])
    while parent >= 0:
        above.add(parent)
        parent = int(skeleton.parents[parent])
    return above


def _is_below_tracked(report: Report, joint: str) -> bool:
    """Return True if the rotation of an ancestor of the joint was tracked with QuaMo."""
    tracking, index = report.state.tracking, report.clip.motion.skeleton.index
    tracked = map(index, tracking.joints) if tracking else ()
    return not _ancestors(report, joint).isdisjoint(tracked)


def _follows_place(report: Report, joint: str) -> bool:
    """Return True if the position of the joint or of one of its ancestors was tracked."""
    tracking, motion = report.state.tracking, report.clip.motion
    if tracking is None or not tracking.place:
        return False
    return find_figure_position_joint(motion) in {
        motion.skeleton.index(joint),
        *_ancestors(report, joint),
    }


def _why_moved(report: Report, joint: str) -> str:
    """Return the reasons why a joint moved, separated by commas, or ''.

    The reasons are the kinds of corrected errors, and tracking.
    """
    chosen, why = report.applied, []
    at, above = report.clip.motion.skeleton.index(joint), _ancestors(report, joint)
    for chain in report.chains:
        own = [i for i in chosen if i.chain == chain.name and i.repairable]
        if own and _moves(report.clip.motion, chain, own, at, above):
            why.append(own[0].kind.value)
    names = report.clip.motion.skeleton.names
    alone = sorted((i for i in chosen if i.kind.info.repairer), key=lambda i: i.kind.info.place)
    why += [i.kind.value for i in alone if i.joint in {names[j] for j in above}]
    if _is_below_tracked(report, joint) or _follows_place(report, joint):
        why.append(_TRACKED)
    return ", ".join(dict.fromkeys(why))


def _moves(
    motion: Motion, chain: Chain, chosen: Sequence[Interval], joint: int, above: set[int]
) -> bool:
    """Return True if the correction of a chain or limb moves a joint.

    Correcting a limb flip moves the joints below the limb's first joint, except its end. It moves
    the joints below the end only if the end was rotated with the limb. `above` are all ancestors of
    `joint`.
    """
    if isinstance(chain, Limb):
        below = chain.end in above and not any(i.carried for i in chosen)
        return chain.parent in above and joint != chain.end and not below
    off_axis = children_off_axis(motion, chain)
    return any(motion.skeleton.names[j] in off_axis for j in (joint, *above))


def _row(judged: Judged, report: Report) -> dict[str, Any]:
    fps = report.clip.motion.fps
    row = {name: of(judged, fps) for name, of in _COLUMNS.items()}
    row["decision"] = report.verdict(judged)
    row["stuck"] = " ".join(report.stuck.get(judged.id, ()))
    if person := next((c.person for c in report.chains if c.name == judged.interval.chain), ""):
        row["person"] = person
    return row


def moved_joints_for_page(document: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """Return the moved joints as the page lists them, for the template.

    Returns
    -------
    dict
        `placed` has phrases about joints whose position channels changed, and `moved` has the moved
        joints. If the position of a joint was tracked, `along` is this joint, with the largest move
        and number of frames among the joints that only follow it. These joints are not in `moved`.
    """
    moved = document["changed"]["moved"]
    along = [
        move
        for move in moved
        if move["why"] == _TRACKED
        and _follows_place(report, move["joint"])
        and not _is_below_tracked(report, move["joint"])
    ]
    moves: dict[str, Any] = {
        "placed": _replaced_positions(report),
        "moved": [move for move in moved if move not in along],
        "along": None,
    }
    if along:  # the tracked joint comes first
        most = {key: max(move[key] for move in along) for key in ("max_of_height", "frames")}
        moves["along"] = {"joint": along[0]["joint"], **most}
    return moves
