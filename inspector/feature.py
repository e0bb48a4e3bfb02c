"""Features of the window, each with its own menu rows, panels, settings and connections.

Each feature is a :class:`Feature` object in the file `feature.py` of its folder. The window is
built from the list of all features in `inspector/window/features.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, TypeVar, cast

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

if TYPE_CHECKING:
    from PySide6.QtGui import QAction

    from inspector.panels.chains_panel import ChainsPanel
    from inspector.panels.detail_card import DetailCard
    from inspector.panels.intervals_panel import IntervalsPanel
    from inspector.panels.transport import Transport
    from inspector.session.document import Document
    from inspector.session.exporter import Exporter
    from inspector.session.player import Player
    from inspector.session.settings import Settings
    from inspector.timeline.timeline import Timeline
    from inspector.viewport.viewport import Viewport
    from inspector.widgets.message_bar import MessageBar
    from inspector.widgets.theme import Colours

T = TypeVar("T")
Built = TypeVar("Built", bound="FeatureParts")
Needs = Literal["", "clip", "figure"]
Area = Qt.DockWidgetArea


class HostWindow(QMainWindow):
    """The main window, with the attributes that features may use.

    Attributes
    ----------
    docks
        The docks, keyed by name.
    actions_by_id
        The actions, keyed by id.
    built
        The objects that the features have built, keyed by the name of the feature.
    """

    document: Document
    player: Player
    exporter: Exporter
    settings: Settings
    colours: Colours
    bar: MessageBar
    viewport: Viewport
    timeline: Timeline
    transport: Transport
    chains: ChainsPanel
    intervals: IntervalsPanel
    detail: DetailCard
    actions_by_id: Mapping[str, QAction]
    docks: dict[str, QDockWidget]
    built: dict[str, FeatureParts]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Return a public attribute or property of a feature's :class:`FeatureParts`."""
            for part in vars(self).get("built", {}).values():
                own = isinstance(getattr(type(part), name, None), property)
                if not name.startswith("_") and (own or name in vars(part)):
                    return getattr(part, name)
            raise AttributeError(f"the window has no attribute {name!r}", name=name, obj=self)

    def part(self, feature: Feature[Built]) -> Built:
        """Return the :class:`FeatureParts` object that a feature has built for this window."""
        return cast("Built", self.built[feature.name])

    def open_path(self, path: Path) -> None:
        """Open a clip, a session or a folder."""
        raise NotImplementedError

    def save_quietly(self) -> bool:
        """Save the review, showing only error messages. Return True if the session is on disk."""
        raise NotImplementedError


class FeatureParts:
    """The objects that a feature builds for a window, such as its panel and its actions.

    Public attributes and properties of a subclass become attributes of the window.
    """

    def connect(self, window: HostWindow) -> None:
        """Create the objects that need docks, and connect this feature with others."""

    def take(self, path: Path) -> bool:
        """Open a dropped file. Returns False if the feature cannot open this kind of file."""
        return False

    def close(self) -> None:
        """Stop all work, because the window is being closed."""


@dataclass(frozen=True)
class Tool:
    """The toolbar button of an action.

    Attributes
    ----------
    word
        The label of the button.
    place
        The position from the left. There is a separator between positions whose tens digits differ,
        such as 19 and 20.
    spared
        A number that determines when the label is hidden in a window that becomes narrower: labels
        with 1 are hidden first, then those with 2, then those with 0.
    """

    word: str
    place: int
    spared: Literal[0, 1, 2] = 0


@dataclass(frozen=True)
class ActionRow(Generic[T]):
    """A menu entry and its action. `T` is the type of the object on which the action acts.

    Attributes
    ----------
    id
        The id of the action.
    text
        The text of the row.
    keys
        The default keyboard shortcuts.
    tip
        The help text.
    checked
        True if the row is checked at the start.
    group
        The name of a group in which exactly one row is checked, or ''.
    needs
        'clip' if the row needs an open clip, 'figure' if it also needs the 3D view, or ''.
    in_list
        True if the row is also in the context menu of the panel's list.
    ready
        False if the row is disabled until its feature enables it.
    tool
        The button in the toolbar, or None.
    verdict
        True if the row decides on an interval. Its key does not repeat, and has no effect until the
        interval is drawn.
    """

    id: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checked: bool = field(default=False, kw_only=True)
    group: str = field(default="", kw_only=True)
    needs: Needs = field(default="", kw_only=True)
    in_list: bool = field(default=False, kw_only=True)
    ready: bool = field(default=True, kw_only=True)
    tool: Tool | None = field(default=None, kw_only=True)
    verdict: bool = field(default=False, kw_only=True)
    checkable: ClassVar[bool] = False

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action of this row to the object `on`, on which it acts."""


@dataclass(frozen=True)
class ActionSpec(ActionRow[T]):
    """A row that runs a command. In a group, the command runs when the row is checked."""

    do: Callable[[T], object] = field(kw_only=True)

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action of this row so that it runs the command with the object `on`."""
        if self.group:
            action.toggled.connect(lambda checked: self.do(on) if checked else None)
        else:
            action.triggered.connect(lambda *_: self.do(on))


@dataclass(frozen=True)
class Switch(ActionRow[T]):
    """A row that switches a setting on or off."""

    turn: Callable[[T, bool], object] = field(kw_only=True)
    checkable: ClassVar[bool] = True

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action of this row so that it switches the setting of the object `on`."""
        action.toggled.connect(lambda checked: self.turn(on, checked))


@dataclass(frozen=True)
class MenuRows(Generic[T]):
    """Rows that a feature adds to one menu. In `rows`, None is a separator.

    `after` is the id of the row after which the rows are inserted, or '' for the end of the menu.
    """

    menu: str
    rows: Sequence[ActionRow[T] | None]
    after: str = ""


@dataclass(frozen=True)
class DockPanel(Generic[T]):
    """The description of a dock of the window.

    Attributes
    ----------
    name
        The name under which the position of the dock is stored.
    title
        The title of the dock.
    area
        The initial area of the dock.
    content
        A function that returns the widget to show in the dock.
    shown
        True if the dock is visible initially.
    empty_at_start
        True if the dock is hidden whenever the program starts, because it is empty until something
        is opened.
    tab
        True if the dock is a tab next to the interval table.
    tall
        True if the list of chains is low while this tab is in front, because the tab needs the
        height.
    before
        The name of the panel before which the dock is placed, or '' for the end.
    """

    name: str
    title: str
    area: Area
    content: Callable[[T], QWidget]
    shown: bool = field(default=True, kw_only=True)
    empty_at_start: bool = field(default=False, kw_only=True)
    tab: bool = field(default=False, kw_only=True)
    tall: bool = field(default=False, kw_only=True)
    before: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Tick:
    """A check box in the preferences for a setting that is on or off.

    Attributes
    ----------
    name
        The name of a FeatureSetting.
    text
        The text next to the check box.
    tip
        The tool tip.
    """

    name: str
    text: str
    tip: str = ""


@dataclass(frozen=True)
class Feature(Generic[Built]):
    """A feature of the window.

    Attributes
    ----------
    name
        The name of the feature.
    build
        A function that creates the objects of the feature. It is called before any dock exists.
    rows
        The rows that the feature adds to menus.
    panels
        The docks of the feature.
    settings
        The check boxes of the feature in the preferences.
    """

    name: str
    build: Callable[[HostWindow], Built]
    rows: tuple[MenuRows[Built], ...] = ()
    panels: tuple[DockPanel[Built], ...] = ()
    settings: tuple[Tick, ...] = ()


AnyFeature = Feature[Any]
