"""Profiles, rigs, truths and exercises of a class, damaged, and used as the program uses them."""

from __future__ import annotations

import json
import random
import re
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from unittest import mock

from inspector.lessons import classroom
from inspector.lessons.classroom import (
    open_for_review,
    open_for_student,
    score_answers,
    write_for_class,
)
from tests.fuzz.json_damage import DEEP, NUMBERS, TEXTS, damage_bytes, damaged_json
from tests.fuzz.review_kinds import ASSETS, analysis, clip
from tests.fuzz.trial import Kind
from twistcore.analysis.clip_analysis import analyse
from twistcore.files.encoding import encode_utf8, json_text
from twistcore.formats.bvh import read_bvh
from twistcore.review import Review
from twistcore.skeleton.rig import OwnChain, Rig, read_rig, rig_from_json, rig_to_json, write_rig
from twistcore.study.class_exercise import StudentAnswer, read_student_answer, write_student_answer
from twistcore.study.evaluation import measure_corrected_clip
from twistcore.synthesis import PROTOCOLS, clip_random_generator, draw_errors
from twistcore.synthesis.truth import Truth, read_truth, write_truth
from twistcore.tuning.learned_confidence import LearnedConfidence
from twistcore.tuning.profile import Profile, TauReasons, read_profile, write_profile
from twistcore.tuning.tau_curve import Tuned


def _written(write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "file")
        write(path)
        return path.read_bytes()


# -- TOML --------------------------------------------------------------------------------------

_TOML = (
    *NUMBERS, *(json_text(text, indent=None) for text in TEXTS if text.isprintable()),
    "nan", "inf", "-inf", "true", "[]", "{}", "[[]]", "{ a = 1 }", "1979-05-27", "9999-99-99", "''",
    "1979-05-27T07:32:00Z", "0x10", "0o7", "1_000", '"\\u0000"', '"\\ud800"', "'''\n\n'''",
    "[" * 200 + "]" * 200, "[" * DEEP, "{a=" * 2000, "a" + ".a" * 20_000, '"' + "x" * 100_000 + '"',
    "[" + "1.0," * 5000 + "]", "[" + '"a",' * 5000 + "]", "9" * 100_000,
    '"' + "x" * 2_000_000 + '"',
)  # fmt: skip
_LINES = (
    "[x]", "[[chain]]", "[[x]]", "x = 1", '"" = 1', "[a.b.c]", "[", "]", "= 1", "tau_deg = 1",
    "[" + "a." * 20_000 + "a]", "a" + ".a" * 50_000 + " = 1", "\0", "# " + "." * 1000, "\x1b[31m",
    '[""]\ntau_deg = 1', "['\u202e']\ntau_deg = 3", 'kind = "limb"', "remove = 3",
)  # fmt: skip


def _damaged_toml(text: str, rng: random.Random) -> bytes:
    lines = text.split("\n")
    what = rng.random()
    for _ in range(rng.choice((1, 1, 2, 3)) if what < 0.85 else 0):
        k = rng.randrange(len(lines))
        change = rng.random()
        if change < 0.5:
            key, equals, value = lines[k].partition(" = ")
            value = rng.choice(_TOML) if equals else value
            lines[k] = f"{key}{equals}{value}"
        elif change < 0.6:
            del lines[k]
            lines = lines or [""]
        elif change < 0.7:
            lines.insert(k, lines[rng.randrange(len(lines))])
        elif change < 0.85:
            lines.insert(k, rng.choice(_LINES))
        elif change < 0.95:
            numbers = list(re.finditer(r"-?\d+\.?\d*|\"[^\"]*\"", lines[k]))
            if numbers:
                one = rng.choice(numbers)
                lines[k] = lines[k][: one.start()] + rng.choice(_TOML) + lines[k][one.end() :]
        else:
            lines *= rng.choice((2, 500 if sum(map(len, lines)) < 20_000 else 1))
    data = encode_utf8("\n".join(lines))
    return damage_bytes(data, rng) if what > 0.8 else data


@cache
def _profiles() -> tuple[str, ...]:
    nan = float("nan")
    names = [chain.name for chain in analysis().chains_and_limbs]
    tau = {name: Tuned(4.5 + k, 0.1, nan, 2.0) for k, name in enumerate(names)}
    whose = Profile({}, "", "a" * 64, "Kim", LearnedConfidence(0.4, 1.2, 30, 12))
    told = {name: TauReasons(5, 2, 3.0, 6.0) for name in names[:4]}
    return (
        _written(lambda p: write_profile(p, tau, "a.bvh", "consistency")).decode(),
        _written(
            lambda p: write_profile(p, tau, "x's sessions", "paper", whose=whose, verdicts=told)
        ).decode(),
    )


def _profile(rng: random.Random) -> dict[str, bytes]:
    return {"p.toml": _damaged_toml(rng.choice(_profiles()), rng)}


def _read_profile(folder: Path) -> object:
    profile = read_profile(folder / "p.toml")
    found = analysis().detect(tau_radians=profile.of(analysis().chains_and_limbs))
    review = Review.of(found)
    if profile.confidence is not None:
        for interval in found:
            if interval.confidence is not None:
                profile.confidence.of(interval.confidence)
    tuned = {n: Tuned(t, 0.0, 0.0, 0.0) for n, t in profile.tau.items()}
    write_profile(folder / "again.toml", tuned, "a", profile.method, whose=profile)
    return review


@cache
def _rigs() -> tuple[str, ...]:
    limb = OwnChain(("LeftArm", "LeftForeArm", "LeftHand"), limb=True)
    skeleton = clip().motion.skeleton
    rigs = (
        Rig((OwnChain(("Spine", "Spine1")),), ("RightLeg", "LeftLeg")),
        Rig((OwnChain(("Spine", "Spine1", "LeftArm")), limb), ("LeftArm-LeftHand", "LeftArm")),
    )
    return tuple(_written(lambda p, r=r: write_rig(p, r, skeleton, "a")).decode() for r in rigs)


def _rig(rng: random.Random) -> dict[str, bytes]:
    return {"rig.toml": _damaged_toml(rng.choice(_rigs()), rng)}


def _read_rig(folder: Path) -> object:
    rig = read_rig(folder / "rig.toml")
    assert rig_from_json(rig_to_json(rig)) == rig
    write_rig(folder / "again.toml", rig, clip().motion.skeleton, "a")
    assert read_rig(folder / "again.toml") == rig
    return analyse(clip(), rig=rig).chains_and_limbs


# -- JSON --------------------------------------------------------------------------------------


@cache
def _truths() -> tuple[dict[str, object], ...]:
    source, chains = read_bvh(ASSETS / "walk.bvh").motion, analysis().chains
    out = []
    for name in ("P0", "H2", "H10"):
        errors = draw_errors(source, chains[:4], clip_random_generator(1, "walk"), PROTOCOLS[name])
        truth = Truth("walk.bvh", name, 1, source.frames, source.fps, errors, "a" * 64)
        out.append(_document(lambda p, t=truth: write_truth(p, t)))
    return (_asset("walk_injected.truth.json"), *out)


def _document(write: Callable[[Path], object]) -> dict[str, object]:
    return dict(json.loads(_written(write)))


def _asset(name: str) -> dict[str, object]:
    return _document(lambda p: p.write_bytes((ASSETS / name).read_bytes()))


def _truth(rng: random.Random) -> dict[str, bytes]:
    return {"a.truth.json": damaged_json(rng.choice(_truths()), rng)}


@cache
def _clean():
    return read_bvh(ASSETS / "walk.bvh").motion


def _read_truth(folder: Path) -> object:
    truth = read_truth(folder / "a.truth.json")
    write_truth(folder / "again.json", truth)
    return measure_corrected_clip(truth, _clean(), clip().motion, analysis().chains)


@cache
def _class() -> tuple[dict[str, object], dict[str, object], dict[str, object], bytes]:
    """Exercise, key and what was handed in, and the clip."""
    with tempfile.TemporaryDirectory() as folder:
        copy, key = write_for_class(ASSETS / "walk.bvh", Path(folder, "e.json"), 3, "judge")
        exercise = Path(folder, "e.json")
        read = classroom.read_student_exercise(exercise)
        review = Review.of(replace(analysis().detect(), intervals=read.listed))
        review.accept()
        handed = StudentAnswer("Kim", 33.0, read.clip, read.sha256, review.state.intervals)
        answer = _document(lambda p: write_student_answer(p, handed))
        documents = [_document(lambda p, f=f: shutil.copy(f, p)) for f in (exercise, key)]
        return documents[0], documents[1], answer, copy.read_bytes()


def _exercise(rng: random.Random) -> dict[str, bytes]:
    return {"e.json": damaged_json(_class()[0], rng), "e.bvh": _class()[3]}


def _read_exercise(folder: Path) -> object:
    (folder / "own").mkdir()
    with mock.patch.object(classroom, "open_for_review", _to_review):
        data, exercise = open_for_student(folder / "e.json", folder / "own")
    handed = StudentAnswer("Kim", 3.0, exercise.clip, exercise.sha256, data.review.state.intervals)
    write_student_answer(folder / "h.json", handed)
    return read_student_answer(folder / "h.json")


@cache
def _known():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "e.bvh")
        path.write_bytes(_class()[3])
        return open_for_review(path, ())


def _to_review(path: Path, listed: object) -> object:
    """The clip is the same each time: it is analysed once."""
    data = _known()
    found = replace(data.analysis.detect(), intervals=tuple(listed))
    return replace(data, review=Review.of(found))


def _handed_in(rng: random.Random) -> dict[str, bytes]:
    _, key, told, _ = _class()
    which = rng.random()
    return {
        "key.json": damaged_json(key, rng) if which < 0.3 else json_text(key).encode(),
        "kim.json": damaged_json(told, rng) if which > 0.2 else json_text(told).encode(),
    }


def _read_handed_in(folder: Path) -> object:
    return score_answers([folder / "key.json", folder / "kim.json"])


KINDS = (
    Kind("profile", _profile, _read_profile),
    Kind("rig", _rig, _read_rig),
    Kind("truth", _truth, _read_truth),
    Kind("exercise", _exercise, _read_exercise),
    Kind("handed-in", _handed_in, _read_handed_in),
)
