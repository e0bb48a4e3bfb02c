"""Turned ends: a foot or hand is also rotated during a limb flip. See `turned_ends.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="turned end",
    label="Turned ends",
    place=42,
    of_capture=True,
    lasting=True,
    sign="±",
    size="turn_deg",
    find="twistcore.detection.turned_ends:find_turned_ends",
    repairer="twistcore.analysis.correction.joint_repairs:PUT_BACK",
    corrected=True,
    colour="warning",
    here="turned end {frames}: {joint} is turned during a flip ({size})",
    happens="{part} is turned during a flip",
    named="the turned end {joint} in {span} ({size})",
    legend="is turned by {size}",
    tip=(
        "{joint} turns by {size} when the limb flips and turns back with it. Accept the "
        "detection to put the joint back"
    ),
    why="{joint} turns by {size} in the frame in which the limb flips, and back by nearly the "
    "same rotation in the frame in which the flip ends",
    offer=(
        "Accept the detection to turn {joint} back by the mean rotation at both ends of the flip. "
        "All joints below move with it. This is never done automatically"
    ),
    quantity="twistcore.detection.quantities.turned_end:angle_from_before",
)
