"""What earlier runs left of a clip's review: journals, and whether the open review has it all."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from inspector.session_files import set_aside, written
from twistcore.bvh import Clip
from twistcore.chain import find_chains
from twistcore.errors import ClipMismatchError, FormatError, TwistError
from twistcore.review import Recovered, ReviewState, recover
from twistcore.review.session import check_belongs, session_document


@dataclass(frozen=True, eq=False)
class Leftover:
    """A journal that an earlier run left.

    same_clip: it belongs to the clip as it is, not to another version of it.
    """

    recovered: Recovered
    same_clip: bool

    @property
    def path(self) -> Path:
        """The journal."""
        return self.recovered.path

    @property
    def when(self) -> datetime:
        """Its last step, local time."""
        return datetime.fromtimestamp(written(self.path) / 1e9)


def read_leftover(path: Path, clip: Clip) -> tuple[Leftover | None, str]:
    """What a journal holds and a sentence for the person, '' if all is well.

    None for one that cannot be used: if it is damaged it is set aside.
    """
    try:
        recovered = recover(path)
    except FormatError as error:
        with suppress(OSError):
            if not path.stat().st_size:  # a crash before its first line was there
                path.unlink()
                return None, ""
        return None, set_aside(path, str(error))
    except TwistError as error:
        return None, str(error)
    told = ""
    if recovered.damaged:
        told = f"{path.name}: {recovered.damaged} entries are damaged; those before are kept."
    try:
        check_belongs(recovered.session, clip, find_chains(clip.motion))
    except ClipMismatchError:
        return Leftover(recovered, same_clip=False), told
    return Leftover(recovered, same_clip=True), told


def holds_more(leftover: Leftover, clip: Clip, state: ReviewState) -> bool:
    """Whether there is anything in it that a review of the clip has not."""
    left = leftover.recovered.review.state
    if leftover.same_clip:
        return _content(clip, left) != _content(clip, state)
    return any(judged.kept for judged in left.intervals)


def _content(clip: Clip, state: ReviewState) -> dict[str, Any]:
    return {k: v for k, v in session_document(clip, state).items() if k != "next_id"}
