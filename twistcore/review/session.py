"""The session file: a review that can be closed, reopened and replayed without the program."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from twistcore.atomic import write_atomically
from twistcore.clip import Clip
from twistcore.detection import Interval, Kind
from twistcore.encoding import json_bytes
from twistcore.errors import FormatError, TwistError
from twistcore.file_kinds import JSON, SESSION, found_instead
from twistcore.ordinary_files import read_file
from twistcore.review.left_out import spans_from_json
from twistcore.review.model import Decision, Judged, ReviewState, Tracking, in_order
from twistcore.rig import AS_FOUND, rig_from_json, rig_to_json

SCHEMA = "twistcore.session/1"
# A session that tracks: a program that knows nothing of it must not replay the rest.
TRACKING_SCHEMA = "twistcore.session/2"
# A session with limbs: a program that knows none would take their flips for twists. Or with other
# chains than found, whose intervals it would not know.
LIMBS_SCHEMA = "twistcore.session/3"
# A session that tracks both ways or the place: a program that knows neither would track otherwise.
BOTH_WAYS_SCHEMA = "twistcore.session/4"
_SCHEMAS = (SCHEMA, TRACKING_SCHEMA, LIMBS_SCHEMA, BOTH_WAYS_SCHEMA)
_WITH_KINDS = (LIMBS_SCHEMA, BOTH_WAYS_SCHEMA)
# What an interval under review has beside the interval, its id and the decision, as files list it.
_JUDGED = {
    **dict.fromkeys(("by_hand", "edited", "supported"), bool),
    **dict.fromkeys(("reviewer", "decided_at", "note", "reason"), str),
}
_ENDLESS = 100_000_000  # no clip has as many frames: a damaged number, not a wish for memory


@dataclass(frozen=True, eq=False)
class Session:
    """A review and the clip it belongs to: the path as saved and the SHA-256 of its bytes."""

    clip: str
    sha256: str
    fps: float
    state: ReviewState


def session_document(clip: Clip, state: ReviewState) -> dict[str, Any]:
    """The session as a JSON document; angles in degrees with nine decimals, times in frames.

    The oldest schema that can say it: older programs read what has nothing new in it.
    """
    tracking = state.tracking
    otherwise = tracks_otherwise(tracking)
    kinds = otherwise or bool(state.rig) or _needs_kinds(clip, state)
    document = {
        "schema": LIMBS_SCHEMA if kinds else SCHEMA,
        "clip": str(clip.path.absolute()),
        "sha256": clip.sha256,
        "fps": clip.motion.fps,
        "method": state.method,
        "tau_deg": tau_to_json(state.tau),
        "next_id": state.next_id,
        "intervals": [judged_to_json(j, kinds=kinds) for j in state.intervals],
    }
    if state.rig:
        document["rig"] = rig_to_json(state.rig)
    if state.left_out:  # changes nothing that is replayed: an older program may leave it
        document["left_out"] = [list(span) for span in state.left_out]
    if tracking is not None:
        document["tracking"] = tracking_to_json(tracking)
        if not kinds:
            document["schema"] = TRACKING_SCHEMA
        elif otherwise:
            document["schema"] = BOTH_WAYS_SCHEMA
    return document


def _needs_kinds(clip: Clip, state: ReviewState) -> bool:
    """Whether anything is no counter-twist, or is τ of a limb, whose name is no joint's."""
    joints = set(clip.motion.skeleton.names)
    of_limb = any(name not in joints for name in state.tau)
    return of_limb or any(j.interval.kind != Kind.COUNTER_TWIST for j in state.intervals)


def session_bytes(clip: Clip, state: ReviewState) -> bytes:
    """The session file's bytes."""
    return json_bytes(session_document(clip, state))


def write_session(path: Path, clip: Clip, state: ReviewState) -> None:
    """Write the session, atomically."""
    write_atomically(path, session_bytes(clip, state))


def read_session(path: Path) -> Session:
    """Read a session; raises TwistError or FormatError in one sentence."""
    return read_session_file(path)[0]


def read_session_file(path: Path) -> tuple[Session, str]:
    """The same, and the SHA-256 of the bytes that were read."""
    try:
        data = read_file(path)
    except FileNotFoundError:
        raise TwistError(f"{path}: expected a session file, but there is no such file") from None
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    try:
        if instead := found_instead(data, SESSION, JSON):
            raise FormatError(instead)
        session = session_from_document(json.loads(data))
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: expected JSON ({error})") from None
    return session, hashlib.sha256(data).hexdigest()


def session_from_document(document: Any) -> Session:
    """A session from its JSON document; FormatError says what is missing or wrong."""
    if not isinstance(document, Mapping) or document.get("schema") not in _SCHEMAS:
        raise FormatError(f"expected a document with schema {', '.join(map(repr, _SCHEMAS))}")
    try:
        tracking = _tracking_of(document)
        fps = float(document["fps"])
        if not (math.isfinite(fps) and fps > 0.0):
            raise ValueError(f"fps {fps}")
        tau = tau_from_json(document["tau_deg"])
        if not all(math.isfinite(t) and t > 0.0 for t in tau.values()):
            raise ValueError("a τ that is not above 0")
        kinds = document["schema"] in _WITH_KINDS
        intervals = tuple(judged_from_json(j, kinds=kinds) for j in document["intervals"])
        ids = [j.id for j in intervals]
        if len(set(ids)) != len(ids) or any(k >= int(document["next_id"]) for k in ids):
            raise ValueError("an interval's id")
        state = ReviewState(
            method=str(document["method"]),
            tau=MappingProxyType(tau),
            intervals=intervals,
            next_id=int(document["next_id"]),
            chain_order=in_order(tau),
            tracking=tracking,
            rig=rig_from_json(document["rig"]) if kinds and "rig" in document else AS_FOUND,
            left_out=spans_from_json(document.get("left_out", ())),
        )
        return Session(str(document["clip"]), str(document["sha256"]), fps, state)
    except (KeyError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise FormatError(f"{error} is missing or of the wrong kind") from None


def _tracking_of(document: Mapping[str, Any]) -> Tracking | None:
    """What is tracked, where the document's schema says that there is such a thing."""
    schema = document["schema"]
    may_be = schema in _WITH_KINDS and document.get("tracking") is not None
    return tracking_from_json(document["tracking"]) if schema == TRACKING_SCHEMA or may_be else None


def degrees_to_json(radians: float) -> float:
    """Degrees with nine decimals; −0.0, which a rounded trace of an angle may be, is 0.0."""
    return round(float(np.degrees(radians)), 9) + 0.0


def tau_to_json(tau: Mapping[str, float]) -> dict[str, float]:
    """τ in degrees, by the name of a chain or limb."""
    return {name: degrees_to_json(t) for name, t in tau.items()}


def tau_from_json(entry: Mapping[str, Any]) -> dict[str, float]:
    """The reverse; AttributeError or TypeError where it is damaged."""
    return {name: float(np.radians(t)) for name, t in entry.items()}


def tracks_otherwise(tracking: Tracking | None) -> bool:
    """Whether it tracks both ways or the place.

    The first programs that track know neither: they would leave the keys that say so.
    """
    return tracking is not None and (tracking.place or not tracking.causal)


def tracking_to_json(tracking: Tracking) -> dict[str, Any]:
    """What is tracked, and how."""
    return {
        "joints": list(tracking.joints),
        "gains": "learned" if tracking.learned else "hand",
        "kp": tracking.kp,
        "kd": tracking.kd,
        "ka": tracking.ka,
        "weights": tracking.weights,
        "causal": tracking.causal,
        "place": tracking.place,
    }


def tracking_from_json(entry: Mapping[str, Any]) -> Tracking:
    """The reverse; KeyError, TypeError or ValueError where it is damaged."""
    entry = {"causal": True, "place": False, **entry}  # which the first files did not have
    joints, gains, causal, place = (entry[k] for k in ("joints", "gains", "causal", "place"))
    for name, value in (("causal", causal), ("place", place)):
        if not isinstance(value, bool):
            raise TypeError(name)
    if not (isinstance(joints, list) and all(isinstance(j, str) for j in joints)):
        raise TypeError("a list of joints to track")
    if not (joints or place):
        raise ValueError("a list of joints to track")
    if gains not in ("hand", "learned"):
        raise ValueError(f"gains {gains!r}")
    kp, kd, ka = (float(entry[key]) for key in ("kp", "kd", "ka"))
    if not all(map(math.isfinite, (kp, kd, ka))):
        raise ValueError("a gain that is not finite")
    learned, weights = gains == "learned", str(entry["weights"])
    return Tracking(tuple(joints), kp, kd, ka, learned, weights, causal, place)


def interval_to_json(interval: Interval, *, kinds: bool = False) -> dict[str, Any]:
    """An interval with its offset in degrees: one number, or one for every frame.

    kinds: also say of a counter-twist that it is one.
    """
    degrees = [degrees_to_json(offset) for offset in interval.offset]
    entry = {
        "chain": interval.chain,
        "start": interval.start,
        "stop": interval.stop,
        "offset_deg": degrees[0] if len(set(degrees)) == 1 else degrees,
        "confidence": interval.confidence,
        "open": interval.open,
        "residual_deg": degrees_to_json(interval.residual),
    }
    if kinds or interval.kind != Kind.COUNTER_TWIST:
        entry |= {"kind": interval.kind.value, "carried": interval.carried, "joint": interval.joint}
    return entry


def interval_from_json(entry: Mapping[str, Any]) -> Interval:
    """The reverse; KeyError, TypeError or ValueError where it is damaged."""
    start, stop = entry["start"], entry["stop"]
    if not (isinstance(start, int) and isinstance(stop, int) and 0 <= start < stop < _ENDLESS):
        raise ValueError(f"an interval from {start} to {stop}")
    if not isinstance(entry["chain"], str):
        raise TypeError("a chain")
    offset = np.radians(np.broadcast_to(np.asarray(entry["offset_deg"], float), (stop - start,)))
    if not np.isfinite(offset).all():
        raise ValueError("an offset that is not finite")
    confidence, residual = entry["confidence"], float(np.radians(entry["residual_deg"]))
    if not (math.isfinite(residual) and (confidence is None or math.isfinite(confidence))):
        raise ValueError("a number that is not finite")
    kind, carried = entry.get("kind", Kind.COUNTER_TWIST), entry.get("carried", False)
    if kind not in list(Kind):
        raise ValueError(f"kind {kind!r}")
    if not isinstance(joint := entry.get("joint", ""), str):
        raise TypeError("joint")
    for name, value in (("open", entry["open"]), ("carried", carried)):
        if not isinstance(value, bool):
            raise TypeError(name)
    return Interval(
        entry["chain"],
        start,
        stop,
        offset,
        confidence=confidence,
        open=entry["open"],
        residual=residual,
        kind=Kind(kind),
        carried=carried,
        joint=joint,
    )


def judged_to_json(judged: Judged, *, kinds: bool = False) -> dict[str, Any]:
    """An interval under review; kinds: as :func:`interval_to_json`."""
    return {
        "id": judged.id,
        **interval_to_json(judged.interval, kinds=kinds),
        "decision": judged.decision.value,
        **{key: getattr(judged, key) for key in _JUDGED},
        **({"in_bulk": True} if judged.in_bulk else {}),  # an older program may leave it
    }


def judged_from_json(entry: Mapping[str, Any], *, kinds: bool = False) -> Judged:
    """The reverse; KeyError, TypeError or ValueError where it is damaged.

    kinds: a counter-twist, too, must say that it is one.
    """
    entry = {"reason": "", **entry}  # which the first files did not have
    if kinds and not {"kind", "carried"} <= entry.keys():
        raise KeyError("kind or carried")
    for key, kind in _JUDGED.items():
        if not isinstance(entry[key], kind):
            raise TypeError(key)
    if not isinstance(in_bulk := entry.get("in_bulk", False), bool):
        raise TypeError("in_bulk")
    return Judged(
        int(entry["id"]),
        interval_from_json(entry),
        Decision(entry["decision"]),
        **{key: entry[key] for key in _JUDGED},
        in_bulk=in_bulk,
    )
