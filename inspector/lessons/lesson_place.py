"""The place in a clip that a lesson page shows, and the settings that describe it in a file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from inspector.language import tr
from inspector.lessons.watched_places import MOST_WATCHED, PLACES
from inspector.teaching.symbols import SYMBOLS
from twistcore.analysis.decomposition import WhatIf
from twistcore.detection import DETECTORS

TABS = ("teaching", "intervals")
_DIGITS = 9  # maximum number of digits of a frame number
_NEAREST = 100.0  # largest zoom factor
LOOKS = ("before", "after", "both")


@dataclass(frozen=True)
class Camera:
    """The direction from which a limb is seen: azimuth and elevation in radians, and zoom.

    At azimuth 0, the camera is in front of the figure.

    Attributes
    ----------
    zoom
        The size of the limb in the image relative to its default size.
    """

    azimuth: float
    elevation: float
    zoom: float


@dataclass(frozen=True)
class LessonPlace:
    """The place in a clip that a lesson page shows, and how the page shows it.

    Attributes
    ----------
    frame
        The frame number, from 0.
    chain
        The name of a chain or limb; '' for none.
    camera
        The camera; None if the program chooses it.
    show
        The symbols whose equations are listed in the teaching tab; () for all.
    lit
        The symbol to highlight, or ''.
    what_if
        The what-if values of the frame.
    stage
        The stage of the parent's rotation, as in TaughtFrame.stage.
    tab
        The tab in front, one of TABS.
    look
        Which figures are shown, one of LOOKS.
    skin
        True for the striped skin, False for bones.
    tau
        τ of the chain in radians; None for the detector's automatic τ.
    detector
        The name of a detector; '' for the default.
    watched
        The parts of the window to watch, keys of PLACES; all others are dimmed. () dims nothing.
    """

    clip: Path
    frame: int = 0
    chain: str = ""
    camera: Camera | None = None
    show: tuple[str, ...] = ()
    lit: str = ""
    what_if: WhatIf = field(default_factory=WhatIf)
    stage: float | None = None
    tab: str = "teaching"
    look: str = "both"
    skin: bool = False
    tau: float | None = None
    detector: str = ""
    watched: tuple[str, ...] = ()


def _frame(text: str) -> dict[str, Any]:
    if not text.isdecimal() or len(text) > _DIGITS:
        raise ValueError(tr("a frame, counted from 0"))
    return {"frame": int(text)}


def _camera(text: str) -> dict[str, Any]:
    if text == "limb":
        return {"camera": None}
    numbers = _numbers(
        text, 3, tr("'limb', or an azimuth and an elevation in degrees and a zoom factor")
    )
    if not 1.0 / _NEAREST <= numbers[2] <= _NEAREST:
        expected = tr(
            "a zoom factor from {least:g} to {most:g}", least=1.0 / _NEAREST, most=_NEAREST
        )
        raise ValueError(expected)
    azimuth, elevation = np.radians(numbers[:2])
    return {"camera": Camera(float(azimuth), float(elevation), numbers[2])}


def _symbol(text: str) -> str:
    if text not in SYMBOLS:
        raise ValueError(tr("one of the symbols {known}", known=", ".join(SYMBOLS)))
    return text


def _look(text: str) -> dict[str, Any]:
    words = [word.strip() for word in text.split(",")]
    figures = [word for word in words if word in LOOKS]
    if len(figures) > 1 or any(word not in (*LOOKS, "skin") for word in words):
        known = ", ".join(LOOKS)
        raise ValueError(tr("one of {known}, and optionally 'skin' to show the skin", known=known))
    return {"look": figures[0] if figures else "both", "skin": "skin" in words}


def _tab(text: str) -> dict[str, Any]:
    if text not in TABS:
        raise ValueError(tr("one of {known}", known=", ".join(TABS)))
    return {"tab": text}


def _tau(text: str) -> dict[str, Any]:
    return {"tau": _degrees(0, 180)(text)}


def _detector(text: str) -> dict[str, Any]:
    if text not in DETECTORS:
        known = ", ".join(DETECTORS)
        raise ValueError(tr("one of the detectors {known}", known=known))
    return {"detector": text}


def _watched(text: str) -> dict[str, Any]:
    places = tuple(dict.fromkeys(re.split(r"[,\s]+", text)))
    if len(places) > MOST_WATCHED or not PLACES.keys() >= set(places):
        known = ", ".join(PLACES)
        raise ValueError(
            tr("at most {most} of these places: {known}", most=MOST_WATCHED, known=known)
        )
    return {"watched": places}


def _what_if(text: str) -> dict[str, Any]:
    altered: dict[str, Any] = {}
    stage: float | None = None
    for part in text.split(","):
        name, _, value = part.strip().partition(" ")
        if name == "stage":
            stage = _within(value, 0.0, 2.0, tr("a number from 0 to 2 after 'stage'"))
        elif name in _ALTERED:
            altered[name] = _ALTERED[name](value)
        else:
            known = ", ".join((*_ALTERED, "stage"))
            raise ValueError(tr("one or more of {known}, each followed by its value", known=known))
    return {"what_if": WhatIf(**altered), "stage": stage}


def _numbers(text: str, count: int, expected: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word.rstrip("°")) for word in text.split())
    except ValueError:
        raise ValueError(expected) from None
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError(expected)
    return numbers


def _within(text: str, low: float, high: float, expected: str) -> float:
    (number,) = _numbers(text, 1, expected)
    if not low <= number <= high:
        raise ValueError(expected)
    return number


def _degrees(low: int, high: int) -> Callable[[str], float]:
    """Return a function that reads an angle in degrees, `low` to `high`, and returns radians."""
    expected = tr("an angle in degrees from {low} to {high}", low=low, high=high)
    return lambda text: float(np.radians(_within(text, low, high, expected)))


def _switch(text: str) -> bool:
    if text:
        raise ValueError(tr("no value after 'counter'"))
    return True


def _share(text: str) -> float:
    return _within(text, 0.0, 1.0, tr("a share from 0 to 1 after 'applied'"))


def _direction(text: str) -> tuple[float, ...]:
    x, y, z = _numbers(text, 3, tr("a direction x y z after 'toward'"))
    length = math.hypot(x, y, z)  # `hypot` does not overflow for large numbers
    if not 1e-9 <= length < math.inf:
        raise ValueError(tr("a direction other than 0 0 0 after 'toward'"))
    return (x / length, y / length, z / length)


_ALTERED: Mapping[str, Callable[[str], Any]] = {
    "twist": _degrees(-180, 180),
    "counter": _switch,
    "swing": _degrees(0, 180),
    "bend": _degrees(0, 180),
    "nudge": _degrees(-3, 3),
    "toward": _direction,
    "applied": _share,
}

# Functions that read the fields of a LessonPlace, keyed by the field's name in a file.
FIELDS: Mapping[str, Callable[[str], dict[str, Any]]] = {
    "frame": _frame,
    "chain": lambda name: {"chain": name},
    "camera": _camera,
    "show": lambda text: {"show": tuple(_symbol(s) for s in re.split(r"[,\s]+", text))},
    "lit": lambda text: {"lit": _symbol(text)},
    "what-if": _what_if,
    "tab": _tab,
    "look": _look,
    "tau": _tau,
    "detector": _detector,
    "watch": _watched,
}


# -- written -------------------------------------------------------------------------------------


def lesson_place_settings(place: LessonPlace) -> str:
    """Return the settings of a lesson place as text for a lesson file.

    The clip is written as a file name without its folder.
    """
    lines = [f"clip: {place.clip.name}", f"frame: {place.frame}"]
    if place.chain:
        lines.append(f"chain: {place.chain}")
    if (camera := place.camera) is None:
        lines.append("camera: limb")
    else:
        around, above = (_short(np.degrees(a), 1) for a in (camera.azimuth, camera.elevation))
        lines.append(
            f"camera: {around} {above} {_short(min(max(camera.zoom, 1.0 / _NEAREST), _NEAREST), 2)}"
        )
    if place.show:
        lines.append(f"show: {', '.join(place.show)}")
    if place.lit:
        lines.append(f"lit: {place.lit}")
    if altered := _alterations(place):
        lines.append(f"what-if: {', '.join(altered)}")
    lines.append(f"tab: {place.tab}")
    lines.append(f"look: {place.look}{', skin' * place.skin}")
    if place.tau is not None:
        lines.append(f"tau: {_short(np.degrees(place.tau), 3)}")
    if place.detector:
        lines.append(f"detector: {place.detector}")
    if place.watched:
        lines.append(f"watch: {', '.join(place.watched)}")
    return "\n".join(("```lesson", *lines, "```"))


def _alterations(place: LessonPlace) -> list[str]:
    what_if = place.what_if
    out = [f"twist {_short(np.degrees(what_if.twist), 1)}"] if what_if.twist else []
    out += ["counter"] * what_if.counter
    for name in ("swing", "bend"):
        if (angle := getattr(what_if, name)) is not None:
            out.append(f"{name} {_short(np.degrees(angle), 1)}")
    if what_if.nudge:
        out.append(f"nudge {_short(np.degrees(what_if.nudge), 1)}")
    if what_if.toward is not None:
        out.append(f"toward {' '.join(_short(x, 4) for x in what_if.toward)}")
    if what_if.applied:
        out.append(f"applied {_short(what_if.applied, 3)}")
    if place.stage is not None:
        out.append(f"stage {_short(place.stage, 2)}")
    return out


def _short(number: float, digits: int) -> str:
    """Return a number as text with at most `digits` decimals, without trailing zeros.

    A negative zero is written as 0.
    """
    return f"{round(float(number), digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".")
