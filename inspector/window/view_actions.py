"""What the actions of the view do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMainWindow

from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.timeline.timeline import Timeline
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.window.presentation import Presentation

# Actions that mean nothing where there is no OpenGL and the plots stand alone.
OF_THE_FIGURE = (
    "cycle_show", "focus_chain", "follow_root", "skin", "side_by_side", "trails",
    "colour_by_offset", "bone_names", "view_iso", "view_front", "view_side", "view_back",
    "view_top",
)  # fmt: skip


class ViewActions(QMainWindow):
    """Looks of the 3D view, the camera that goes along with a review, plots and window.

    Stands before the classes whose verdicts and steps it lets the camera follow.
    """

    document: Document
    settings: Settings
    viewport: Viewport
    timeline: Timeline
    presenting: Presentation

    def skin(self, on: bool) -> None:
        """Striped skin on the limbs, or wedges for bones."""
        self.viewport.set_style(Style.SKIN if on else Style.WEDGES)

    def side_by_side(self, on: bool) -> None:
        """Before and after beside each other."""
        self.viewport.set_side_by_side(on)

    def trails(self, on: bool) -> None:
        """The ways of hands and feet."""
        self.viewport.set_trails(on)

    def colour_by_offset(self, on: bool) -> None:
        """Colour bones by |offset| at the frame."""
        self.viewport.set_colour_by_offset(on)

    def bone_names(self, on: bool) -> None:
        """Name the bone under the mouse."""
        self.viewport.pointing.names = on

    def focus_chain(self) -> None:
        """Turn the camera to the selected chain."""
        self.viewport.focus_chain(self.settings.turn_ms)

    def follow_root(self, on: bool) -> None:
        """Let the camera go along with the root."""
        self.viewport.set_follow(on)

    def view_iso(self) -> None:
        """Three-quarter view."""
        self.viewport.set_view("iso")

    def view_front(self) -> None:
        """From the front."""
        self.viewport.set_view("front")

    def view_side(self) -> None:
        """From the side."""
        self.viewport.set_view("side")

    def view_back(self) -> None:
        """From behind."""
        self.viewport.set_view("back")

    def view_top(self) -> None:
        """From above."""
        self.viewport.set_view("top")

    # Going to another interval, the camera turns to where its limb's roll shows best.

    def next_interval(self) -> None:
        """Go to the next interval."""
        super().next_interval()
        self._look()

    def previous_interval(self) -> None:
        """Go to the previous interval."""
        super().previous_interval()
        self._look()

    def next_faint(self) -> None:
        """Go to the next faint candidate."""
        super().next_faint()
        self.viewport.focus_chain(self.settings.turn_ms)

    def accept(self) -> None:
        """Accept, and go to the next undecided."""
        super().accept()
        self._look()

    def reject(self) -> None:
        """Reject, and go to the next undecided."""
        super().reject()
        self._look()

    def _look(self) -> None:
        if self.document.interval is not None:
            self.viewport.focus_chain(self.settings.turn_ms)

    # -- plots and window ---------------------------------------------------------------------

    def zoom_to_interval(self) -> None:
        """Plots: the selected interval."""
        self.timeline.visible.zoom_to_interval()

    def show_all(self) -> None:
        """Plots: the whole clip."""
        self.timeline.visible.show_all()

    def both_detectors(self, on: bool) -> None:
        """The other detector's plot, or not."""
        self.timeline.toggles["other"].setChecked(on)

    def presentation(self, on: bool) -> None:
        """Large type, figure and curves; or the window as it was."""
        self.presenting.enter() if on else self.presenting.leave()

    def full_screen(self, on: bool) -> None:
        """Full screen or not."""
        full, now = Qt.WindowState.WindowFullScreen, self.windowState()
        self.setWindowState(now | full if on else now & ~full)  # maximised before: so afterwards
