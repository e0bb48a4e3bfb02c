"""Run `twistcore inject` and `twistcore evaluate`, which inject errors and measure corrections.

The command `benchmark` does both for a folder. It is in a separate module because its libraries
load slowly.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from twistcore.cli.output import (
    print_json,
    print_problem,
    print_remark,
    print_result_lines,
    refuse_overwrite,
    report_problems,
)
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.formats.bvh import decimated, parse_bvh, read_bvh
from twistcore.formats.clip import create_file_patch_for_motion, write_clip
from twistcore.skeleton.chain import Chain, find_chains, uncorrectable_joints
from twistcore.skeleton.limb import find_limbs
from twistcore.study.evaluation import (
    Sample,
    evaluation_to_json,
    evaluation_to_text,
    measure_corrected_clip,
    summarise_samples,
)
from twistcore.synthesis import (
    Truth,
    add_twist_from_opposite_side,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    last_limb_chains,
    parse_protocol,
    prepare_clean_motion_for_injection,
    read_truth,
    write_truth,
)


def inject_command(arguments: argparse.Namespace) -> int:
    """Inject errors into a clip, write the truth file, and return the exit code."""
    protocol = parse_protocol(arguments.protocol)
    clip = read_bvh(arguments.clip)
    refuse_overwrite([arguments.output, arguments.truth], [arguments.clip])
    every = find_chains(clip.motion)
    among: Sequence[Chain] = find_limbs(clip.motion, every) if protocol.limb else every
    if protocol.single:
        among = last_limb_chains(clip.motion.skeleton, every)
    free = [c for c in among if not uncorrectable_joints(clip.motion, c)]
    if not free:
        what = "a limb for a flip" if protocol.limb else "a chain for a twist error"
        raise TwistError(f"{arguments.clip}: expected {what}, found none that can be changed")
    if protocol.rich:
        chains = [c for c in every if not uncorrectable_joints(clip.motion, c)]
        rich = add_twist_from_opposite_side(clip.motion, chains)
        clip = parse_bvh(create_file_patch_for_motion(clip, rich).data, clip.path)
    clip = decimated(clip, protocol.step)
    motion = clip.motion
    rng = clip_random_generator(arguments.seed, arguments.clip.name)
    targets = draw_targets(free, rng, protocol)
    errors = draw_errors(motion, targets, rng, protocol)
    write_clip(clip, inject(motion, free, errors), arguments.output)
    truth = Truth(
        arguments.clip.name, protocol.name, arguments.seed, motion.frames, motion.fps, errors
    )
    write_truth(arguments.truth, truth)
    names = sorted({e.chain for e in errors})
    where = ", ".join(names) or ("no limb" if protocol.limb else "no chain")
    print_remark(
        f"{arguments.output}: {len(errors)} errors in {where}, protocol {protocol.name}, "
        f"seed {arguments.seed}"
    )
    if arguments.json:
        print_json(
            {
                "schema": "twistcore.inject/1",
                "clip": str(arguments.clip),
                "output": str(arguments.output),
                "truth": str(arguments.truth),
                "protocol": protocol.name,
                "seed": arguments.seed,
                "frames": motion.frames,
                "fps": motion.fps,
                "errors": len(errors),
                "chains": names,
            }
        )
    if not errors and not protocol.clean:
        print_problem(f"{arguments.clip} is too short for an error")
        return 1
    return 0


def evaluate_command(arguments: argparse.Namespace) -> int:
    """Compare refined clips with the injected errors, print a table, and return the exit code."""
    counts = {len(arguments.truth), len(arguments.clean), len(arguments.refined)}
    if len(counts) != 1:
        raise TwistError("--truth, --clean and --refined: expected the same number of files")
    samples, problems = [], []
    for files in zip(arguments.truth, arguments.clean, arguments.refined, strict=True):
        try:
            samples.append(_measured(*files))
        except TwistError as error:
            problems.append(str(error))
    code = report_problems(problems, len(samples))
    if not samples:
        return code
    table = summarise_samples(samples)
    if arguments.json:
        print_json(evaluation_to_json(table))
    else:
        print_result_lines(evaluation_to_text(table))
    return code


def _measured(truth: Path, clean: Path, refined: Path) -> Sample:
    source, known = read_bvh(clean).motion, read_truth(truth)
    chains = find_chains(source)
    base = prepare_clean_motion_for_injection(source, chains, parse_protocol(known.protocol))
    try:
        return measure_corrected_clip(known, base, read_bvh(refined).motion, chains)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{refined}: {error}") from None
