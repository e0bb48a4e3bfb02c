"""Whether a page of a lesson has a place in its clip: its chain, its frame, what its task asks."""

from __future__ import annotations

from inspector.lessons.lesson_file import LessonFile, LessonPage
from inspector.session.opening import Analysed
from twistcore.chain import Chain
from twistcore.errors import FormatError


def chain_of(lesson: LessonFile, page: LessonPage, data: Analysed) -> Chain | None:
    """The chain or limb of a page, None where it has none; data: its clip.

    Raises FormatError where the clip has no such chain, or no such frame, or is too short for
    what the page's task asks.
    """
    place, last = page.place, data.motion.frames - 1

    def refused(key: str, expected: str, found: object) -> FormatError:
        where = f"{lesson.path}, line {page.line(key)}"
        return FormatError(f"{where}: expected {expected}, found '{found}'")

    if place.frame > last:
        raise refused("frame", f"a frame of {place.clip.name} up to {last}", place.frame)
    far = max(place.frame, last - place.frame)
    for condition in page.done:
        if condition.name == "moved" and condition.amount > far:
            expected = f"'moved' and up to {far} frames, as {place.clip.name} has no more"
            raise refused("done", expected, f"moved {condition.amount:g}")
    if not place.chain:
        return None
    for chain in data.chains_and_limbs:
        if chain.name == place.chain:
            return chain
    known = ", ".join(c.name for c in data.chains_and_limbs) or "none: it has no chains"
    raise refused("chain", f"a chain of {place.clip.name} ({known})", place.chain)
