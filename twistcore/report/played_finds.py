"""Collect the motion around the worst intervals, for a clip's page to play."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from twistcore.analysis.correction.twist_removal import refiner
from twistcore.detection import Interval
from twistcore.files.packed_numbers import encode_base64_array
from twistcore.report.curve_drawing import frames_around, interval_severity
from twistcore.report.document import Report
from twistcore.review.model import Decision, Judged, Span
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass

MOST_BYTES = 2_150_000  # for figure, motion and labels, so that a page has at most 3 MB
_LONGEST = 4.0  # seconds that are played of one interval
_TURN, _PLACE = 4 * 2, 3 * 4  # bytes of a rotation and of a position
_BASE64 = 4 / 3
_BODY, _TEXTS = 8_000, 2_500  # bytes for the shape of each joint, and for each interval's labels


@dataclass(frozen=True, eq=False)
class PlayedFind:
    """An interval with the motion to play.

    Attributes
    ----------
    judged
        The interval.
    span
        The frames [start, stop) to play.
    frame
        The frame to show first.
    joints
        Indices of the joints that the correction rotates.
    after
        The corrected motion in these frames.
    """

    judged: Judged
    span: Span
    frame: int
    joints: tuple[int, ...]
    after: Motion


def pictured_frame(interval: Interval) -> int:
    """Return the frame of an interval to show in a picture.

    It is in the middle of the frames with at least 90 % of the largest offset.
    """
    size = np.abs(interval.offset)
    there = np.flatnonzero(size >= 0.9 * size.max())
    return interval.start + int(there[len(there) // 2])


def merge_applied_intervals(report: Report, *also: Interval) -> list[Interval]:
    """Return the applied intervals of a report, followed by those in `also`, without duplicates."""
    return [*(i for i in report.applied if all(i is not own for own in also)), *also]


def select_intervals_to_play(
    report: Report, most: int = MOST_BYTES
) -> tuple[list[PlayedFind], list[Judged]]:
    """Return the worst intervals that fit into `most` bytes of a page, and the other intervals.

    Rejected intervals are considered last. Frames that are in several intervals are counted once.
    """
    motion, names = report.clip.motion, {chain.name for chain in report.chains}
    moving = _moving(motion)
    per_frame = _BASE64 * (_TURN * len(motion.skeleton) + _PLACE * len(moving))
    taken, finds, out = np.zeros(motion.frames, np.bool_), [], []
    left = float(most - _BODY * len(motion.skeleton))
    for judged in sorted(report.state.intervals, key=_urgency):
        if judged.interval.chain not in names:
            continue
        span = _span(judged.interval, motion)
        find = _find(report, judged, span)
        after = _BASE64 * _TURN * len(find.joints) * (span[1] - span[0])
        cost = _TEXTS + per_frame * np.count_nonzero(~taken[slice(*span)]) + after
        if cost <= left:
            left -= cost
            taken[slice(*span)] = True
            finds.append(find)
        else:
            out.append(judged)
    return finds, out


def player_script_data(
    report: Report, finds: Sequence[PlayedFind], player: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the data for the script that plays intervals on the page, without any names.

    The data has the same form as on lesson pages. `player` is the figure as in :class:`Drawn`.
    Rotations are quaternions of 16-bit numbers, which the script scales to length 1.
    """
    spans = _joined([find.span for find in finds])
    pages = [
        {
            **view,
            "span": next(k for k, span in enumerate(spans) if find.span[1] <= span[1]),
            "chain": None,
            "first": find.span[0],
            "last": find.span[1] - 1,
            "frame": find.frame,
            "start": find.judged.interval.start,
            "offset": np.degrees(find.judged.interval.offset).round(1).tolist(),
            "curve": frames_around(find.judged.interval, report.clip.motion),
            "accepted": find.judged.decision == Decision.ACCEPTED,
            "after": _after(find),
        }
        for find, view in zip(finds, player["views"], strict=True)
    ]
    return {
        **{key: player[key] for key in ("themes", "ghost")},
        "figures": [player["figure"]],
        "spans": [_span_data(report.clip.motion, span) for span in spans],
        "chains": [],
        "pages": pages,
    }


def _urgency(judged: Judged) -> tuple[bool, float, int]:
    return judged.decision == Decision.REJECTED, -interval_severity(judged), judged.interval.start


def _moving(motion: Motion) -> list[int]:
    """Return the columns of `motion.positions` that vary over the frames."""
    return list(map(int, np.flatnonzero(np.ptp(motion.positions, axis=0).any(axis=-1))))


def _span(interval: Interval, motion: Motion) -> Span:
    start, stop = frames_around(interval, motion)
    most = round(_LONGEST * motion.fps)
    if stop - start > most:
        start = max(start, pictured_frame(interval) - most // 2)
        stop = min(stop, start + most)
    return start, stop


def _find(report: Report, judged: Judged, span: Span) -> PlayedFind:
    """Return an interval with its corrected motion.

    If the interval was not applied, the motion is corrected as if the interval had been accepted.
    """
    motion, interval = report.clip.motion.sliced(*span), judged.interval
    if any(interval is own for own in report.applied):
        after = report.refined.sliced(*span)
    elif interval.correctable:
        intervals = merge_applied_intervals(report, interval)
        after = refiner(report.clip.motion, report.chains, intervals)(*span)
    else:
        after = motion
    turned = np.flatnonzero((after.rotations != motion.rotations).any(axis=(0, 2)))
    return PlayedFind(judged, span, pictured_frame(interval), tuple(turned.tolist()), after)


def _joined(spans: Sequence[Span]) -> list[Span]:
    """Return the spans sorted, with adjacent and overlapping spans merged."""
    out: list[Span] = []
    for start, stop in sorted(spans):
        if out and start <= out[-1][1]:
            start, before = out.pop()
            stop = max(stop, before)
        out.append((start, stop))
    return out


def _span_data(motion: Motion, span: Span) -> dict[str, Any]:
    own, moving = motion.sliced(*span), _moving(motion)
    offsets = motion.skeleton.offsets.copy()
    offsets[list(motion.positioned)] = motion.positions[0]
    return {
        "figure": 0,
        "first": span[0],
        "fps": motion.fps,
        "offsets": offsets.round(6).tolist(),
        "moving": [motion.positioned[k] for k in moving],
        "rotations": _turns(own.rotations),
        "positions": encode_base64_array(own.positions[:, moving], "f4"),
    }


def _after(find: PlayedFind) -> dict[str, Any] | None:
    if not find.joints:
        return None
    rotations = _turns(find.after.rotations[:, list(find.joints)])
    return {"joints": list(find.joints), "first": find.span[0], "rotations": rotations}


def _turns(rotations: Any) -> dict[str, str]:
    return encode_base64_array(np.rint(32767.0 * rotations), "i2")
