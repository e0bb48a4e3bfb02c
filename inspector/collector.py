"""Python's garbage is collected between two events of the GUI thread, and at no other time.

Left to itself the collector runs in whatever thread makes the next object, in the middle of what
that is doing. Garbage may hold Qt's objects: they then die in a worker's thread, or while PySide
is at its own table of connections, and the program crashes or hangs.
"""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

_PERIOD_MS = 1000


def collect_between_events(owner: QObject) -> None:
    """Collect in Python's place from now on, as long as events are handled and `owner` lives."""
    gc.disable()
    timer = QTimer(owner)
    timer.timeout.connect(collect_due)
    timer.start(_PERIOD_MS)


def collect_due() -> None:
    """Collect the oldest generation that is due by Python's own thresholds."""
    counts = zip(gc.get_count(), gc.get_threshold(), strict=True)
    due = [generation for generation, (count, limit) in enumerate(counts) if count > limit > 0]
    if due:
        gc.collect(due[-1])


def keep_for_good() -> None:
    """Say that what is there now, the program itself, never becomes garbage.

    To look through all of it again and again would hold the window up, 0.15 s each time.
    """
    gc.freeze()
