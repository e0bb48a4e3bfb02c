"""Intervals and thresholds τ as JSON data, as in sessions and journals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from twistcore.detection.interval import Interval, Kind
from twistcore.errors import FormatError
from twistcore.files.document_values import (
    DEGREES,
    check_bool,
    check_keys,
    check_number,
    check_positive_number,
    check_string,
    read_frame_span,
    unexpected_value_error,
)
from twistcore.skeleton.rotation import Array


def radians_to_json_degrees(radians: float) -> float:
    """Convert an angle from radians to degrees with nine decimals. −0.0 becomes 0.0."""
    return round(float(np.degrees(radians)), 9) + 0.0


def tau_to_json(tau: Mapping[str, float]) -> dict[str, float]:
    """Return τ in degrees as JSON data, keyed by the name of the chain or limb."""
    return {name: radians_to_json_degrees(t) for name, t in tau.items()}


def tau_from_json(entry: Any) -> dict[str, float]:
    """Return τ in radians, keyed by name, from JSON data in degrees. Raises FormatError."""
    degrees = {
        name: check_positive_number(t, "tau_deg")
        for name, t in check_keys(entry, what="tau_deg").items()
    }
    return {
        check_string(name, "tau_deg"): math.radians(min(t, DEGREES)) for name, t in degrees.items()
    }


def interval_to_json(interval: Interval, *, kinds: bool = False) -> dict[str, Any]:
    """Return an interval as JSON data.

    The offset, in degrees, is one number if it is constant, or a list with one number per frame. If
    `kinds` is True, the kind is written even for a counter-twist.
    """
    degrees = [radians_to_json_degrees(offset) for offset in interval.offset]
    entry = {
        "chain": interval.chain,
        "start": interval.start,
        "stop": interval.stop,
        "offset_deg": degrees[0] if len(set(degrees)) == 1 else degrees,
        "confidence": interval.confidence,
        "open": interval.open,
        "residual_deg": radians_to_json_degrees(interval.residual),
    }
    if kinds or interval.kind != Kind.COUNTER_TWIST:
        entry |= {"kind": interval.kind.value, "carried": interval.carried, "joint": interval.joint}
    return entry


def interval_from_json(entry: Any) -> Interval:
    """Convert JSON data to an interval. Raises FormatError if it is damaged.

    A constant offset takes up the memory of a single number, because frame numbers in a damaged
    file may be huge.
    """
    check_keys(entry, "chain", "start", "stop", "offset_deg", "confidence", "open", "residual_deg")
    start, stop = read_frame_span(entry)
    confidence = entry["confidence"]
    return Interval(
        check_string(entry["chain"], "chain"),
        start,
        stop,
        _offset(entry["offset_deg"], stop - start),
        confidence=None if confidence is None else check_number(confidence, "confidence"),
        open=check_bool(entry["open"], "open"),
        residual=math.radians(
            check_number(entry["residual_deg"], "residual_deg", -DEGREES, DEGREES)
        ),
        kind=_kind(entry.get("kind", Kind.COUNTER_TWIST.value)),
        carried=check_bool(entry.get("carried", False), "carried"),
        joint=check_string(entry.get("joint", ""), "joint"),
    )


def _kind(entry: Any) -> Kind:
    """Return the kind of error that a name stands for. It may be unknown to this program version.

    Raises FormatError if the name is not a string or is not spelled exactly as expected.
    """
    if not check_string(entry, "kind").strip():
        raise unexpected_value_error("a string", "kind", entry)
    if (kind := Kind(entry)) != entry:  # any other spelling counts as damage
        raise unexpected_value_error(repr(kind.value), "kind", entry)
    return kind


def _offset(entry: Any, frames: int) -> Array:
    """Convert an offset in degrees, one number or one per frame, to radians, shape (frames,)."""
    listed = entry if isinstance(entry, list) else [entry]
    degrees = [check_number(one, "offset_deg", -DEGREES, DEGREES) for one in listed]
    if len(degrees) not in (1, frames):
        raise FormatError(f"expected {frames} numbers for offset_deg, found {len(degrees)}")
    return np.broadcast_to(np.radians(degrees), (frames,))
