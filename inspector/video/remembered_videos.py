"""The setting that records which video belongs to which clip."""

from __future__ import annotations

from pathlib import Path

from inspector.session import settings_checks as checks
from inspector.session.settings import FeatureSetting, Settings
from twistcore.files.ordinary import real_path

MOST_VIDEOS = 500
FARTHEST_S = 86_400.0  # maximum offset of a video in seconds, in either direction

# The video's path and its offset in seconds, keyed by the clip's path. The latest comes last.
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
    """Record the path of a clip's video and its time offset in seconds.

    The time in the video is the time in the clip plus the offset.
    """
    now = str(real_path(video)), min(max(offset, -FARTHEST_S), FARTHEST_S)
    others = {k: v for k, v in VIDEOS.of(settings).items() if k != clip}
    VIDEOS.put(settings, dict([*others.items(), (clip, now)][-MOST_VIDEOS:]))


def forget_video(settings: Settings, clip: str) -> None:
    """Delete the record of a clip's video, if there is one."""
    VIDEOS.put(settings, {k: v for k, v in VIDEOS.of(settings).items() if k != clip})
