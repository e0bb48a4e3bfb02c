"""Our export in Blender: python -m benchmarks.blender_check FILE-OR-FOLDER… [--blender PYTHON].

Every rotation number of each clip is written anew from quaternions; Blender imports the file, and
the heads of its bones are compared with our joints in up to 40 frames, of the skeleton's height
(expected ≤ 1e-3). Exit status 1 if any is further away.

PYTHON is an interpreter that can import bpy; it may be another than this one, since bpy comes for
one version of Python only: python3.11 -m venv v && v/bin/pip install bpy==4.5.* numpy
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

MOST = 1e-3
FRAMES = 40


def export(source: Path, folder: Path) -> Path:
    """Write the clip anew into `folder`, and beside it where its joints are."""
    from benchmarks.bvh_crosscheck import rewritten
    from twistcore.bvh import read_bvh
    from twistcore.motion import forward_kinematics

    clip = read_bvh(source)
    out = folder / "again.bvh"
    out.write_bytes(rewritten(clip))
    positions = forward_kinematics(clip.motion)[1]
    frames = np.arange(0, len(positions), max(1, len(positions) // FRAMES))
    height = clip.skeleton.height
    np.savez(out.with_suffix(".npz"), frames=frames, positions=positions[frames] / height)
    out.with_suffix(".json").write_text(json.dumps([list(clip.skeleton.names), height]))
    return out


def in_blender(path: Path) -> dict[str, Any]:
    """Import an export into Blender and compare; runs where bpy is, without twistcore."""
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
            if distance > worst:
                worst, where = distance, f"{name}, frame {frame}"
    version = bpy.app.version_string
    return {"worst": worst, "where": where, "missing": missing, "blender": version}


def compared(source: Path, blender: str) -> dict[str, Any]:
    """What `in_blender` found for one clip; raises RuntimeError where Blender could not read it."""
    with tempfile.TemporaryDirectory() as folder:
        path = export(source, Path(folder))
        command = [blender, __file__, "--inside", str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError((done.stderr.strip() or done.stdout.strip()).splitlines()[-1])
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def main() -> int:
    """Print one line a clip."""
    if sys.argv[1:2] == ["--inside"]:
        with contextlib.redirect_stdout(sys.stderr):
            found = in_blender(Path(sys.argv[2]))
        print(json.dumps(found), flush=True)
        os._exit(0)  # Blender's own clean-up may crash as a module, long after the result
    from twistcore.errors import BvhError

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
            found = compared(path, arguments.blender)
        except (BvhError, RuntimeError) as error:
            print(f"{path.name}: {error}")
            wrong += isinstance(error, RuntimeError)
            continue
        worst = max(worst, found["worst"])
        note = f" ({len(found['missing'])} names unknown there)" if found["missing"] else ""
        if found["worst"] > MOST:
            note, wrong = f" at {found['where']} <-- differs", wrong + 1
        print(f"{path.name}: {found['worst']:.1e}{note}  Blender {found['blender']}", flush=True)
    print(f"{len(files)} files, {wrong} differ or were refused; worst {worst:.1e} of the height")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
