"""Waiting while threads go on: `QTest.qWait` keeps Python to itself even while it sleeps."""

import time

from PySide6.QtCore import QCoreApplication, QEvent

_STEP_S = 0.002


def wait(ms: float) -> None:
    """Do what comes to the event loop for so many milliseconds, at least what has come by now."""
    end = time.monotonic() + 1e-3 * ms
    while True:
        QCoreApplication.processEvents()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        if (left := end - time.monotonic()) <= 0.0:
            return
        time.sleep(min(left, _STEP_S))
