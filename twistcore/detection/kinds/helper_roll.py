"""Helper rolls: a helper bone rolls by a wrong angle. See `helper_rolls.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="helper roll",
    label="Helper rolls",
    place=30,
    repair="roll",  # never automatic, because the confidence was not measured
    here="helper roll {frames} of {joint} ({size})",
    happens="{part} rolls",
    quantity="twistcore.detection.quantities.helper_roll:roll_of_helper",
)
