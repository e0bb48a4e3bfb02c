"""Run `twistcore apply` and `twistcore diff` on folders."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from twistcore.cli.interval_words import jump_sentences, print_channel_jumps
from twistcore.cli.output import (
    clip_progress_printer,
    count_with_noun,
    print_json,
    print_note,
    print_remark,
    print_result,
    report_problems,
)
from twistcore.errors import TwistError
from twistcore.export.folder_compare import (
    FolderDifference,
    compare_folders,
    folder_difference_to_json,
    largest_rotation_difference,
)
from twistcore.export.folder_replay import (
    Pairs,
    Replayed,
    pair_sessions_with_clips,
    read_recorded_hashes_of_exports,
    record_hash_of_exported_clip,
    write_replayed_clip,
)
from twistcore.files.atomic import same_file
from twistcore.files.ordinary import path_exists
from twistcore.work.processes import describe_failure, map_in_processes


def apply_folder(arguments: argparse.Namespace) -> int:
    """Apply every session of a folder to its clip. Return 1 if some failed, 2 if all failed."""
    sessions, clips, output = _folders(arguments.session, arguments.clip, arguments.output)
    if same_file(output, clips):
        raise TwistError(f"{output} is the folder of the clips; choose another folder to write to")
    found = pair_sessions_with_clips(sessions, clips, output)
    output.mkdir(parents=True, exist_ok=True)
    own = read_recorded_hashes_of_exports(output)
    problems, through = list(found.problems), dict[str, Replayed]()
    work = partial(write_replayed_clip, output, own)
    with clip_progress_printer(len(found.pairs)) as tell:
        for pair, result in map_in_processes(work, found.pairs, _workers(arguments)):
            if isinstance(result, Exception):
                problems.append(describe_failure(pair.session, result))
            else:
                through[pair.name] = result
                if result.new:
                    record_hash_of_exported_clip(output, pair.name, result.sha256)
            tell(pair.name)
    for path in found.older:
        print_note(f"{path}: note: skipped, because the clip has a later session")
    for name in sorted(through):
        _tell_replayed(output / name, through[name])
    problems += [sentence for name in sorted(through) for sentence in through[name].left]
    problems.sort()
    if arguments.json:
        print_json(_applied_to_json(arguments, found, through, problems))
    applied = sum(one.applied for one in through.values())
    alone = (
        f"; {count_with_noun(len(found.alone), 'clip')} without a session" if found.alone else ""
    )
    where = count_with_noun(len(through), "clip")
    print_remark(f"{output}: {count_with_noun(applied, 'interval')} applied in {where}{alone}")
    return report_problems(problems, len(through))


def _applied_to_json(
    arguments: argparse.Namespace,
    found: Pairs,
    through: Mapping[str, Replayed],
    problems: Sequence[str],
) -> dict[str, Any]:
    clips = []
    for name, one in sorted(through.items()):
        notes = [*jump_sentences(arguments.output / name, one.jumps), *one.beside]
        counts = {"repairable": one.repairable, "applied": one.applied, "new": one.new}
        clips.append({"clip": name, "sha256": one.sha256, **counts, "notes": notes})
    return {
        "schema": "twistcore.apply_folder/1",
        "sessions": str(arguments.session),
        "clips": str(arguments.clip),
        "output": str(arguments.output),
        "written": clips,
        "without_session": list(found.alone),
        "older_sessions": list(map(str, found.older)),
        "problems": list(problems),
    }


def diff_folders(arguments: argparse.Namespace) -> int:
    """Print the differences between two folders of clips. Return 1 if a pair failed."""
    a, b = _folders(arguments.a, arguments.b)
    found = compare_folders(a, b, workers=_workers(arguments), counter=clip_progress_printer)
    if arguments.json:
        print_json(folder_difference_to_json(found, str(arguments.a), str(arguments.b)))
    else:
        _tell_difference(found, arguments.a, arguments.b)
    return report_problems(
        list(found.failed.values()), 1
    )  # 1, because it is not a failure if no clip is in both folders


def _folders(*paths: Path) -> tuple[Path, ...]:
    for path in paths:
        if path_exists(path) and not path.is_dir():
            raise TwistError(
                f"{path} is not a folder, but another argument is; expected only "
                "folders or only files"
            )
    return paths


def _tell_replayed(path: Path, one: Replayed) -> None:
    kept = "" if one.new else ", already there"
    print_remark(f"{path}: {one.applied} of {one.repairable} intervals applied{kept}")
    print_channel_jumps(path, one.jumps)
    for sentence in one.beside:
        print_note(sentence)


def _tell_difference(found: FolderDifference, a: Path, b: Path) -> None:
    for folder, names in ((a, found.only_a), (b, found.only_b)):
        for name in names:
            print_result(f"{name}: only in {folder}")
    for name, difference in found.different.items():
        joints = {j.joint for j in difference.joints}
        print_result(
            f"{name}: {count_with_noun(len(joints), 'joint')} in "
            f"{count_with_noun(difference.frames, 'frame')}, "
            f"up to {largest_rotation_difference(difference):.3f}°; joints move by at most "
            f"{difference.max_position_of_height:.1e} of the figure's height"
        )
    for name in found.same_motion:
        print_result(f"{name}: different bytes, same motion")
    print_result(
        f"{count_with_noun(found.in_both, 'clip')} compared: {len(found.identical)} identical, "
        f"{len(found.same_motion)} with the same motion, {len(found.different)} different; "
        f"{len(found.only_a)} only in {a}, {len(found.only_b)} only in {b}"
    )


def _workers(arguments: argparse.Namespace) -> int:
    return arguments.workers or os.cpu_count() or 1
