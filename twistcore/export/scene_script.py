"""Write the corrections as a script that sets keys in the scene from which the clip was exported.

The scene keeps its rig, meshes and namespaces. The script needs no other file. It contains the
keys, the computation in plain Python (not every program has numpy), and the part that controls the
program.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from twistcore.errors import TwistError
from twistcore.export.scene_keys import Reference, SceneKeys, scene_keys
from twistcore.review.model import Judged
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array

_IMPORTS = {
    "blender": "import bpy",
    "maya": "from maya import cmds",
    "motionbuilder": "import pyfbsdk as fb",
}
PROGRAMS = tuple(_IMPORTS)
_FITS = 0.01  # allowed distance as a share of the height: above rounding, below changes of the pose
_TOLERANCE = 0.5  # degrees

_HEADER = '''"""Corrections of {clip}: run this in {program} with the clip's original scene open.

The script first checks that the motion of the scene matches the clip. Then it sets keys for the
rotations of the joints in KEYS at the frames listed there, and nothing else. With DRY_RUN = True it
only reports. Frame f of the clip is at START + f · SCENE_FPS / CLIP_FPS in the scene.
"""

import math

{imports}

DRY_RUN = {dry_run}
CLIP = {clip_literal}
TAKE = {take}
START = {start:.9g}
SCENE_FPS = {scene_fps:.9g}
CLIP_FPS = {clip_fps:.9g}
FRAMES = {frames}
HEIGHT = {height:.9g}
FITS = {fits:g}  # share of the figure's height
TOLERANCE = {tolerance:g}  # degrees
'''


@dataclass(frozen=True)
class SceneOptions:
    """The scene in which a script sets keys, and the position of the clip's frames in it.

    Parameters
    ----------
    program
        One of PROGRAMS.
    namespace
        The prefix of every joint's name, before ':'. '' removes the namespace of the clip, and None
        keeps the names.
    take
        The take (in Blender the action) that must be active.
    fps
        The scene's frame rate, or None for the clip's.
    start
        The scene's frame at which the clip begins, or None for the program's default.
    dry_run
        True to report changes without making them.
    """

    program: str
    namespace: str | None = None
    take: str | None = None
    fps: float | None = None
    start: float | None = None
    dry_run: bool = False


def scene_script(
    clip: str,
    motion: Motion,
    corrected: Motion,
    intervals: Iterable[Judged],
    options: SceneOptions,
) -> str:
    """Return the text of a script that sets the corrections as animation keys.

    Parameters
    ----------
    clip
        Name of the clip's file.
    motion, corrected
        The motion before and after the correction.
    intervals
        The intervals that the script lists.
    options
        The scene and the position of the clip's frames in it.

    Raises
    ------
    TwistError
        If nothing is corrected, or if two joints would have the same name.
    """
    if options.program == "maya" and options.take is not None:
        raise TwistError("a Maya scene has no takes; leave --take out")
    keys = scene_keys(motion, corrected)
    names = _names(motion.skeleton.names, options.namespace)
    start = options.start
    if start is None:
        start = 1.0 if options.program == "blender" else 0.0
    safe = ascii(clip)[1:-1].replace("\\", "/").replace('"', "'")
    parts = [
        _HEADER.format(
            clip=safe,
            program={"blender": "Blender", "maya": "Maya"}.get(options.program, "MotionBuilder"),
            imports=_IMPORTS[options.program],
            dry_run=options.dry_run,
            clip_literal=ascii(clip),
            take=ascii(options.take),
            start=start,
            scene_fps=options.fps or motion.fps,
            clip_fps=motion.fps,
            frames=motion.frames,
            height=motion.skeleton.height,
            fits=_FITS,
            tolerance=_TOLERANCE,
        ),
        _interval_lines(intervals, [names[j] for j in keys.unseen]),
        _data(keys, names),
        _template(options.program),
        _template("common"),
    ]
    return "\n".join(parts)


def _names(names: Sequence[str], namespace: str | None) -> list[str]:
    """Return the names of the joints in the scene. Raises TwistError if they are not unique."""
    if namespace is None:
        return list(names)
    if namespace == "":
        bare = [name.rpartition(":")[2] for name in names]
        if len(set(bare)) < len(bare):
            raise TwistError(
                "--namespace '' cannot be used, because two joints would have the same name"
            )
        return bare
    return [f"{namespace.removesuffix(':')}:{name}" for name in names]


def _interval_lines(intervals: Iterable[Judged], unseen: Sequence[str]) -> str:
    """Return Python code that assigns a list of lines, one per interval, which the script prints.

    `unseen` are the names of the joints that are corrected in every frame.
    """
    lines = []
    for judged in intervals:
        i = judged.interval
        by = f" by {judged.reviewer}" if judged.reviewer else ""
        size = f"{np.degrees(i.size):+.1f} degrees"
        what = f"{i.kind} of {i.joint}" if i.kind.info.repairer else i.kind
        lines.append(f"{i.chain} {what}, frames {i.start}-{i.stop}, {size}, {judged.verdict}{by}")
    if unseen:
        lines.append(
            f"{', '.join(unseen)}: corrected in every frame, so the script cannot detect whether "
            "it was run before; run it only once"
        )
    return "INTERVALS = [\n" + "".join(f"    {line!a},\n" for line in lines) + "]\n"


def _data(keys: SceneKeys, names: Sequence[str]) -> str:
    lines = ["# by joint: (frame of the clip, rotation before, rotation after), w x y z"]
    lines.append("KEYS = {")
    for joint, at in keys.frames.items():
        lines.append(f"    {names[joint]!a}: [")
        rows = zip(at.tolist(), keys.before[joint], keys.after[joint], strict=True)
        lines += [f"        ({frame}, {_tuple(old)}, {_tuple(new)})," for frame, old, new in rows]
        lines.append("    ],")
    lines += [
        "}",
        "# frames without corrections, which show the scene's axes",
    ]
    lines.append("REFERENCES = [")
    for reference in keys.references:
        lines += _reference(reference, names)
    lines.append("]\n")
    return "\n".join(lines)


def _reference(reference: Reference, names: Sequence[str]) -> list[str]:
    lines = ["    {", f'        "frame": {reference.frame},', '        "positions": {']
    for name, place in zip(names, reference.positions, strict=True):
        lines.append(f"            {name!a}: {_tuple(place)},")
    lines += ["        },", '        "joints": {']
    for joint, (above, own) in reference.joints.items():
        lines.append(f"            {names[joint]!a}: ({_tuple(above)}, {_tuple(own)}),")
    return [*lines, "        },", "    },"]


def _tuple(vector: Array) -> str:
    return f"({', '.join(f'{v:.9g}' for v in vector.tolist())})"


def _template(name: str) -> str:
    return (files("twistcore.export") / "scene_templates" / f"{name}.py.txt").read_text("utf-8")
