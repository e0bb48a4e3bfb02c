"""Lone jumps: a joint rotates impossibly fast about its axis, and no other error explains it.

See `lone_jumps.py`.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="lone jump",
    label="Lone jumps",
    place=40,
    size="turn_deg",
    here="lone jump {frames} of {joint} ({size})",
    happens="{part} jumps",
    named="the lone jump of {joint} in {span} ({size})",
    legend="jumps by {angle}",
    tip="{joint} turns suddenly about its own axis; this is not corrected",
    find="twistcore.detection.lone_jumps:find_lone_jumps",
    corrected=True,
    quantity="twistcore.detection.quantities.lone_jump:turn_about_axis",
)
