"""The settings with which QuaMo tracks or smooths a clip, as they are stored in sessions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from twistcore.errors import FormatError
from twistcore.files.document_values import (
    check_bool,
    check_choice,
    check_integer,
    check_keys,
    check_number,
    check_positive_number,
    check_string,
    check_string_list,
    read_each,
)
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Tracking:
    """The joints to track or smooth after the twist correction, and the settings.

    Parameters
    ----------
    joints
        The joints' names, in the skeleton's order. Empty if only the position is tracked.
    kp, kd, ka
        The gains κP (1/s²), κD (1/s) and κA, unless `learned` is True.
    learned
        True to use gains from the included networks.
    weights
        The first 16 digits of the SHA-256 of the networks' file, or '' for gains set by hand.
    causal
        True to track only forward in time, False to track forward and backward.
    place
        True to track the position of the figure as well.
    spline
        True to smooth with a spline, which has no gains, instead of tracking.
    cutoff
        The cut-off frequency of the spline in Hz.
    bursts
        The joint and the frames [start, stop) of each noise burst to smooth. Empty to smooth the
        whole clip.
    """

    joints: tuple[str, ...]
    kp: float = 600.0
    kd: float = 15.0
    ka: float = 0.0
    learned: bool = False
    weights: str = ""
    causal: bool = True
    place: bool = False
    spline: bool = False
    cutoff: float = 0.0
    bursts: tuple[tuple[str, int, int], ...] = ()

    @property
    def what(self) -> str:
        """A short description of the tracked parts, such as '2 joints and the position'."""
        joints = self.joints[0] if len(self.joints) == 1 else f"{len(self.joints)} joints"
        if self.bursts:
            count = len({(start, stop) for _, start, stop in self.bursts})
            return f"{joints} in one burst" if count == 1 else f"{joints} in {count} bursts"
        return " and ".join((joints,) * bool(self.joints) + ("the position",) * self.place)


def tracking_to_json(tracking: Tracking) -> dict[str, Any]:
    """Return the tracking settings as JSON data."""
    smooth = {"cutoff": tracking.cutoff, "bursts": [list(burst) for burst in tracking.bursts]}
    return {
        "joints": list(tracking.joints),
        "gains": "spline" if tracking.spline else "learned" if tracking.learned else "hand",
        "kp": tracking.kp,
        "kd": tracking.kd,
        "ka": tracking.ka,
        "weights": tracking.weights,
        "causal": tracking.causal,
        "place": tracking.place,
        **(smooth if tracking.spline else {}),
    }


def tracking_from_json(entry: Any) -> Tracking:
    """Convert JSON data to tracking settings. Raises FormatError if they are damaged."""
    check_keys(entry, "joints", "gains", "kp", "kd", "ka", "weights", what="tracking")
    joints = check_string_list(entry["joints"], "joints")
    causal = check_bool(
        entry.get("causal", True), "causal"
    )  # the first files lack this key and the next
    place = check_bool(entry.get("place", False), "place")
    if not (joints or place):
        raise FormatError("expected joints to track, found an empty list")
    gains = check_choice(entry["gains"], "gains", ("hand", "learned", "spline"))
    kp, kd, ka = (check_number(entry[key], key) for key in ("kp", "kd", "ka"))
    weights = check_string(entry["weights"], "weights")
    found = Tracking(joints, kp, kd, ka, gains == "learned", weights, causal, place)
    if gains != "spline":
        return found
    check_keys(entry, "cutoff", "bursts", what="tracking")
    cutoff = check_positive_number(entry["cutoff"], "cutoff")
    bursts = read_each(entry["bursts"], what="bursts", read=_burst_from_json)
    if not {name for name, _, _ in bursts} <= set(joints):
        raise FormatError("expected noise bursts only in joints that are tracked")
    return replace(found, spline=True, cutoff=cutoff, bursts=bursts)


def _burst_from_json(entry: Any) -> tuple[str, int, int]:
    """Convert JSON data to a noise burst: joint, start and stop. Raises FormatError."""
    if not (isinstance(entry, list) and len(entry) == 3):
        raise FormatError("expected a joint, a start and a stop for each burst")
    start, stop = (check_integer(frame, "bursts") for frame in entry[1:])
    if start >= stop:
        raise FormatError(f"expected a burst that starts before it stops, found {start} and {stop}")
    return check_string(entry[0], "bursts"), start, stop
