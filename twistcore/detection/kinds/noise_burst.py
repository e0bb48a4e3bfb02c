"""Noise bursts: joints jitter more than any body can for a while. See `noise_bursts.py`."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="noise burst",
    label="Noise bursts",
    place=50,
    of_capture=True,
    weight=0.0,
    sign="±",
    size="sigma_deg",
    here="noise burst {frames} of {joint}",
    happens="{part} jitters",
    named="the noise burst of {joint} in {span}",
    legend="noise of {size}",
    tip="{joint} has noise of {size}; this is not corrected",
    find="twistcore.detection.capture_faults:find_bursts",
    quantity="twistcore.detection.quantities.noise_burst:noise_of_joint",
)
