"""Spikes: a joint leaves its path for a few frames and returns to it. See `all_joints/`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="spike",
    label="Spikes",
    place=43,
    of_capture=True,
    sign="±",
    size="angle_deg",
    find="twistcore.detection.all_joints.finders:find_spikes",
    repairer="twistcore.analysis.correction.joint_repairs:BRIDGE",
    corrected=True,
    colour="warning",
    here="spike {frames} of {joint} ({size})",
    happens="{part} leaves its path",
    named="the spike of {joint} in {span} ({size})",
    legend="spike of {size}",
    tip=(
        "{joint} is wrong by {size} and then returns to its path. Accept the detection to "
        "replace these frames"
    ),
    why="{joint} leaves its path by {size} and returns at once; no body can do this",
    offer="Accept the detection to interpolate {joint} between the frames before and after it. "
    "All joints below move with it. This is never done automatically",
    quantity="twistcore.detection.quantities.spike:angle_off_path",
)
