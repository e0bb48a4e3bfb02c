"""Joint jumps: a joint rotates about any axis in a single step between calm frames.

See `all_joints/`.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="joint jump",
    label="Joint jumps",
    place=45,
    of_capture=True,
    sign="±",
    size="angle_deg",
    find="twistcore.detection.all_joints.finders:find_joint_jumps",
    corrected=True,
    colour="warning",
    here="joint jump {frames} of {joint} ({size})",
    happens="{part} jumps",
    named="the joint jump of {joint} in {span} ({size})",
    legend="jumps by {size}",
    tip="{joint} jumps by {size} in one frame; this is not corrected",
    why="{joint} jumps by {size} in one frame and is steady before and after it",
    quantity="twistcore.detection.quantities.joint_jump:turn_per_frame",
)
