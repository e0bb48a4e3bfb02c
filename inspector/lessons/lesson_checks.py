"""Every condition of a lesson's page: when it holds, and how the program does it itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_conditions import Condition
from inspector.session.open_clip import Show
from twistcore.review import Decision, Judged

_NEARLY = 0.05  # degrees: sliders have steps of a tenth
_TURNED, _STRAIGHT = np.radians(178.0), np.radians(2.0)  # near enough to a singularity
_NUDGED = np.radians(0.5)
_SHOWN = 15.0  # degrees further than what is asked, so that one sees it is enough
_TWIST = np.radians(75.0)


@dataclass(eq=False)
class Visit:
    """A page that is open: since when, and which singularities were nudged on it."""

    program: GuidedProgram
    frame: int  # at its begin
    met: set[str] = field(default_factory=set)


Check = tuple[Callable[[Visit, Condition], bool], Callable[[Visit, Condition], object]]


def holds(visit: Visit, condition: Condition) -> bool:
    """Whether what the condition asks for has been done."""
    return CHECKS[condition.name][0](visit, condition)


def do(visit: Visit, condition: Condition) -> None:
    """Do what it asks for, as the person would."""
    CHECKS[condition.name][1](visit, condition)


# -- the frame ------------------------------------------------------------------------------------


def _moved(visit: Visit, condition: Condition) -> bool:
    return abs(visit.program.document.frame - visit.frame) >= condition.amount


def _move(visit: Visit, condition: Condition) -> None:
    document, frames = visit.program.document, round(condition.amount)
    ahead = visit.frame + frames < document.frames
    document.go_to(visit.frame + (frames if ahead else -frames))


def _seen(visit: Visit, condition: Condition) -> bool:
    return visit.program.document.show in condition.words


def _see(visit: Visit, condition: Condition) -> None:
    visit.program.document.set_show(Show(condition.words[0]))


# -- the teaching tab -----------------------------------------------------------------------------


def _lit(visit: Visit, condition: Condition) -> bool:
    return visit.program.taught.lit in condition.words


def _light(visit: Visit, condition: Condition) -> None:
    if not _lit(visit, condition):
        visit.program.taught.light(condition.words[0])


def _swung(visit: Visit, condition: Condition) -> bool:
    taught = visit.program.taught
    by_hand = taught.what_if.swing is not None or taught.what_if.toward is not None
    d = taught.quantities
    return by_hand and d is not None and np.degrees(d.alpha) >= condition.amount - _NEARLY


def _swing(visit: Visit, condition: Condition) -> None:
    angle = min(condition.amount + _SHOWN, 180.0)
    visit.program.taught.alter(swing=np.radians(angle), toward=None)


def _twisted(visit: Visit, condition: Condition) -> bool:
    what_if = visit.program.taught.what_if
    return bool(np.degrees(abs(what_if.twist)) >= condition.amount - _NEARLY)


def _twist(visit: Visit, condition: Condition) -> None:
    angle = min(condition.amount + _SHOWN, 180.0)
    visit.program.taught.alter(twist=np.radians(angle))


def _opposed(visit: Visit, _: Condition) -> bool:
    taught, d = visit.program.taught, visit.program.taught.quantities
    return taught.what_if.counter and d is not None and d.strength >= taught.tau


def _oppose(visit: Visit, _: Condition) -> None:
    taught = visit.program.taught
    taught.alter(counter=True, twist=taught.what_if.twist or _TWIST)


def _along(visit: Visit, _: Condition) -> bool:
    return not visit.program.taught.what_if.counter


def _go_along(visit: Visit, _: Condition) -> None:
    visit.program.taught.alter(counter=False)


def _nudged(visit: Visit, condition: Condition) -> bool:
    """Each singularity that is named was nudged, one after the other."""
    what_if = visit.program.taught.what_if
    if abs(what_if.nudge) >= _NUDGED:
        if what_if.swing is not None and what_if.swing >= _TURNED:
            visit.met.add("swing")
        if what_if.bend is not None and what_if.bend <= _STRAIGHT:
            visit.met.add("bend")
    return visit.met >= set(condition.words)


def _nudge(visit: Visit, condition: Condition) -> None:
    taught = visit.program.taught
    if "swing" in condition.words:
        taught.alter(swing=np.radians(179.0), bend=None, nudge=np.radians(1.0))
    if "bend" in condition.words:
        taught.alter(swing=None, bend=np.radians(1.0), nudge=np.radians(1.0))


def _applied(visit: Visit, condition: Condition) -> bool:
    return visit.program.taught.what_if.applied >= condition.amount - 1e-9


def _apply(visit: Visit, _: Condition) -> None:
    visit.program.taught.alter(applied=1.0)


# -- the review -----------------------------------------------------------------------------------


def _wanted(visit: Visit, condition: Condition, decision: Decision) -> Judged | None:
    """The selected one of such a kind and decision, else the first."""
    document = visit.program.document
    own = [j for j in (document.interval,) if j is not None]
    for judged in (*own, *document.intervals):
        kind = judged.interval.kind.value.replace(" ", "-")
        if judged.decision == decision and (not condition.words or kind in condition.words):
            return judged
    return None


def _accepted(visit: Visit, condition: Condition) -> bool:
    return _wanted(visit, condition, Decision.ACCEPTED) is not None


def _accept(visit: Visit, condition: Condition) -> None:
    if (judged := _wanted(visit, condition, Decision.UNDECIDED)) is not None:
        visit.program.document.select_interval(judged.id, jump=True)
        visit.program.actions["accept"].trigger()


CHECKS: dict[str, Check] = {
    "moved": (_moved, _move),
    "seen": (_seen, _see),
    "lit": (_lit, _light),
    "swing": (_swung, _swing),
    "twist": (_twisted, _twist),
    "along": (_along, _go_along),
    "counter": (_opposed, _oppose),
    "nudged": (_nudged, _nudge),
    "applied": (_applied, _apply),
    "accepted": (_accepted, _accept),
}
