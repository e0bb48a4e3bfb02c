"""The window's layout: the initial layout, or the layout of the last run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QByteArray, QEvent, QObject, QPoint, QRect, Qt, QTimer
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QWidget

from inspector.window.low_window import Compact, LowWindow, is_seen


@dataclass(frozen=True)
class _Size:
    """The initial size of a panel: a share of the window's size, within limits.

    Attributes
    ----------
    share
        The usual share of the window's width or height.
    least, most
        The limits in pixels. In a small window, `largest` takes precedence over `least`.
    largest
        The largest share of the window's width or height.
    """

    share: float
    least: int
    most: int
    largest: float

    def of(self, whole: int) -> int:
        """Return the size in pixels for a window of this width or height."""
        return round(min(max(self.share * whole, self.least), self.most, self.largest * whole))


# The right column is as wide as the card needs, and scrolls the list of chains. The curves are as
# high as two rows of plots. The figure gets the rest.
_COLUMN = _Size(share=0.31, least=410, most=540, largest=0.4)
_CHAINS = _Size(share=0.29, least=0, most=340, largest=0.29)
_FEW_CHAINS = _Size(share=0.125, least=90, most=140, largest=0.29)  # below a tab that is tall
_CURVES = _Size(share=0.3, least=236, most=330, largest=0.34)
_CLIPS = _Size(share=0.23, least=0, most=340, largest=0.25)  # to the left of the figure
_LOW_CURVES = 0.27  # share of a low window's height
# With a large font, the lines of text above the curves take some of the curves' height.
# Pixels of a line; number of lines, such as menus, titles and tabs
_USUAL_LINE, _LINES_ABOVE = 14, 14
_SIZE = (1440, 900)  # initial size of the window, in pixels, if the screen is large enough
_FRAME = (12, 40)  # pixels for the window's borders and title bar
_SIZED = (  # docks whose size is set, with the direction of the size
    ("intervals", Qt.Orientation.Horizontal),
    ("chains", Qt.Orientation.Vertical),
    ("curves", Qt.Orientation.Vertical),
)
_STATE_VERSION = 3
_SEPARATOR = 3  # pixels between two docks, as in the style sheet
_LEEWAY = 3  # pixels by which a layout may be rounded
# Limits of restored panels: the smallest size in pixels, and the largest share of the window's
# size. The size is the width of a panel next to the figure, or the height of a panel above or
# below.
_Area = Qt.DockWidgetArea
_USABLE = {
    _Area.LeftDockWidgetArea: (120, 0.35),
    _Area.RightDockWidgetArea: (240, 0.5),
    _Area.BottomDockWidgetArea: (110, 0.6),
    _Area.TopDockWidgetArea: (110, 0.6),
}
_SIDES = _Area.LeftDockWidgetArea, _Area.RightDockWidgetArea


def move_clear_of_rectangle(panel: QRect, taken: QRect, room: QRect) -> QRect:
    """Return the rectangle `panel`, moved so that it does not cover the rectangle `taken`.

    The panel is moved up, down, left or right, by the shortest distance that keeps it inside
    `room`. If no direction is possible, the panel is returned unchanged.
    """
    if not panel.intersects(taken):
        return panel
    places = [QRect(panel) for _ in range(4)]
    below, above, right, left = places
    below.moveTop(taken.bottom() + 1)
    above.moveBottom(taken.top() - 1)
    right.moveLeft(taken.right() + 1)
    left.moveRight(taken.left() - 1)
    fitting = [place for place in places if room.contains(place)]

    def way(place: QRect) -> int:
        return (place.topLeft() - panel.topLeft()).manhattanLength()

    return min(fitting, key=way, default=panel)


class UsualLayout(QObject):
    """Arranges the docks, and reserves at least a third of the window's width for the 3D view."""

    def __init__(
        self,
        window: QMainWindow,
        docks: Mapping[str, QDockWidget],
        controls: QWidget,
        compact: Sequence[Compact] = (),
        tall: Sequence[str] = (),
    ) -> None:
        """Prepare the layout.

        Parameters
        ----------
        docks
            The docks in their initial positions, keyed by object name.
        controls
            The controls below the figure. Floating panels are placed so that they do not cover
            them.
        compact
            The widgets that have a layout for low windows, see :class:`LowWindow`.
        tall
            The names of the docks that get some of the height of the list of chains while they are
            in front.
        """
        super().__init__(window)
        self._window, self._docks, self._controls = window, docks, controls
        self._tall = tuple(docks[name] for name in tall)
        self._double_clicked = False
        self._low = LowWindow(window, docks, compact)
        self._usual = window.saveState()
        self._by_hand = False  # True if the user has resized the panels
        self._pressed: tuple[int, ...] = ()  # sizes of the panels when the mouse was pressed
        self._restored = False  # True if a layout was restored but has not been shown yet
        self._floating: list[QDockWidget] = []
        self._column_laid = QTimer(self, singleShot=True, interval=0)
        self._column_laid.timeout.connect(self._divide_column)
        docks["clips"].visibilityChanged.connect(self._fit_clips)
        window.installEventFilter(self)
        for dock in docks.values():
            dock.topLevelChanged.connect(partial(self._floated, dock))
            for changed in (dock.visibilityChanged, dock.dockLocationChanged):
                changed.connect(lambda _: self._column_laid.start())
            dock.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Detect a drag of the border between two panels, or a double-click on a title."""
        if watched is not self._window:
            self._double_clicked |= event.type() == QEvent.Type.MouseButtonDblClick
        elif event.type() == QEvent.Type.MouseButtonPress:
            self._pressed = self._dragged_sizes() if self._complete else ()
        elif event.type() == QEvent.Type.MouseButtonRelease and self._pressed:
            self._by_hand |= self._dragged_sizes() != self._pressed
        return super().eventFilter(watched, event)

    def restore(self, geometry: str, layout: str) -> None:
        """Restore the window's saved geometry and layout. If a value is '', use the initial one.

        Both parameters are the bytes saved by Qt, as hexadecimal strings.
        """
        window = self._window
        room = window.screen().availableSize()  # includes the borders of the window
        pairs = zip(_SIZE, room.toTuple(), _FRAME, strict=True)
        window.resize(*(min(size, most - frame) for size, most, frame in pairs))
        self.fit()
        if geometry:
            window.restoreGeometry(QByteArray.fromHex(geometry.encode()))
        if layout:
            self._restored = True
            window.restoreState(QByteArray.fromHex(layout.encode()), _STATE_VERSION)
        docks = self._docks.values()
        self._floating = [d for d in docks if d.isFloating() and not d.isHidden()]
        for dock in self._floating:
            dock.hide()

    def window_shown(self) -> None:
        """Show floating panels after the main window, so that it does not cover them."""
        if self._restored:
            self._make_usable()
            pairs = zip(self._sizes(), self._fitting(), strict=True)
            self._by_hand = any(abs(now - fitting) > _LEEWAY for now, fitting in pairs)
            self._restored = False
        while self._floating:
            dock = self._floating.pop()
            QTimer.singleShot(0, dock.show)
            QTimer.singleShot(0, partial(self._clear_of_controls, dock))

    def _floated(self, dock: QDockWidget, floating: bool) -> None:
        # If the user is dragging the panel, its position is the user's choice.
        pressed = QApplication.mouseButtons() != Qt.MouseButton.NoButton
        if floating and (self._double_clicked or not pressed):
            QTimer.singleShot(0, dock, partial(self._clear_of_controls, dock))
        self._double_clicked = False

    def _clear_of_controls(self, dock: QDockWidget) -> None:
        """Move a floating panel so that it does not cover the controls below the figure."""
        if not dock.isFloating():
            return
        taken = QRect(self._controls.mapToGlobal(QPoint(0, 0)), self._controls.size())
        room = self._window.screen().availableGeometry()
        dock.move(move_clear_of_rectangle(dock.frameGeometry(), taken, room).topLeft())

    def _make_usable(self) -> None:
        """Limit the sizes of restored panels, which may have been saved on a different screen."""
        window = self._window
        for dock in self._docks.values():
            if dock.isFloating() or not is_seen(dock):
                continue
            area = window.dockWidgetArea(dock)
            least, share = _USABLE[area]
            across = area in _SIDES
            size, whole = (part.width() if across else part.height() for part in (dock, window))
            most = max(round(share * whole), least)
            way = Qt.Orientation.Horizontal if across else Qt.Orientation.Vertical
            if not least <= size <= most:
                window.resizeDocks([dock], [min(max(size, least), most)], way)

    def kept(self, geometry: str) -> tuple[str, str] | None:
        """Return the geometry and layout for `restore`, or None while the window is not visible.

        `geometry` is returned instead of the current geometry if the window is in full screen.
        """
        window = self._window
        if not window.isVisible() or window.isMinimized():
            return None
        now, layout = window.saveGeometry(), window.saveState(_STATE_VERSION)
        of_window = geometry if window.isFullScreen() else bytes(now.toHex().data()).decode()
        return of_window, bytes(layout.toHex().data()).decode()

    def fit(self) -> None:
        """Set the sizes of the panels to fit the current size of the window."""
        self._low.follow()
        window, docks = self._window, self._docks
        across, upright = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        column, chains, curves = self._fitting()
        window.resizeDocks([docks["intervals"]], [column], across)
        window.resizeDocks([docks["curves"]], [curves], upright)
        self._fit_clips(not docks["clips"].isHidden())
        self._divide_column(chains)
        self._column_laid.start()  # again, with the column's height in the new layout

    def _fit_clips(self, shown: bool) -> None:
        """Set the width of the list of clips if it is visible.

        If the user has resized the panels, the width stays the same.
        """
        if shown and not self._by_hand and not self._restored:
            size = _CLIPS.of(self._window.width())
            self._window.resizeDocks([self._docks["clips"]], [size], Qt.Orientation.Horizontal)

    def _divide_column(self, chains: int | None = None) -> None:
        """Set the height of the list of chains. The panel above it gets the rest."""
        parts = [self._in_front("intervals"), self._docks["chains"]]
        areas = {self._window.dockWidgetArea(part) for part in parts}
        together = len(areas) == 1 and not any(part.isFloating() for part in parts)
        if self._by_hand or self._restored or not self._complete or not together:
            return
        column, fitting, _ = self._fitting()
        chains = fitting if chains is None else chains
        if not self._has_left_panels():  # such a panel may have taken some of the column's width
            self._window.resizeDocks(parts[:1], [column], Qt.Orientation.Horizontal)
        # If one height were missing, Qt would divide the rest between both panels. The status bar,
        # unlike the chains, already has its final position while Qt moves the docks.
        bottom = self._window.statusBar().geometry().top() - _SEPARATOR
        rest = bottom - parts[0].geometry().top() - chains
        self._window.resizeDocks(parts, [max(rest, 0), chains], Qt.Orientation.Vertical)

    def _has_left_panels(self) -> bool:
        """Return True if a panel is visible to the left of the figure."""
        area, left = self._window.dockWidgetArea, _Area.LeftDockWidgetArea
        docks = (dock for dock in self._docks.values() if not dock.isFloating())
        return any(is_seen(dock) and area(dock) == left for dock in docks)

    def follow(self) -> None:
        """Adapt the panels to a new size of the window, unless the user has resized them."""
        self._low.follow()
        if self._complete and not self._by_hand and not self._restored:
            self.fit()

    def reset(self) -> None:
        """Reset every panel to its initial position, visibility and size."""
        self._window.restoreState(self._usual)
        self._by_hand = False
        self._docks["intervals"].raise_()
        self.fit()

    def _fitting(self) -> tuple[int, ...]:
        """Return the default panel sizes, in pixels, for the current size of the window.

        The order is the same as in `_sizes`.
        """
        wide, high = self._window.width(), self._window.height()
        least = round(_LOW_CURVES * high)
        curves = least if self._low.low else _CURVES.of(high)
        higher = max(self._window.fontMetrics().height() - _USUAL_LINE, 0)
        curves = max(curves - _LINES_ABOVE * higher, min(curves, least))
        chains = _FEW_CHAINS if self._in_front("intervals") in self._tall else _CHAINS
        return _COLUMN.of(wide), chains.of(high), curves

    @property
    def _complete(self) -> bool:
        """Return True if all panels whose size is set are visible. Presentations hide some."""
        return not any(self._docks[name].isHidden() for name, _ in _SIZED)

    def _dragged_sizes(self) -> tuple[int, ...]:
        """Return the sizes, in pixels, that the user can change by dragging a border."""
        return *self._sizes(), self._docks["clips"].width()

    def _sizes(self) -> tuple[int, ...]:
        """Return the width of the right column and the heights of the chains and curves panels."""
        across = Qt.Orientation.Horizontal
        docks = ((self._in_front(name), way) for name, way in _SIZED)
        return tuple(dock.width() if way == across else dock.height() for dock, way in docks)

    def _in_front(self, name: str) -> QDockWidget:
        """Return the dock that is visible in the place of a dock: itself, or the tab before it.

        Qt does not update the position and size of a dock behind a different tab.
        """
        dock = self._docks[name]
        tabs = (dock, *self._window.tabifiedDockWidgets(dock))
        return next((tab for tab in tabs if is_seen(tab) and not tab.isFloating()), dock)
