"""Compute the severity of a clip's errors, and list the limbs that were not examined."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from twistcore.analysis.clip_analysis import Detection
from twistcore.detection import Interval
from twistcore.skeleton.body import Unexamined
from twistcore.skeleton.chain import Chain

# Visibility of a twist error, 0…1. Twists of a collar or forearm are less visible than those of an
# upper arm.
_SHOWS = {"Arm": 1.0, "UpLeg": 1.0}
_ELSEWHERE = 0.7
_SEEN = 0.1  # seconds for which a viewer notices an edge, a jump or a spike
# A joint's error is fully visible if the body parts below the joint reach this far, as a share of
# the body height.
_REACH = 0.35


def measure_clip_severity(found: Detection) -> float:
    """Return the severity of a clip in degrees: the root mean square of all visible errors.

    The mean is over the clip's frames. The weight of an interval depends on its angle, its joint,
    its confidence, and its length plus 0.1 s. Jumps, spikes and steps are treated as 0.1 s long.
    Noise and frozen frames are ignored. Because of the squares, a knee that bends backward for a
    moment counts more than a small, uncertain error in many frames.
    """
    motion, of = found.analysis.motion, found.analysis.chain
    return severity_of_intervals(((i, of(i.chain)) for i in found), motion.frames, motion.fps)


def severity_of_intervals(
    finds: Iterable[tuple[Interval, Chain]], frames: int, fps: float
) -> float:
    """Return the severity of a clip's errors in degrees, as defined in
    :func:`measure_clip_severity`.

    `finds` contains a pair of interval and chain for each error in the clip. `frames` is the number
    of frames of the clip, and `fps` is its frame rate.
    """
    total = 0.0
    for interval, chain in finds:
        if not (weight := _shows(interval, chain)):
            continue
        shown = _degrees(interval) * weight
        counts = interval.repairable or interval.kind.info.lasting
        lasts = interval.frames * counts + _SEEN * fps
        sure = 1.0 if interval.confidence is None else interval.confidence
        total += sure * shown**2 * lasts
    return math.sqrt(total / max(frames, 1))


def _degrees(interval: Interval) -> float:
    if interval.kind.info.size == "way_percent":  # a distance
        way = (interval.evidence or {}).get("way_percent", 0.0) / 100.0
        return math.degrees(math.atan(way / _REACH))
    return abs(math.degrees(interval.shown))


def _shows(interval: Interval, chain: Chain) -> float:
    """Return how visible an error is, from 0 (invisible) to 1.

    Depending on the kind of error, the result is a constant, or it is derived from the size of the
    body parts below the joint or from the body segment of the chain.
    """
    if (weight := interval.kind.info.weight) is not None:
        return weight
    if interval.kind.of_capture and (reach := (interval.evidence or {}).get("reach")) is not None:
        return min(1.0, float(reach) / _REACH)
    return _SHOWS.get(chain.segment, _ELSEWHERE)


def percent_of_frames_with_error(affected: int, frames: int) -> float:
    """Return the percentage of frames with an error, or 0 for a clip without frames.

    `affected` is the number of frames with an error.
    """
    return 100.0 * affected / frames if frames else 0.0


def unexamined_limb_sentences(result: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a sentence for each limb that was not examined, such as 'left arm not examined: …'.

    `result` is the clip's result document.
    """
    return tuple(
        f"{_limb(entry)} not examined: {entry['why']}" for entry in result.get("unexamined") or ()
    )


def _limb(entry: Mapping[str, str]) -> str:
    return Unexamined(entry["limb"], entry["why"], person=entry.get("person", "")).title
