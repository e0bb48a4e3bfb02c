"""What the actions of going about do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from PySide6.QtWidgets import QInputDialog, QMainWindow

from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.document import Document, Show
from inspector.session.player import Player
from inspector.session.settings import Settings


class GoActions(QMainWindow):
    """Intervals, frames, playing."""

    document: Document
    player: Player
    settings: Settings
    intervals: IntervalsPanel

    def next_interval(self) -> None:
        """Go to the next interval."""
        self.document.step_interval(+1, order=self.intervals.shown_ids())

    def previous_interval(self) -> None:
        """Go to the previous interval."""
        self.document.step_interval(-1, order=self.intervals.shown_ids())

    def toggle_play(self) -> None:
        """Play or pause."""
        self.player.toggle()

    def loop_interval(self, on: bool) -> None:
        """Play the selected interval ± 0.5 s over and over."""
        self.player.set_loop(on)

    def faster(self) -> None:
        """Play faster."""
        self.player.step_speed(+1)

    def slower(self) -> None:
        """Play slower."""
        self.player.step_speed(-1)

    def normal_speed(self) -> None:
        """Play in real time."""
        self.player.set_speed(1.0)

    def next_frame(self) -> None:
        """One frame on."""
        self.document.go_to(self.document.frame + 1)

    def previous_frame(self) -> None:
        """One frame back."""
        self.document.go_to(self.document.frame - 1)

    def ten_forward(self) -> None:
        """As many frames on as the preferences say."""
        self.document.go_to(self.document.frame + self.settings.step)

    def ten_back(self) -> None:
        """As many frames back as the preferences say."""
        self.document.go_to(self.document.frame - self.settings.step)

    def first_frame(self) -> None:
        """To the start."""
        self.document.go_to(0)

    def last_frame(self) -> None:
        """To the end."""
        self.document.go_to(self.document.frames - 1)

    def go_to_frame(self) -> None:
        """Ask for a frame."""
        if not self.document.frames:
            return
        first = self.document.first_frame
        last = max(self.document.frames - 1, 0) + first
        frame, chosen = QInputDialog.getInt(
            self,
            "Go to frame",
            f"Frame ({first} – {last})",
            self.document.frame + first,
            first,
            last,
        )
        if chosen:
            self.document.go_to(frame - first)

    def cycle_show(self) -> None:
        """Before, after, both, before …"""
        every = list(Show)
        self.document.set_show(every[(every.index(self.document.show) + 1) % len(every)])
