"""What the program remembers between two runs, in one JSON file."""

from __future__ import annotations

import contextlib
import glob
import json
import math
import os
import stat
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import platformdirs

from inspector.language import tr
from inspector.session import settings_checks as checks
from inspector.session.settings_checks import Check
from twistcore.files.atomic import free_name, write_atomically
from twistcore.files.ordinary import own_folder, read_file, real_path

RECENT = 10
VIDEOS = 500
FOLDERS = 100
STEPS = (2, 1000)  # frames that Ctrl+arrow may go by
MOST_DRAWS = 50  # of errors, to measure what τ costs
FARTHEST_S = 86_400.0  # a video's offset, either way
_FOLDER_TAU = {"profile", "method", "tau"}  # what is kept of a folder and belongs together
_LARGEST_FILE = 64_000_000  # bytes; ours have some kilobytes
_LONGEST_NUMBER = 18  # digits: longer ones are out of all bounds, and slow to read


@dataclass
class Settings:
    """What is kept; within which bounds say CHECKS.

    theme: 'system', 'light' or 'dark'; geometry, layout: Qt's bytes as hex; first_frame: 0 or 1;
    step: frames that Ctrl+arrow goes by; keys: keys by action id where they differ from the table;
    zoom_to_interval: whether N, A and R zoom the plots to the interval they go to; order: of going
    through intervals, 'chain' or 'time'; reviewer_asked: whether the name was asked for;
    turn_ms: milliseconds in which the camera turns to another limb, 0 for at once; videos: by the
    clip's path its video's path and offset in seconds, the latest last; folders: by a folder's path
    where one stopped in it, `clip`, and τ for all of it, `profile` (its name, '' for each clip's
    automatic one), `method` and `tau` in radians, the latest last; autosave: a session is saved by
    itself; next_after_export: in a folder the next clip opens then; columns: of the list of
    intervals, none for those there is room for; interval_sort: the column it is sorted by, '-'
    before it where the other way round, '' for none; alarm_points, smallest_error, error_draws: of
    a suggested τ, points of FSR that a false alarm may cost, degrees of the smallest errors looked
    for, draws of errors to measure with; language: of texts, 'system' or a code such as 'de', one
    that there is not is as 'system'; of_others: what the file holds beside, of a
    newer version perhaps, kept for it.
    """

    theme: str = "system"
    recent: list[str] = field(default_factory=list)
    reviewer: str = ""
    geometry: str = ""
    layout: str = ""
    first_frame: int = 0
    step: int = 10
    keys: dict[str, list[str]] = field(default_factory=dict)
    zoom_to_interval: bool = True
    order: str = "chain"
    reviewer_asked: bool = False
    turn_ms: int = 220
    videos: dict[str, tuple[str, float]] = field(default_factory=dict)
    folders: dict[str, dict[str, Any]] = field(default_factory=dict)
    autosave: bool = True
    next_after_export: bool = True
    columns: list[str] = field(default_factory=list)
    interval_sort: str = ""
    alarm_points: float = 5.0
    smallest_error: float = 2.0
    error_draws: int = 3
    language: str = "system"
    of_others: dict[str, Any] = field(default_factory=dict)

    def remember(self, path: Path) -> None:
        """Put a file first in the list of recent ones."""
        name = str(real_path(path))
        self.recent = [name, *(r for r in self.recent if r != name)][:RECENT]

    def remember_video(self, clip: str, video: Path, offset: float) -> None:
        """Keep a clip's video and its offset in seconds."""
        self.videos.pop(clip, None)
        self.videos[clip] = str(real_path(video)), min(max(offset, -FARTHEST_S), FARTHEST_S)
        for oldest in list(self.videos)[:-VIDEOS]:
            del self.videos[oldest]

    def of_folder(self, folder: Path) -> dict[str, Any]:
        """What is kept of a folder."""
        return _new_folder() | self.folders.get(str(real_path(folder)), {})

    def remember_folder(self, folder: Path, **known: Any) -> None:
        """Keep where one is in a folder, or its τ: what is not named stays as it is."""
        now = self.of_folder(folder) | known
        name = str(real_path(folder))
        others = {k: v for k, v in self.folders.items() if k != name}
        self.folders = dict([*others.items(), (name, now)][-FOLDERS:])


# What the fields of a file must be; the window lets nobody choose what is out of these bounds.
CHECKS: dict[str, Check] = {
    "theme": checks.any_of("system", "light", "dark"),
    "recent": checks.first_of(checks.file_path, RECENT),
    "reviewer": checks.text_up_to(1000),
    "geometry": checks.sealed_bytes(100_000),
    "layout": checks.sealed_bytes(1_000_000),
    "first_frame": checks.whole_between(0, 1),
    "step": checks.whole_between(*STEPS),
    "keys": checks.last_by(checks.text_up_to(100), checks.list_of(checks.text_up_to(100), 8), 1000),
    "zoom_to_interval": checks.truth,
    "order": checks.any_of("chain", "time"),
    "reviewer_asked": checks.truth,
    "turn_ms": checks.whole_between(0, 10_000),
    "videos": checks.last_by(
        checks.file_path,
        checks.both(checks.file_path, checks.number_between(-FARTHEST_S, FARTHEST_S)),
        VIDEOS,
    ),
    "folders": checks.last_by(
        checks.file_path,
        checks.record(
            clip=checks.file_path_or_none,
            profile=checks.text_up_to(1000),
            method=checks.text_up_to(100),
            tau=checks.last_by(checks.text_up_to(1000), checks.number_between(0.0, math.pi), 1000),
        ),
        FOLDERS,
    ),
    "autosave": checks.truth,
    "next_after_export": checks.truth,
    "columns": checks.first_of(checks.text_up_to(20), 20),
    "interval_sort": checks.text_up_to(21),
    "alarm_points": checks.number_between(0.0, 100.0),
    "smallest_error": checks.number_between(0.1, 180.0),
    "error_draws": checks.whole_between(1, MOST_DRAWS),
    "language": checks.text_up_to(20),
}


def settings_path() -> Path:
    """Where the settings live; the environment variable TWIST_INSPECTOR_SETTINGS moves them."""
    if moved := os.environ.get("TWIST_INSPECTOR_SETTINGS"):
        return Path(moved)
    find = partial(platformdirs.user_config_path, "twist-inspector", appauthor=False)
    return own_folder(find) / "settings.json"


def load_settings(path: Path) -> tuple[Settings, str]:
    """The settings and a sentence to show, '' if all is well; raises nothing.

    What is damaged goes back to its default, field by field, in lists and objects entry by entry;
    a copy of the damaged file is kept beside it, under a name that no other file has.
    """
    if trouble := _trouble(path):
        return Settings(), _unread(path, trouble)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return Settings(), ""
    except OSError as error:
        return Settings(), _unread(path, error.strerror)
    settings, damaged = settings_from_json(data)
    if not damaged:
        return settings, ""
    which = tr("All settings")
    if len(damaged) < len(CHECKS):
        which = tr("The settings {names}", names=", ".join(damaged))
    said = tr(
        "{settings} were damaged: what was good of them is kept, the rest is as it was at first;",
        settings=which,
    )
    try:
        aside = tr("the old file was set aside as {file}.", file=_set_aside(path, data))
    except OSError as error:
        aside = tr("the old file could not be set aside ({why}).", why=error.strerror)
    return settings, f"{said} {aside}"


def settings_from_json(data: bytes) -> tuple[Settings, tuple[str, ...]]:
    """The settings in a file's bytes and the names of damaged fields."""
    try:
        # A path may hold bytes that are not UTF-8; where they are no path, the checks find them.
        document = json.loads(data.decode("utf-8-sig", "surrogateescape"), parse_int=_whole)
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict):
        return Settings(), tuple(CHECKS)
    damaged: list[str] = []
    values: dict[str, Any] = {}
    for name in [name for name in CHECKS if name in document]:
        value = document.pop(name)
        try:
            values[name] = CHECKS[name](value)
            if isinstance(value, list | dict) and len(values[name]) < len(value):
                damaged.append(name)
        except ValueError:
            damaged.append(name)
    others = checks.last_by(checks.text_up_to(100), checks.shallow, 100)(document)
    if len(others) < len(document):
        damaged.append("unknown to this version")
    return Settings(**values, of_others=others), tuple(damaged)


def save_settings(path: Path, settings: Settings) -> str:
    """Write the settings; a sentence if that failed, else ''; raises nothing."""
    if trouble := _trouble(path):
        return _unwritten(path, trouble)
    document = asdict(settings)
    document = {**document.pop("of_others"), **document}
    for name in ("geometry", "layout"):
        document[name] = checks.sealed(document[name])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # In ASCII: halves of surrogate pairs, as in paths that are not UTF-8, have no other form.
        write_atomically(path, (json.dumps(document, indent=1) + "\n").encode("ascii"))
    except OSError as error:
        return _unwritten(path, error.strerror)
    return ""


def save_changes(path: Path, settings: Settings, before: Settings) -> str:
    """Write what has changed since `before` into the file as it is by now; as `save_settings`.

    Another program may have written there meanwhile: what was not changed here stays as it is, and
    of lists and objects every entry; of a folder where one stopped and its τ, each by itself.
    """
    there, damaged = before, tuple[str, ...]()
    if path.is_file() and not _trouble(path):
        with contextlib.suppress(OSError):
            there, damaged = settings_from_json(path.read_bytes())
    there = replace(there, **{n: getattr(before, n) for n in damaged if n in CHECKS})
    return save_settings(path, merged(before, settings, there))


def merged(before: Settings, ours: Settings, theirs: Settings) -> Settings:
    """Theirs, with what is otherwise in ours than it was before."""
    changed: dict[str, Any] = {}
    for name in CHECKS:
        old, new, other = (getattr(s, name) for s in (before, ours, theirs))
        if new == old:
            continue
        if isinstance(new, dict):
            left = {k: v for k, v in other.items() if k in new or k not in old}
            own = {k: v for k, v in new.items() if old.get(k) != v}
            if name == "folders":
                own = {k: _merged_folder(old.get(k), v, other.get(k)) for k, v in own.items()}
            new = {k: v for k, v in left.items() if k not in own} | own
        elif isinstance(new, list):
            old_place = {k: place for place, k in enumerate(old)}
            latest_first = [k for n, k in enumerate(new) if old_place.get(k, n + 1) > n]
            rest = [k for k in other if (k in new or k not in old) and k not in latest_first]
            new = [*latest_first, *rest]
        with contextlib.suppress(ValueError):  # what no file can hold stays as it was
            changed[name] = CHECKS[name](new) if name not in ("geometry", "layout") else new
    return replace(theirs, **changed)


def _unread(path: Path, why: str | None) -> str:
    return tr("{file}: the settings cannot be read ({why}).", file=path, why=why)


def _unwritten(path: Path, why: str | None) -> str:
    return tr("{file}: the settings cannot be written ({why}).", file=path, why=why)


def _new_folder() -> dict[str, Any]:
    """What is kept of a folder in which nothing was done yet."""
    return {"clip": "", "profile": "", "method": "", "tau": {}}


def _merged_folder(
    old: dict[str, Any] | None, new: dict[str, Any], other: dict[str, Any] | None
) -> dict[str, Any]:
    """What another program keeps of a folder, with what was changed here; τ goes by whole."""
    if other is None:
        return new
    old = _new_folder() | (old or {})
    changed = {key for key, value in new.items() if old[key] != value}
    if changed & _FOLDER_TAU:
        changed |= _FOLDER_TAU
    return other | {key: value for key, value in new.items() if key in changed}


def _trouble(path: Path) -> str:
    """Why a path is no place for settings, or ''; what nobody could read is not written over."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return ""
    except OSError as error:
        return str(error.strerror)
    if not stat.S_ISREG(status.st_mode):  # to open a FIFO would wait for somebody
        return tr("it is no file")
    if status.st_size > _LARGEST_FILE:
        return tr("it has {size} MB", size=status.st_size // 1_000_000)
    return "" if os.access(path, os.R_OK) else "Permission denied"


def _whole(digits: str) -> float:
    return int(digits) if len(digits) <= _LONGEST_NUMBER else math.inf


def _set_aside(path: Path, data: bytes) -> Path:
    """Keep a copy beside a file, one for the same bytes; raises OSError."""
    for aside in path.parent.glob(f"{glob.escape(path.name)}.damaged*"):
        if aside.is_file() and read_file(aside) == data:
            return aside
    aside = free_name(path, ".damaged")
    write_atomically(aside, data)
    return aside
