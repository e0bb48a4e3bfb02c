"""Work in threads whose owner is deleted while they are at it: for two seconds, then it says so."""

import sys
import time

from PySide6.QtCore import QCoreApplication, QEvent, QObject

from inspector.widgets.background import Task

app = QCoreApplication([])
sys.setswitchinterval(1e-5)
end = time.monotonic() + 2.0
while time.monotonic() < end:
    owners = [QObject() for _ in range(20)]
    for owner in owners:
        for _ in range(5):
            Task(lambda tell: tell(0.5), owner).start()
    for owner in owners[::2]:
        owner.deleteLater()
    del owners, owner
    for _ in range(30):
        app.processEvents()
    app.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
print("still there")
