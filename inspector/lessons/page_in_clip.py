"""Check that a lesson page fits its clip: its chain, its frame and its task."""

from __future__ import annotations

from inspector.language import tr
from inspector.lessons.lesson_conditions import hyphenated_kind_name
from inspector.lessons.lesson_file import LessonFile, LessonPage
from inspector.session.opening import Analysed
from twistcore.detection import Kind
from twistcore.errors import FormatError
from twistcore.files.document_values import shorten_foreign_message
from twistcore.skeleton.chain import Chain

_OF_CHAINS = ("swing", "counter")  # conditions that are only defined for chains
_OF_THE_CHAIN = ("tau", "listed")  # conditions for the page's chain


def lesson_page_chain(lesson: LessonFile, page: LessonPage, data: Analysed) -> Chain | None:
    """Return the chain or limb of a page, or None if the page does not name one.

    `data` is the clip of the page. Raises FormatError if the clip lacks the chain, the frame, or
    something that the task requires, such as enough frames, an interval of a certain kind, or a
    chain instead of a limb.
    """
    place, last = page.place, data.motion.frames - 1

    def refused(key: str, expected: str, found: object) -> FormatError:
        fields = {"file": lesson.path, "line": page.line(key), "expected": expected}
        text = tr(
            "{file}, line {line}: expected {expected}, found '{found}'",
            **fields,
            found=shorten_foreign_message(found),
        )
        return FormatError(text)

    if place.frame > last:
        expected = tr("a frame of {clip} from 0 to {last}", clip=place.clip.name, last=last)
        raise refused("frame", expected, place.frame)
    far = max(place.frame, last - place.frame)
    far, kinds = max(place.frame, last - place.frame), _kinds(data)
    for condition in page.done:
        if condition.name == "moved" and condition.amount > far:
            expected = tr(
                "at most {most} frames after 'moved', because {clip} has no frames farther away",
                most=far,
                clip=place.clip.name,
            )
            raise refused("done", expected, f"moved {condition.amount:g}")
        if condition.name == "accepted" and not kinds.intersection(condition.words or kinds):
            expected = tr(
                "a kind of interval in {clip} after 'accepted': {kinds}",
                clip=place.clip.name,
                kinds=", ".join(sorted(kinds)) or tr("nothing"),
            )
            raise refused("done", expected, " ".join(("accepted", *condition.words)))
        if condition.name in _OF_CHAINS and data.limb(place.chain) is not None:
            expected = tr(
                "no {name!r} on a page for a limb, because {name!r} is measured only for chains",
                name=condition.name,
            )
            raise refused("done", expected, condition.name)
        if condition.name in _OF_THE_CHAIN and not place.chain:
            expected = tr("a page with a 'chain' for the condition {name!r}", name=condition.name)
            raise refused("done", expected, condition.name)
    if not place.chain:
        return None
    for chain in data.chains_and_limbs:
        if chain.name == place.chain:
            return chain
    known = ", ".join(c.name for c in data.chains_and_limbs) or tr("the clip has no chains")
    expected = tr("one of the chains of {clip} ({known})", clip=place.clip.name, known=known)
    raise refused("chain", expected, place.chain)


def _kinds(data: Analysed) -> set[str]:
    """Return the names of the kinds of intervals that a clip contains or that a user can insert."""
    kinds = {judged.interval.kind for judged in data.review.state.intervals}
    limbs = len(data.chains_and_limbs) - len(data.chains)
    kinds |= {Kind.COUNTER_TWIST} if data.chains else set()
    kinds |= {Kind.LIMB_FLIP} if limbs else set()
    return set(map(hyphenated_kind_name, kinds))
