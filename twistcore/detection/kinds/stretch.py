"""Stretches: a joint turns suddenly about its own bone and keeps the error. See `stretches.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="stretch",
    label="Stretches",
    short="stretch",
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
    here="stretch {frames} in which {joint} stays turned ({size})",
    happens="{part} stays turned",
    named="the stretch of {joint} in {span} ({size})",
    legend="stays turned by {angle}",
    tip="{joint} jumps about its own bone and stays turned; accept it to turn the joint back",
    why="{joint} stays turned about its own bone by {size}, from one jump to the next",
    offer="Accepting it turns {joint} back in all these frames; this is never done automatically",
    quantity="twistcore.detection.quantities.stretch:roll_from_usual",
)
