"""Read the clips of a command, and analyse them with the chosen chains and detector."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from twistcore.analysis.clip_analysis import ALL_KINDS, ClipAnalysis, Detection, analyse
from twistcore.cli.arguments.argument_types import STANDARD_INPUT
from twistcore.cli.output import print_note, print_step_duration
from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.skeleton.joint_names import read_joint_vocabulary_file
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notes import Note
from twistcore.skeleton.own_words import add_user_joint_words
from twistcore.skeleton.rig import AS_FOUND, Rig, read_rig

Found = TypeVar("Found")

_NOTES = 5  # largest number of notes printed for one clip; `info` lists all notes


def clip_name_for_messages(path: Path) -> str:
    """Return the name of a clip for messages: its path, or '-' for standard input."""
    return "-" if path == STANDARD_INPUT else str(path)


def read_clip_or_stdin(path: Path, *, fps: float | None = None) -> Clip:
    """Read a clip, or a BVH from standard input.

    `fps` is the frame rate to use instead of the file's.
    """
    with print_step_duration(f"  {clip_name_for_messages(path)}: read"):
        if path != STANDARD_INPUT:
            return read_clip(path, fps=fps)
        if sys.stdin is None:
            raise TwistError("-: expected a BVH on standard input, but standard input is closed")
        return parse_bvh(sys.stdin.buffer.read(), "standard input", fps=fps)


def reading_assumption_sentences(name: object, clip: Clip) -> list[str]:
    """Return sentences about the assumptions that were made when a clip was read.

    If there are many, only the first ones and the number of the others are returned.
    """
    shown = clip.warnings if len(clip.warnings) <= _NOTES else clip.warnings[: _NOTES - 1]
    sentences = [f"{name}: note: {warning}" for warning in shown]
    if left := len(clip.warnings) - len(shown):
        sentences.append(f"{name}: note: {left} more such notes; `twistcore info` lists them")
    return sentences


def print_clip_notes(name: object, clip: Clip) -> None:
    """Print the notes about a clip."""
    for sentence in reading_assumption_sentences(name, clip):
        print_note(sentence)


def run_on_clips_collecting_failures(
    clips: Sequence[Path], work: Callable[[Path], Found]
) -> tuple[list[Found], list[tuple[str, str]]]:
    """Return the results of `work` for all clips, and the names and errors of failed clips.

    If there is only one clip, its error is raised instead. Raises TwistError if standard input is
    given twice.
    """
    if clips.count(STANDARD_INPUT) > 1:
        raise TwistError("- (standard input) can be given only once")
    if len(clips) == 1:
        return [work(clips[0])], []
    found, failed = [], []
    for path in clips:
        try:
            found.append(work(path))
        except (TwistError, OSError) as error:
            from twistcore.work.processes import describe_failure  # slow to load

            failed.append((clip_name_for_messages(path), describe_failure(path, error)))
    return found, failed


def failed_clips_to_json(failed: Sequence[tuple[str, str]]) -> list[dict[str, str]]:
    """Return the failed clips as JSON data. `failed` has pairs of name and reason."""
    return [{"clip": name, "reason": why} for name, why in failed]


def analyse_with_options(arguments: argparse.Namespace, clip: Clip) -> ClipAnalysis:
    """Analyse a clip with the chains chosen by --rig, --joint-names, --person and --chain."""
    rig = add_user_joint_words(chosen_rig(arguments), clip.motion, chosen_joint_names(arguments))
    try:
        rig.chains(clip.motion)
    except TwistError as error:
        raise TwistError(f"{arguments.rig}: {error}, in the clip {clip.path}") from None
    chains, people = (getattr(arguments, name, None) for name in ("chain", "person"))
    return analyse(clip, chains, rig, people)


def reference_notes(arguments: argparse.Namespace, analysis: ClipAnalysis) -> tuple[Note, ...]:
    """Return notes about differences between a clip and the take given by --reference, if any."""
    path = arguments.reference
    return analysis.compared_with(_reference(path), path.name) if path else ()


@lru_cache(1)
def _reference(path: Path) -> Motion:
    return read_clip_or_stdin(path).motion


def chosen_rig(arguments: argparse.Namespace) -> Rig:
    """Return the rig given by --rig, or a rig without changes to the chains found in the clip."""
    return read_rig(arguments.rig) if arguments.rig else AS_FOUND


def chosen_joint_names(arguments: argparse.Namespace) -> dict[str, Any] | None:
    """Return the contents of the file given by --joint-names, or None without this option."""
    return read_joint_vocabulary_file(arguments.joint_names) if arguments.joint_names else None


def detect_with_options(arguments: argparse.Namespace, clip: Clip) -> Detection:
    """Analyse a clip and detect intervals with the chosen options."""
    with print_step_duration(f"  {clip.path}: analysed and searched"):
        return detect_in_analysis(arguments, analyse_with_options(arguments, clip))


def detect_in_analysis(arguments: argparse.Namespace, analysis: ClipAnalysis) -> Detection:
    """Detect intervals in an analysed clip with the chosen options.

    The profile of --profile has priority over --tau.
    """
    method = arguments.method
    kinds = ALL_KINDS if arguments.kinds is None else arguments.kinds
    if not arguments.profile:
        return analysis.detect(method, kinds=kinds, tau_radians=arguments.tau)
    from twistcore.tuning import read_profile  # slow to load; few commands need it

    profile = read_profile(arguments.profile)
    if profile.method not in ("", method):
        print_note(
            f"{arguments.profile}: note: tuned for the detector {profile.method}, "
            f"but used with {method}"
        )
    given = analysis.tau_of(arguments.tau, profile.tau)
    return analysis.detect(method, kinds=kinds, tau_radians=given)
