"""Features of the window: each has rows in menus, panels, settings and connections.

A feature is one object of :class:`Feature`, in the file `feature.py` of its folder;
`inspector/window/features.py` lists all of them, and the window is built from that list.
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
    """The window as seen by features; docks: by name; actions_by_id: by the rows' ids."""

    document: Document
    player: Player
    exporter: Exporter
    settings: Settings
    colours: Colours
    bar: MessageBar
    viewport: Viewport
    timeline: Timeline
    chains: ChainsPanel
    intervals: IntervalsPanel
    detail: DetailCard
    actions_by_id: Mapping[str, QAction]
    docks: dict[str, QDockWidget]
    built: dict[str, FeatureParts]

    def part(self, feature: Feature[Built]) -> Built:
        """Return the parts that a feature has built in this window."""
        return cast("Built", self.built[feature.name])

    def open_path(self, path: Path) -> None:
        """Open a clip, a session or a folder."""
        raise NotImplementedError

    def save_quietly(self) -> bool:
        """Save the review without a message; True if it is on disk."""
        raise NotImplementedError


class FeatureParts:
    """Parts that a feature builds; their public attributes become attributes of the window."""

    def connect(self, window: HostWindow) -> None:
        """Build parts that need the docks, and connect them with parts of other features."""

    def take(self, path: Path) -> bool:
        """Show a file that was dropped on the window; False if it is not for this feature."""
        return False

    def close(self) -> None:
        """Stop all work, because the window closes."""


@dataclass(frozen=True)
class Tool:
    """The button of a row in the toolbar: its word, and its place from the left.

    A line separates places of different tens. spared: in a narrow window its word disappears first
    (1), second (2), or last, with all others (0).
    """

    word: str
    place: int
    spared: Literal[0, 1, 2] = 0


@dataclass(frozen=True)
class ActionRow(Generic[T]):
    """A row of a menu; T: the object that its action works on.

    checked: True if it is checked at the start; group: name of a group in which one row is checked;
    needs: 'clip' if it needs an open clip, 'figure' if it also needs the 3D view; in_list: True if
    the context menu of the panel's list has it, too; tool: its button in the toolbar, if any;
    verdict: True if it decides, so that a held key does it once, and only about what was drawn.
    """

    id: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checked: bool = field(default=False, kw_only=True)
    group: str = field(default="", kw_only=True)
    needs: Needs = field(default="", kw_only=True)
    in_list: bool = field(default=False, kw_only=True)
    tool: Tool | None = field(default=None, kw_only=True)
    verdict: bool = field(default=False, kw_only=True)
    checkable: ClassVar[bool] = False

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action with what the row does."""


@dataclass(frozen=True)
class ActionSpec(ActionRow[T]):
    """A row with a command; a row of a group runs it when it becomes checked."""

    do: Callable[[T], object] = field(kw_only=True)

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action with the command."""
        if self.group:
            action.toggled.connect(lambda checked: self.do(on) if checked else None)
        else:
            action.triggered.connect(lambda *_: self.do(on))


@dataclass(frozen=True)
class Switch(ActionRow[T]):
    """A row that turns something on and off."""

    turn: Callable[[T, bool], object] = field(kw_only=True)
    checkable: ClassVar[bool] = True

    def connect(self, action: QAction, on: T) -> None:
        """Connect the action with the switch."""
        action.toggled.connect(lambda checked: self.turn(on, checked))


@dataclass(frozen=True)
class MenuRows(Generic[T]):
    """Rows of one menu; None stands for a separator.

    after: id of the row after which they are inserted, '' for the menu's end.
    """

    menu: str
    rows: Sequence[ActionRow[T] | None]
    after: str = ""


@dataclass(frozen=True)
class DockPanel(Generic[T]):
    """A dock with its name, under which its place is remembered, its title and its first place.

    content: returns the widget in the dock; tab: True for a tab next to the intervals; before: name
    of the panel that it precedes, '' for the end.
    """

    name: str
    title: str
    area: Area
    content: Callable[[T], QWidget]
    shown: bool = field(default=True, kw_only=True)
    tab: bool = field(default=False, kw_only=True)
    before: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Tick:
    """A check box in the preferences; name: its FeatureSetting."""

    name: str
    text: str
    tip: str = ""


@dataclass(frozen=True)
class Feature(Generic[Built]):
    """A feature of the window; build: creates its views, before any docks exist."""

    name: str
    build: Callable[[HostWindow], Built]
    rows: tuple[MenuRows[Built], ...] = ()
    panels: tuple[DockPanel[Built], ...] = ()
    settings: tuple[Tick, ...] = ()


AnyFeature = Feature[Any]
