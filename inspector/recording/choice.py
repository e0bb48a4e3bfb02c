"""The choice of what to record: a film of frames or of a sweep, or a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inspector.recording.film import SUFFIXES
from inspector.recording.sweep import Sweep

FPS = {".mp4": 30.0, ".gif": 15.0}
USUAL_POINTS = 8.0  # type size of the plots' numbers, on the screen and on paper
SCREEN_DPI = 96.0


@dataclass(frozen=True)
class Contents:
    """Which parts of the window are recorded."""

    view: bool = True  # the figure in 3D
    curves: bool = True
    equations: bool = False

    @property
    def anything(self) -> bool:
        """True if there is anything to record."""
        return self.view or self.curves or self.equations


@dataclass(frozen=True)
class Paper:
    """The medium of a picture.

    dpi: pixels per inch; points: size of the smallest letters, which also scales the lines; white:
    True for the light theme on white paper, False for the window's colours.
    """

    dpi: float = SCREEN_DPI
    points: float = USUAL_POINTS
    white: bool = False


@dataclass(frozen=True)
class RecordChoice:
    """What to record, how, and where to.

    path: its suffix is a film's, or .png, .svg or .pdf; first, stop: frames of the clip for a
    film; speed: relative to real time; size: in pixels, where a picture's height 0 means as high
    as needed; sweep: the slider that a film of one frame moves, or None.
    """

    path: Path
    first: int = 0
    stop: int = 1
    speed: float = 1.0
    size: tuple[int, int] = (1280, 720)
    contents: Contents = Contents()
    replace: bool = False
    paper: Paper = Paper()
    sweep: Sweep | None = None

    @property
    def film(self) -> bool:
        """True for a film, False for a picture."""
        return self.path.suffix.lower() in SUFFIXES

    @property
    def fps(self) -> float:
        """Pictures per second of a film."""
        return FPS[self.path.suffix.lower()]


@dataclass(frozen=True)
class Shot:
    """One picture of a film: a frame of the clip, and the value of the swept slider."""

    frame: int
    value: float | None = None


def shots(choice: RecordChoice, clip_fps: float, frame: int) -> list[Shot]:
    """Return the pictures of a film in their order; frame: the playhead."""
    if choice.sweep is not None:
        return [Shot(frame, value) for value in choice.sweep.values(choice.fps)]
    step = choice.speed * clip_fps / choice.fps
    count = max(1, int(np.ceil((choice.stop - choice.first) / step - 1e-9)))
    return [Shot(min(choice.first + int(k * step), choice.stop - 1)) for k in range(count)]
