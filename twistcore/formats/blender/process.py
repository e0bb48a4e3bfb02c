"""Open a scene in a separate Blender process, and return its bones as arrays.

Blender is licensed under the GPL, so it is neither imported nor a dependency. It is run as the
program `blender`, or as a Python in which the module bpy is installed.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.files.ordinary import real_path
from twistcore.skeleton.rotation import Array
from twistcore.work.with_parent import parent_bound_command

VARIABLE = "TWIST_BLENDER"
TIME_LIMIT = 600.0  # seconds that Blender may take by default
# Metres per length unit. Nearly all programs write FBX in centimetres; glTF is always in metres.
SUFFIXES: Mapping[str, float] = MappingProxyType(
    {".fbx": 0.01, ".glb": 1.0, ".gltf": 1.0, ".blend": 1.0}
)
_NEEDED = (
    "Blender was not found: install it so that `blender` is on the path, or specify it (or a "
    f"Python that has the module bpy) with --blender or the environment variable {VARIABLE}"
)


@dataclass(frozen=True, eq=False)
class Handover:
    """The skeleton and motion that Blender read from a scene.

    Coordinates are Blender's, with Z up, in metres.

    Parameters
    ----------
    names
        Names of the bones, parents before children.
    parents
        Index of each bone's parent, or −1 for a root, shape (bones,).
    rest
        Matrices of the bones in the rest pose, shape (bones, 4, 4).
    tails
        Positions of the bones' ends in the rest pose, shape (bones, 3).
    poses
        Matrices of the bones in each frame, shape (frames, bones, 4, 4).
    fps
        Frames per second.
    figure, take
        Names of the figure and the take.
    blender
        Blender's version.
    """

    names: tuple[str, ...]
    parents: NDArray[np.int64]
    rest: Array
    tails: Array
    poses: Array
    fps: float
    figure: str
    take: str
    blender: str


def find_blender(named: str | None = None) -> str:
    """Return the path of the program to run as Blender.

    The candidates are, in this order: the program `named`, the program in the environment variable
    TWIST_BLENDER, `blender` on the path, and this Python if it has bpy. Raises TwistError if there
    is none, or if the program that the user named cannot be run.
    """
    for program, by in ((named, "--blender"), (os.environ.get(VARIABLE), VARIABLE)):
        if program:
            found = shutil.which(program)
            if found is None:
                raise TwistError(f"{by}: {program!r} is not a program that can be run")
            return found
    found = shutil.which("blender")
    if found is not None:
        return found
    if find_spec("bpy") is not None:  # found without importing it
        return sys.executable
    raise TwistError(_NEEDED)


def read_scene(
    source: Path,
    blender: str,
    *,
    take: str | None = None,
    figure: str | None = None,
    fps: float | None = None,
    time_limit: float = TIME_LIMIT,
) -> Handover:
    """Open a scene in Blender, sample its skeleton's motion, and wait until Blender ends.

    Parameters
    ----------
    source
        The scene file.
    blender
        The program, from :func:`find_blender`.
    take, figure
        Names of the take and the figure to read if there are several.
    fps
        Frame rate to use instead of the scene's.
    time_limit
        The longest time that Blender may take, in seconds.

    Raises
    ------
    TwistError
        If there is no skeleton or more than one, or if Blender fails or takes too long.
    """
    if not source.is_file():
        raise TwistError(f"{source}: the file does not exist")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        job, script = folder / "job.json", folder / "read_scene.py"
        words = {"source": str(real_path(source)), "take": take, "figure": figure, "fps": fps}
        job.write_text(json.dumps({**words, "out": str(folder)}))
        text = (files("twistcore.formats.blender") / "read_scene.py.txt").read_text("utf-8")
        script.write_text(text, "utf-8")
        last = _run(_command(blender, script, job), folder, source, time_limit)
        answer = folder / "answer.json"
        if not answer.is_file():
            raise TwistError(f"{source}: Blender exited without a result ({last})")
        found = json.loads(answer.read_text("utf-8"))
        if "error" in found:
            raise TwistError(f"{source}: {' '.join(found['error'].split())}")
        with np.load(folder / "arrays.npz", allow_pickle=False) as arrays:
            return Handover(
                tuple(found["names"]),
                np.array(found["parents"], dtype=np.int64),
                arrays["rest"],
                arrays["tails"],
                arrays["poses"],
                float(found["fps"]),
                found["figure"],
                found["take"],
                found["blender"],
            )


def _command(blender: str, script: Path, job: Path) -> list[str]:
    if Path(blender).name.lower().startswith("python"):
        return [blender, "-I", str(script), str(job)]
    options = ["--background", "--factory-startup", "--disable-autoexec", "-noaudio"]
    return [blender, *options, "--python", str(script), "--", str(job)]


def _run(command: Sequence[str], folder: Path, source: Path, time_limit: float) -> str:
    """Run a command, and return a string with its exit code and its last line of output.

    Raises TwistError if the command cannot be run or exceeds the time limit. In the latter case,
    the process is killed. `folder` is used for temporary files.
    """
    # When run as a module, Blender does not remove its temporary folder. Create that folder in
    # `folder`.
    own = {**os.environ, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))}
    with (folder / "said.txt").open("w+b") as said:
        try:
            process = subprocess.Popen(
                parent_bound_command(command),
                env=own,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=said,
                start_new_session=True,
            )
        except OSError as error:
            raise TwistError(f"{command[0]} cannot be run ({error.strerror})") from None
        try:
            process.wait(time_limit)
        except subprocess.TimeoutExpired:
            raise TwistError(
                f"{source}: Blender did not finish within {time_limit:g} s; raise the limit with "
                "--time-limit"
            ) from None
        finally:
            with contextlib.suppress(OSError):
                if process.poll() is None:
                    _end(process)
        said.seek(0)
        lines = said.read().decode("utf-8", "replace").split("\n")
    output = [line.strip() for line in lines if line.strip()]
    return f"exit {process.returncode}" + (f": {output[-1]:.200}" if output else "")


def _end(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all its child processes."""
    if os.name == "posix":
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()
