"""Backward bends: a knee or an elbow bends against its hinge. See `backward_bends.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="backward bend",
    label="Backward bends",
    place=44,
    of_capture=True,
    weight=1.0,
    lasting=True,
    find="twistcore.detection.backward_bends:find_backward_bends",
    corrected=True,
    colour="warning",
    sign="±",
    size="backward_deg",
    here="backward bend {frames} of {joint} ({size})",
    named="the backward bend of {joint} in {span} ({size})",
    legend="bends backward by {size}",
    tip="{joint} bends backward by {size}; this is not corrected",
    why="{joint} bends backward by {size}; in most of the clip it bends to the other side",
    quantity="twistcore.detection.quantities.backward_bend:flexion_of_hinge",
)
