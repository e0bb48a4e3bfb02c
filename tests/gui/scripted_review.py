"""A seeded review in the real window, to be killed: `scripted_review.py CLIP SEED`.

Behind every command it prints the hash of the session as it must survive.
"""

import hashlib
import random
import sys
from pathlib import Path

from PySide6.QtTest import QTest

from inspector.app import make_application
from inspector.export import ExportChoice
from inspector.main_window import MainWindow
from inspector.settings import Settings
from twistcore.review import session_bytes
from twistcore.review.model import resized

COMMANDS = [
    "accept",
    "accept",
    "reject",
    "reset",
    "undo",
    "redo",
    "edit",
    "tau",
    "save",
    "export",
]


def main() -> None:
    clip, rng = Path(sys.argv[1]), random.Random(int(sys.argv[2]))
    _app = make_application()
    window = MainWindow(Settings(), None)
    window.show()
    window.open_path(clip)
    document = window.document
    while document.data is None:
        QTest.qWait(5)

    def tell() -> None:
        document.keeper.flush()
        state = session_bytes(document.data.clip, document.review.state)
        print(hashlib.sha256(state).hexdigest(), flush=True)

    tell()
    while True:
        window.next_interval()
        what = rng.choice(COMMANDS)
        if what == "edit":
            if judged := document.interval:
                start, stop = judged.interval.start, judged.interval.stop + rng.randint(1, 3)
                stop = min(stop, document.frames)
                document.edit(judged.id, resized(judged.interval, start, stop))
        elif what == "tau":
            document.set_tau(rng.uniform(0.02, 0.3))
        elif what == "save":
            window.save_session()
        elif what == "export":
            window.export(ExportChoice(clip.with_name("out.bvh"), replace=True))
        else:
            getattr(window, what)()
        tell()
        QTest.qWait(1)


main()
