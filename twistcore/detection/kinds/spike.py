"""Spikes: a joint leaves its path for a few frames and comes back. See `all_joints/`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="spike",
    label="Spikes",
    short="spike",
    place=42,
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
    tip="{joint} is off by {size} and comes back; accept it to replace these frames",
    why="{joint} leaves its path by {size} and comes back at once, as no body does",
    offer="Accepting it moves {joint} evenly from the frame before to the frame after, and with it "
    "all joints below; this is never done automatically",
    quantity="twistcore.detection.quantities.spike:angle_off_path",
)
