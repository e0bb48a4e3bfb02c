"""What the program remembers between two runs, in one JSON file."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import platformdirs

from twistcore.atomic import write_atomically

RECENT = 10
VIDEOS = 500


@dataclass
class Settings:
    """What is kept.

    theme: 'system', 'light' or 'dark'; geometry, layout: Qt's bytes as hex; first_frame: 0 or 1;
    step: frames that Ctrl+arrow goes by; keys: keys by action id where they differ from the table;
    turn_ms: milliseconds in which the camera turns to another limb, 0 for at once; videos: by the
    clip's path its video's path and offset in seconds, the latest last.
    """

    theme: str = "system"
    recent: list[str] = field(default_factory=list)
    reviewer: str = ""
    geometry: str = ""
    layout: str = ""
    first_frame: int = 0
    step: int = 10
    keys: dict[str, list[str]] = field(default_factory=dict)
    turn_ms: int = 220
    videos: dict[str, tuple[str, float]] = field(default_factory=dict)

    def remember(self, path: Path) -> None:
        """Put a file first in the list of recent ones."""
        name = str(path.resolve())
        self.recent = [name, *(r for r in self.recent if r != name)][:RECENT]

    def remember_video(self, clip: str, video: Path, offset: float) -> None:
        """Keep a clip's video and its offset in seconds."""
        self.videos.pop(clip, None)
        self.videos[clip] = str(video.resolve()), offset
        for oldest in list(self.videos)[:-VIDEOS]:
            del self.videos[oldest]


def settings_path() -> Path:
    """Where the settings live; the environment variable TWIST_INSPECTOR_SETTINGS moves them."""
    if moved := os.environ.get("TWIST_INSPECTOR_SETTINGS"):
        return Path(moved)
    return Path(platformdirs.user_config_dir("twist-inspector", appauthor=False)) / "settings.json"


def load_settings(path: Path) -> tuple[Settings, str]:
    """The settings and a sentence to show, '' if all is well.

    A damaged file is renamed to NAME.damaged and defaults are used.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        known = {f.name: type(getattr(Settings(), f.name)) for f in fields(Settings)}
        values = {k: v for k, v in document.items() if k in known}
        if not all(isinstance(v, known[k]) for k, v in values.items()):
            raise ValueError
        if not all(isinstance(r, str) for r in values.get("recent", [])):
            raise ValueError
        values["videos"] = {
            clip: (str(video), float(offset))
            for clip, (video, offset) in values.get("videos", {}).items()
        }
        if not all(math.isfinite(offset) for _, offset in values["videos"].values()):
            raise ValueError
        settings = Settings(**values)
        if settings.first_frame not in (0, 1) or settings.step < 1 or settings.turn_ms < 0:
            raise ValueError
        return settings, ""
    except FileNotFoundError:
        return Settings(), ""
    except OSError as error:
        return Settings(), f"{path}: the settings cannot be read ({error.strerror})."
    except (ValueError, AttributeError, TypeError):
        aside = path.with_name(path.name + ".damaged")
        try:
            path.replace(aside)
        except OSError:
            return Settings(), f"{path}: the settings are damaged; defaults are used."
        return Settings(), f"The settings were damaged and set aside as {aside}."


def save_settings(path: Path, settings: Settings) -> str:
    """Write the settings; a sentence if that failed, else ''."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, (json.dumps(asdict(settings), indent=1) + "\n").encode())
    except OSError as error:
        return f"{path}: the settings cannot be written ({error.strerror})."
    return ""
