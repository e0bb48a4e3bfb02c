"""What the plots are told of an altered frame: plain numbers."""

from __future__ import annotations

from inspector.teaching.gizmo_shapes import UNDEFINED
from inspector.teaching.taught_frame import TaughtFrame


def plotted(taught: TaughtFrame) -> dict[str, float]:
    """Angles of the what-if in radians, by the names of TwistSignals; {} as captured.

    What is undefined is missing. While a rotation is on its way nothing is compared.
    """
    d = taught.quantities if taught.active and taught.what_if.changes else None
    if d is None or (taught.stage is not None and taught.stage < 2.0):
        return {}
    out: dict[str, float] = {}
    if d.swing_reliability >= UNDEFINED:
        out |= {"theta_p": d.theta_p, "dtheta_p": d.dtheta_p}
    if d.azimuth_reliability >= UNDEFINED:
        out["dtheta_c"] = d.dtheta_c
    if len(out) == 3:
        out["strength"] = d.strength
    return out
