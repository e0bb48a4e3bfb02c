"""Survey the detections in folders of captures: python -m benchmarks.atlas FOLDER [--json FILE].

    python3 dev.py bench atlas FOLDER [--only SET]… [--json FILE] [--pictures DIR] [--verdicts CSV]
    python3 dev.py bench atlas FOLDER --kinds spike --kinds stretch… --blind DIR

FOLDER contains one folder for each set of captures. Errors are detected in every clip with default
settings. For each set, the table shows clips, minutes, failures, and the number of intervals of
each kind, in total and per hour. The column `applied` counts automatic corrections. Failed clips
are listed and do not stop the survey, but the exit status is then 1.

--kinds selects kinds of errors, including capture faults and errors of single joints. --pictures
draws contact sheets of at most --most detections (:mod:`benchmarks.atlas_pictures`), chosen at
random from all sets and kinds. --blind draws the detections for judges, who see neither the set nor
the confidence (:mod:`benchmarks.blind_verdicts`). With --kinds, it draws the whole body and the
marked joint (:mod:`benchmarks.joint_pictures`). --verdicts reads a table of visual verdicts with
the columns of docs/atlas-verdicts.csv, and prints the numbers of *error*, *doubtful* and *alarm*,
and Wilson's interval for the share of errors.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import random
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Interval, Kind
from twistcore.formats.reading import is_clip, read_clip
from twistcore.work.processes import describe_failure, map_in_processes

KINDS = tuple(kind for kind in Kind if not kind.of_capture)  # surveyed by default
VERDICTS = ("error", "doubtful", "alarm")
COLUMNS = ("set", "clip", "chain", "joint", "start", "stop", "kind", "degrees", "applied")
WILSON = 1.96  # quantile of the normal distribution for 95 %
FREE = "cmu"  # start of the names of sets whose skeletons may be published

Row = dict[str, float | int | str]


@dataclass(frozen=True)
class Find:
    """A detected interval.

    Attributes
    ----------
    clip, chain, kind, joint
        Names of the clip, the chain, the kind of error and, if the kind has one, the joint.
    start, stop
        The frames [start, stop).
    degrees
        The size of the error.
    confidence, open
        The interval's confidence, and True if it is open.
    applied
        True if `refine` corrects the interval automatically.
    offset
        The offset in degrees, one number per frame, 0 for a kind without correction.
    carried
        True if the error also rotated the part below the limb or joint.
    """

    clip: str
    chain: str
    kind: str
    start: int
    stop: int
    degrees: float
    confidence: float | None
    open: bool
    applied: bool
    joint: str
    offset: tuple[float, ...]
    carried: bool = False


@dataclass(frozen=True)
class Seen:
    """The detections in a clip.

    Attributes
    ----------
    set, clip
        Names of the set and of the clip.
    frames, fps, chains
        Number of frames, frame rate, and number of chains and limbs.
    finds
        The detections.
    problem
        The reason why detection failed, or ''.
    """

    set: str
    clip: str
    frames: int = 0
    fps: float = 0.0
    chains: int = 0
    finds: tuple[Find, ...] = ()
    problem: str = ""

    @property
    def seconds(self) -> float:
        """Return the duration of the clip in seconds."""
        return self.frames / self.fps if self.fps > 0.0 else 0.0


def look(path: Path, kinds: Sequence[Kind] = KINDS) -> Seen:
    """Detect errors of the given kinds in a clip. Raises TwistError if the clip cannot be read."""
    motion = read_clip(path).motion
    analysis = analyse(motion)
    found = analysis.detect(kinds=kinds)
    sure = {id(i) for i in automatic_corrections(found)}
    finds = tuple(_find(path.name, i, applied=id(i) in sure) for i in found)
    chains = len(analysis.chains_and_limbs)
    return Seen(path.parent.name, path.name, motion.frames, motion.fps, chains, finds)


def _find(clip: str, i: Interval, *, applied: bool) -> Find:
    return Find(
        clip=clip,
        chain=i.chain,
        kind=str(i.kind),
        start=i.start,
        stop=i.stop,
        degrees=round(math.degrees(i.shown), 2),
        confidence=i.confidence,
        open=i.open,
        applied=applied,
        joint=i.joint,
        offset=tuple(np.degrees(i.for_review.offset).round(2).tolist()),
        carried=i.carried,
    )


def survey(
    folder: Path, only: Sequence[str] = (), workers: int = 2, kinds: Sequence[Kind] = KINDS
) -> Iterator[Seen]:
    """Yield the detections in each clip of each set as soon as the clip is finished.

    `only` has the names of sets to survey, empty for all.
    """
    paths = [p for p in sorted(folder.glob("*/*")) if is_clip(p)]
    paths = [p for p in paths if not only or p.parent.name in only]
    for path, seen in map_in_processes(partial(look, kinds=kinds), paths, workers):
        if isinstance(seen, Exception):
            yield Seen(path.parent.name, path.name, problem=describe_failure(path.name, seen))
        else:
            yield seen


def table(seen: Iterable[Seen], kinds: Sequence[Kind] = KINDS) -> list[Row]:
    """Return a row for each set and a row of totals.

    The columns are clips, minutes, failures, detections and corrections, in total and per hour.
    """
    by_set: dict[str, list[Seen]] = defaultdict(list)
    for s in seen:
        by_set[s.set].append(s)
    rows = {name: by_set[name] for name in sorted(by_set)}
    rows["all"] = [s for own in by_set.values() for s in own]
    return [_row(name, own, kinds) for name, own in rows.items()]


def _row(name: str, own: Sequence[Seen], kinds: Sequence[Kind]) -> Row:
    minutes = sum(s.seconds for s in own) / 60.0
    row: Row = {
        "set": name,
        "clips": len(own),
        "minutes": round(minutes, 1),
        "failed": sum(bool(s.problem) for s in own),
        "no chain": sum(not s.problem and not s.chains for s in own),
    }
    finds = [f for s in own for f in s.finds]
    for kind in kinds:
        there = [f for f in finds if f.kind == kind]
        row[str(kind)] = len(there)
        if kind.repairable:
            row[f"{kind} applied"] = sum(f.applied for f in there)
        row[f"{kind} an hour"] = round(60.0 * len(there) / minutes, 1) if minutes else 0.0
    return row


def sample(seen: Iterable[Seen], most: int, seed: int) -> list[tuple[str, Find]]:
    """Return at most `most` detections with their sets, drawn evenly from groups.

    A group has the same set, kind and `applied`. `seed` seeds the draw.
    """
    groups: dict[tuple[str, str, bool], list[Find]] = defaultdict(list)
    for s in sorted(seen, key=lambda s: (s.set, s.clip)):
        for find in s.finds:
            groups[s.set, find.kind, find.applied].append(find)
    share = 0
    while share < most and sum(min(len(g), share + 1) for g in groups.values()) <= most:
        share += 1
    draw = random.Random(seed)
    chosen = []
    for key in sorted(groups):
        own = groups[key]
        kept = sorted(draw.sample(range(len(own)), min(len(own), share)))
        chosen += [(key[0], own[k]) for k in kept]
    return chosen


def wilson(right: int, of: int) -> tuple[float, float]:
    """Return Wilson's (1927) 95 % interval for the share `right / of`, or 0 to 1 without data."""
    if not of:
        return 0.0, 1.0
    p, z2 = right / of, WILSON**2
    middle = (p + z2 / (2 * of)) / (1 + z2 / of)
    half = WILSON / (1 + z2 / of) * math.sqrt(p * (1 - p) / of + z2 / (4 * of**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def precision(verdicts: Iterable[Mapping[str, str]], *by: str) -> list[Row]:
    """Return the number of verdicts of each kind, and the share of errors with its interval.

    `by` are the columns by which the verdicts are grouped into rows.
    """
    counted: dict[tuple[str, ...], Counter[str]] = defaultdict(Counter)
    for row in verdicts:
        counted[tuple(row[column] for column in by)][row["verdict"]] += 1
    out = []
    for key in sorted(counted):
        n, right = sum(counted[key].values()), counted[key]["error"]
        low, high = (round(100 * v, 1) for v in wilson(right, n))
        row: Row = {**dict(zip(by, key, strict=True)), "judged": n}
        row |= {v: counted[key][v] for v in VERDICTS}
        out.append(row | {"errors %": round(100 * right / n, 1), "from": low, "to": high})
    return out


def markdown(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows as a Markdown table, or '' if there are none."""
    if not rows:
        return ""
    lines = [list(rows[0]), ["---"] * len(rows[0]), *(list(r.values()) for r in rows)]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Survey the clips, print the table and draw the pictures. Return 1 if a clip failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", action="append", default=[], metavar="SET")
    parser.add_argument("--kinds", action="append", type=Kind, help="instead of the usual kinds")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path, help="write the finds, clip by clip")
    parser.add_argument("--pictures", type=Path, help="a folder for contact sheets")
    parser.add_argument(
        "--blind", type=Path, help="a folder for pictures without set and confidence"
    )
    parser.add_argument("--most", type=int, default=300, help="finds on contact sheets")
    parser.add_argument("--seed", type=int, default=19)
    parser.add_argument("--verdicts", type=Path, help="a table of verdicts to count")
    parser.add_argument("--figures", type=Path, help="a folder for the pictures named in the table")
    options = parser.parse_args(arguments)
    kinds = options.kinds or KINDS
    seen = []
    for s in survey(options.folder, options.only, options.workers, kinds):
        seen.append(s)
        if s.problem:
            print(f"{s.set}: {s.problem}", file=sys.stderr)
    print(markdown(table(seen, kinds)))
    if options.json:
        document = {"schema": "benchmarks.atlas/1", "clips": [asdict(s) for s in seen]}
        options.json.write_text(json.dumps(document), encoding="utf-8")
    if options.pictures:
        draw(options.folder, sample(seen, options.most, options.seed), options.pictures)
    if options.blind:
        finds = sample(seen, options.most, options.seed)
        draw_blind(options.folder, finds, options.blind, joints=bool(options.kinds))
    if options.verdicts:
        with options.verdicts.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        for by in (("kind",), ("kind", "applied"), ("set", "kind")):
            print(f"\n{markdown(precision(rows, *by))}")
        if options.figures:
            figures(options.folder, seen, rows, options.figures)
    return 1 if any(s.problem for s in seen) else 0


def draw(folder: Path, finds: Sequence[tuple[str, Find]], output: Path) -> None:
    """Draw contact sheets of detections, and write a table in which a judge enters the verdicts."""
    from benchmarks.atlas_pictures import A_SHEET, sheet

    output.mkdir(parents=True, exist_ok=True)
    rows = [(name, folder / name / find.clip, find) for name, find in finds]
    for start in range(0, len(rows), A_SHEET):
        sheet(rows[start : start + A_SHEET], output / f"{start:04d}.png", start)
    with (output / "verdicts.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("number", *COLUMNS, "verdict", "why"))
        for k, (name, find) in enumerate(finds):
            own = asdict(find) | {"set": name, "applied": "yes" if find.applied else "no"}
            writer.writerow((k, *(own[c] for c in COLUMNS), "", ""))


def draw_blind(
    folder: Path,
    finds: Sequence[tuple[str, Find]],
    output: Path,
    seed: int = 19,
    *,
    joints: bool = False,
) -> None:
    """Draw numbered pictures of the detections in random order, and write a key for them.

    The judges do not open the key. :mod:`benchmarks.blind_verdicts` evaluates their verdicts. If
    `joints` is True, the body and one joint are drawn instead of the chain.
    """
    from benchmarks.atlas_pictures import picture
    from benchmarks.joint_pictures import joint_picture

    output.mkdir(parents=True, exist_ok=True)
    finds = random.Random(seed).sample(finds, len(finds))
    columns = ("set", *(f.name for f in fields(Find) if f.name not in ("offset", "carried")))
    with (output / "key.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, ("number", *columns), extrasaction="ignore")
        writer.writeheader()
        for k, (name, find) in enumerate(finds):
            own = asdict(find) | {"set": name, "applied": "yes" if find.applied else "no"}
            writer.writerow({"number": k, **own})
            clip, to = folder / name / find.clip, output / f"{k:03d}.png"
            if joints:
                joint_picture(clip, find, to, f"{k:03d}")
            else:
                picture(clip, find, to, bare=True)


def figures(
    folder: Path, seen: Iterable[Seen], verdicts: Iterable[Mapping[str, str]], output: Path
) -> None:
    """Draw each detection for which a verdict names a picture.

    Bones are drawn as lines unless the set may be published.
    """
    from benchmarks.atlas_pictures import picture

    def key(name: str, find: Mapping[str, object]) -> tuple[str, ...]:
        columns = ("clip", "chain", "joint", "kind", "start", "stop")
        return name, *(str(find[column]) for column in columns)

    output.mkdir(parents=True, exist_ok=True)
    finds = {key(s.set, asdict(f)): f for s in seen for f in s.finds}
    for row in verdicts:
        name, found = row["set"], finds.get(key(row["set"], row))
        if row.get("picture") and found:
            to = output / f"atlas-{row['picture']}.png"
            picture(folder / name / found.clip, found, to, bare=not name.startswith(FREE))


if __name__ == "__main__":
    sys.exit(main())
