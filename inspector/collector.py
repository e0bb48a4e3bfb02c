"""Run Python's garbage collector only between two events of the GUI thread.

By default, the collector may run in any thread that creates an object. Garbage may contain Qt
objects. If they are deleted in another thread, or while PySide is changing its table of
connections, the program crashes or hangs.
"""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

_PERIOD_MS = 1000


def collect_between_events(owner: QObject) -> None:
    """Replace Python's automatic collection with a timer that runs as long as `owner` exists."""
    gc.disable()
    timer = QTimer(owner)
    timer.timeout.connect(collect_due_garbage)
    timer.start(_PERIOD_MS)


def collect_due_garbage() -> None:
    """Collect the oldest generation that is due according to Python's thresholds."""
    counts = zip(gc.get_count(), gc.get_threshold(), strict=True)
    due = [generation for generation, (count, limit) in enumerate(counts) if count > limit > 0]
    if due:
        gc.collect(due[-1])


def exclude_from_collection() -> None:
    """Exclude all existing objects from future collections.

    These objects exist until the program ends, and searching them would block the window for 0.15 s
    each time.
    """
    gc.freeze()
