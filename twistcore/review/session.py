"""Read and write session files, which store a review so that it can be continued or replayed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, overload

from twistcore.detection import Interval, Kind
from twistcore.detection.interval_json import (
    interval_from_json,
    interval_to_json,
    tau_from_json,
    tau_to_json,
)
from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import (
    check_bool,
    check_choice,
    check_integer,
    check_keys,
    check_path_string,
    check_positive_number,
    check_string,
    parsed_json,
    prefix_format_errors,
    read_bytes_limited,
    read_each,
)
from twistcore.files.encoding import json_bytes
from twistcore.files.kinds import JSON, SESSION, wrong_file_kind_message
from twistcore.files.ordinary import path_exists
from twistcore.formats.clip import Clip
from twistcore.quamo.tracking_settings import Tracking, tracking_from_json, tracking_to_json
from twistcore.review.history import Review
from twistcore.review.left_out import excluded_spans_from_json
from twistcore.review.model import Decision, Judged, ReviewState, chain_index_by_name
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, rig_from_json, rig_to_json
from twistcore.work.frozen import dataclass

SCHEMA = "twistcore.session/1"
# For sessions with tracking. A program that cannot track must not replay the rest.
TRACKING_SCHEMA = "twistcore.session/2"
# For sessions with limb flips, which older programs would read as twists, or with edited chains,
# whose intervals older programs would not find.
LIMBS_SCHEMA = "twistcore.session/3"
# For sessions that track forward and backward, or that track the position. Older programs would
# track differently.
BOTH_WAYS_SCHEMA = "twistcore.session/4"
# For sessions with accepted errors of single joints, which older programs would not correct.
JOINTS_SCHEMA = "twistcore.session/5"
# For sessions that smooth with the spline, which older programs do not have.
SPLINE_SCHEMA = "twistcore.session/6"
_SCHEMAS = (SCHEMA, TRACKING_SCHEMA, LIMBS_SCHEMA, BOTH_WAYS_SCHEMA, JOINTS_SCHEMA, SPLINE_SCHEMA)
_WITH_KINDS = (LIMBS_SCHEMA, BOTH_WAYS_SCHEMA, JOINTS_SCHEMA, SPLINE_SCHEMA)
# Fields of an interval under review in addition to the interval, its id and the decision.
_JUDGED: Mapping[str, Callable[[Any, str], Any]] = {
    **dict.fromkeys(("by_hand", "edited", "supported"), check_bool),
    **dict.fromkeys(("reviewer", "decided_at", "note", "reason"), check_string),
}


@dataclass(frozen=True, eq=False)
class Session:
    """A review and its clip, as stored in a session file.

    Parameters
    ----------
    clip
        The clip's path when the session was saved.
    sha256
        The SHA-256 of the clip's bytes.
    fps
        The clip's frame rate.
    state
        The state of the review.
    """

    clip: str
    sha256: str
    fps: float
    state: ReviewState

    def to_correct(self, motion: Motion) -> tuple[tuple[Chain, ...], tuple[Interval, ...]]:
        """Return the chains and limbs under review in a motion, and the accepted intervals.

        An accepted interval that cannot be corrected, such as a lone jump, is excluded.
        """
        return self.state.to_correct(motion)


def session_document(clip: Clip, state: ReviewState) -> dict[str, Any]:
    """Return a session as JSON data, in which angles are in degrees with nine decimals.

    The oldest possible schema is used, so that older programs can read any session that uses no
    newer features.
    """
    tracking = state.tracking
    extended = tracks_place_or_both_ways(tracking)
    kinds = extended or bool(state.rig) or _needs_kinds(clip, state)
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
    if state.left_out:  # does not affect a replay, so older programs may ignore it
        document["left_out"] = [list(span) for span in state.left_out]
    if tracking is not None:
        document["tracking"] = tracking_to_json(tracking)
        if not kinds:
            document["schema"] = TRACKING_SCHEMA
        elif extended:
            document["schema"] = BOTH_WAYS_SCHEMA
    if any(j.corrects and not j.interval.repairable for j in state.intervals):
        document["schema"] = JOINTS_SCHEMA
    if tracking is not None and tracking.spline:
        document["schema"] = SPLINE_SCHEMA
    return document


def _needs_kinds(clip: Clip, state: ReviewState) -> bool:
    """Return True if the review needs a newer schema than the first ones.

    The first schemas store only counter-twists, and only τ of chains, not of limbs.
    """
    joints = set(clip.motion.skeleton.names)
    of_limb = any(name not in joints for name in state.tau)
    return of_limb or any(j.interval.kind != Kind.COUNTER_TWIST for j in state.intervals)


def session_bytes(clip: Clip, state: ReviewState) -> bytes:
    """Return the contents of a session file."""
    return json_bytes(session_document(clip, state))


@overload
def write_session(clip: Clip, review: Review | ReviewState, path: str | Path) -> None: ...


@overload  # the order of the arguments up to version 0.2
def write_session(clip: str | Path, review: Clip, path: Review | ReviewState) -> None: ...


def write_session(
    clip: Clip | str | Path,
    review: Review | ReviewState | Clip,
    path: str | Path | Review | ReviewState,
) -> None:
    """Write a review of a clip to a session file, from which it can be continued or replayed.

    Arguments in the order of earlier versions, ``(path, clip, state)``, are also accepted.

    Parameters
    ----------
    clip : Clip
        The clip that was reviewed.
    review : Review or ReviewState
        The decisions.
    path : str or Path
        The file to write, usually ``NAME.twist.json`` next to the clip. An existing file is
        replaced atomically.

    Raises
    ------
    TypeError
        If an argument has an unsupported type.
    OSError
        If the file cannot be written.

    See Also
    --------
    read_session : Read a session.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> review = tc.Review(tc.detect(clip))
    >>> review.accept()
    8
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tc.write_session(clip, review, Path(folder) / "walk.twist.json")
    ...     session = tc.read_session(Path(folder) / "walk.twist.json")
    >>> session.state
    <ReviewState by consistency: 8 of 8 decided>
    """
    if isinstance(clip, str | Path):
        clip, review, path = review, path, clip  # type: ignore[assignment]
    state = getattr(review, "state", review)
    if not (isinstance(clip, Clip) and isinstance(state, ReviewState)):
        wrong = state if isinstance(clip, Clip) else clip
        raise TypeError(f"expected a clip, a review and a path, found {wrong!r:.80}")
    write_atomically(Path(str(path)), session_bytes(clip, state))


def read_session(path: str | Path) -> Session:
    """Read a session file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Session
        The review's state, and the clip's path and SHA-256 as saved.

    Raises
    ------
    TwistError
        If the file does not exist.
    FormatError
        If the file is damaged or not a session. A FormatError is a TwistError.

    See Also
    --------
    write_session : Write a session; includes an example.

    Examples
    --------
    >>> import twistcore as tc
    >>> tc.read_session("no.twist.json")
    Traceback (most recent call last):
    twistcore.errors.TwistError: no.twist.json: expected a session file, but the file does not exist
    """
    return read_session_with_hash(Path(path))[0]


def read_session_with_hash(path: Path) -> tuple[Session, str]:
    """Return the session in a file, and the SHA-256 of the file's bytes. Raises TwistError."""
    if not path_exists(path):
        raise TwistError(f"{path}: expected a session file, but the file does not exist")
    data = read_bytes_limited(path)
    with prefix_format_errors(path):
        if instead := wrong_file_kind_message(data, SESSION, JSON):
            raise FormatError(instead)
        session = session_from_document(parsed_json(data))
    return session, hashlib.sha256(data).hexdigest()


def session_from_document(document: Any) -> Session:
    """Convert JSON data to a session. Raises FormatError if a part is missing or wrong."""
    if not isinstance(document, Mapping) or document.get("schema") not in list(_SCHEMAS):
        raise FormatError(f"expected a document with schema {', '.join(map(repr, _SCHEMAS))}")
    check_keys(document, "clip", "sha256", "fps", "method", "tau_deg", "next_id", "intervals")
    kinds = document["schema"] in _WITH_KINDS
    tau = tau_from_json(document["tau_deg"])
    intervals = read_each(
        document["intervals"], "intervals", partial(judged_from_json, kinds=kinds)
    )
    next_id, ids = check_integer(document["next_id"], "next_id"), [j.id for j in intervals]
    if len(set(ids)) != len(ids) or any(k >= next_id for k in ids):
        raise FormatError("expected intervals with different ids, all below next_id")
    state = ReviewState(
        method=check_string(document["method"], "method"),
        tau=MappingProxyType(tau),
        intervals=intervals,
        next_id=next_id,
        chain_order=chain_index_by_name(tau),
        tracking=_tracking_of(document),
        rig=rig_from_json(document["rig"]) if kinds and "rig" in document else AS_FOUND,
        left_out=excluded_spans_from_json(document.get("left_out", ())),
    )
    clip, sha256 = (
        check_path_string(document["clip"], "clip"),
        check_string(document["sha256"], "sha256"),
    )
    return Session(clip, sha256, check_positive_number(document["fps"], "fps"), state)


def _tracking_of(document: Mapping[str, Any]) -> Tracking | None:
    """Return the tracking settings of a session, or None if its schema has none."""
    schema = document["schema"]
    may_be = schema in _WITH_KINDS and document.get("tracking") is not None
    if schema == TRACKING_SCHEMA or may_be:
        return tracking_from_json(document.get("tracking"))
    return None


def tracks_place_or_both_ways(tracking: Tracking | None) -> bool:
    """Return True if tracking includes the position, or runs forward and backward in time.

    The first program versions with tracking would ignore these settings, so a session with them
    needs a newer schema.
    """
    return tracking is not None and (tracking.place or not tracking.causal)


def judged_to_json(judged: Judged, *, kinds: bool = False) -> dict[str, Any]:
    """Return an interval under review as JSON data. `kinds` is as in :func:`interval_to_json`."""
    return {
        "id": judged.id,
        **interval_to_json(judged.interval, kinds=kinds),
        "decision": judged.decision.value,
        **{key: getattr(judged, key) for key in _JUDGED},
        **({"in_bulk": True} if judged.in_bulk else {}),  # older programs may ignore it
    }


def judged_from_json(entry: Any, *, kinds: bool = False) -> Judged:
    """Convert JSON data to an interval under review. Raises FormatError if it is damaged.

    If `kinds` is True, a counter-twist without a kind counts as damaged.
    """
    check_keys(entry, "id", "decision", *(k for k in _JUDGED if k != "reason"), what="an interval")
    check_keys(entry, *(("kind", "carried") if kinds else ()))
    values = {"reason": "", **entry}  # the first files have no reason
    return Judged(
        check_integer(entry["id"], "id"),
        interval_from_json(entry),
        Decision(check_choice(entry["decision"], "decision", [d.value for d in Decision])),
        **{key: check(values[key], key) for key, check in _JUDGED.items()},
        in_bulk=check_bool(entry.get("in_bulk", False), "in_bulk"),
    )
