"""The intervals of a clip as `detect --json` and a batch's results have them."""

from __future__ import annotations

import math
from typing import Any

from twistcore.analysis.clip_analysis import Detection


def intervals_to_json(found: Detection, *, explain: bool = False) -> list[dict[str, Any]]:
    """One entry an interval; explain: with what is left over and the evidence (docs/formats.md)."""
    return found.to_rows(explain=explain)


def detection_tau_degrees(found: Detection) -> dict[str, float]:
    """τ in degrees by the name of a chain or limb."""
    return {name: math.degrees(t) for name, t in found.tau.items()}
