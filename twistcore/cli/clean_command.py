"""Run `twistcore clean`, which changes the angles, axes, units, names or frame rate of a clip."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from twistcore.cli.arguments.clean_arguments import NAMINGS
from twistcore.cli.clip_inputs import (
    clip_name_for_messages,
    read_clip_or_stdin,
    reading_assumption_sentences,
)
from twistcore.cli.output import (
    count_with_noun,
    print_json,
    print_note,
    print_problem,
    print_remark,
    refuse_overwrite,
    terminal_text,
)
from twistcore.errors import TwistError
from twistcore.export.compare import Deviation, largest_deviation
from twistcore.export.joint_map import joint_names_in_scheme, read_joint_names_for_export
from twistcore.files.atomic import is_stream, write_atomically
from twistcore.formats.bvh import BvhClip, parse_bvh, read_bvh, rewriting
from twistcore.formats.bvh.compose import bvh_text
from twistcore.formats.clip import Clip
from twistcore.formats.suffixes import clip_suffix
from twistcore.skeleton.figure import vertical_axis_letter
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array

# An option, a function that rewrites the clip, and a function that makes the same change in the
# motion, which is then compared with the written file.
Step: TypeAlias = tuple[str, Callable[[BvhClip], rewriting.Rewriting], Callable[[Motion], Motion]]

OPTIONS = ("up", "scale", "channels", "order", "unroll", "fps", "rename")  # in order of execution
LIMITS = 1e-4, 1e-4  # allowed differences of a written pose: degrees, share of the body height
Z_TO_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def clean_command(arguments: argparse.Namespace) -> int:
    """Rewrite the clip, read the new file, print the differences, and return the exit code."""
    output, name = arguments.output, clip_name_for_messages(arguments.clip)
    if not any(getattr(arguments, option) for option in OPTIONS):
        raise TwistError(
            "expected at least one option that changes the clip: "
            f"{', '.join(f'--{word}' for word in OPTIONS)}"
        )
    if arguments.keep_moving and not arguments.channels:
        raise TwistError("--keep-moving works only with --channels 3")
    if clip_suffix(output) not in ("", ".bvh"):
        raise TwistError(f"{output}: expected a name that ends in .bvh")
    table = [] if arguments.rename in (None, *NAMINGS) else [Path(arguments.rename)]
    refuse_overwrite([output], [arguments.clip, *table])
    source = read_clip_or_stdin(arguments.clip)
    clip = first = _as_bvh(source)
    said = [] if clip is source else ["written as a new BVH with six decimals"]
    expected = source.motion
    changes: list[tuple[str, rewriting.RewrittenJoint]] = []
    for option, step, moved in _steps(arguments, clip, said):
        done = step(clip)
        clip, expected = done.clip, moved(expected)
        changes += ((option, change) for change in done.changes)
        said += done.notes
    notes = [
        *reading_assumption_sentences(name, source),
        *(f"{name}: note: {sentence}" for sentence in said),
    ]
    write_atomically(output, clip.data)
    again = clip if is_stream(output) else read_bvh(output)
    found = largest_deviation(expected, again.motion)
    problems = _too_far(output, found)
    pairs = zip(first.skeleton.names, again.skeleton.names, strict=True)
    renamed = {old: new for old, new in pairs if old != new}
    if arguments.json:
        print_json(
            {
                "schema": "twistcore.clean/1",
                "clip": name,
                "output": str(output),
                "frames": again.frames,
                "fps": again.fps,
                "changes": [{"option": option} | asdict(change) for option, change in changes],
                "renamed": renamed,
                "largest": asdict(found),
                "notes": notes,
                "problems": problems,
            }
        )
    _print(output, (first, again), changes, renamed, found)
    for sentence in problems:
        print_problem(sentence)
    for sentence in notes:
        print_note(sentence)
    return int(bool(problems))


def _as_bvh(source: Clip) -> BvhClip:
    """Return the clip if it is a BVH, or a new BVH with the motion of the clip."""
    if isinstance(source, BvhClip):
        return source
    return parse_bvh(bvh_text(source.motion).encode("utf-8", "surrogateescape"), source.path)


def _steps(arguments: argparse.Namespace, clip: BvhClip, said: list[str]) -> Iterator[Step]:
    """Yield the steps for the chosen options.

    Notes about options without effect are appended to `said`.
    """
    for option, matrix in _axes(arguments, clip.motion, said):
        yield (
            option,
            partial(rewriting.change_axes_and_unit, matrix=matrix),
            partial(_in_axes, matrix=matrix),
        )
    if arguments.channels:
        keep = arguments.keep_moving
        yield (
            "channels",
            lambda c: rewriting.without_redundant_positions(c, keep_moving=keep),
            _same,
        )
    if arguments.order:
        yield "order", lambda c: rewriting.change_rotation_order(c, dict(arguments.order)), _same
    if arguments.unroll:
        yield "unroll", rewriting.unwrap_bvh_clip_angles, _same
    if fps := arguments.fps:
        times = rewriting.resampled_frame_times(clip.frames, clip.frame_time, fps)
        after = partial(rewriting.resample_motion, times=times, frame_time=1.0 / fps)
        yield "fps", lambda c: rewriting.resample_clip(c, fps), after
    if arguments.rename:
        names = _new_names(arguments.rename, clip, said)
        yield (
            "rename",
            lambda c: rewriting.with_joint_names(c, names),
            lambda m: _with_names(m, names),
        )


def _same(motion: Motion) -> Motion:
    return motion


def _axes(
    arguments: argparse.Namespace, motion: Motion, said: list[str]
) -> Iterator[tuple[str, Array]]:
    """Yield an option's name and matrix, (3, 3), for `--up` and `--scale` if they have an effect.

    A note about an option without effect is appended to `said`.
    """
    if up := arguments.up:
        if vertical_axis_letter(motion) != up:
            yield "up", Z_TO_Y if up == "Y" else Z_TO_Y.T
        else:
            said.append(f"{up} already points up")
    if arguments.scale:
        yield "scale", arguments.scale * np.eye(3)


def _in_axes(motion: Motion, matrix: Array) -> Motion:
    """Return the motion in different axes and units.

    `matrix`, (3, 3), is a rotation times a scale factor.
    """
    rotations = motion.rotations.copy()
    rotations[..., 1:] @= matrix.T / np.cbrt(np.linalg.det(matrix))
    skeleton = replace(motion.skeleton, offsets=motion.skeleton.offsets @ matrix.T)
    positions = motion.positions @ matrix.T
    return replace(motion, skeleton=skeleton, rotations=rotations, positions=positions)


def _with_names(motion: Motion, names: Mapping[str, str]) -> Motion:
    new = tuple(names.get(name, name) for name in motion.skeleton.names)
    return replace(motion, skeleton=replace(motion.skeleton, names=new))


def _new_names(chosen: str, clip: BvhClip, said: list[str]) -> Mapping[str, str]:
    """Return the new names of joints, keyed by old name, as specified by `--rename`."""
    if chosen in NAMINGS:
        return joint_names_in_scheme(clip.motion, chosen)
    names = read_joint_names_for_export(Path(chosen))
    absent = [old for old in names if old not in clip.skeleton.names]
    if len(absent) == len(names):
        raise TwistError(f"{chosen}: expected the name of a joint of {clip.path.name}, found none")
    if absent:
        listed = ", ".join(absent)[:200]
        said.append(f"{chosen} also names joints that the clip does not have: {listed}")
    return names


def _print(
    output: Path,
    clips: tuple[BvhClip, BvhClip],
    changes: Sequence[tuple[str, rewriting.RewrittenJoint]],
    renamed: Mapping[str, str],
    found: Deviation,
) -> None:
    """Print a row for each changed joint, a summary, and the differences from the source."""
    rows = []
    for option, change in changes:
        new = f" → {renamed[change.joint]}" if option == "rename" else ""
        rows.append((f"{option:<8} {terminal_text(change.joint)}{new}", change))
    if rows:
        width = max(32, *(len(text) for text, _ in rows))
        print_remark(f"{'joint':<{width}}   start – stop       numbers   words")
    for text, change in rows:
        span = f"{change.start:>7} – {change.stop:<7}" if change.frames else " " * 17
        print_remark(f"{text:<{width}} {span} {change.numbers:>9} {change.words:>7}")
    numbers = count_with_noun(sum(change.numbers for _, change in changes), "number")
    words = count_with_noun(sum(change.words for _, change in changes), "word")
    joints = count_with_noun(len({change.joint for _, change in changes}), "joint")
    sizes = [f"{c.frames} frames at {c.fps:.6g} fps" for c in clips]
    size = " → ".join(dict.fromkeys(sizes))
    print_remark(f"{output}: {numbers} and {words} of {joints} rewritten; {size}")
    print_remark(
        f"{output}, read again: rotations differ by at most {found.degrees:.1e}° ({found.joint}, "
        f"frame {found.frame}) and positions by {found.of_height:.1e} of the figure's height"
    )


def _too_far(output: Path, found: Deviation) -> list[str]:
    """Return a list with a sentence if the written poses differ by more than LIMITS, or []."""
    degrees, of_height = LIMITS
    if found.degrees <= degrees and found.of_height <= of_height:
        return []
    return [
        f"{output}: the written pose differs from the source by {found.degrees:.1e}° "
        f"({found.joint}, frame {found.frame}) and {found.of_height:.1e} of the figure's height"
    ]
