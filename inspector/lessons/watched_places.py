"""Dim all parts of the window except the places that the user should watch on a lesson page."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial

from PySide6.QtWidgets import QWidget

from inspector.feature import HostWindow
from inspector.teaching.feature import feature as teaching
from inspector.timeline.plot import plots
from inspector.widgets.veil import Veil

MOST_WATCHED = 2  # more places cannot be watched at once
_Widgets = tuple[QWidget, ...]


def _equations(window: HostWindow) -> _Widgets:
    panel = window.part(teaching).teaching
    return panel.title, panel.scroll_area


def _dock(name: str, window: HostWindow) -> _Widgets:
    return (window.docks[name].widget(),)


def _pane(key: str, window: HostWindow) -> _Widgets:
    return (window.timeline.panes[key],)


# Functions that return the widgets of a place, keyed by the name of the place in a lesson file.
PLACES: Mapping[str, Callable[[HostWindow], _Widgets]] = {
    "figure": lambda window: (window.viewport,),
    "clock": lambda window: (window.viewport.overlays.clock, window.viewport.overlays.whole),
    "transport": lambda window: (window.transport,),
    "strip": lambda window: (window.timeline.overview, window.timeline.readout),
    **{key: partial(_pane, key) for key in plots()},
    "equations": _equations,
    "sliders": lambda window: (window.part(teaching).teaching.what_if,),
    "intervals": partial(_dock, "intervals"),
    "chains": partial(_dock, "chains"),
    "status": lambda window: (window.statusBar(),),
}


class Dimming:
    """Dims the parts of the window that the user need not watch.

    The widgets of all places are looked up only when the first place is watched, because the lookup
    builds panels.
    """

    def __init__(self, window: HostWindow) -> None:
        self._window = window
        self._places: dict[str, _Widgets] = {}
        self._veils: dict[QWidget, Veil] = {}

    def _find(self) -> None:
        """Find the widgets of all places, and create a translucent overlay to dim each of them."""
        self._places = {name: find(self._window) for name, find in PLACES.items()}
        self._veils = {
            widget: Veil(widget, self._window.colours)
            for widgets in self._places.values()
            for widget in widgets
        }

    def watch(self, names: Collection[str]) -> None:
        """Dim all places except the given ones, or none if no place is given.

        Places that contain one of the given places are not dimmed either.
        """
        if names and not self._places:
            self._find()
        watched = [widget for name in names for widget in self._places[name]]
        # In Qt, a widget is its own ancestor
        unwatched = [
            widget
            for widget in self._veils
            if watched and not any(widget.isAncestorOf(one) for one in watched)
        ]
        for widget, veil in self._veils.items():
            around = [other for other in unwatched if other.isAncestorOf(widget)]
            veil.cover(around == [widget])  # not inside another dimmed place
