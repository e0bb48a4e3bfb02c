"""The settings of a recording: a picture, a film of the clip, or a film of a moving slider."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inspector.recording.film import SUFFIXES
from inspector.recording.sweep import Sweep

FPS = {".mp4": 30.0, ".gif": 15.0}
USUAL_POINTS = 8.0  # font size of the numbers in plots, on the screen and on paper
SCREEN_DPI = 96.0


@dataclass(frozen=True)
class Contents:
    """The parts of the window that are recorded."""

    view: bool = True  # the figure in 3D
    curves: bool = True
    equations: bool = False

    @property
    def anything(self) -> bool:
        """Return True if any part is recorded."""
        return self.view or self.curves or self.equations


@dataclass(frozen=True)
class Paper:
    """The properties of a picture for print or screen.

    Attributes
    ----------
    dpi
        Pixels per inch.
    points
        The size of the smallest text in points. Line widths are scaled by the same factor.
    white
        True for the light theme on white paper, False for the colours of the window.
    """

    dpi: float = SCREEN_DPI
    points: float = USUAL_POINTS
    white: bool = False


@dataclass(frozen=True)
class RecordChoice:
    """The settings of a recording.

    Attributes
    ----------
    path
        The file to write. Its suffix is .png, .svg, .pdf or one of the suffixes for films.
    first, stop
        The range of frames [first, stop) of a film.
    speed
        The speed relative to real time.
    size
        The width and the height in pixels. If the height is 0, it is adapted to the contents.
    contents
        The parts of the window to record.
    replace
        True if an existing file may be replaced.
    paper
        The resolution, text size and colours of a picture.
    sweep
        The movement of a slider in a film of a single frame, or None.
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
        """The number of images per second in a film."""
        return FPS[self.path.suffix.lower()]


@dataclass(frozen=True)
class Shot:
    """One image of a film: the clip's frame and, if a slider moves, the slider's value."""

    frame: int
    value: float | None = None


def film_shots(choice: RecordChoice, clip_fps: float, frame: int) -> list[Shot]:
    """Return the images of a film in order. `frame` is the frame at the playhead."""
    if choice.sweep is not None:
        return [Shot(frame, value) for value in choice.sweep.values(choice.fps)]
    step = choice.speed * clip_fps / choice.fps
    count = max(1, int(np.ceil((choice.stop - choice.first) / step - 1e-9)))
    return [Shot(min(choice.first + int(k * step), choice.stop - 1)) for k in range(count)]
