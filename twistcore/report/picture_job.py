"""Draw the figures of a report in a separate process that runs the desktop program.

The figures are written into a folder, and the process writes the pictures into the same folder. For
a page that plays its intervals, the process also prepares the figure. Because of the separate
process, this module needs neither Qt nor VTK, and a crash of the graphics driver does not end the
report.
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.files.encoding import json_bytes
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.work.frozen import dataclass
from twistcore.work.with_parent import parent_bound_module_command

PROGRAM = "inspector.recording.report_pictures"
SCHEMA = "twistcore.report_pictures/1"
SIZE = (400, 320)  # pixels
_JOB = "job.json"
_NEEDED = ("inspector", "PySide6", "vtkmodules")
NOT_INSTALLED = 'the window is not installed (install it with pip install "twist-inspector[gui]")'
_NO_LIBRARY = re.compile(r"(\S+\.so\S*): cannot open shared object file")
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")  # codes of terminal colours in VTK's log
_SAMPLE = 60  # number of frames from which the body is estimated
_TO_START, _TO_DRAW = 60.0, 3.0  # seconds until a process is killed: in total, and per pair
_SCREEN = ("DISPLAY", "WAYLAND_DISPLAY")  # variables to remove, since drawing needs no screen


@dataclass(frozen=True)
class BeforeAfter:
    """Two poses to draw from the same viewpoint, before and after a correction.

    Attributes
    ----------
    chain
        Name of the chain in the centre of the pictures.
    first, second
        Frames of the two poses in the figure's motion.
    """

    chain: str
    first: int
    second: int


@dataclass(frozen=True, eq=False)
class Figure:
    """The poses to draw for one clip.

    Attributes
    ----------
    motion
        A motion with the poses as frames. It has further frames, from which the body's shape is
        estimated.
    chains
        The chains and limbs, which determine the figure's skin and its front.
    pairs
        The poses to draw as pictures.
    views
        The poses for which a page that plays its intervals needs a viewpoint, if any.
    """

    motion: Motion
    chains: tuple[Chain, ...]
    pairs: tuple[BeforeAfter, ...]
    views: tuple[BeforeAfter, ...] = ()


@dataclass(frozen=True)
class Drawn:
    """The pictures of a figure.

    Attributes
    ----------
    pictures
        A pair of JPEG files for each pair of poses, in order.
    problem
        The reason why there are no pictures, or ''.
    player
        The data for a page that plays its intervals: `figure`, `themes`, `ghost`, `scripts`, and
        one item of `views` for each view of the figure. Empty if the figure has no views.
    """

    pictures: tuple[tuple[bytes, bytes], ...] = ()
    problem: str = ""
    player: Mapping[str, Any] = field(default_factory=dict)


def make_clip_figure(
    before: Motion,
    after: Motion,
    chains: Sequence[Chain],
    wanted: Sequence[tuple[str, int]],
    views: Sequence[tuple[str, Motion, Motion]] = (),
) -> Figure:
    """Return a figure with the poses to draw for a clip.

    Parameters
    ----------
    before, after
        The motion before and after the correction.
    chains
        The chains and limbs.
    wanted
        The chain's name and the frame of each pair of pictures.
    views
        For each view, a chain's name and two motions of one frame, before and after the correction.
    """
    count = min(before.frames, _SAMPLE)
    some = np.linspace(0, before.frames - 1, count).astype(np.intp)
    frames = np.array([frame for _, frame in wanted], dtype=np.intp)
    poses = [pose for _, *both in views for pose in both]
    parts = before.at(some), before.at(frames), after.at(frames), *poses
    motion = Motion(
        before.skeleton,
        np.concatenate([p.rotations for p in parts]),
        before.positioned,
        np.concatenate([p.positions for p in parts]),
        before.frame_time,
    )
    pairs = [BeforeAfter(n, count + k, count + len(wanted) + k) for k, (n, _) in enumerate(wanted)]
    at = count + 2 * len(wanted)
    seen = [BeforeAfter(n, at + 2 * k, at + 2 * k + 1) for k, (n, *_) in enumerate(views)]
    return Figure(motion, tuple(chains), tuple(pairs), tuple(seen))


def draw_figures(
    figures: Sequence[Figure], python: Sequence[str] = (sys.executable,)
) -> list[Drawn]:
    """Draw all figures in one process. If drawing fails, the results contain the reason.

    `python` is the command that runs Python.
    """
    total = sum(len(figure.pairs + figure.views) for figure in figures)
    if not total:
        return [Drawn() for _ in figures]
    if any(importlib.util.find_spec(name) is None for name in _NEEDED):
        return [Drawn(problem=NOT_INSTALLED)] * len(figures)
    with tempfile.TemporaryDirectory(prefix="twist-pictures-") as name:
        folder = Path(name)
        write_report_picture_job(folder, figures)
        problem = _run(
            [*python, *parent_bound_module_command(PROGRAM, name)[1:]], _TO_START + _TO_DRAW * total
        )
        return [_read_pictures(folder, k, figure, problem) for k, figure in enumerate(figures)]


def _run(command: Sequence[str], seconds: float) -> str:
    """Run a command for at most `seconds`, and return the reason why it failed, or ''."""
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
        return f"the drawing process took longer than {seconds:.0f} s"
    except OSError as error:
        return f"the drawing process did not start ({error.strerror})"
    if ended.returncode == 0:
        return ""
    output = _COLOURS.sub("", ended.stderr.decode("utf-8", "replace")).strip().splitlines()
    last = output[-1].strip() if output else f"exit code {ended.returncode}"
    if absent := _NO_LIBRARY.search(last):
        return f"this system lacks {absent[1]}; twist-inspector shows the command to install it"
    return f"the drawing process failed: {last:.200}"


def _read_pictures(folder: Path, number: int, figure: Figure, problem: str) -> Drawn:
    pairs = [
        [picture_path(folder, number, k, which) for which in (0, 1)]
        for k in range(len(figure.pairs))
    ]
    player = player_path(folder, number)
    asked = [*(file for pair in pairs for file in pair), *([player] if figure.views else ())]
    if not all(file.is_file() for file in asked):
        return Drawn(problem=problem or "the drawing process did not draw all pictures")
    pictures = tuple((before.read_bytes(), after.read_bytes()) for before, after in pairs)
    return Drawn(pictures, player=json.loads(player.read_bytes()) if figure.views else {})


def picture_path(folder: Path, figure: int, pair: int, which: int) -> Path:
    """Return the path of a picture in a job's folder.

    `which` is 0 for the pose before the correction and 1 for the pose after it.
    """
    return folder / f"{figure}-{pair}-{which}.jpg"


def player_path(folder: Path, figure: int) -> Path:
    """Return the path of a figure's data for playing intervals, in a job's folder."""
    return folder / f"{figure}.player.json"


# -- the files of a job ----------------------------------------------------------------------------


def write_report_picture_job(folder: Path, figures: Sequence[Figure]) -> None:
    """Write figures into a folder, for :func:`read_picture_job`."""
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
                "views": [vars(view) for view in figure.views],
            }
            for figure in figures
        ],
    }
    (folder / _JOB).write_bytes(json_bytes(document))


def read_picture_job(folder: Path) -> tuple[tuple[int, int], list[Figure]]:
    """Return the picture size (width, height) and the figures that :func:`write_report_picture_job`
    wrote.

    Raises ValueError if the files have a different schema.
    """
    document = json.loads((folder / _JOB).read_bytes())
    if document["schema"] != SCHEMA:
        raise ValueError(f"expected the schema {SCHEMA!r}")
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
    pairs, views = (tuple(BeforeAfter(**pair) for pair in entry[k]) for k in ("pairs", "views"))
    return Figure(motion, chains, pairs, views)


def _chain_to_json(chain: Chain) -> dict[str, Any]:
    """Return the data of a chain for drawing. If the axis varies, its value in frame 0 is used."""
    axis, arm = (np.atleast_2d(v)[0].tolist() for v in (chain.axis, chain.arm))
    keys = ("name", "parent", "child", "grandchild", "side", "segment", "person")
    own = {key: getattr(chain, key) for key in keys}
    return own | {"axis": axis, "arm": arm, "limb": isinstance(chain, Limb)}


def _chain_from(entry: dict[str, Any]) -> Chain:
    own = {k: v for k, v in entry.items() if k not in ("axis", "arm", "limb")}
    kind = Limb if entry["limb"] else Chain
    return kind(axis=np.array(entry["axis"]), arm=np.array(entry["arm"]), **own)
