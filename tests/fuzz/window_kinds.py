"""What the window alone reads: lessons, its settings, and what it keeps beside them, damaged."""

from __future__ import annotations

import json
import os
import random
import re
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

from inspector.lessons.lesson_file import body_and_task, read_lesson
from inspector.lessons.lesson_place import lesson_place_settings as settings_of_place
from inspector.lessons.page_in_clip import lesson_page_chain
from inspector.lessons.page_texts import markdown_html
from inspector.session import session_files
from inspector.session.export_files import ExportChoice
from inspector.session.export_files import files_replaced_by_export as replaced_by_export
from inspector.session.opening import Analysed
from inspector.session.rig_profiles import load_rig_profile, rig_path
from inspector.session.settings import (
    Settings,
    load_settings,
    merged,
    save_changes,
    save_settings,
)
from inspector.tuning.remembered_profiles import Performers, load_saved_profile, profile_path
from tests.fuzz.file_kinds import _damaged_toml, _profiles, _rigs
from tests.fuzz.json_damage import NUMBERS, TEXTS, damage_bytes, damaged_json
from tests.fuzz.review_kinds import ASSETS, clip
from tests.fuzz.trial import Kind
from twistcore.analysis.clip_analysis import analyse
from twistcore.errors import TwistError
from twistcore.export.folder_replay import WRITTEN, read_recorded_hashes_of_exports
from twistcore.formats.bvh import read_bvh
from twistcore.review import Review
from twistcore.skeleton.rig import skeleton_hash

# -- lessons -----------------------------------------------------------------------------------

_VALUES = (
    *NUMBERS, *TEXTS, "limb", "nan nan nan", "1e308 1e308 1", "1 2", "1 2 3 4", "0 0 0", "١٢", "²",
    "twist 1e999", "twist nan", "stage 3", "swing", "toward 0 0 0", "toward 1e200 1e200 1e200",
    "counter, counter", "moved 1e300", "moved inf", "swing >= 1e999", "accepted nothing", "seen",
    "lit θp", "../walk.bvh", "walk.bvh", "/dev/zero", "x" * 300 + ".bvh", "a\0.bvh", ".", "..",
    "9" * 5000, "LeftArm-LeftHand", "both, skin, skin", "x," * 20_000, "applied >= 0.5",
)  # fmt: skip
_LINES = (
    "```", "```lesson", "# ", "#", "# x", "---", "> ", "> task", "frame: 1", "clip: walk.bvh",
    ": ", "title: x", "$" * 100, "$a$" * 100, "$\\frac{a}{b}$", "![x](file:///etc/passwd)",
    "<img src='file:///etc/passwd'>", "[x](javascript:alert(1))", "| a | b |", "\t", "\0", "\u2028",
    "\x0c", "\x85", "a" * 200_000, "*" * 3000, "[" * 3000, "> " * 500, "- " * 500, "`" * 999,
    "1. " * 500, "_" * 3000, "![" * 1000, "|" * 3000,
)  # fmt: skip


@cache
def _lessons() -> tuple[str, ...]:
    return tuple(path.read_text("utf-8") for path in sorted((ASSETS / "lessons").glob("*.md")))


def _lesson(rng: random.Random) -> dict[str, bytes]:
    lines = rng.choice(_lessons()).split("\n")
    what = rng.random()
    for _ in range(rng.choice((1, 1, 2, 4)) if what < 0.88 else 0):
        _damage_lesson(lines, rng)
    data = "\n".join(lines).encode("utf-8", "surrogatepass")
    return {"lesson.md": damage_bytes(data, rng) if what > 0.8 else data}


def _damage_lesson(lines: list[str], rng: random.Random) -> None:
    keyed = [k for k, line in enumerate(lines) if re.match(r"[a-z-]+: ", line)]
    change = rng.random()
    if change < 0.6 and keyed:
        k = rng.choice(keyed)
        key, _, value = lines[k].partition(": ")
        lines[k] = f"{key}: {rng.choice((*_VALUES, value + 'x', value * 2, value[:-1]))}"
    elif change < 0.7 and keyed:
        del lines[rng.choice(keyed)]
    elif change < 0.8:
        lines.insert(rng.randint(0, len(lines)), rng.choice(lines or [""]))
    elif change < 0.97:
        lines.insert(rng.randint(0, len(lines)), rng.choice(_LINES))
    elif sum(map(len, lines)) < 50_000:
        lines *= 50


class _NoFormulas:
    """Setting them takes its time, and is Matplotlib's."""

    def svg(self, tex: str, words: str = "") -> str:
        raise ValueError(tex)


@cache
def _analysed(path: Path) -> Analysed:
    source = read_bvh(path)
    found = analyse(source)
    return Analysed(source, found, Review.of(found.detect()))


def _read_lesson(folder: Path) -> object:
    lesson = read_lesson(folder / "lesson.md")
    for page in lesson.pages[:30]:
        lesson_page_chain(lesson, page, _analysed(page.place.clip))
        settings_of_place(page.place)
    for page in lesson.pages[:3]:
        markdown_html(page.body, _NoFormulas())
        body_and_task(page.body.split("\n"))
    return lesson


# -- settings ----------------------------------------------------------------------------------


@cache
def _full() -> dict[str, Any]:
    """Settings with something in every field."""
    folder = {"clip": "/a/b.bvh", "profile": "p", "method": "paper", "tau": {"LeftArm": 0.1}}
    return {
        "theme": "dark", "recent": ["/a/b.bvh", "/a/c.bvh"], "reviewer": "Kim", "geometry": "",
        "layout": "00ff", "first_frame": 1, "step": 10, "keys": {"accept": ["A", "B"]},
        "zoom_to_interval": True, "order": "time", "reviewer_asked": True, "turn_ms": 220,
        "look_ms": 400,
        "videos": {"/a/b.bvh": ["/a/b.mp4", 1.5]}, "folders": {"/a": folder}, "autosave": True,
        "next_after_export": True, "columns": ["chain"], "interval_sort": "-start",
        "alarm_points": 5.0, "smallest_error": 2.0, "error_draws": 3, "language": "de",
        "of_a_newer_version": {"a": [1, 2]},
    }  # fmt: skip


def _settings(rng: random.Random) -> dict[str, bytes]:
    return {"settings.json": damaged_json(_full(), rng)}


def _read_settings(folder: Path) -> object:
    path = folder / "settings.json"
    before = path.read_bytes()
    known, said = load_settings(path)
    assert path.read_bytes() == before, "what cannot be read is not written over"
    assert len(said) < 2000
    other = Settings(recent=["/x/y.bvh"], keys={"a": ["B"]}, of_features={"folders": {"/f": {}}})
    merged(Settings(), other, known)
    for trouble in (save_changes(path, other, known), save_settings(path, known)):
        if trouble:
            raise TwistError(trouble)
    again, said = load_settings(path)
    assert not said, said
    assert again == known
    return known


# -- what is kept beside settings and clips ----------------------------------------------------

_MARK = "a" * 64


def _kept(rng: random.Random) -> dict[str, bytes]:
    mark = skeleton_hash(clip().motion.skeleton)
    at = str((Path("/a") / "b.bvh").resolve())
    lines = [{"schema": "twistcore.applied/1"}, {"clip": "a/b.bvh", "sha256": _MARK}]
    names = ["a.bvh", "a.report.html", "../a.bvh", "/a", "", "."]
    files = {rng.choice(names): _MARK, "a.markers.py": _MARK}
    report = {"schema": "twistcore.report/1", "clip": "a.bvh", "files": files, "replaced": files}
    rig = random.Random(0).choice(_rigs())
    return {
        "performers.json": damaged_json({at: "Kim", "/x": "Y"}, rng),
        f"rigs/{mark[:24]}.toml": _damaged_toml(rig, rng),
        f"profiles/{_MARK[:24]}.toml": _damaged_toml(_profiles()[1], rng),
        "walk-0.elsewhere.json": damaged_json({"session": "/a/b.twist.json"}, rng),
        WRITTEN: b"\n".join(damaged_json(line, rng).replace(b"\n", b" ") for line in lines),
        "a.report.json": damaged_json(report, rng),
        "a.bvh": b"an earlier export",
    }


def _read_kept(folder: Path) -> object:
    place = {"TWIST_INSPECTOR_SETTINGS": str(folder / "settings.json")}
    with mock.patch.dict(os.environ, place):
        performers = Performers()
        performers.of(Path("/a/b.bvh"))
        performers.name(Path("/a/c.bvh"), "Kim")
        assert Performers().of(Path("/a/c.bvh")) == "Kim"
        assert rig_path(clip().motion.skeleton).exists()
        found = [
            load_rig_profile(clip().motion),
            load_saved_profile(_MARK),
            load_saved_profile(_MARK, "Kim"),
        ]
        assert profile_path(_MARK).parent.exists()
    for _, said in found:
        if len(said) > 1500:
            raise AssertionError(said)
    pointer = folder / "walk-0.elsewhere.json"
    with mock.patch.object(session_files, "_pointer", return_value=pointer):
        session_files.find_existing_sessions(folder / "walk.bvh")
    replaced_by_export(ExportChoice(folder / "a.bvh"), {})
    json.dumps(read_recorded_hashes_of_exports(folder))
    return found


KINDS = (
    Kind("lesson", _lesson, _read_lesson),
    Kind("settings", _settings, _read_settings),
    Kind("kept", _kept, _read_kept),
)
