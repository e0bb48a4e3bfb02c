"""Stretches: a joint rotates suddenly about its bone and stays rotated. See `stretches.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="stretch",
    label="Stretches",
    place=41,
    of_capture=True,
    lasting=True,
    repairer="twistcore.analysis.correction.joint_repairs:TURN_BACK",
    turns=True,
    below=True,
    find="twistcore.detection.stretches:find_stretches",
    corrected=True,
    colour="warning",
    size="turn_deg",
    here="stretch {frames} with {joint} rotated ({size})",
    happens="{part} stays rotated",
    named="the stretch of {joint} in {span} ({size})",
    legend="is rotated by {angle}",
    tip=(
        "{joint} turns suddenly about its own bone and does not turn back. Accept the "
        "detection to turn the joint back"
    ),
    why="Between two jumps, or between a jump and an end of the clip, {joint} is rotated by {size}",
    offer=(
        "Accept the detection to turn {joint} back in all these frames. This is never done "
        "automatically"
    ),
    quantity="twistcore.detection.quantities.stretch:roll_from_usual",
)
