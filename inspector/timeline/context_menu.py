"""The menu under the right button. It never deletes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from twistcore.review import Decision, Judged

if TYPE_CHECKING:
    from inspector.timeline.timeline import Timeline


def context_menu(
    timeline: Timeline, key: str, frame: float, degrees: float, judged: Judged | None
) -> QMenu:
    """What can be done at a place of a plot; `judged`: the interval there, else the selected."""
    menu = QMenu(timeline)
    document = timeline.document
    at = max(0, min(document.frames - 1, round(frame)))

    def add(text: str, slot: Callable[[], object], *, enabled: bool = True) -> QAction:
        action = QAction(text, menu)
        menu.addAction(action)
        action.triggered.connect(lambda *_: slot())
        action.setEnabled(enabled)
        return action

    there = judged or document.interval
    add(
        "Zoom to interval",
        lambda: timeline.zoom_to_interval(there),
        enabled=there is not None,
    )
    add("Show all", timeline.show_all)
    menu.addSeparator()
    add(f"New interval at frame {at}", lambda: timeline.insert_interval(at))
    if key == "strength" and degrees > 0.0:
        add(f"Set τ to {degrees:.1f}°", lambda: timeline.set_tau_degrees(degrees))
    menu.addSeparator()
    for text, decision in (
        ("Accept", Decision.ACCEPTED),
        ("Reject", Decision.REJECTED),
        ("Reset to undecided", Decision.UNDECIDED),
    ):
        add(
            text,
            lambda d=decision: document.decide(d, [there.id]) if there else None,
            enabled=there is not None and there.decision != decision,
        )
    return menu
