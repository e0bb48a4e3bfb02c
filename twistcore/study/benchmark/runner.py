"""Run the benchmark on all clips of a folder in several processes, with progress and resumption."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from twistcore.detection.natural_events import NaturalEvent
from twistcore.errors import FormatError
from twistcore.files.document_values import parsed_json
from twistcore.files.encoding import escape_invalid_utf8
from twistcore.formats.clip_files import BVH, clips_by_name
from twistcore.study.benchmark.clip_run import (
    BenchmarkSettings,
    ClipResult,
    benchmark_result_from_json,
    run_clip_benchmark,
)
from twistcore.study.benchmark.filtering_cost import Fidelity
from twistcore.study.benchmark.tally import Tallies, add_tallies
from twistcore.work.processes import describe_failure, map_in_processes
from twistcore.work.progress import TellName, show_clip_progress_bar

PART_SCHEMA = "twistcore.benchmark-part/1"


@dataclass
class BenchmarkSummary:
    """The benchmark results of all clips, from which the tables are made.

    Sums are integers, so the order of the clips does not matter. Lists have an entry for each clip.

    Attributes
    ----------
    clips
        Number of clips.
    micros
        Duration of all captures, µs.
    dropped
        Number of frames that were skipped at the start of clips.
    tallies
        Counts and sums for each protocol, method, side and segment.
    fidelity
        Lag and loss of peak speed in each clean clip, keyed by method.
    events, problems
        Natural events and failures, each with the name of its clip.
    missing
        Number of clips that were not run.
    """

    clips: int = 0
    micros: int = 0
    dropped: int = 0
    tallies: Tallies = field(default_factory=dict)
    fidelity: dict[str, list[tuple[str, Fidelity]]] = field(default_factory=dict)
    events: list[tuple[str, NaturalEvent]] = field(default_factory=list)
    problems: list[tuple[str, str]] = field(default_factory=list)
    missing: int = 0

    def add(self, result: ClipResult) -> None:
        """Add the result of a clip."""
        self.clips += bool(result.tallies)
        self.micros += result.micros
        self.dropped += result.dropped
        add_tallies(self.tallies, result.tallies)
        for method, measured in result.fidelity.items():
            self.fidelity.setdefault(method, []).append((result.clip, measured))
        self.events += [(result.clip, e) for e in result.events]
        self.problems += [(result.clip, p) for p in result.problems]

    def sort(self) -> None:
        """Sort the lists by clip. The order within a clip does not change."""
        self.events.sort(key=lambda entry: entry[0])
        self.problems.sort(key=lambda entry: entry[0])
        for measured in self.fidelity.values():
            measured.sort(key=lambda entry: entry[0])


def find_benchmark_clips(folder: Path) -> dict[str, Path]:
    """Return the BVH files in a folder and its subfolders, keyed by relative path.

    `folder` may also be a single file.
    """
    if folder.is_file():
        return {folder.name: folder}
    return clips_by_name(folder, suffixes=BVH)


def run_benchmark(
    clips: dict[str, Path],
    settings: BenchmarkSettings,
    *,
    workers: int,
    partial: Path | None = None,
    resume: bool = False,
    counter: Callable[[int, int], AbstractContextManager[TellName]] = show_clip_progress_bar,
) -> BenchmarkSummary:
    """Run the benchmark on every clip.

    If the user presses Ctrl+C, the run ends with the results so far.

    Parameters
    ----------
    clips
        Paths of the clips, keyed by name.
    settings
        The protocols, methods and seeds.
    workers
        Number of processes.
    partial
        A JSON-lines file to which the result of each clip is written as soon as it is known.
    resume
        True to keep the results in `partial` and run only the remaining clips, False to overwrite
        the file.
    counter
        A function that shows the progress, such as
        :func:`~twistcore.work.progress.show_clip_progress_bar`.

    Raises
    ------
    FormatError
        If `partial` was written with other settings.
    """
    summary = BenchmarkSummary()
    stamps = {name: _stamp(path) for name, path in clips.items()}
    known: set[str] = set()
    if partial and resume and partial.exists():
        for result in read_unfinished_benchmark(partial, settings, stamps):
            if result.clip not in known:
                known.add(result.clip)
                summary.add(result)
    # Run the longest clips first. A long clip that starts last would leave all other cores idle.
    todo = sorted((n for n in clips if n not in known), key=lambda n: (-stamps[n][0], n))
    summary.missing = len(todo)
    with (
        _partial_file(partial, settings, append=bool(known)) as file,
        counter(len(clips), len(known)) as tell,
    ):
        try:
            for result in _results(todo, clips, settings, workers):
                summary.add(result)
                summary.missing -= 1
                if file:
                    line = {**result.to_json(), "stamp": stamps[result.clip]}
                    text = json.dumps(line, ensure_ascii=False, separators=(",", ":"))
                    file.write(escape_invalid_utf8(text) + "\n")
                    file.flush()
                tell(result.clip)
        except KeyboardInterrupt:
            pass
    summary.sort()
    return summary


def _results(
    todo: Sequence[str], clips: dict[str, Path], settings: BenchmarkSettings, workers: int
) -> Iterator[ClipResult]:
    """Yield the results of clips in order of completion. A failing clip does not end the run."""
    items = [(clips[name], name) for name in todo]
    for (_, name), result in map_in_processes(
        functools.partial(_run_item, settings), items, workers
    ):
        if isinstance(result, Exception):
            yield ClipResult(name, problems=(describe_failure(name, result),))
        else:
            yield result


def _run_item(settings: BenchmarkSettings, item: tuple[Path, str]) -> ClipResult:
    return run_clip_benchmark(*item, settings)


def _stamp(path: Path) -> tuple[int, int]:
    """Return a file's size and modification time, which reveal changes to the file."""
    try:
        status = path.stat()
    except OSError:  # the file is missing or a broken link; reading it will report the error
        return 0, 0
    return status.st_size, status.st_mtime_ns


def read_unfinished_benchmark(
    path: Path, settings: BenchmarkSettings, stamps: dict[str, tuple[int, int]]
) -> Iterator[ClipResult]:
    """Yield the stored results of clips that have not changed and had no problems.

    An incomplete last line is ignored. Raises FormatError if the file has a different schema or was
    written with other settings.
    """
    with path.open(encoding="utf-8") as file:
        head = None
        with suppress(FormatError, UnicodeDecodeError):
            head = parsed_json(next(file, "null"))
        if not isinstance(head, dict) or head.get("schema") != PART_SCHEMA:
            raise FormatError(f"{path}: expected a document with schema {PART_SCHEMA!r}")
        if head.get("settings") != settings.to_json():
            raise FormatError(
                f"{path} was written with other protocols, methods or seeds; use the same "
                "ones, or leave --resume out"
            )
        for line in file:
            try:
                document = parsed_json(line)
                result = benchmark_result_from_json(document)
                unchanged = tuple(document["stamp"]) == stamps.get(result.clip)
            except (FormatError, AttributeError, KeyError, TypeError, ValueError):
                continue
            if unchanged and not result.problems:
                yield result


@contextmanager
def _partial_file(
    path: Path | None, settings: BenchmarkSettings, *, append: bool
) -> Iterator[IO[str] | None]:
    if path is None:
        yield None
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a" if append else "w", encoding="utf-8") as file:
        if append:
            file.write("\n")  # the last line may be incomplete
        else:
            head = {"schema": PART_SCHEMA, "settings": settings.to_json()}
            file.write(json.dumps(head, ensure_ascii=False) + "\n")
        file.flush()
        yield file
