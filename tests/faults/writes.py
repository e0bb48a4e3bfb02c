"""Every write that leaves a file for good: what it is called, and how it is done into a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from inspector.session.session_files import write_session_with_backup
from inspector.session.settings import Settings, save_settings
from inspector.tuning.remembered_profiles import Performers
from tests.twistcore.batch_records import done
from tests.twistcore.reviews import CHAINS, CLIP, fresh
from twistcore.batch.corrected_files import write_corrected
from twistcore.batch.manifest import ManifestRow
from twistcore.batch.result_files import write_clip_table, write_interval_parquet, write_json_lines
from twistcore.formats.bvh import write_motion
from twistcore.formats.clip import write_clip
from twistcore.quamo.network import initial_gain_network_for_training, write_gain_network_weights
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review.session import session_bytes, write_session
from twistcore.skeleton.rig import OwnChain, Rig, write_rig
from twistcore.study.class_exercise import StudentAnswer, write_student_answer
from twistcore.study.exercise_clip import write_student_exercise_clip
from twistcore.synthesis import Truth, write_truth
from twistcore.tuning import write_profile

Write = Callable[[Path], object]

OWN = OwnChain(("Spine", "Spine1", "Neck1"))
RIG = Rig(add=(OWN,))


def _report(folder: Path) -> None:
    write_clip_report(folder, Report(CLIP, CHAINS, fresh().state, CLIP.motion, name="x"))


def _corrected(folder: Path) -> None:
    write_corrected(
        folder, ManifestRow("s", "x.bvh"), None, CLIP.data, {"x.asf": b"a skeleton beside it"}
    )


def _settings(folder: Path) -> None:
    if said := save_settings(folder / "settings.json", Settings(reviewer="Ada")):
        raise OSError(0, said)  # it raises nothing, and says so


def _performers(folder: Path) -> None:
    performers = Performers()
    performers._path = folder / "performers.json"
    performers.name(Path("walk.bvh"), "Ada")


@cache
def _network():
    return initial_gain_network_for_training(4, 4, np.random.default_rng(0), "")


@cache
def _records():
    return [done("a.bvh"), done("b.bvh")]


# By the name of the file that is written last. Each writes what it writes into a folder.
WRITES: Mapping[str, Write] = {
    "clip.bvh": lambda f: write_clip(CLIP, CLIP.motion, f / "clip.bvh"),
    "motion.bvh": lambda f: write_motion(CLIP.motion, f / "motion.bvh"),
    "exercise.bvh": lambda f: write_student_exercise_clip(CLIP, CLIP.motion, f / "exercise.bvh"),
    "walk.twist.json": lambda f: write_session(CLIP, fresh().state, f / "walk.twist.json"),
    "known.twist.json": lambda f: write_session_with_backup(
        f / "known.twist.json", session_bytes(CLIP, fresh().state), {}
    ),
    "x.report.json": _report,
    "corrected/x.bvh": _corrected,
    "settings.json": _settings,
    "performers.json": _performers,
    "rig.toml": lambda f: write_rig(f / "rig.toml", RIG, CLIP.motion.skeleton, "walk"),
    "tau.toml": lambda f: write_profile(f / "tau.toml", {}, "walk", "paper"),
    "truth.json": lambda f: write_truth(
        f / "truth.json", Truth("a", "p", 1, CLIP.motion.frames, 120.0, ())
    ),
    "handed.json": lambda f: write_student_answer(
        f / "handed.json", StudentAnswer("Ada", 1.0, "x", "ab", ())
    ),
    "clips.csv": lambda f: write_clip_table(f / "clips.csv", _records()),
    "clips.jsonl": lambda f: write_json_lines(f / "clips.jsonl", _records()),
    "clips.parquet": lambda f: write_interval_parquet(f / "clips.parquet", _records()),
    "weights.npz": lambda f: write_gain_network_weights(_network(), f / "weights.npz"),
}
