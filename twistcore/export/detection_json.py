"""Convert the intervals of a clip to the JSON format of `detect --json` and of batch results."""

from __future__ import annotations

import math
from typing import Any

from twistcore.analysis.clip_analysis import Detection


def intervals_to_json(found: Detection, *, explain: bool = False) -> list[dict[str, Any]]:
    """Return one JSON entry for each interval.

    Set `explain` to True to include the residual and the evidence (docs/formats.md).
    """
    return found.to_rows(explain=explain)


def detection_tau_degrees(found: Detection) -> dict[str, float]:
    """Return the detection threshold τ in degrees, keyed by the name of the chain or limb."""
    return {name: math.degrees(t) for name, t in found.tau.items()}
