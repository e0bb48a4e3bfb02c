"""Frozen frames: a limb does not move at all for a while. See `frozen_frames.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="frozen frames",
    label="Frozen frames",
    place=60,
    of_capture=True,
    weight=0.0,
    sign="",
    counted="frozen span",
    here="frozen frames {frames} of {joint}",
    happens="{part} is frozen",
    named="the frozen span of {joint} in {span}",
    legend="does not move",
    tip="the limb does not move at all; this is not corrected",
    find="twistcore.detection.capture_faults:find_frozen",
)
