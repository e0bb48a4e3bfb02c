"""The settings that record which video belongs to each clip."""

from __future__ import annotations

from pathlib import Path

from inspector.session import settings_checks as checks
from inspector.session.settings import FeatureSetting, Settings
from twistcore.files.ordinary import real_path

MOST_VIDEOS = 500
FARTHEST_S = 86_400.0  # maximum offset of a video in either direction

# Keyed by the clip's path: the video's path and its offset in seconds. The latest is the last.
VIDEOS: FeatureSetting[dict[str, tuple[str, float]]] = FeatureSetting(
    "videos",
    {},
    checks.last_by(
        checks.file_path,
        checks.both(checks.file_path, checks.number_between(-FARTHEST_S, FARTHEST_S)),
        MOST_VIDEOS,
    ),
)


def remember_video(settings: Settings, clip: str, video: Path, offset: float) -> None:
    """Save the path of a clip's video and the offset between them, in seconds."""
    now = str(real_path(video)), min(max(offset, -FARTHEST_S), FARTHEST_S)
    others = {k: v for k, v in VIDEOS.of(settings).items() if k != clip}
    VIDEOS.put(settings, dict([*others.items(), (clip, now)][-MOST_VIDEOS:]))


def forget_video(settings: Settings, clip: str) -> None:
    """Remove the record of a clip's video."""
    VIDEOS.put(settings, {k: v for k, v in VIDEOS.of(settings).items() if k != clip})
