"""Records of recent folders: the last open clip and the τ of each folder."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from inspector.session import settings_checks as checks
from inspector.session.settings import FeatureSetting, Settings
from twistcore.files.ordinary import real_path

_MOST = 100
_OF_TAU = {"profile", "method", "tau"}  # these values belong together


def _new() -> dict[str, Any]:
    """Return the record of a new folder."""
    return {"clip": "", "profile": "", "method": "", "tau": {}}


def _merged(
    old: dict[str, Any] | None, new: dict[str, Any], other: dict[str, Any] | None
) -> dict[str, Any]:
    """Merge this window's changes to a folder's record into the record saved by another window.

    `old` is the record before this window's changes, `new` the record after them, and `other` the
    record saved by the other window. The three values that determine τ are always copied together.
    """
    if other is None:
        return new
    old = _new() | (old or {})
    changed = {key for key, value in new.items() if old[key] != value}
    if changed & _OF_TAU:
        changed |= _OF_TAU
    return other | {key: value for key, value in new.items() if key in changed}


# Keyed by the path of a folder: the clip at which the user stopped; and for all clips of the
# folder, the name of a profile ('' for the automatic τ of each clip), the detector, and τ in
# radians. The latest folder comes last.
FOLDERS: FeatureSetting[dict[str, dict[str, Any]]] = FeatureSetting(
    "folders",
    {},
    checks.last_by(
        checks.file_path,
        checks.record(
            clip=checks.file_path_or_none,
            profile=checks.text_up_to(1000),
            method=checks.text_up_to(100),
            tau=checks.last_by(checks.text_up_to(1000), checks.number_between(0.0, math.pi), 1000),
        ),
        _MOST,
    ),
    _merged,
)
# True to open the next clip of the folder after an export.
NEXT_AFTER_EXPORT = FeatureSetting("next_after_export", True, checks.truth)


def folder_record(settings: Settings, folder: Path) -> dict[str, Any]:
    """Return the record of a folder, or a new record if the folder has not been opened before."""
    return _new() | FOLDERS.of(settings).get(str(real_path(folder)), {})


def recent_folders(settings: Settings) -> list[Path]:
    """Return the recently opened folders, the latest first."""
    return [Path(name) for name in reversed(FOLDERS.of(settings))]


def remember_folder(settings: Settings, folder: Path, **known: Any) -> None:
    """Update fields in a folder's record, and move the folder to the top of the recent folders."""
    now = folder_record(settings, folder) | known
    name = str(real_path(folder))
    others = {k: v for k, v in FOLDERS.of(settings).items() if k != name}
    FOLDERS.put(settings, dict([*others.items(), (name, now)][-_MOST:]))
