"""The angles of a frame that the user has edited, for display in the plots."""

from __future__ import annotations

from inspector.teaching.taught_frame import TaughtFrame


def what_if_angles(taught: TaughtFrame) -> dict[str, float]:
    """Return the angles of an edited frame in radians, keyed by the field names of TwistSignals.

    Undefined angles are omitted. If the frame is not edited, or during an animation, the result is
    empty.
    """
    d = taught.quantities if taught.active and taught.what_if.changes else None
    if d is None or (taught.stage is not None and taught.stage < 2.0):
        return {}
    out: dict[str, float] = {}
    if d.swing_is_one:
        out["theta_p"] = d.theta_p
    if d.dtheta_p_is_defined:
        out["dtheta_p"] = d.dtheta_p
    if d.dtheta_c_is_defined:
        out["dtheta_c"] = d.dtheta_c
    if d.strength_is_defined:
        out["strength"] = d.strength
    return out
