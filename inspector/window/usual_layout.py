"""How the window is laid out: at first, as a person left it, and again as at first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QByteArray, QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow

from inspector.window.low_window import Compact, LowWindow

# Chains, intervals, curves: pixels where there is room, else shares of the window's size.
_MOST = 350, 545, 330
_SHARES = 0.25, 0.38, 0.35
_LOW_SHARES = 0.25, 0.38, 0.27  # in a low window
# Where lines are higher than usual, as many above the curves take of their height.
_USUAL_LINE, _LINES_ABOVE = 14, 14  # pixels; menus, titles, tabs, sliders, a sentence
_SIZE = (1440, 900)  # of the first window, where the screen has room
_FRAME = (12, 40)  # pixels: more than borders and a title bar take
_STATE_VERSION = 2
_LEEWAY = 3  # pixels that a layout may round by


class UsualLayout(QObject):
    """Docks in their places, the 3D view with a third of the window's width or more."""

    def __init__(
        self,
        window: QMainWindow,
        docks: Mapping[str, QDockWidget],
        compact: Sequence[Compact] = (),
    ) -> None:
        """`docks`: by their object names, where they belong; `compact`: see LowWindow."""
        super().__init__(window)
        self._window, self._docks = window, docks
        self._low = LowWindow(window, docks, compact)
        self._usual = window.saveState()
        self._by_hand = False  # a person gave the panels their sizes
        self._pressed: tuple[int, ...] = ()  # their sizes when the mouse was pressed
        self._restored = False  # from another run, not seen yet
        self._floating: list[QDockWidget] = []
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Between two panels the mouse is the window's own."""
        if event.type() == QEvent.Type.MouseButtonPress:
            self._pressed = self._sizes() if self._complete else ()
        elif event.type() == QEvent.Type.MouseButtonRelease and self._pressed:
            self._by_hand |= self._sizes() != self._pressed
        return super().eventFilter(watched, event)

    def restore(self, geometry: str, layout: str) -> None:
        """As a person left it, Qt's bytes as hex; as at first where they are empty."""
        window = self._window
        room = window.screen().availableSize()  # of it the frame takes some
        pairs = zip(_SIZE, room.toTuple(), _FRAME, strict=True)
        window.resize(*(min(wanted, most - frame) for wanted, most, frame in pairs))
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
        """The window is there: panels that float come after it, or they would lie behind it."""
        if self._restored:
            pairs = zip(self._sizes(), self._fitting(), strict=True)
            self._by_hand = any(abs(now - fitting) > _LEEWAY for now, fitting in pairs)
            self._restored = False
        while self._floating:
            QTimer.singleShot(0, self._floating.pop().show)

    def kept(self, geometry: str) -> tuple[str, str] | None:
        """Geometry and layout now, as `restore` takes them; None while nobody sees the window.

        geometry: what it was before the whole screen was filled.
        """
        window = self._window
        if not window.isVisible() or window.isMinimized():
            return None
        now, layout = window.saveGeometry(), window.saveState(_STATE_VERSION)
        of_window = geometry if window.isFullScreen() else bytes(now.toHex().data()).decode()
        return of_window, bytes(layout.toHex().data()).decode()

    def fit(self) -> None:
        """The sizes that go with the size of the window."""
        window, docks = self._window, self._docks
        self._low.follow()
        left, right, curves = self._fitting()
        across, upright = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        window.resizeDocks([docks["chains"], docks["intervals"]], [left, right], across)
        window.resizeDocks([docks["curves"]], [curves], upright)

    def follow(self) -> None:
        """The window has another size: so have its panels, unless a person gave them theirs."""
        self._low.follow()
        if self._complete and not self._by_hand and not self._restored:
            self.fit()

    def reset(self) -> None:
        """Every panel in its place, shown or not, as in the first window."""
        self._window.restoreState(self._usual)
        self._by_hand = False
        self._docks["intervals"].raise_()
        self.fit()

    def _fitting(self) -> tuple[int, ...]:
        wide, high = self._window.width(), self._window.height()
        shares = _LOW_SHARES if self._low.low else _SHARES
        sizes = zip(_MOST, shares, (wide, wide, high), strict=True)
        left, right, curves = (min(most, round(share * all_)) for most, share, all_ in sizes)
        higher = max(self._window.fontMetrics().height() - _USUAL_LINE, 0)
        least = min(curves, round(_LOW_SHARES[2] * high))
        return left, right, max(curves - _LINES_ABOVE * higher, least)

    @property
    def _complete(self) -> bool:
        """Whether nobody took a panel away, as a presentation does."""
        return not any(self._docks[name].isHidden() for name in ("chains", "intervals", "curves"))

    def _sizes(self) -> tuple[int, ...]:
        docks = self._docks
        return docks["chains"].width(), docks["intervals"].width(), docks["curves"].height()
