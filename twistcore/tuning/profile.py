"""Profiles: τ per joint in a TOML file, for other clips, for `--profile` and for a folder."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from twistcore.atomic import write_atomically
from twistcore.chain import Chain
from twistcore.detection import DETECTORS
from twistcore.encoding import encoded, escaped, unescaped
from twistcore.errors import FormatError, TwistError
from twistcore.tuning.tau_curve import Tuned


@dataclass(frozen=True)
class Profile:
    """τ for other clips.

    tau: radians by the name of a chain or limb; method: the detector that it was tuned for, '' if
    not said.
    """

    tau: Mapping[str, float]
    method: str = ""

    def of(self, chains: Iterable[Chain]) -> dict[str, float]:
        """τ of those chains that it names."""
        return {c.name: self.tau[c.name] for c in chains if c.name in self.tau}


def write_profile(path: Path, profile: Mapping[str, Tuned], source: str, method: str) -> None:
    """One TOML table a joint, readable by :func:`read_profile`, with its reasons; raises OSError.

    The file is the old one or the new one, never half of either.
    """
    lines = [f"# τ per joint for twistcore --profile, tuned on {source} with detector {method}."]
    for name, t in profile.items():
        reasons = {
            "noise_deg": (t.noise, 4),
            "fsr_percent": (t.fsr, 3),
            "false_alarms_per_minute": (t.alarms_per_minute, 3),
        }
        lines += [
            "",
            f"[{json.dumps(escaped(name), ensure_ascii=False)}]",
            f"tau_deg = {t.tau:.4f}",
            f"detector = {json.dumps(method)}",
            *(f"{k} = {v:.{n}f}" for k, (v, n) in reasons.items() if not math.isnan(v)),
        ]
    write_atomically(path, encoded("\n".join(lines) + "\n"))


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
    except (KeyError, TypeError, ValueError):
        raise FormatError(f"{path}: expected a table with tau_deg for every joint") from None
    if not tau:
        raise FormatError(f"{path}: expected a table with tau_deg for every joint, found none")
    for name, value in tau.items():
        if not 0.0 < value <= math.pi:
            raise FormatError(f"{path}: expected tau_deg above 0 and up to 180 for {name}")
    if len(methods) > 1 or methods - DETECTORS.keys():
        known, found = " or ".join(sorted(DETECTORS)), ", ".join(sorted(methods))
        raise FormatError(f"{path}: expected one detector, {known}, found {found}")
    return Profile(tau, methods.pop() if methods else "")
