"""The settings of the program, stored in one JSON file.

Each feature of the window declares its settings in its own folder, as FeatureSetting objects.
Therefore, settings can be read only after the modules of the window have been imported.
"""

from __future__ import annotations

import contextlib
import glob
import json
import math
import os
import stat
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

import platformdirs

from inspector.language import tr
from inspector.session import settings_checks as checks
from inspector.session.settings_checks import Check
from twistcore.files.atomic import first_unused_path, write_atomically
from twistcore.files.ordinary import read_file, real_path, user_folder_or_uncreatable_path

RECENT = 10
STEPS = (2, 1000)  # range of frames for Ctrl+arrow
_LARGEST_FILE = 64_000_000  # bytes; a file written by this program has a few kilobytes
_LONGEST_NUMBER = 18  # digits; longer numbers are out of range and slow to read


T = TypeVar("T")


@dataclass
class Settings:
    """The settings of the program. The functions in CHECKS define the allowed values.

    Attributes
    ----------
    theme
        'system', 'light' or 'dark'.
    recent
        The paths of the files opened last, the latest first.
    reviewer
        The reviewer's name.
    geometry, layout
        The window's geometry and layout as saved by Qt, in hexadecimal.
    first_frame
        The number of the first frame, 0 or 1.
    step
        The number of frames by which Ctrl+arrow moves the playhead.
    keys
        The keyboard shortcuts that differ from the defaults, keyed by action id.
    zoom_to_interval
        True if N, A and R zoom the plots to the interval.
    order
        The order in which N, A and R visit intervals: 'worst', 'chain' or 'time'.
    reviewer_asked
        True if the program has already asked for the reviewer's name.
    turn_ms
        The duration, in milliseconds, of the camera's rotation to another limb; 0 for none.
    look_ms
        The minimum time, in milliseconds, for which each error of a group is shown before a
        decision on the group.
    autosave
        True if sessions are saved automatically.
    columns
        The columns of the list of intervals; if empty, as many columns as fit.
    interval_sort
        The column by which intervals are sorted, with '-' in front for descending order; '' for
        none.
    group_errors
        True to list errors that belong together as a group.
    skin
        True to draw limbs with the striped skin instead of wedges.
    side_by_side
        True to draw the poses before and after the correction side by side.
    looks_by_kind
        For each kind of error, the list of those views ('skin', 'side_by_side') that are on. A
        kind without an entry uses the last choice.
    language
        'system' or a language code such as 'de'; an unknown code means 'system'.
    of_features
        The value of each FeatureSetting, keyed by the name of the setting.
    of_others
        Entries that this version does not know; they are saved unchanged for newer versions.
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
    order: str = "worst"
    reviewer_asked: bool = False
    turn_ms: int = 220
    look_ms: int = 400
    autosave: bool = True
    columns: list[str] = field(default_factory=list)
    interval_sort: str = ""
    group_errors: bool = True
    skin: bool = True
    side_by_side: bool = True
    looks_by_kind: dict[str, list[str]] = field(default_factory=dict)
    language: str = "system"
    of_features: dict[str, Any] = field(default_factory=dict)
    of_others: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = {name: setting.default for name, setting in _of_features.items()}
        self.of_features = known | self.of_features

    def remember(self, path: Path) -> None:
        """Move a file to the top of the list of recent files."""
        name = str(real_path(path))
        self.recent = [name, *(r for r in self.recent if r != name)][:RECENT]

    def value(self, name: str) -> Any:
        """Return the value of a field of this class or of a feature's setting."""
        return _of_features[name].of(self) if name in _of_features else getattr(self, name)

    def put(self, name: str, value: Any) -> None:
        """Set the value of a field of this class or of a feature's setting."""
        if name in _of_features:
            _of_features[name].put(self, value)
        else:
            setattr(self, name, value)


# Takes the values (before, ours, theirs) and returns the value to save
Merge = Callable[[Any, Any, Any], Any]
_of_features: dict[str, FeatureSetting[Any]] = {}


@dataclass(frozen=True)
class FeatureSetting(Generic[T]):
    """A setting that a feature of the window declares in its own folder.

    Attributes
    ----------
    name
        The name of the setting in settings files.
    default
        The initial value.
    check
        The function that checks a value from a file.
    merge
        If the value is a dictionary: the function that chooses between two values of an entry that
        two windows have changed. By default, the value of this window is kept.
    """

    name: str
    default: T
    check: Check
    merge: Merge | None = None

    def __post_init__(self) -> None:
        if self.name in CHECKS or self.name in _of_features:
            raise ValueError(f"there is a setting {self.name!r} already")
        _of_features[self.name] = self

    def of(self, settings: Settings) -> T:
        """Return the value of this setting in `settings`."""
        found: T = settings.of_features.get(self.name, self.default)
        return found

    def put(self, settings: Settings, value: T) -> None:
        """Set the value of this setting in `settings`."""
        settings.of_features[self.name] = value


# The checks of the values in a file. All values that the window offers pass their check.
CHECKS: dict[str, Check] = {
    "theme": checks.any_of("system", "light", "dark"),
    "recent": checks.first_of(checks.file_path, RECENT),
    "reviewer": checks.text_up_to(1000),
    "geometry": checks.hex_with_checksum(100_000),
    "layout": checks.hex_with_checksum(1_000_000),
    "first_frame": checks.whole_between(0, 1),
    "step": checks.whole_between(*STEPS),
    "keys": checks.last_by(checks.text_up_to(100), checks.list_of(checks.text_up_to(100), 8), 1000),
    "zoom_to_interval": checks.truth,
    "order": checks.any_of("worst", "chain", "time"),
    "reviewer_asked": checks.truth,
    "turn_ms": checks.whole_between(0, 10_000),
    "look_ms": checks.whole_between(0, 10_000),
    "autosave": checks.truth,
    "columns": checks.first_of(checks.text_up_to(20), 20),
    "interval_sort": checks.text_up_to(21),
    "group_errors": checks.truth,
    "skin": checks.truth,
    "side_by_side": checks.truth,
    "looks_by_kind": checks.last_by(
        checks.text_up_to(100), checks.list_of(checks.any_of("skin", "side_by_side"), 2), 100
    ),
    "language": checks.text_up_to(20),
}


def checks_by_name() -> Mapping[str, Check]:
    """Return the check of every setting, including those of features, keyed by name."""
    return {**CHECKS, **{name: setting.check for name, setting in _of_features.items()}}


def settings_path() -> Path:
    """Return the path of the settings file.

    The environment variable TWIST_INSPECTOR_SETTINGS overrides the default path.
    """
    if moved := os.environ.get("TWIST_INSPECTOR_SETTINGS"):
        return Path(moved)
    find = partial(platformdirs.user_config_path, "twist-inspector", appauthor=False)
    return user_folder_or_uncreatable_path(find) / "settings.json"


def load_settings(path: Path) -> tuple[Settings, str]:
    """Return the settings in a file, and a sentence about a problem, or ''. Never raises.

    Damaged fields get their defaults, and damaged entries of lists and objects are removed. A copy
    of the damaged file is saved next to the original.
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
    if len(damaged) < len(checks_by_name()):
        which = tr("The settings {names}", names=", ".join(damaged))
    said = tr(
        "{settings} were damaged. Intact values were kept; the others were reset.",
        settings=which,
    )
    try:
        aside = tr("The old file was kept as {file}.", file=_set_aside(path, data))
    except OSError as error:
        aside = tr("The old file could not be backed up ({why}).", why=error.strerror)
    return settings, f"{said} {aside}"


def settings_from_json(data: bytes) -> tuple[Settings, tuple[str, ...]]:
    """Return the settings in a file's bytes, and the names of damaged fields."""
    try:
        # Paths may contain bytes that are not UTF-8; in other values, the checks reject such bytes.
        document = json.loads(data.decode("utf-8-sig", "surrogateescape"), parse_int=_whole)
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict):
        return Settings(), tuple(checks_by_name())
    damaged: list[str] = []
    values: dict[str, Any] = {}
    for name, check in checks_by_name().items():
        if name not in document:
            continue
        value = document.pop(name)
        try:
            values[name] = check(value)
            if isinstance(value, list | dict) and len(values[name]) < len(value):
                damaged.append(name)
        except ValueError:
            damaged.append(name)
    others = checks.last_by(checks.text_up_to(100), checks.shallow_json, 100)(document)
    if len(others) < len(document):
        damaged.append("unknown to this version")
    of_features = {name: values.pop(name) for name in _of_features if name in values}
    return Settings(**values, of_features=of_features, of_others=others), tuple(damaged)


def save_settings(path: Path, settings: Settings) -> str:
    """Write the settings. Return '', or a sentence with the reason for a failure. Never raises."""
    if trouble := _trouble(path):
        return _unwritten(path, trouble)
    document = asdict(settings)
    document = {**document.pop("of_others"), **document.pop("of_features"), **document}
    for name in ("geometry", "layout"):
        document[name] = checks.append_hex_checksum(document[name])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Write ASCII, because lone surrogates (from paths that are not UTF-8) need escapes.
        write_atomically(path, (json.dumps(document, indent=1) + "\n").encode("ascii"))
    except OSError as error:
        return _unwritten(path, error.strerror)
    return ""


def save_changes(path: Path, settings: Settings, before: Settings) -> str:
    """Write only the settings that differ from `before`; another window may have changed the rest.

    The file keeps its values for all settings that this window did not change. Lists and objects
    are merged entry by entry. Returns '' on success, or a sentence with the reason for the failure.
    """
    there, damaged = before, tuple[str, ...]()
    if path.is_file() and not _trouble(path):
        with contextlib.suppress(OSError):
            there, damaged = settings_from_json(path.read_bytes())
    there = _with_values(there, {n: before.value(n) for n in damaged if n in checks_by_name()})
    return save_settings(path, merged(before, settings, there))


def _with_values(settings: Settings, values: Mapping[str, Any]) -> Settings:
    own = {name: value for name, value in values.items() if name in CHECKS}
    others = {name: value for name, value in values.items() if name not in CHECKS}
    return replace(settings, **own, of_features={**settings.of_features, **others})


def merged(before: Settings, ours: Settings, theirs: Settings) -> Settings:
    """Return `theirs` with the changes that were made from `before` to `ours`."""
    changed: dict[str, Any] = {}
    for name, check in checks_by_name().items():
        old, new, other = (s.value(name) for s in (before, ours, theirs))
        if new == old:
            continue
        if isinstance(new, dict):
            left = {k: v for k, v in other.items() if k in new or k not in old}
            own = {k: v for k, v in new.items() if old.get(k) != v}
            if name in _of_features and (merge := _of_features[name].merge) is not None:
                own = {k: merge(old.get(k), v, other.get(k)) for k, v in own.items()}
            new = {k: v for k, v in left.items() if k not in own} | own
        elif isinstance(new, list):
            old_place = {k: place for place, k in enumerate(old)}
            latest_first = [k for n, k in enumerate(new) if old_place.get(k, n + 1) > n]
            rest = [k for k in other if (k in new or k not in old) and k not in latest_first]
            new = [*latest_first, *rest]
        with contextlib.suppress(ValueError):  # keep the old value if the new one fails its check
            changed[name] = check(new) if name not in ("geometry", "layout") else new
    return _with_values(theirs, changed)


def _unread(path: Path, why: str | None) -> str:
    return tr("The settings file {file} cannot be read ({why}).", file=path, why=why)


def _unwritten(path: Path, why: str | None) -> str:
    return tr("The settings file {file} cannot be written ({why}).", file=path, why=why)


def _trouble(path: Path) -> str:
    """Return the reason why a path cannot be used as a settings file, or '' if it can."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return ""
    except OSError as error:
        return str(error.strerror)
    if not stat.S_ISREG(status.st_mode):  # opening a FIFO would block
        return tr("it is not a regular file")
    if status.st_size > _LARGEST_FILE:
        return tr("it is too large ({size} MB)", size=status.st_size // 1_000_000)
    return "" if os.access(path, os.R_OK) else "Permission denied"


def _whole(digits: str) -> float:
    return int(digits) if len(digits) <= _LONGEST_NUMBER else math.inf


def _set_aside(path: Path, data: bytes) -> Path:
    """Return the path of a damaged file's copy. Copy the file first if there is no copy yet.

    Raises OSError.
    """
    for aside in path.parent.glob(f"{glob.escape(path.name)}.damaged*"):
        if aside.is_file() and read_file(aside) == data:
            return aside
    aside = first_unused_path(path, ".damaged")
    write_atomically(aside, data)
    return aside
