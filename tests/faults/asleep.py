"""Children that note their number in a file and sleep for long: `python -m tests.faults.asleep`."""

import os
import sys
import time
from multiprocessing import Pipe
from pathlib import Path
from threading import Thread

from inspector.folder import survey_worker


def asleep(note):
    Path(note).write_text(str(os.getpid()))
    time.sleep(600)


def work_asleep(note):
    """The window's worker with a clip on which it sleeps."""
    ours, theirs = Pipe()
    survey_worker.survey_clip = lambda path, *_: asleep(path)
    Thread(target=survey_worker.survey_clips_from_pipe, args=(theirs,)).start()
    ours.send((Path(note), None))
    time.sleep(600)


if __name__ == "__main__":
    asleep(sys.argv[1])
