"""What a person asks to have recorded: a film of frames or of a sweep, or a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inspector.recording.film import SUFFIXES
from inspector.recording.sweep import Sweep

FPS = {".mp4": 30.0, ".gif": 15.0}
USUAL_POINTS = 8.0  # type of the numbers at the plots, on a screen as on paper
SCREEN_DPI = 96.0


@dataclass(frozen=True)
class Contents:
    """What is seen in it."""

    view: bool = True  # the figure in 3D
    curves: bool = True
    equations: bool = False

    @property
    def anything(self) -> bool:
        """Whether there is something to record."""
        return self.view or self.curves or self.equations


@dataclass(frozen=True)
class Paper:
    """What a picture is made for.

    dpi: pixels an inch; points: the type of the smallest letters, lines go with it; white: on white
    paper in the light theme, else as the window looks.
    """

    dpi: float = SCREEN_DPI
    points: float = USUAL_POINTS
    white: bool = False


@dataclass(frozen=True)
class RecordChoice:
    """What a person asked for.

    path: its suffix says what it becomes, one of a film's or .png, .svg, .pdf; first, stop: frames
    of the clip for a film; speed: times real time; size: pixels, of a picture the height may be 0:
    as high as its contents; sweep: the film is of a slider at the frame that is shown, not of
    frames.
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
        """Whether it is one, not a picture."""
        return self.path.suffix.lower() in SUFFIXES

    @property
    def fps(self) -> float:
        """Pictures a second of a film."""
        return FPS[self.path.suffix.lower()]


@dataclass(frozen=True)
class Shot:
    """One picture of a film: a frame of the clip, and where the swept slider stands."""

    frame: int
    value: float | None = None


def shots(choice: RecordChoice, clip_fps: float, frame: int) -> list[Shot]:
    """What a film shows, one after the other; frame: where the playhead is."""
    if choice.sweep is not None:
        return [Shot(frame, value) for value in choice.sweep.values(choice.fps)]
    step = choice.speed * clip_fps / choice.fps
    count = max(1, int(np.ceil((choice.stop - choice.first) / step - 1e-9)))
    return [Shot(min(choice.first + int(k * step), choice.stop - 1)) for k in range(count)]
