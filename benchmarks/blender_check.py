"""Compare exported files with Blender.

    python -m benchmarks.blender_check FILE-OR-FOLDER… [--blender PYTHON]

Two files are written for each clip. In the first, every rotation is computed again from
quaternions. In the second, all detections of `refine` are also corrected. Blender imports both
files, and the heads of its bones are compared with our joints in up to 40 frames, including
corrected ones. The distances are shares of the skeleton's height (expected ≤ 1e-3). The exit status
is 1 if any distance is larger.

PYTHON is an interpreter that can import bpy. It may differ from this one, because bpy exists for
only one version of Python: python3.11 -m venv v && v/bin/pip install bpy==4.5.* numpy
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from twistcore.formats.clip import Clip

MOST = 1e-3
FRAMES = 40


def export(source: Path, folder: Path) -> list[Path]:
    """Write a clip into `folder`, rewritten and corrected, each with its joint positions."""
    from benchmarks._refined import EVERYTHING, refine_file
    from benchmarks.bvh_crosscheck import rewritten
    from twistcore.formats.bvh import read_bvh

    clip = read_bvh(source)
    again, corrected = folder / "again.bvh", folder / "corrected.bvh"
    again.write_bytes(rewritten(clip))
    note_joints(again, clip, ())
    refine_file(source, corrected, *EVERYTHING)
    after = read_bvh(corrected)
    changed = (clip.motion.rotations != after.motion.rotations).any(axis=(1, 2))
    note_joints(corrected, after, np.flatnonzero(changed))
    return [again, corrected]


def note_joints(out: Path, clip: Clip, also: Sequence[int] | NDArray[np.int64]) -> None:
    """Write the joint positions of some frames next to a file.

    The frames are evenly spaced, plus some of the frames in `also`.
    """
    from twistcore.skeleton.motion import forward_kinematics

    positions = forward_kinematics(clip.motion)[1]
    spread = np.arange(0, len(positions), max(1, len(positions) // FRAMES))
    among = np.asarray(also, dtype=int)[:: max(1, len(also) // FRAMES)]
    frames = np.union1d(spread, among)
    height = clip.skeleton.height
    np.savez(out.with_suffix(".npz"), frames=frames, positions=positions[frames] / height)
    out.with_suffix(".json").write_text(json.dumps([list(clip.skeleton.names), height]))


def in_blender(path: Path) -> dict[str, Any]:
    """Import a file into Blender, and compare its joint positions with ours.

    The function runs with bpy, without twistcore.
    """
    import bpy

    names, height = json.loads(path.with_suffix(".json").read_text())
    ours = np.load(path.with_suffix(".npz"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_anim.bvh(
        filepath=str(path), axis_forward="Y", axis_up="Z", rotate_mode="NATIVE", frame_start=1
    )
    rig = bpy.context.object
    missing = [name for name in names if name not in rig.pose.bones]
    worst, where = 0.0, ""
    for frame, positions in zip(ours["frames"].tolist(), ours["positions"], strict=True):
        bpy.context.scene.frame_set(frame + 1)
        for name, position in zip(names, positions, strict=True):
            if name in missing:
                continue
            head = np.array(rig.matrix_world @ rig.pose.bones[name].head) / height
            distance = float(np.abs(head - position).max())
            if not distance <= worst:  # NaN counts as the worst
                worst, where = distance, f"{name}, frame {frame}"
    version = bpy.app.version_string
    return {"worst": worst, "where": where, "missing": missing, "blender": version}


def compared(source: Path, blender: str) -> list[dict[str, Any]]:
    """Return the results of `in_blender` for a clip, rewritten and corrected.

    `blender` is the interpreter that can import bpy. Raises RuntimeError if Blender cannot read a
    file, and TwistError if twistcore cannot.
    """
    with tempfile.TemporaryDirectory() as folder:
        paths = map(str, export(source, Path(folder)))
        command = [blender, __file__, "--inside", *paths]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = (done.stderr.strip() or done.stdout.strip() or "no word").splitlines()
        said = [line for line in lines if "Error" in line]
        raise RuntimeError((said or lines)[-1])
    found: list[dict[str, Any]] = json.loads(done.stdout.splitlines()[-1])
    return found


def main() -> int:
    """Compare every clip and print one line for each."""
    if sys.argv[1:2] == ["--inside"]:
        with contextlib.redirect_stdout(sys.stderr):
            found = [in_blender(Path(name)) for name in sys.argv[2:]]
        print(json.dumps(found), flush=True)
        os._exit(0)  # as a module, Blender may crash in its clean-up, after the result
    from twistcore.errors import TwistError

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sources", nargs="+", type=Path)
    parser.add_argument("--blender", default=sys.executable, metavar="PYTHON")
    arguments = parser.parse_args()
    files = sorted(
        file for s in arguments.sources for file in (s.rglob("*.bvh") if s.is_dir() else [s])
    )
    worst, wrong = 0.0, 0
    for path in files:
        try:
            again, corrected = compared(path, arguments.blender)
        except (TwistError, RuntimeError) as error:
            print(f"{path.name}: {error}")
            wrong += isinstance(error, RuntimeError)
            continue
        worst = max(worst, again["worst"], corrected["worst"])
        note = f" ({len(again['missing'])} names unknown there)" if again["missing"] else ""
        for found in (again, corrected):
            if not found["worst"] <= MOST:
                note, wrong = f" at {found['where']} <-- differs", wrong + 1
        said = f"{again['worst']:.1e} written, {corrected['worst']:.1e} corrected"
        print(f"{path.name}: {said}{note}  Blender {again['blender']}", flush=True)
    print(f"{len(files)} files, {wrong} different or refused; worst {worst:.1e} of the height")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
