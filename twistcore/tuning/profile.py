"""Read and write profiles, which are TOML files with a threshold τ for each chain."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from twistcore.detection import DETECTORS
from twistcore.errors import FormatError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import (
    check_choice,
    check_integer,
    check_keys,
    check_number,
    check_string,
    format_value_for_message,
    parsed_toml,
    prefix_format_errors,
    read_bytes_limited,
    unexpected_value_error,
)
from twistcore.files.encoding import (
    encode_utf8,
    escape_control_characters,
    toml_string,
    unescape_invalid_utf8,
)
from twistcore.skeleton.chain import Chain
from twistcore.tuning.learned_confidence import LearnedConfidence
from twistcore.tuning.tau_curve import Tuned
from twistcore.work.frozen import dataclass

# Limits of the parameters of a learned confidence. Other values indicate a damaged file.
_MOST_SHIFT, _LEAST_SCALE, _MOST_SCALE = 30.0, 1e-6, 100.0
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Profile:
    """The τ of each chain of a rig, for use with other clips.

    Parameters
    ----------
    tau
        τ in radians, keyed by the name of the chain or limb.
    method
        The detector for which τ was tuned, '' if unknown.
    rig
        A string that identifies the skeleton.
    performer
        Name of the performer, '' for any.
    confidence
        The confidence learned from verdicts, which is used only on request.
    """

    tau: Mapping[str, float]
    method: str = ""
    rig: str = ""
    performer: str = ""
    confidence: LearnedConfidence | None = None

    def of(self, chains: Iterable[Chain]) -> dict[str, float]:
        """Return τ in radians, keyed by chain name. Chains without a τ are omitted."""
        return {c.name: self.tau[c.name] for c in chains if c.name in self.tau}


@dataclass(frozen=True)
class TauReasons:
    """The evidence for a chain's τ.

    Parameters
    ----------
    accepted, rejected
        Number of accepted and number of rejected intervals of the chain.
    low, high
        The range, in degrees, that contains 90 % of the τ values suggested by resampled verdicts.
    """

    accepted: int
    rejected: int
    low: float = math.nan
    high: float = math.nan


def write_profile(
    path: Path,
    profile: Mapping[str, Tuned],
    source: str,
    method: str,
    *,
    whose: Profile | None = None,
    verdicts: Mapping[str, TauReasons] | None = None,
) -> None:
    """Write a profile atomically as a TOML file with one table per chain.

    Parameters
    ----------
    path
        The file.
    profile
        The τ of each chain with its cost, keyed by chain name.
    source
        Name of the clips on which τ was tuned, written as a comment.
    method
        The detector for which τ was tuned.
    whose
        A profile whose rig, performer and confidence are written into every table, since earlier
        versions ignore unknown keys only inside a table.
    verdicts
        The evidence from verdicts, keyed by chain name.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    clip, by = (
        escape_control_characters(source),
        escape_control_characters(method),
    )  # without line breaks
    lines = [f"# τ per joint for twistcore --profile, tuned on {clip} with detector {by}."]
    common = [f"detector = {toml_string(method)}", *_shared_lines(whose)]
    for name, t in profile.items():
        reasons = {
            "noise_deg": (t.noise, 4),
            "fsr_percent": (t.fsr, 3),
            "false_alarms_per_minute": (t.alarms_per_minute, 3),
        }
        if verdicts and name in verdicts:
            v = verdicts[name]
            reasons |= {"accepted": (v.accepted, 0), "rejected": (v.rejected, 0)}
            reasons |= {"tau_low_deg": (v.low, 4), "tau_high_deg": (v.high, 4)}
        lines += [
            "",
            f"[{toml_string(name)}]",
            f"tau_deg = {t.tau:.4f}",
            *common,
            *(f"{k} = {v:.{n}f}" for k, (v, n) in reasons.items() if not math.isnan(v)),
        ]
    write_atomically(path, encode_utf8("\n".join(lines) + "\n"))


def _shared_lines(whose: Profile | None) -> list[str]:
    if whose is None:
        return []
    texts = {"rig": whose.rig, "performer": whose.performer}
    lines = [f"{key} = {toml_string(text)}" for key, text in texts.items() if text]
    if (c := whose.confidence) is not None:
        numbers = f"shift = {c.shift:.6f}, scale = {c.scale:.6f}"
        counts = f"accepted = {c.accepted}, rejected = {c.rejected}"
        lines.append(f"confidence = {{ {numbers}, {counts} }}")
    return lines


def read_profile(path: Path) -> Profile:
    """Read a profile from a TOML file, in which the table of each chain contains tau_deg.

    Raises TwistError if the file cannot be read or is invalid.
    """
    data = read_bytes_limited(path)
    with prefix_format_errors(path):
        return _profile(parsed_toml(data))


def _profile(document: Mapping[str, Any]) -> Profile:
    expected = "expected a table with tau_deg for every joint"
    if not document:
        raise FormatError(f"{expected}, found none")
    for name, table in document.items():
        if not (isinstance(table, dict) and "tau_deg" in table):
            raise FormatError(f"{expected}, found none for {format_value_for_message(name)}")
    tables = list(document.values())
    tau = {unescape_invalid_utf8(name): _tau(t["tau_deg"], name) for name, t in document.items()}
    methods = {
        check_choice(t["detector"], "detector", DETECTORS) for t in tables if "detector" in t
    }
    if len(methods) > 1:
        known, found = " or ".join(sorted(DETECTORS)), ", ".join(sorted(methods))
        raise FormatError(f"expected the detector {known}, found {found}")
    rig, performer = (check_string(_one(tables, key, ""), key) for key in ("rig", "performer"))
    confidence = _one(tables, "confidence", None)
    return Profile(
        tau,
        methods.pop() if methods else "",
        unescape_invalid_utf8(rig),
        unescape_invalid_utf8(performer),
        None if confidence is None else _confidence(confidence),
    )


def _tau(degrees: Any, name: str) -> float:
    """Convert a chain's τ to radians. Raises FormatError unless it is in (0°, 180°]."""
    place = f"tau_deg of {format_value_for_message(name)}"
    if not check_number(degrees, place, 0.0, 180.0):
        raise unexpected_value_error("a number above 0", place, degrees)
    return math.radians(degrees)


def _one(tables: Iterable[Mapping[str, Any]], key: str, default: _Value) -> Any:
    """Return the value of a key, which must be the same in all tables that contain the key.

    Raises FormatError if the values differ.
    """
    values = [table[key] for table in tables if key in table]
    if others := sum(value != values[0] for value in values):
        raise FormatError(
            f"expected the same {key} in all tables, but {others} tables have different values"
        )
    return values[0] if values else default


def _confidence(entry: Any) -> LearnedConfidence:
    check_keys(entry, "shift", "scale", what="confidence")
    shift = check_number(entry["shift"], "shift", -_MOST_SHIFT, _MOST_SHIFT)
    scale = check_number(entry["scale"], "scale", _LEAST_SCALE, _MOST_SCALE)
    counts = (check_integer(entry.get(key, 0), key) for key in ("accepted", "rejected"))
    return LearnedConfidence(shift, scale, *counts)
