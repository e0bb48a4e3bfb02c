"""Pictures of a report, drawn by another process: the desktop program has what draws bodies.

What is to be drawn goes there as files in a folder, and pictures come back in it: nothing here
knows Qt or VTK, and a driver that takes its process along takes no report.
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.files.encoding import json_bytes
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.work.frozen import dataclass
from twistcore.work.with_parent import python_bound

PROGRAM = "inspector.recording.report_pictures"
SCHEMA = "twistcore.report_pictures/1"
SIZE = (400, 320)  # pixels
_JOB = "job.json"
_NEEDED = ("inspector", "PySide6", "vtkmodules")
NOT_INSTALLED = 'the window is not installed (pip install "twist-inspector[gui]" brings it)'
_NO_LIBRARY = re.compile(r"(\S+\.so\S*): cannot open shared object file")
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")  # of a terminal, which VTK's log writes
_SAMPLE = 60  # frames of a clip from which its figure is judged
_TO_START, _TO_DRAW = 60.0, 3.0  # seconds until a process is given up, and more for every pair
_SCREEN = ("DISPLAY", "WAYLAND_DISPLAY")  # it is to draw without one


@dataclass(frozen=True)
class BeforeAfter:
    """Two pictures from one side, before and after a correction.

    chain: the name of what is looked at; first, second: where the two poses stand in the motion.
    """

    chain: str
    first: int
    second: int


@dataclass(frozen=True, eq=False)
class Figure:
    """What is drawn of one clip: some frames of its motion, the poses of the pairs behind them.

    chains: limbs too; they say which limbs wear a skin, and which way the figure faces.
    """

    motion: Motion
    chains: tuple[Chain, ...]
    pairs: tuple[BeforeAfter, ...]


@dataclass(frozen=True)
class Drawn:
    """JPEG pictures of every pair in the order asked for, or in one line why there are none."""

    pictures: tuple[tuple[bytes, bytes], ...] = ()
    problem: str = ""


def figure_of(
    before: Motion, after: Motion, chains: Sequence[Chain], wanted: Sequence[tuple[str, int]]
) -> Figure:
    """Pairs at (chain's name, frame); before, after: the motions that poses are taken from."""
    count = min(before.frames, _SAMPLE)
    some = np.linspace(0, before.frames - 1, count).astype(np.intp)
    frames = np.array([frame for _, frame in wanted], dtype=np.intp)
    parts = before.at(some), before.at(frames), after.at(frames)
    motion = Motion(
        before.skeleton,
        np.concatenate([p.rotations for p in parts]),
        before.positioned,
        np.concatenate([p.positions for p in parts]),
        before.frame_time,
    )
    pairs = [BeforeAfter(n, count + k, count + len(wanted) + k) for k, (n, _) in enumerate(wanted)]
    return Figure(motion, tuple(chains), tuple(pairs))


def draw_figures(
    figures: Sequence[Figure], python: Sequence[str] = (sys.executable,)
) -> list[Drawn]:
    """The pictures of every figure, all by one process; nothing is raised where it fails."""
    total = sum(len(figure.pairs) for figure in figures)
    if not total:
        return [Drawn() for _ in figures]
    if any(importlib.util.find_spec(name) is None for name in _NEEDED):
        return [Drawn(problem=NOT_INSTALLED)] * len(figures)
    with tempfile.TemporaryDirectory(prefix="twist-pictures-") as name:
        folder = Path(name)
        write_job(folder, figures)
        problem = _run([*python, *python_bound(PROGRAM, name)[1:]], _TO_START + _TO_DRAW * total)
        return [_come_back(folder, k, figure, problem) for k, figure in enumerate(figures)]


def _run(command: Sequence[str], seconds: float) -> str:
    """Why a process did not end well, '' if it did."""
    environment = {k: v for k, v in os.environ.items() if k not in _SCREEN}
    try:
        ended = subprocess.run(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"the process that draws them took longer than {seconds:.0f} s"
    except OSError as error:
        return f"the process that draws them did not start ({error.strerror})"
    if ended.returncode == 0:
        return ""
    said = _COLOURS.sub("", ended.stderr.decode("utf-8", "replace")).strip().splitlines()
    last = said[-1].strip() if said else f"it ended with {ended.returncode}"
    if absent := _NO_LIBRARY.search(last):
        return f"this system lacks {absent[1]}; twist-inspector says which command installs it"
    return f"the process that draws them failed: {last:.200}"


def _come_back(folder: Path, number: int, figure: Figure, problem: str) -> Drawn:
    pictures = []
    for k in range(len(figure.pairs)):
        files = [picture_path(folder, number, k, which) for which in (0, 1)]
        if not all(file.is_file() for file in files):
            return Drawn(problem=problem or "the process that draws them left some out")
        before, after = (file.read_bytes() for file in files)
        pictures.append((before, after))
    return Drawn(tuple(pictures))


def picture_path(folder: Path, figure: int, pair: int, which: int) -> Path:
    """Where a picture of a job is put; which: 0 before, 1 after."""
    return folder / f"{figure}-{pair}-{which}.jpg"


# -- the files of a job ----------------------------------------------------------------------------


def write_job(folder: Path, figures: Sequence[Figure]) -> None:
    """Put what is to be drawn into a folder."""
    for k, figure in enumerate(figures):
        motion = figure.motion
        np.savez(
            folder / f"{k}.npz",
            parents=motion.skeleton.parents,
            offsets=motion.skeleton.offsets,
            end_joints=np.array([joint for joint, _ in motion.skeleton.ends], dtype=np.int64),
            end_offsets=np.array([o for _, o in motion.skeleton.ends]).reshape(-1, 3),
            rotations=motion.rotations,
            positioned=np.array(motion.positioned, dtype=np.int64),
            positions=motion.positions,
        )
    document = {
        "schema": SCHEMA,
        "size": list(SIZE),
        "figures": [
            {
                "names": list(figure.motion.skeleton.names),
                "frame_time": figure.motion.frame_time,
                "chains": [_chain_to_json(chain) for chain in figure.chains],
                "pairs": [vars(pair) for pair in figure.pairs],
            }
            for figure in figures
        ],
    }
    (folder / _JOB).write_bytes(json_bytes(document))


def read_job(folder: Path) -> tuple[tuple[int, int], list[Figure]]:
    """The size of the pictures and what is to be drawn, from the files of :func:`write_job`."""
    document = json.loads((folder / _JOB).read_bytes())
    if document["schema"] != SCHEMA:
        raise ValueError(f"expected schema {SCHEMA!r}")
    width, height = document["size"]
    return (width, height), [
        _figure_from(folder / f"{k}.npz", entry) for k, entry in enumerate(document["figures"])
    ]


def _figure_from(path: Path, entry: dict[str, Any]) -> Figure:
    with np.load(path, allow_pickle=False) as arrays:
        ends = zip(arrays["end_joints"].tolist(), arrays["end_offsets"].tolist(), strict=True)
        skeleton = Skeleton(
            tuple(entry["names"]),
            arrays["parents"],
            arrays["offsets"],
            tuple((joint, (x, y, z)) for joint, (x, y, z) in ends),
        )
        motion = Motion(
            skeleton,
            arrays["rotations"],
            tuple(arrays["positioned"].tolist()),
            arrays["positions"],
            entry["frame_time"],
        )
    chains = tuple(_chain_from(chain) for chain in entry["chains"])
    return Figure(motion, chains, tuple(BeforeAfter(**pair) for pair in entry["pairs"]))


def _chain_to_json(chain: Chain) -> dict[str, Any]:
    """What a body is drawn by; an axis that varies is told as it is in the first frame."""
    axis, arm = (np.atleast_2d(v)[0].tolist() for v in (chain.axis, chain.arm))
    keys = ("name", "parent", "child", "grandchild", "side", "segment", "person")
    own = {key: getattr(chain, key) for key in keys}
    return own | {"axis": axis, "arm": arm, "limb": isinstance(chain, Limb)}


def _chain_from(entry: dict[str, Any]) -> Chain:
    own = {k: v for k, v in entry.items() if k not in ("axis", "arm", "limb")}
    kind = Limb if entry["limb"] else Chain
    return kind(axis=np.array(entry["axis"]), arm=np.array(entry["arm"]), **own)
