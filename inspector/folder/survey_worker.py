"""A process that surveys one clip after the other, so that a bad one takes only it down."""

from __future__ import annotations

import sys
from multiprocessing.connection import Connection
from pathlib import Path

from inspector.session.rig_profiles import kept_rig
from twistcore.batch import survey
from twistcore.errors import TwistError

_SPARE = 1_500_000_000  # bytes for Python and its libraries
_OF_FILE = 12  # times the file's size for reading and analysing it


def work(pipe: Connection) -> None:
    """Answer every (path, profile) with a ClipSurvey or a sentence, until the pipe closes."""
    while True:
        try:
            path, profile = pipe.recv()
        except EOFError:
            return
        try:
            _limit_memory(path)
            pipe.send(survey(path, profile, lambda motion: kept_rig(motion)[0]))
        except TwistError as error:
            pipe.send(str(error))
        except MemoryError:
            pipe.send(f"{path.name}: needs more memory than a clip of its size should")
        except Exception as error:  # a defect of ours must not stop the other clips
            pipe.send(f"{path.name}: {type(error).__name__}: {error}")


def _limit_memory(path: Path) -> None:
    if sys.platform != "linux":
        return
    import resource

    try:
        limit = _SPARE + _OF_FILE * path.stat().st_size + _virtual_memory()
    except OSError:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _virtual_memory() -> int:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    return pages * 4096
