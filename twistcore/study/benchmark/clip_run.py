"""Run all protocols, methods and seeds of the benchmark on one clip, in a worker process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from twistcore.detection import DETECTORS
from twistcore.detection.natural_events import NaturalEvent
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.study.benchmark.clip_scene import AUDITOR, CleanScene, make_clean_scene
from twistcore.study.benchmark.filtering_cost import Fidelity, measure_fidelity
from twistcore.study.benchmark.passes import (
    CleanRun,
    benchmark_method_names,
    run_benchmark_passes,
    run_on_clean_motion,
    tally_clean_run,
)
from twistcore.study.benchmark.tally import MICRO, Key, Tallies, Tally, add_tallies
from twistcore.synthesis import parse_protocol


@dataclass(frozen=True)
class BenchmarkSettings:
    """The protocols, methods and seeds of a benchmark run."""

    protocols: tuple[str, ...] = ("P0",)
    methods: tuple[str, ...] = field(default_factory=benchmark_method_names)
    seeds: tuple[int, ...] = (1,)

    @property
    def auditor(self) -> str:
        """Return the name of the detector whose detections in clean clips are natural events."""
        if AUDITOR in DETECTORS:
            return AUDITOR
        return next((m for m in self.methods if m in DETECTORS), next(iter(DETECTORS)))

    def to_json(self) -> dict[str, Any]:
        """Return the settings, keyed by name."""
        return {**{k: list(v) for k, v in vars(self).items()}, "auditor": self.auditor}


@dataclass(frozen=True, eq=False)
class ClipResult:
    """The benchmark result of one clip, which takes up a few kilobytes for a clip of any length.

    Attributes
    ----------
    clip
        Path of the clip, relative to the folder.
    micros
        Duration of the capture, µs.
    dropped
        Number of frames that were skipped because they come before the capture, such as a T-pose.
    tallies
        Counts and sums for each protocol, method, side and segment.
    fidelity
        Lag and loss of peak speed that each method causes in the clean clip.
    events
        Natural events: detections in the clean clip.
    problems
        A sentence for each failure.
    """

    clip: str
    micros: int = 0
    dropped: int = 0
    tallies: Tallies = field(default_factory=dict)
    fidelity: Mapping[str, Fidelity] = field(default_factory=dict)
    events: tuple[NaturalEvent, ...] = ()
    problems: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON data, for one line of the file that --resume reads."""
        return {
            **vars(self),
            "tallies": [[*vars(k).values(), t.values()] for k, t in self.tallies.items()],
            "fidelity": {m: list(vars(f).values()) for m, f in self.fidelity.items()},
            "events": [list(vars(e).values()) for e in self.events],
        }


def benchmark_result_from_json(document: Mapping[str, Any]) -> ClipResult:
    """Convert JSON data to a result.

    Raises KeyError, TypeError or ValueError if the data are invalid.
    """
    counts = [field.name for field in fields(Tally)]
    tallies = {
        Key(*key): Tally(**dict(zip(counts, values, strict=True)))
        for *key, values in document["tallies"]
    }
    return ClipResult(
        document["clip"],
        document["micros"],
        document["dropped"],
        tallies,
        {m: Fidelity(*values) for m, values in document["fidelity"].items()},
        tuple(NaturalEvent(*values) for values in document["events"]),
        tuple(document["problems"]),
    )


def run_clip_benchmark(path: Path, name: str, settings: BenchmarkSettings) -> ClipResult:
    """Run the benchmark on one clip.

    `name` is the clip's name in the results. The random errors depend on this name without its
    suffix.
    """
    problems: list[str] = []
    try:
        motion = read_bvh(path).motion
        base = make_clean_scene(name, motion, parse_protocol("P0"), settings.auditor)
    except TwistError as error:
        # In the message, replace the path, which differs between machines, by the clip's name.
        return ClipResult(name, problems=(str(error).replace(str(path), name),))
    prepared: dict[tuple[bool, int], CleanScene] = {(False, 1): base}
    scenes: list[CleanScene] = []
    for text in settings.protocols:
        protocol = parse_protocol(text)
        how = protocol.rich, protocol.step
        try:
            if how not in prepared:
                prepared[how] = make_clean_scene(name, motion, protocol, settings.auditor)
            scenes.append(replace(prepared[how], protocol=protocol))
        except TwistError as error:
            problems.append(f"{error} ({text})")
    tallies: Tallies = {}
    kept: dict[str, Fidelity] = {}
    for method in settings.methods:
        runs: dict[tuple[bool, int, str], CleanRun] = {
            (False, 1, ""): run_on_clean_motion(base, method)
        }
        if measured := measure_fidelity(base, runs[False, 1, ""].outcome.rotations):
            kept[method] = measured
        for scene in scenes:
            run = scene.protocol.rich, scene.protocol.step, scene.protocol.single
            if run not in runs:
                runs[run] = run_on_clean_motion(scene, method)
            add_tallies(tallies, tally_clean_run(scene, method, runs[run]))
            for seed in settings.seeds:
                add_tallies(tallies, run_benchmark_passes(scene, method, seed, runs[run]))
    micros = round(base.motion.frames * base.motion.frame_time * MICRO)
    return ClipResult(name, micros, base.dropped, tallies, kept, base.events, tuple(problems))
