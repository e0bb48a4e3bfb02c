"""Survey clips in a separate process, so that a faulty clip cannot crash the window."""

from __future__ import annotations

from contextlib import suppress
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from inspector.folder.queued_clip import TOO_LARGE
from inspector.session.rig_profiles import load_rig_profile
from twistcore.batch import survey_clip
from twistcore.errors import TwistError
from twistcore.work.memory import limited_memory
from twistcore.work.with_parent import end_with_parent

if TYPE_CHECKING:
    from twistcore.batch import ClipSurvey
    from twistcore.tuning import Profile


def survey_clips_from_pipe(pipe: Connection) -> None:
    """For each (path, profile) from the pipe, send back a ClipSurvey or an error message.

    The process ends when the pipe or the window closes, even during a survey.
    """
    if (parent := parent_process()) is not None and parent.pid:
        end_with_parent(parent.pid)
    while True:
        try:
            path, profile = pipe.recv()
        except EOFError:
            return
        answer = _answer(path, profile)
        try:
            pipe.send(answer)
        except BrokenPipeError:
            return  # the window was closed


def _answer(path: Path, profile: Profile | None) -> ClipSurvey | str:
    try:
        with limited_memory(_size(path)):
            return survey_clip(path, profile, lambda motion: load_rig_profile(motion)[0])
    except TwistError as error:
        return str(error)
    except MemoryError:
        return f"{path.name}: {TOO_LARGE}"
    except Exception as error:  # a bug in this program must not stop the other clips
        return f"{path.name}: {type(error).__name__}: {error}"


def _size(path: Path) -> int:
    with suppress(OSError):  # the error is reported when the file is read
        return path.stat().st_size
    return 0
