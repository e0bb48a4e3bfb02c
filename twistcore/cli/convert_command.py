"""Run `twistcore convert`, which converts scenes to BVH with Blender, and clips to glTF."""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    parse_frame_rate,
    parse_output_path,
    parse_positive_number,
)
from twistcore.cli.arguments.common_arguments import add_output, deferred_command
from twistcore.cli.output import print_note as tell_note
from twistcore.cli.output import print_remark, refuse_overwrite
from twistcore.errors import TwistError
from twistcore.files.atomic import is_stream


def add_convert(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `twistcore convert` to a parser."""
    parser.add_argument(
        "scene", type=Path, metavar="IN", help="the FBX, GLB, glTF or .blend file, or a clip"
    )
    what = "BVH to write, or .glb for a clip; '-' is standard output, for BVH"
    add_output(parser, what, parse_output_path)
    parser.add_argument(
        "--blender",
        metavar="PATH",
        help="Blender, or a Python that has the module bpy (default: the first of these that "
        "exists: the environment variable TWIST_BLENDER, `blender` on the path, bpy in this "
        "Python)",
    )
    for name, what in (("--take", "take"), ("--armature", "armature")):
        parser.add_argument(
            name,
            metavar="NAME",
            help=f"{what} to convert if there are several (default: the only one)",
        )
    parser.add_argument(
        "--fps",
        type=parse_frame_rate,
        metavar="HZ",
        help="frame rate to use (default: the scene's)",
    )
    parser.add_argument(
        "--unit",
        type=parse_positive_number,
        metavar="METRES",
        help="length of one unit of the BVH or the clip (default: 0.01 for FBX, 1 for the others)",
    )
    parser.add_argument(
        "--time-limit",
        type=parse_positive_number,
        metavar="SECONDS",
        help="time after which Blender is stopped (default: 600)",
    )
    parser.set_defaults(run=deferred_command("convert_command", "convert_command"))


def convert_command(arguments: argparse.Namespace) -> int:
    """Write the BVH or the GLB, and return the exit code."""
    if arguments.output.suffix.lower() == ".glb":
        return _write_glb(arguments)
    from twistcore.formats import blender as scenes
    from twistcore.formats.blender.scene_motion import write_as_bvh  # scipy.spatial

    source, output = arguments.scene, arguments.output
    if output.suffix.lower() != ".bvh" and not is_stream(output):
        raise TwistError(f"{output}: expected a name that ends in .bvh or .glb")
    unit = scenes.SUFFIXES.get(source.suffix.lower())
    if unit is None:
        raise TwistError(
            f"{source}: expected a file whose name ends in one of {', '.join(scenes.SUFFIXES)}"
        )
    refuse_overwrite([output], [source])
    unit = arguments.unit or unit
    scene, found = write_as_bvh(
        source,
        output,
        scenes.find_blender(arguments.blender),
        unit=unit,
        take=arguments.take,
        figure=arguments.armature,
        fps=arguments.fps,
        time_limit=arguments.time_limit or scenes.TIME_LIMIT,
    )
    take = f", take {scene.take}" if scene.take else ""
    print_remark(
        f"{output}: {found.motion.frames} frames at {found.motion.fps:g} fps, "
        f"{len(found.motion.skeleton)} joints of {scene.figure}{take}; Y up, "
        f"one unit is {unit:g} m; Blender {scene.blender}"
    )
    for note in found.notes:
        tell_note(f"{output}: note: {note}")
    return 0


def _write_glb(arguments: argparse.Namespace) -> int:
    from twistcore.formats.glb import write_glb
    from twistcore.formats.reading import is_clip, read_clip
    from twistcore.formats.suffixes import CLIP_SUFFIXES
    from twistcore.skeleton.figure import figure_size
    from twistcore.skeleton.motion import forward_kinematics

    source, output = arguments.scene, arguments.output
    if not is_clip(source):
        names = ", ".join(CLIP_SUFFIXES)
        raise TwistError(
            f"{source}: to write a .glb, expected a clip, which is a file whose name ends in "
            f"{names}"
        )
    for name in ("blender", "take", "armature", "time_limit"):
        if getattr(arguments, name) is not None:
            option = name.replace("_", "-")
            raise TwistError(
                f"--{option} is only for scenes, but {source} is a clip; leave --{option} out"
            )
    refuse_overwrite([output], [source])
    motion = read_clip(source, fps=arguments.fps).motion
    unit = arguments.unit or 1.0
    write_glb(motion, output, unit=unit)
    height = unit * figure_size(forward_kinematics(motion)[1], motion.skeleton)
    print_remark(
        f"{output}: {motion.frames} frames at {motion.fps:g} fps, {len(motion.skeleton)} joints; "
        f"the figure is {height:.3g} m tall (--unit)"
    )
    return 0
