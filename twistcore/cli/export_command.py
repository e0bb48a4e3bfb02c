"""Run `twistcore export`, which writes accepted corrections as a script for a 3D program."""

from __future__ import annotations

import argparse
from dataclasses import replace

from twistcore.cli.clip_inputs import print_clip_notes
from twistcore.cli.output import count_with_noun, print_note, print_remark, refuse_overwrite
from twistcore.errors import TwistError
from twistcore.export.scene_script import SceneOptions, scene_script
from twistcore.files.atomic import write_atomically
from twistcore.formats.reading import read_clip
from twistcore.review import read_session
from twistcore.review.replay import accepted_motion, session_chains

_PROGRAMS = {"blender": "Blender", "maya": "Maya", "motionbuilder": "MotionBuilder"}


def export_command(arguments: argparse.Namespace) -> int:
    """Write the script and return the exit code, which is 1 if a tracked position is left out."""
    session = read_session(arguments.session)
    clip = read_clip(arguments.clip, fps=session.fps)
    refuse_overwrite([arguments.output], [arguments.clip, arguments.session])
    print_clip_notes(arguments.clip, clip)
    state = session.state
    corrected = accepted_motion(clip, session_chains(session, clip), state)
    accepted = [j for j in state.intervals if j.corrects]
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
    count = f"{count_with_noun(len(accepted), 'interval')} on {count_with_noun(joints, 'joint')}"
    if state.tracking is not None and state.tracking.joints:
        count += f", with tracking of {replace(state.tracking, place=False).what}"
    where = f"run it in {_PROGRAMS[arguments.script]}, with the scene of the clip open"
    print_remark(f"{arguments.output}: {count}; {where}")
    return _tell_place(arguments, state.tracking is not None and state.tracking.place)


def _tell_place(arguments: argparse.Namespace, place: bool) -> int:
    """Print a note and return 1 if the position was tracked, since the script sets no positions."""
    if place:
        print_note(
            f"{arguments.output}: only rotations are keyed, not the figure's tracked position"
        )
    return int(place)
