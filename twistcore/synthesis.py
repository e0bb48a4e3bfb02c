"""Twist errors put into a clip on purpose, seeded, with their truth [Choi26 §4.1]."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.atomic import write_atomically
from twistcore.chain import Chain
from twistcore.errors import FormatError, TwistError
from twistcore.motion import Motion
from twistcore.refinement import remove_twist
from twistcore.rotation import Array

SCHEMA = "twistcore.truth/1"
PROTOCOLS = ("P0",)


@dataclass(frozen=True, eq=False)
class InjectedError:
    """A known twist error: chain name, frames [start, stop), offset in radians, (stop − start,)."""

    chain: str
    start: int
    stop: int
    offset: Array


@dataclass(frozen=True, eq=False)
class Truth:
    """What was injected into which clip."""

    clip: str
    protocol: str
    seed: int
    frames: int
    fps: float
    errors: tuple[InjectedError, ...]


def generator(seed: int, clip: str) -> np.random.Generator:
    """Random numbers that depend on the seed and the clip's name, on nothing else."""
    return np.random.default_rng([seed, zlib.crc32(Path(clip).stem.encode())])


def draw_errors(
    chains: Sequence[Chain], frames: int, rng: np.random.Generator
) -> tuple[InjectedError, ...]:
    """P0 [Choi26 §4.1.1-2]: 2-5 intervals of 1-20 frames in each chain, offsets ±5…±180°, uniform.

    Intervals of one chain are at least 2 frames apart; the first two frames (a T-pose may stand in
    frame 0) and the last stay clean, so that every edge lies inside. A clip too short for 2
    intervals gets fewer.
    """
    errors: list[InjectedError] = []
    for chain in chains:
        taken = np.zeros(frames, dtype=bool)
        taken[:2] = taken[-1:] = True
        for _ in range(int(rng.integers(2, 6))):
            length = int(rng.integers(1, 21))
            # A start is free if the interval and two frames on either side of it are.
            blocked = np.convolve(taken, np.ones(length + 4), mode="full") > 0.5
            starts = np.flatnonzero(~blocked[length + 1 : length + 1 + frames - length])
            delta = np.radians(rng.uniform(5.0, 180.0)) * rng.choice([-1.0, 1.0])
            if not len(starts):
                continue
            start = int(rng.choice(starts))
            taken[start : start + length] = True
            errors.append(InjectedError(chain.name, start, start + length, np.full(length, delta)))
    return tuple(sorted(errors, key=lambda e: (e.chain, e.start)))


def draw_targets(chains: Sequence[Chain], rng: np.random.Generator) -> tuple[Chain, ...]:
    """Two chains that share no joint and form no continuous line [Choi26 §4.1.1]."""
    pairs = [
        (a, b)
        for k, a in enumerate(chains)
        for b in chains[k + 1 :]
        if not {a.parent, a.child, a.grandchild} & ({b.parent, b.child, b.grandchild} - {-1})
    ]
    if not pairs:
        return tuple(chains[:1])
    return pairs[int(rng.integers(len(pairs)))]


def inject(motion: Motion, chains: Sequence[Chain], errors: Sequence[InjectedError]) -> Motion:
    """q_P ← q_P ⊗ R_a(δ), and R_a(−δ) ⊗ q_X on every child X [Choi26 §4.1.3]."""
    offsets: dict[str, Array] = {}
    for error in errors:
        offset = offsets.setdefault(error.chain, np.zeros(motion.frames))
        offset[error.start : error.stop] -= error.offset
    return remove_twist(motion, chains, offsets)


def truth_to_json(truth: Truth) -> dict[str, Any]:
    """The truth as a JSON document; angles in degrees."""
    return {
        "schema": SCHEMA,
        "clip": truth.clip,
        "protocol": truth.protocol,
        "seed": truth.seed,
        "frames": truth.frames,
        "fps": truth.fps,
        "errors": [
            {
                "chain": e.chain,
                "start": e.start,
                "stop": e.stop,
                "offset_deg": [round(float(d), 9) for d in np.degrees(e.offset)],
            }
            for e in truth.errors
        ],
    }


def write_truth(path: Path, truth: Truth) -> None:
    """Write a truth file, atomically."""
    write_atomically(path, (json.dumps(truth_to_json(truth), indent=1) + "\n").encode())


def read_truth(path: Path) -> Truth:
    """Read a truth file; FormatError or TwistError in one sentence."""
    try:
        document: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise FormatError(f"{path}: expected JSON ({error})") from None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise FormatError(f"{path}: expected a document with schema {SCHEMA!r}")
    try:
        errors = tuple(
            InjectedError(e["chain"], e["start"], e["stop"], np.radians(e["offset_deg"]))
            for e in document["errors"]
        )
        return Truth(
            document["clip"],
            document["protocol"],
            document["seed"],
            document["frames"],
            document["fps"],
            errors,
        )
    except (KeyError, TypeError) as error:
        raise FormatError(f"{path}: {error} is missing or of the wrong kind") from None
