"""The truth file: which errors were put into which clip."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.atomic import write_atomically
from twistcore.detection import Kind
from twistcore.encoding import json_bytes
from twistcore.errors import FormatError, TwistError
from twistcore.ordinary_files import read_text_file
from twistcore.synthesis.injection import InjectedError
from twistcore.synthesis.protocol import parse_protocol

SCHEMA = "twistcore.truth/1"
SUCCESS = 0.2  # a frame is repaired if at most this share of its error is left [Choi26 §4.2.1]


@dataclass(frozen=True, eq=False)
class Truth:
    """What was injected into which clip; sha256: of the clip's file, where one is to be sure."""

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
    if error.kind == Kind.LIMB_FLIP:
        entry["kind"] = error.kind.value
    if error.carried:
        entry["carried"] = True
    return entry


def write_truth(path: Path, truth: Truth) -> None:
    """Write a truth file, atomically; angles in degrees."""
    errors = [_error_to_json(e) for e in truth.errors]
    own = {key: value for key, value in vars(truth).items() if key != "sha256" or value}
    write_atomically(path, json_bytes({"schema": SCHEMA, **own, "errors": errors}))


def read_truth(path: Path) -> Truth:
    """Read a truth file; FormatError or TwistError in one sentence."""
    try:
        document: Mapping[str, Any] = json.loads(read_text_file(path))
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise FormatError(f"{path}: expected JSON ({error})") from None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise FormatError(f"{path}: expected a document with schema {SCHEMA!r}")
    try:
        frames = int(document["frames"])
        parse_protocol(document["protocol"])
        errors = tuple(
            InjectedError(
                e["chain"],
                e["start"],
                e["stop"],
                np.radians(e["offset_deg"]),
                np.radians(e["leak_deg"]) if "leak_deg" in e else None,
                Kind(e.get("kind", Kind.COUNTER_TWIST)),
                bool(e.get("carried", False)),
            )
            for e in document["errors"]
        )
        for e in errors:
            if not (0 <= e.start < e.stop <= frames and len(e.offset) == e.stop - e.start):
                raise ValueError(f"the error in frames {e.start}-{e.stop}")
            if not np.isfinite(e.offset).all():
                raise ValueError("an offset that is not finite")
            if e.kind == Kind.LONE_JUMP or (e.carried and e.kind != Kind.LIMB_FLIP):
                raise ValueError(f"an error of the kind {e.kind.value!r}")
        named = {key: document[key] for key in ("clip", "protocol", "seed", "fps")}
        sha256 = str(document.get("sha256", ""))
        return Truth(**named, frames=frames, errors=errors, sha256=sha256)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"{path}: {error} is missing or of the wrong kind") from None
