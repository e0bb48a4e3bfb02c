"""Class exercises, which a teacher creates, students solve and the program scores."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from inspector.language import tr
from inspector.session.opening import Analysed, analyse_clip
from twistcore.detection import Interval
from twistcore.errors import ClipMismatchError, FormatError
from twistcore.files.document_values import shorten_foreign_message
from twistcore.files.ordinary import is_file
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.review import Review
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.study.class_exercise import (
    SCORE,
    ClassExercise,
    exercise_json_file_schema,
    read_student_answer,
    read_student_exercise,
    student_exercise_score_table,
    write_student_exercise,
)
from twistcore.study.exercise import exercise_intervals_between_errors, hide_exercise_errors
from twistcore.study.exercise_clip import write_student_exercise_clip
from twistcore.synthesis import InjectedError
from twistcore.synthesis.truth import SCHEMA as TRUTH
from twistcore.synthesis.truth import Truth, read_truth, write_truth


def with_hidden_errors(
    source: Clip, seed: int, kind: str
) -> tuple[Motion, tuple[InjectedError, ...], tuple[Interval, ...]]:
    """Hide random errors in a motion. Return the motion, the errors and the intervals to judge.

    Parameters
    ----------
    source
        The clip in which errors are hidden.
    seed
        The seed of the random errors.
    kind
        'find' if students must find the errors; then there are no intervals to judge. 'judge' if
        students judge a list of intervals.
    """
    motion, chains = source.motion, find_chains(source.motion)
    dirty, errors = hide_exercise_errors(motion, chains, seed)
    listed: list[Interval] = []
    if kind == "judge":
        listed = [Interval(e.chain, e.start, e.stop, e.offset) for e in errors]
        listed += exercise_intervals_between_errors(errors, motion.frames)
    return dirty, errors, tuple(sorted(listed, key=lambda i: (i.chain, i.start)))


def open_for_review(path: Path, listed: Sequence[Interval]) -> Analysed:
    """Read a clip and return it with a review of the given intervals, but no detector results."""
    data = analyse_clip(read_bvh(path))
    found = replace(data.analysis.detect(), intervals=tuple(listed))
    return replace(data, review=Review.of(found), blind=True)


def write_for_class(source: Path, exercise: Path, seed: int, kind: str) -> tuple[Path, Path]:
    """Write an exercise, its clip and its answer key to one folder. Return paths of clip and key.

    Raises FormatError if the clip or the key already exists. Only the exercise file may be
    overwritten, because the file dialog has asked the user about this file.
    """
    copy, key = exercise_files(exercise)
    clip = read_bvh(source)
    dirty, errors, listed = with_hidden_errors(clip, seed, kind)
    if not errors:
        why = tr("expected a clip with chains that can be corrected. Choose another clip.")
        raise FormatError(f"{source}: {why}")
    write_student_exercise_clip(clip, dirty, copy)
    sha256, motion = read_bvh(copy).sha256, clip.motion
    write_student_exercise(exercise, ClassExercise(copy.name, sha256, kind, listed))
    write_truth(key, Truth(copy.name, "P0", seed, motion.frames, motion.fps, errors, sha256))
    return copy, key


def exercise_files(exercise: Path) -> tuple[Path, Path]:
    """Return the paths for the clip and the answer key of a new exercise.

    Raises FormatError if one of these files exists.
    """
    name = exercise.stem if exercise.suffix.lower() == ".json" else exercise.name
    if name.lower().endswith(".key"):
        why = tr("names that end in '.key' are reserved for answer keys. Choose another name.")
        raise FormatError(f"{exercise.name}: {why}")
    copy, key = (exercise.with_name(name + ending) for ending in (".bvh", ".key.json"))
    for path in (copy, key):
        if os.path.lexists(path):
            why = tr("{file} already exists. Choose another name.", file=path.name)
            raise FormatError(f"{exercise.name}: {why}")
    return copy, key


def open_for_student(path: Path, folder: Path) -> tuple[Analysed, ClassExercise]:
    """Open a class exercise for a student. A copy of its clip is written to `folder`."""
    exercise = read_student_exercise(path)
    clip = path.with_name(exercise.clip)
    if not is_file(clip):
        why = tr(
            "the clip {clip} is missing. Put it into the same folder as the exercise.",
            clip=shorten_foreign_message(exercise.clip),
        )
        raise ClipMismatchError(f"{path.name}: {why}")
    data = open_for_review(Path(shutil.copy(clip, folder)), exercise.listed)
    if data.clip.sha256 != exercise.sha256:
        why = tr(
            "{clip} is not the clip that this exercise was made from. Ask your teacher for "
            "both files.",
            clip=shorten_foreign_message(exercise.clip),
        )
        raise ClipMismatchError(f"{path.name}: {why}")
    chains = {chain.name for chain in data.chains}
    for interval in exercise.listed:
        if interval.chain not in chains or interval.stop > data.motion.frames:
            why = tr(
                "the exercise lists intervals that do not fit {clip}. Use the clip that was "
                "written together with the exercise.",
                clip=shorten_foreign_message(exercise.clip),
            )
            raise FormatError(f"{path}: {why}")
    return data, exercise


def score_answers(files: Sequence[Path]) -> str:
    """Compare the students' answers with the answer key, and return the scores as CSV.

    `files` are the paths of the key and of the answers, in any order.
    """
    by_schema = [(exercise_json_file_schema(path), path) for path in files]
    keys = [path for schema, path in by_schema if schema == TRUTH]
    handed = [(path, read_student_answer(path)) for schema, path in by_schema if schema == SCORE]
    if len(keys) != 1 or not handed:
        why = tr("Select the key of the exercise and all answer files together.")
        raise FormatError(why)
    truth = read_truth(keys[0])
    if not truth.sha256:
        why = tr(
            "this file is not the answer key of an exercise, because it has no checksum "
            "(sha256). Choose the key that was written with the exercise."
        )
        raise FormatError(f"{keys[0].name}: {why}")
    for path, one in handed:
        if one.clip != truth.clip:
            raise ClipMismatchError(
                tr(
                    "{file} belongs to the clip {clip}, but the key belongs to {other}.",
                    file=path.name,
                    clip=shorten_foreign_message(one.clip),
                    other=shorten_foreign_message(truth.clip),
                )
            )
        if one.sha256 != truth.sha256:
            raise ClipMismatchError(
                tr(
                    "{file} and the key belong to different clips that are both named {clip}. "
                    "Choose the answers and the key from the same exercise.",
                    file=path.name,
                    clip=shorten_foreign_message(one.clip),
                )
            )
    return student_exercise_score_table(truth.errors, [one for _, one in handed])
