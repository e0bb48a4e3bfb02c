"""Measure jitter, foot slide and deviation of a whole figure without ground truth [Le26 §4.3].

Positions of the 24 SMPL joints have the shape (frames, 24, 3) and are in millimetres at 25 Hz.
Joint 0 is the root.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.formats.smpl.skeleton import ANKLES, TOES, find_network_joints, metres_per_unit
from twistcore.quamo.resample import network_sample_times
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array, vector_lengths
from twistcore.work.frozen import dataclass

SLIDE_MM = 20.0
CONTACT_MM = 30.0


@dataclass(frozen=True)
class FigureQuality:
    """Quality measures of a figure. A high value does not prove an error.

    Parameters
    ----------
    deviation
        Mean distance from the input after aligning the roots, mm. None for the input itself.
    jitter
        Mean magnitude of the third difference of positions, mm per frame³.
    foot_slide
        Percentage of frame pairs in which a foot slides, as in :func:`foot_slide`. Ground contact
        is estimated from the motion.
    """

    deviation: float | None
    jitter: float
    foot_slide: float


def quality_of_positions(places: Array, given: Array | None = None) -> FigureQuality:
    """Measure the quality of positions (frames, 24, 3) in mm.

    `given` contains the positions before a correction, from which the deviation is measured.
    """
    third = np.diff(places, n=3, axis=0)
    return FigureQuality(
        None
        if given is None
        else mean_distance_between_positions(
            positions_relative_to_root(places), positions_relative_to_root(given)
        ),
        float(vector_lengths(third).mean()) if len(third) else 0.0,
        foot_slide(places, foot_contact_mask(places)),
    )


def quality_before_and_after(
    before: Motion, after: Motion, unit: float | None = None
) -> tuple[FigureQuality, FigureQuality] | None:
    """Measure the quality before and after a correction, at 25 Hz in mm.

    The result is None if the skeleton lacks any of SMPL's 24 joints. `unit` is the file's length
    unit in metres, or None if it is unknown.
    """
    try:
        topology, scale = (
            find_network_joints(before.skeleton),
            metres_per_unit(before.skeleton, unit),
        )
    except TwistError:
        return None
    times = network_sample_times(before.frames, before.frame_time)
    given, found = (_places_mm(m, topology.joints, times, scale) for m in (before, after))
    return quality_of_positions(given), quality_of_positions(found, given)


def measure_body_motion_quality(motion: Motion) -> FigureQuality | None:
    """Measure the quality of a motion, at 25 Hz in mm.

    The result is None if the skeleton lacks any of SMPL's 24 joints.
    """
    try:
        topology, scale = (
            find_network_joints(motion.skeleton),
            metres_per_unit(motion.skeleton, None),
        )
    except TwistError:
        return None
    times = network_sample_times(motion.frames, motion.frame_time)
    return quality_of_positions(_places_mm(motion, topology.joints, times, scale))


def foot_contact_mask(places: Array) -> NDArray[np.bool_]:
    """Return a mask of the frames in which each foot is on the ground, (frames, 2).

    A foot is on the ground if its ankle and its toe are less than 3 cm above ground level. Ground
    level is the 2nd percentile of height over the clip, separately for each ankle and toe.
    """
    out = np.ones((len(places), 2), dtype=np.bool_)
    for foot in range(2):
        for joint in (ANKLES[foot], TOES[foot]):
            height = places[:, joint, 1]
            out[:, foot] &= height < np.percentile(height, 2.0) + CONTACT_MM
    return out


def foot_slide(places: Array, contact: NDArray[np.bool_]) -> float:
    """Return the percentage of frame pairs in which a foot slides.

    A foot slides if it moves horizontally by at least 20 mm while it is on the ground. The
    percentages of both feet are added. `contact` comes from :func:`foot_contact_mask`.
    """
    slides = 0
    for foot in range(2):
        middle = 0.5 * (places[:, ANKLES[foot]] + places[:, TOES[foot]])[:, [0, 2]]
        moved = vector_lengths(np.diff(middle, axis=0))
        slides += int(((moved >= SLIDE_MM) & contact[1:, foot] & contact[:-1, foot]).sum())
    return 100.0 * slides / max(len(places) - 1, 1)


def positions_relative_to_root(places: Array) -> Array:
    """Return the positions shifted so that the root is at the origin in each frame."""
    return places - places[:, :1]


def mean_distance_between_positions(a: Array, b: Array) -> float:
    """Return the mean distance between positions (…, 3), or 0 if there are none."""
    return float(vector_lengths(a - b).mean()) if len(a) else 0.0


def _places_mm(motion: Motion, joints: NDArray[np.int64], times: Array, scale: float) -> Array:
    low = np.floor(times).astype(np.intp)
    high = np.minimum(low + 1, motion.frames - 1)
    # Only frames next to a sample are computed, which is about half of the frames in most captures.
    below, above = (forward_kinematics(motion.at(k))[1][:, joints] for k in (low, high))
    share = (times - low)[:, None, None]
    return 1000.0 * scale * (below + share * (above - below))
