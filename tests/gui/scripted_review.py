"""A seeded review in the real window, to be killed: `scripted_review.py CLIP SEED COMMANDS`.

It restores what an earlier run left. Behind every command it prints the hash of the session as it
must survive; the same seed in the same folder makes the same states.
"""

import hashlib
import itertools
import random
import sys
from pathlib import Path

from inspector.app import make_application
from inspector.session.document import Document
from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.detection.interval_offsets import resized_interval
from twistcore.review import session_bytes
from twistcore.skeleton.rig import OwnChain

SPINE = OwnChain(("Spine", "Spine1", "Neck1"))
COMMANDS = [
    "accept",
    "accept",
    "reject",
    "reset",
    "undo",
    "redo",
    "edit",
    "drag",
    "tau",
    "save",
    "export",
    "turn_end",
    "chains",
]


def main() -> None:
    clip, rng, commands = Path(sys.argv[1]), random.Random(int(sys.argv[2])), int(sys.argv[3])
    clock = itertools.count()
    Document.now = staticmethod(lambda: f"2026-01-01T00:{next(clock):04d}")
    _app = make_application()
    window = MainWindow(Settings(), None)
    window.show()
    window.open_path(clip)
    document = window.document
    while document.data is None:
        wait(5)
    for button in window.bar.buttons():
        if button.text() == "Restore":
            button.click()

    def tell() -> None:
        while document.opener.busy:  # other chains are analysed first
            wait(2)
        document.keeper.journal.flush()
        state = session_bytes(document.data.clip, document.review.state)
        print(hashlib.sha256(state).hexdigest(), flush=True)

    tell()
    for _ in range(commands):
        window.actions_by_id["next_interval"].trigger()
        what = rng.choice(COMMANDS)
        if what in ("edit", "drag"):
            if judged := document.interval:
                drag = document.begin_drag() if what == "drag" else 0
                for more in range(1, 4 if drag else 2):
                    start, stop = judged.interval.start, judged.interval.stop + more
                    stop = min(stop, document.frames)
                    document.edit(judged.id, resized_interval(judged.interval, start, stop), drag)
        elif what == "tau":
            document.set_tau(rng.uniform(0.02, 0.3))
        elif what == "chains":
            rig = document.review.state.rig
            other = rig.without("Spine") if rig.add else rig.with_chain(document.data.motion, SPINE)
            document.change_chains(other, "Other chains")
        elif what == "save":
            window.files.save_session()
        elif what == "export":
            window.files.export(ExportChoice(clip.with_name("out.bvh"), replace=True))
        else:
            window.actions_by_id[what].trigger()
        tell()
        wait(1)
    window.exporter.finish()


main()
