"""Profiles: τ per joint in a TOML file, for other clips, for `--profile` and for a folder."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from twistcore.atomic import write_atomically
from twistcore.chain import Chain
from twistcore.detection import DETECTORS
from twistcore.encoding import encoded, escaped, legible, unescaped
from twistcore.errors import FormatError, TwistError
from twistcore.tuning.learned_confidence import LearnedConfidence
from twistcore.tuning.tau_curve import Tuned

_MOST_SHIFT, _MOST_SCALE = 30.0, 100.0  # of a learned confidence: beyond them it is damaged
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Profile:
    """τ for other clips.

    tau: radians by the name of a chain or limb; method: the detector that it was tuned for, '' if
    not said; rig: mark of the skeleton that it is for, performer: who performs, '' for any;
    confidence: what was learned from verdicts, to be used where a person says so.
    """

    tau: Mapping[str, float]
    method: str = ""
    rig: str = ""
    performer: str = ""
    confidence: LearnedConfidence | None = None

    def of(self, chains: Iterable[Chain]) -> dict[str, float]:
        """τ of those chains that it names."""
        return {c.name: self.tau[c.name] for c in chains if c.name in self.tau}


@dataclass(frozen=True)
class TauReasons:
    """What verdicts say of a chain's τ: accepted and rejected intervals, and from where to where.

    low, high: degrees, where 90 % of the suggestions lie that other verdicts make.
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
    """One TOML table a joint, readable by :func:`read_profile`, with its reasons; raises OSError.

    whose: its rig, performer and confidence are written too, into every table: readers of earlier
    versions pass over what they do not know inside a table, and over nothing else. verdicts: what
    they say, by chain. The file is the old one or the new one, never half of either.
    """
    told = f"tuned on {legible(source)} with detector {legible(method)}"  # on this line
    lines = [f"# τ per joint for twistcore --profile, {told}."]
    common = [f"detector = {_text(method)}", *_whose_lines(whose)]
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
            f"[{_text(name)}]",
            f"tau_deg = {t.tau:.4f}",
            *common,
            *(f"{k} = {v:.{n}f}" for k, (v, n) in reasons.items() if not math.isnan(v)),
        ]
    write_atomically(path, encoded("\n".join(lines) + "\n"))


def _whose_lines(whose: Profile | None) -> list[str]:
    if whose is None:
        return []
    texts = {"rig": whose.rig, "performer": whose.performer}
    lines = [f"{key} = {_text(text)}" for key, text in texts.items() if text]
    if (c := whose.confidence) is not None:
        numbers = f"shift = {c.shift:.6f}, scale = {c.scale:.6f}"
        counts = f"accepted = {c.accepted}, rejected = {c.rejected}"
        lines.append(f"confidence = {{ {numbers}, {counts} }}")
    return lines


def _text(text: str) -> str:
    """A string of TOML, which differs from JSON's in DEL: that is escaped."""
    return json.dumps(escaped(text), ensure_ascii=False).replace("\x7f", "\\u007f")


def read_profile(path: Path) -> Profile:
    """A TOML file with a table for every joint, each with its tau_deg; raises TwistError."""
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        tau = {unescaped(name): math.radians(float(t["tau_deg"])) for name, t in document.items()}
        methods = {str(t["detector"]) for t in document.values() if "detector" in t}
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: expected TOML ({error})") from None
    except (KeyError, TypeError, ValueError, OverflowError):
        raise FormatError(f"{path}: expected a table with tau_deg for every joint") from None
    if not tau:
        raise FormatError(f"{path}: expected a table with tau_deg for every joint, found none")
    for name, value in tau.items():
        if not 0.0 < value <= math.pi:
            raise FormatError(f"{path}: expected tau_deg above 0 and up to 180 for {name}")
    if len(methods) > 1 or methods - DETECTORS.keys():
        known, found = " or ".join(sorted(DETECTORS)), ", ".join(sorted(methods))
        raise FormatError(f"{path}: expected one detector, {known}, found {found}")
    tables = document.values()
    rig, performer = (_one(path, tables, key, "") for key in ("rig", "performer"))
    confidence = _one(path, tables, "confidence", None)
    for key, value in (("rig", rig), ("performer", performer)):
        if not isinstance(value, str):
            raise FormatError(f"{path}: expected a text for {key}")
    return Profile(
        tau,
        methods.pop() if methods else "",
        unescaped(rig),
        unescaped(performer),
        None if confidence is None else _confidence(path, confidence),
    )


def _one(path: Path, tables: Iterable[Mapping[str, Any]], key: str, default: _Value) -> Any:
    """What every table that has a key has there."""
    values: list[Any] = []
    for table in tables:
        if key in table and table[key] not in values:
            values.append(table[key])
    if len(values) > 1:
        raise FormatError(f"{path}: expected one {key} in all tables, found {len(values)}")
    return values[0] if values else default


def _confidence(path: Path, entry: Any) -> LearnedConfidence:
    try:
        shift, scale = float(entry["shift"]), float(entry["scale"])
        counts = entry.get("accepted", 0), entry.get("rejected", 0)
        good = abs(shift) <= _MOST_SHIFT and 0.0 < scale <= _MOST_SCALE
        if not (good and all(isinstance(n, int) and n >= 0 for n in counts)):
            raise ValueError
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        raise FormatError(
            f"{path}: expected confidence with a shift within ±{_MOST_SHIFT:.0f}, a scale above 0 "
            f"and up to {_MOST_SCALE:.0f}, and whole numbers accepted and rejected"
        ) from None
    return LearnedConfidence(shift, scale, *counts)
