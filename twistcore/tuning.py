"""τ per joint: from the clips' own noise and from errors injected into these very clips.

[Choi26] has a threshold τ and names no value. Ours is chosen by what it costs: at every τ of a grid
the share of injected error frames that is repaired (FSR) and the false alarms in the clips as they
are. Few false alarms come first, then FSR, then the larger τ, which is safer against noise.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.atomic import write_atomically
from twistcore.bvh import read_bvh
from twistcore.chain import Chain, find_chains, uncorrectable_joints
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Analysis, Interval
from twistcore.errors import FormatError, TwistError
from twistcore.evaluation import SUCCESS
from twistcore.motion import Motion
from twistcore.rotation import Array, wrap
from twistcore.synthesis import (
    InjectedError,
    draw_errors,
    generator,
    inject,
    parse_protocol,
)

GRID = np.radians(np.geomspace(0.5, 30.0, 42))
LOSS_ALLOWED = 0.001  # share of error frames that a larger τ may lose against the best one
_PROTOCOLS = ("P0", "H6")  # the paper's sizes and small ones: the large alone say nothing about τ


@dataclass(frozen=True, eq=False)
class TauCurve:
    """What every τ of a grid costs a chain; counts, so that curves of many clips add.

    tau: radians, (n,); repaired: error frames repaired by 80 % or more, (n,); errors: error frames
    in all; alarms: intervals found in the clean clips, (n,); minutes: their length; noise: the
    detectors' own τ, radians, one for every clip.
    """

    tau: Array
    repaired: Array
    errors: int
    alarms: Array
    minutes: float
    noise: tuple[float, ...]

    @property
    def fsr(self) -> Array:
        """Share of the error frames that were repaired, 0…1, (n,)."""
        share: Array = self.repaired / max(self.errors, 1)
        return share

    @property
    def alarms_per_minute(self) -> Array:
        """False alarms per minute of clip, (n,)."""
        rate: Array = self.alarms / max(self.minutes, 1e-9)
        return rate

    def __add__(self, other: TauCurve) -> TauCurve:
        return TauCurve(
            self.tau,
            self.repaired + other.repaired,
            self.errors + other.errors,
            self.alarms + other.alarms,
            self.minutes + other.minutes,
            self.noise + other.noise,
        )

    def suggested(self) -> float:
        """τ in radians: fewest alarms, then FSR, then the largest τ that loses next to nothing.

        Never below the clips' own noise (the median of the detector's automatic τ).
        """
        floor = float(np.median(self.noise)) if self.noise else 0.0
        usable = np.flatnonzero(self.tau >= floor)
        if not len(usable):
            return floor
        quiet = usable[self.alarms[usable] == self.alarms[usable].min()]
        best = self.fsr[quiet].max()
        good = quiet[self.fsr[quiet] >= best - LOSS_ALLOWED]
        return float(self.tau[good[-1]])


@dataclass(frozen=True)
class Tuned:
    """A chain's τ with the reasons for it; degrees, per cent."""

    tau: float
    noise: float
    fsr: float
    alarms_per_minute: float


def tau_curve(
    motion: Motion,
    chains: Sequence[Chain],
    chain: Chain,
    *,
    name: str,
    clean: Analysis | None = None,
    method: str = DEFAULT_METHOD,
    seeds: Iterable[int] = (0, 1, 2),
    grid: Array = GRID,
) -> TauCurve:
    """The curve of one chain in one clip; `name` seeds the errors, `clean` saves an analysis."""
    detector = DETECTORS[method]
    clean = clean or detector.analyse(motion, chains)
    alarms = np.array([len(clean.intervals(chain.name, t)) for t in grid], dtype=float)
    repaired = np.zeros(len(grid))
    total = 0
    for seed in seeds:
        for k, protocol in enumerate(map(parse_protocol, _PROTOCOLS)):
            rng = generator(seed, name, k)
            errors = draw_errors([chain], motion.frames, rng, protocol, fps=motion.fps)
            if not errors:
                continue
            dirty = detector.analyse(inject(motion, chains, errors), chains)
            truth, wrong = _truth(errors, motion.frames)
            total += int(wrong.sum())
            repaired += [_repaired(dirty.intervals(chain.name, t), truth, wrong) for t in grid]
    noise = (clean.automatic_tau(chain.name),)
    minutes = motion.frames * motion.frame_time / 60.0
    return TauCurve(grid, repaired, total, alarms, minutes, noise)


def clip_curves(path: Path, method: str, seeds: int) -> dict[str, TauCurve]:
    """The curves of all correctable chains of a clip, by name; raises TwistError."""
    motion = read_bvh(path).motion
    chains = find_chains(motion)
    clean = DETECTORS[method].analyse(motion, chains)
    return {
        c.name: tau_curve(
            motion, chains, c, name=path.name, clean=clean, method=method, seeds=range(seeds)
        )
        for c in chains
        if not uncorrectable_joints(motion, c)
    }


def tuned(curve: TauCurve) -> Tuned:
    """The suggestion of a curve, with what it costs."""
    tau = curve.suggested()
    at = int(np.argmin(np.abs(curve.tau - tau)))
    return Tuned(
        tau=math.degrees(tau),
        noise=math.degrees(float(np.median(curve.noise))) if curve.noise else 0.0,
        fsr=100.0 * float(curve.fsr[at]),
        alarms_per_minute=float(curve.alarms_per_minute[at]),
    )


def _truth(
    errors: Sequence[InjectedError], frames: int
) -> tuple[Array, np.typing.NDArray[np.bool_]]:
    truth, wrong = np.zeros(frames), np.zeros(frames, dtype=bool)
    for error in errors:
        truth[error.start : error.stop] = error.offset
        wrong[error.start : error.stop] = True
    return truth, wrong


def _repaired(found: Sequence[Interval], truth: Array, wrong: np.typing.NDArray[np.bool_]) -> int:
    """Error frames in which at most a fifth of the error is left; open intervals count as found."""
    offset = np.zeros(len(truth))
    for interval in found:
        offset[interval.start : interval.stop] += interval.offset
    left = np.abs(wrap(truth - offset))[wrong]
    return int((left <= SUCCESS * np.abs(wrap(truth[wrong]))).sum())


def write_profile(path: Path, profile: Mapping[str, Tuned], source: str, method: str) -> None:
    """A profile: one TOML table a joint, readable by :func:`read_profile`, with its reasons."""
    lines = [f"# τ per joint for twistcore --profile, tuned on {source} with detector {method}."]
    for name, t in profile.items():
        lines += [
            "",
            f"[{json.dumps(name, ensure_ascii=False)}]",
            f"tau_deg = {t.tau:.4f}",
            f"noise_deg = {t.noise:.4f}",
            f"fsr_percent = {t.fsr:.3f}",
            f"false_alarms_per_minute = {t.alarms_per_minute:.3f}",
        ]
    write_atomically(path, ("\n".join(lines) + "\n").encode())


def read_profile(path: Path) -> dict[str, float]:
    """τ in radians by chain name, from a TOML file with a table for every joint holding tau_deg."""
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        profile = {name: math.radians(float(t["tau_deg"])) for name, t in document.items()}
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: expected TOML ({error})") from None
    except (KeyError, TypeError, ValueError):
        raise FormatError(f"{path}: expected a table with tau_deg for every joint") from None
    for name, tau in profile.items():
        if not (math.isfinite(tau) and tau > 0.0):
            raise FormatError(f"{path}: expected tau_deg above 0 for {name}")
    return profile
