"""The context menu of the plots. None of its entries deletes anything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.tau_line import set_tau_degrees
from inspector.timeline.visible_range import VisibleRange
from twistcore.review import Decision, Judged


def context_menu(
    parent: QWidget,
    document: Document,
    visible: VisibleRange,
    frame: float,
    degrees: float,
    judged: Judged | None,
    plots: Sequence[tuple[str, Callable[[], None]]] = (),
) -> QMenu:
    """Return the context menu for a point in a plot.

    Parameters
    ----------
    degrees
        The value of τ, in degrees, at the height of the point, or 0 in plots without τ.
    judged
        The interval at the point, or None.
    plots
        Additional menu entries for the plot, as (text, function).
    """
    menu = QMenu(parent)
    at = max(0, min(document.frames - 1, round(frame)))

    def add(text: str, slot: Callable[[], object], *, enabled: bool = True) -> QAction:
        action = QAction(text, menu)
        menu.addAction(action)
        action.triggered.connect(lambda *_: slot())
        action.setEnabled(enabled)
        return action

    there = judged or document.interval
    add(tr("Zoom to interval"), lambda: visible.zoom_to_interval(there), enabled=there is not None)
    add(tr("Show all"), visible.show_all)
    for text, slot in plots:
        add(text, slot)
    menu.addSeparator()
    add(tr("New interval at frame {frame}", frame=at), lambda: document.insert_interval(at))
    if degrees > 0.0:
        add(tr("Set τ to {tau:.1f}°", tau=degrees), lambda: set_tau_degrees(document, degrees))
    menu.addSeparator()
    for text, decision in (
        (tr("Accept"), Decision.ACCEPTED),
        (tr("Reject"), Decision.REJECTED),
        (tr("Reset to undecided"), Decision.UNDECIDED),
    ):
        able = there is not None and there.decision != decision
        add(text, partial(document.decide, decision, [there.id] if there else []), enabled=able)
    return menu
