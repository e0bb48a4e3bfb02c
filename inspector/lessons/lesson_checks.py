"""Check the conditions of a task on a lesson page, and meet them if the user asks for help.

The user asks for help with the button "Show me".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_conditions import FARTHEST, Condition, hyphenated_kind_name, tau_meets
from inspector.session.open_clip import Show
from twistcore.detection import Kind
from twistcore.review import Decision, Judged
from twistcore.skeleton.runs import runs_of_true

_NEARLY = 0.05  # degrees; sliders have steps of a tenth of a degree
_TURNED, _STRAIGHT = np.radians(178.0), np.radians(2.0)  # close enough to a singularity
_NUDGED = np.radians(0.5)
_SHOWN = 15.0  # degrees added to the required angle, for a visible result
_TWIST = np.radians(75.0)
_TAU, _TRIED = (0.05, 180.0), 60  # degrees: the range of τ, and the number of values of τ to try


@dataclass(eq=False)
class Visit:
    """The state of a lesson page since the user opened the page.

    Attributes
    ----------
    frame
        The frame displayed when the page was opened.
    chain
        The name of the page's chain, or '' for any chain.
    met
        The singularities at which the user has nudged the limb: 'swing', 'bend'.
    """

    program: GuidedProgram
    frame: int
    chain: str = ""
    met: set[str] = field(default_factory=set)


Check = tuple[Callable[[Visit, Condition], bool], Callable[[Visit, Condition], object]]


def all_met(visit: Visit, conditions: Sequence[Condition]) -> bool:
    """Return True if every condition is met.

    Each condition is checked even if an earlier one is not met, because some checks record what the
    user has done.
    """
    met = [CHECKS[c.name][0](visit, c) for c in conditions]
    return all(met)


def meet_all(visit: Visit, conditions: Sequence[Condition]) -> None:
    """Meet all conditions on the user's behalf, with the actions that the user would perform."""
    for condition in sorted(conditions, key=lambda c: list(CHECKS).index(c.name)):
        check, act = CHECKS[condition.name]
        # Every other condition stays met once it is met
        if condition.name == "nudged" or not check(visit, condition):
            act(visit, condition)


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


def _alter(visit: Visit, **change: Any) -> None:
    """Select the page's chain in the teaching tab, and change the given what-if values."""
    document = visit.program.document
    visit.program.show_teaching()
    if visit.chain and document.chain != visit.chain:
        document.select_chain(visit.chain)
    visit.program.taught.alter(**change)


def _lit(visit: Visit, condition: Condition) -> bool:
    return visit.program.taught.lit in condition.words


def _light(visit: Visit, condition: Condition) -> None:
    visit.program.show_teaching()
    visit.program.taught.highlight(condition.words[0])


def _swung(visit: Visit, condition: Condition) -> bool:
    taught = visit.program.taught
    by_hand = taught.what_if.swing is not None or taught.what_if.toward is not None
    d = taught.quantities
    return by_hand and d is not None and np.degrees(d.alpha) >= condition.amount - _NEARLY


def _swing(visit: Visit, condition: Condition) -> None:
    angle = min(condition.amount + _SHOWN, 180.0)
    _alter(visit, swing=np.radians(angle), toward=None)
    if not _swung(visit, condition):  # a sideways nudge makes the swing smaller than 180°
        _alter(visit, nudge=0.0)


def _twisted(visit: Visit, condition: Condition) -> bool:
    what_if = visit.program.taught.what_if
    return bool(np.degrees(abs(what_if.twist)) >= condition.amount - _NEARLY)


def _twist(visit: Visit, condition: Condition) -> None:
    angle = max(condition.amount, min(condition.amount + _SHOWN, FARTHEST))
    _alter(visit, twist=np.radians(angle))


def _opposed(visit: Visit, _: Condition) -> bool:
    """Return True if the what-if values contain a counter-twist of at least τ.

    Applying the correction as well does not change the result.
    """
    taught = visit.program.taught
    if not taught.what_if.counter or (numbers := taught.numbers) is None:
        return False
    return bool(numbers.correction.before.strength >= taught.tau)


def _oppose(visit: Visit, condition: Condition) -> None:
    twist = visit.program.taught.what_if.twist
    far = np.copysign(max(abs(twist), _TWIST), twist)
    # The motion's own change may have the opposite sign, and angles jump near a singularity.
    for nudge in (visit.program.taught.what_if.nudge, 0.0):
        for angle in (twist or _TWIST, far, -far):
            _alter(visit, counter=True, twist=float(angle), nudge=nudge)
            if _opposed(visit, condition):
                return


def _along(visit: Visit, _: Condition) -> bool:
    return not visit.program.taught.what_if.counter


def _go_along(visit: Visit, _: Condition) -> None:
    _alter(visit, counter=False)


def _nudged(visit: Visit, condition: Condition) -> bool:
    """Return True if the user has nudged the limb at every singularity in the condition."""
    what_if = visit.program.taught.what_if
    if abs(what_if.nudge) >= _NUDGED:
        if what_if.swing is not None and what_if.swing >= _TURNED:
            visit.met.add("swing")
        if what_if.bend is not None and what_if.bend <= _STRAIGHT:
            visit.met.add("bend")
    return visit.met >= set(condition.words)


def _nudge(visit: Visit, condition: Condition) -> None:
    nudge = np.radians(1.0)
    if "swing" in condition.words:
        _alter(visit, swing=np.radians(179.0), bend=None, nudge=nudge)
        _nudged(visit, condition)
    if "bend" in condition.words:
        _alter(visit, swing=None, bend=np.radians(1.0), nudge=nudge)
        _nudged(visit, condition)


def _applied(visit: Visit, condition: Condition) -> bool:
    return visit.program.taught.what_if.applied >= condition.amount - 1e-9


def _apply(visit: Visit, _: Condition) -> None:
    _alter(visit, applied=1.0)


# -- the review -----------------------------------------------------------------------------------


def _find_judged(visit: Visit, condition: Condition, decision: Decision) -> Judged | None:
    """Return an interval of the required kind with the given decision, or None.

    The selected interval is preferred if it matches.
    """
    document = visit.program.document
    own = [j for j in (document.interval,) if j is not None]
    for judged in (*own, *document.intervals):
        if judged.decision == decision and _fits(condition, judged.interval.kind):
            return judged
    return None


def _fits(condition: Condition, kind: Kind) -> bool:
    return not condition.words or hyphenated_kind_name(kind) in condition.words


def _accepted(visit: Visit, condition: Condition) -> bool:
    return _find_judged(visit, condition, Decision.ACCEPTED) is not None


def _accept(visit: Visit, condition: Condition) -> None:
    document = visit.program.document
    judged = _find_judged(visit, condition, Decision.UNDECIDED)
    judged = judged or _find_judged(visit, condition, Decision.REJECTED)
    if judged is not None:
        document.select_interval(judged.id, jump=True)
    else:
        _insert(visit, condition)
    visit.program.actions["accept"].trigger()


def _insert(visit: Visit, condition: Condition) -> None:
    """Insert an interval of the required kind at the page's frame.

    If possible, the interval is inserted in the page's chain; if not, in another chain.
    """
    document = visit.program.document
    assert document.data is not None
    for chain in sorted(document.data.chains_and_limbs, key=lambda c: c.name != visit.chain):
        limb = document.data.limb(chain.name) is not None
        if _fits(condition, Kind.LIMB_FLIP if limb else Kind.COUNTER_TWIST):
            document.select_chain(chain.name)
            document.insert_interval(visit.frame)
            return


# -- the threshold --------------------------------------------------------------------------------


def _tau_set(visit: Visit, condition: Condition) -> bool:
    return tau_meets(condition, visit.program.document.review.state.tau[visit.chain])


def _set_tau(visit: Visit, condition: Condition) -> None:
    visit.program.document.set_tau(math.radians(condition.amount), visit.chain)


def _listed(visit: Visit, condition: Condition) -> bool:
    """Return True if the page's chain has the required number of counter-twists."""
    own = (j.interval for j in visit.program.document.intervals)
    count = sum(i.chain == visit.chain and i.kind == Kind.COUNTER_TWIST for i in own)
    return count == condition.amount


def _list(visit: Visit, condition: Condition) -> None:
    """Set τ so that the page's chain has the required number of intervals.

    The middle of the widest suitable range of τ is used.
    """
    document = visit.program.document
    tau = np.radians(np.geomspace(*_TAU, _TRIED))
    found = (document.detector.intervals(visit.chain, float(t)) for t in tau)
    fits = np.array([len(own) == condition.amount for own in found])
    if fits.any():
        low, high = max(runs_of_true(fits), key=lambda run: run[1] - run[0])
        document.set_tau(float(tau[(low + high - 1) // 2]), visit.chain)


# "Show me" meets the conditions in this order, in which no step undoes an earlier one. Accepting an
# interval selects another frame and chain, which resets what-if values; a nudge is recorded.
CHECKS: dict[str, Check] = {
    "accepted": (_accepted, _accept),
    "moved": (_moved, _move),
    "seen": (_seen, _see),
    "nudged": (_nudged, _nudge),
    "swing": (_swung, _swing),
    "twist": (_twisted, _twist),
    "along": (_along, _go_along),
    "counter": (_opposed, _oppose),
    "applied": (_applied, _apply),
    "lit": (_lit, _light),
    "tau": (_tau_set, _set_tau),
    "listed": (_listed, _list),
}
