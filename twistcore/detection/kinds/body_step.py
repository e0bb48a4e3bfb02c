"""Body steps: many joints jump in the same frame. See `all_joints/`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="body step",
    label="Body steps",
    place=48,
    of_capture=True,
    whole_body=True,
    weight=1.0,
    sign="±",
    size="angle_deg",
    find="twistcore.detection.all_joints.finders:find_body_steps",
    colour="warning",
    here="body step {frames} ({size})",
    happens="The whole body jumps",
    named="the body step in {span} ({size})",
    legend="jumps by {size}",
    tip="many joints jump at once, by a median of {size}; this is not corrected",
    why="Many joints jump in the same frame, by a median of {size}",
    quantity="twistcore.detection.quantities.body_step:turn_of_body",
)
