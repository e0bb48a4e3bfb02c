"""Read and write truth files, which list the errors that were injected into a clip."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.detection import Kind
from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import (
    DEGREES,
    MOST_FRAMES,
    check_bool,
    check_choice,
    check_integer,
    check_keys,
    check_list,
    check_number,
    check_path_string,
    check_positive_number,
    check_string,
    parsed_json,
    prefix_format_errors,
    read_bytes_limited,
    read_each,
    unexpected_value_error,
)
from twistcore.files.document_values import read_frame_span as frames_of
from twistcore.files.encoding import json_bytes
from twistcore.skeleton.rotation import Array
from twistcore.synthesis.injection import InjectedError
from twistcore.synthesis.protocol import parse_protocol
from twistcore.work.frozen import dataclass

SCHEMA = "twistcore.truth/1"
_ALWAYS_CARRIED = Kind.CARRIED_ROLL, Kind.STRETCH, Kind.SPIKE
_KINDS = tuple(k.value for k in (Kind.COUNTER_TWIST, Kind.LIMB_FLIP, *_ALWAYS_CARRIED))
_LONGEST_NAME = 200  # maximum length of a protocol's name, which may combine several protocols
_MOST_ERRORS = 20_000  # limits the time of comparing each error with the intervals of a review
SUCCESS = 0.2  # a frame is repaired if at most this share of its error remains [Choi26 §4.2.1]


@dataclass(frozen=True, eq=False)
class Truth:
    """The errors that were injected into a clip.

    Attributes
    ----------
    clip
        Name of the clip.
    protocol
        Name of the protocol.
    seed
        Seed of the random generator.
    frames, fps
        Number of frames of the clip, and frames per second.
    errors
        The errors.
    sha256
        SHA-256 of the clip's file, or '' if it is unknown.
    """

    clip: str
    protocol: str
    seed: int
    frames: int
    fps: float
    errors: tuple[InjectedError, ...]
    sha256: str = ""


def _error_to_json(error: InjectedError) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "chain": error.chain,
        "start": error.start,
        "stop": error.stop,
        "offset_deg": [round(float(d), 9) for d in np.degrees(error.offset)],
    }
    if error.leak is not None:
        entry["leak_deg"] = [round(float(d), 9) for d in np.degrees(error.leak)]
    if error.kind != Kind.COUNTER_TWIST:
        entry["kind"] = error.kind.value
    if error.carried:
        entry["carried"] = True
    return entry


def write_truth(path: Path, truth: Truth) -> None:
    """Write a truth file atomically, with angles in degrees."""
    errors = [_error_to_json(e) for e in truth.errors]
    own = {key: value for key, value in vars(truth).items() if key != "sha256" or value}
    write_atomically(path, json_bytes({"schema": SCHEMA, **own, "errors": errors}))


def read_truth(path: Path) -> Truth:
    """Read a truth file. Raises FormatError or TwistError if it is invalid."""
    data = read_bytes_limited(path)
    with prefix_format_errors(path):
        document = parsed_json(data)
        if not isinstance(document, dict) or document.get("schema") != SCHEMA:
            raise FormatError(f"expected a document with schema {SCHEMA!r}")
        check_keys(document, "clip", "protocol", "seed", "frames", "fps", "errors")
        frames = check_integer(document["frames"], "frames", 0, MOST_FRAMES)
        return Truth(
            check_path_string(document["clip"], "clip"),
            _protocol(document["protocol"]),
            check_integer(document["seed"], "seed"),
            frames,
            check_positive_number(document["fps"], "fps"),
            _errors(document["errors"], frames),
            check_string(document.get("sha256", ""), "sha256"),
        )


def _protocol(name: Any) -> str:
    if len(check_string(name, "protocol")) > _LONGEST_NAME:
        raise unexpected_value_error("the name of a protocol", "protocol", name)
    try:
        parse_protocol(name)
    except TwistError as error:
        raise FormatError(str(error)) from None
    return str(name)


def _errors(entries: Any, frames: int) -> tuple[InjectedError, ...]:
    if len(check_list(entries, "errors")) > _MOST_ERRORS:
        raise FormatError(f"expected at most {_MOST_ERRORS} errors, found {len(entries)}")
    return read_each(entries, "errors", partial(_error, frames=frames))


def _error(entry: Any, frames: int) -> InjectedError:
    check_keys(entry, "chain", "start", "stop", "offset_deg", what="an error")
    start, stop = frames_of(entry, frames)
    kind = Kind(check_choice(entry.get("kind", Kind.COUNTER_TWIST), "kind", _KINDS))
    carried = check_bool(entry.get("carried", False), "carried")
    if carried and kind == Kind.COUNTER_TWIST:
        raise unexpected_value_error(
            "a limb flip or a carried roll", "an error with 'carried'", kind.value
        )
    if kind in _ALWAYS_CARRIED and not carried:
        raise unexpected_value_error("'carried' with the value true", f"a {kind.value}", "none")
    leak = None
    if "leak_deg" in entry:
        leak = _angles(entry["leak_deg"], "leak_deg", stop - start)
    offset = _angles(entry["offset_deg"], "offset_deg", stop - start)
    chain = check_string(entry["chain"], "chain")
    return InjectedError(chain, start, stop, offset, leak, kind, carried)


def _angles(entry: Any, what: str, frames: int) -> Array:
    """Return an angle for each frame, radians.

    Raises FormatError if there are too few or too many.
    """
    if len(check_list(entry, what)) != frames:
        raise FormatError(f"expected {frames} numbers for {what}, found {len(entry)}")
    return np.radians([check_number(one, what, -DEGREES, DEGREES) for one in entry])
