"""Place jumps: the position of the root, or of a joint with position channels, jumps.

See `all_joints/`.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="place jump",
    label="Place jumps",
    place=46,
    of_capture=True,
    weight=1.0,
    sign="",
    size="way_percent",
    find="twistcore.detection.all_joints.finders:find_place_jumps",
    colour="warning",
    here="place jump {frames} of {joint}",
    happens="{part} jumps to another position",
    named="the place jump of {joint} in {span}",
    legend="the position jumps",
    tip="the position of {joint} jumps; this is not corrected",
    why="The position of {joint} jumps in one frame",
    quantity="twistcore.detection.quantities.place_jump:way_off_path",
)
