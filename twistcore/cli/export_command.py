"""`twistcore export`: what a session has accepted, as a script for the scene the clip came from."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from twistcore.atomic import write_atomically
from twistcore.cli.argument_types import number, positive, target
from twistcore.cli.output import refuse_overwrite
from twistcore.errors import TwistError
from twistcore.export.replay import accepted_motion, chains_of
from twistcore.export.scene_script import PROGRAMS, SceneOptions, scene_script
from twistcore.formats import read_clip
from twistcore.review import Decision, read_session


def add_export(subparsers: argparse._SubParsersAction[Any]) -> None:
    """The command's words."""
    parser = subparsers.add_parser("export", help="keys for the scene that a clip came from")
    parser.add_argument("session", type=Path, metavar="SESSION")
    parser.add_argument("clip", type=Path, metavar="CLIP")
    parser.add_argument(
        "--script",
        choices=PROGRAMS,
        required=True,
        help="a script that keys the accepted intervals on the scene's joints (docs/pipelines.md)",
    )
    parser.add_argument("-o", "--output", type=target, required=True, metavar="FILE.py")
    parser.add_argument(
        "--namespace", metavar="NAME", help="of the scene's joints; '': take off the clip's own"
    )
    parser.add_argument("--take", metavar="NAME", help="in which to key; in Blender the action")
    parser.add_argument("--fps", type=positive, help="the scene's rate; default the clip's")
    parser.add_argument(
        "--start", type=number, help="the scene's frame of frame 0; default 0, in Blender 1"
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="let the script only tell what it would key"
    )
    parser.set_defaults(run=export)


def export(arguments: argparse.Namespace) -> int:
    """Write the script."""
    session = read_session(arguments.session)
    clip = read_clip(arguments.clip, fps=session.fps)
    refuse_overwrite([arguments.output], [arguments.clip, arguments.session])
    state = session.state
    corrected = accepted_motion(clip, chains_of(session, clip), state)
    accepted = [
        j for j in state.intervals if j.decision == Decision.ACCEPTED and j.interval.repairable
    ]
    options = SceneOptions(
        arguments.script,
        arguments.namespace,
        arguments.take,
        arguments.fps,
        arguments.start,
        arguments.dry_run,
    )
    try:
        text = scene_script(clip.name, clip.motion, corrected, accepted, options)
    except TwistError as error:
        raise TwistError(f"{arguments.session}: {error}") from None
    write_atomically(arguments.output, text.encode("utf-8"))
    joints = int((clip.motion.rotations != corrected.rotations).any(axis=(0, 2)).sum())
    count = f"{len(accepted)} interval{'' if len(accepted) == 1 else 's'}"
    print(f"{arguments.output}: {count} on {joints} joints, for {arguments.script}")
    return _tell_place(arguments, state.tracking is not None and state.tracking.place)


def _tell_place(arguments: argparse.Namespace, place: bool) -> int:
    """1, with a sentence, where a place was tracked: keys of rotations do not hold it."""
    if place:
        print(f"{arguments.output}: the tracked place of the figure is not among the keys")
    return int(place)
