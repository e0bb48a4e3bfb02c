"""What a person decided, when intervals are found anew, or in another review."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.twistcore.plain_review import ARM, FOUND, LEG, made, review
from twistcore.detection import Kind
from twistcore.review import (
    Annotate,
    CarryOver,
    Decide,
    Decision,
    Insert,
    Redetect,
    Review,
    start_review,
)
from twistcore.review.commands import ChangeChains
from twistcore.review.model import Judged, with_earlier_decisions
from twistcore.review.reasons import intervals_detected_at_review_tau, make_evidence_adder
from twistcore.skeleton.rig import AS_FOUND, Rig


def test_reasons_are_told_again_of_what_was_found_alike():
    done = review()
    done.do(Annotate(2, "a"))
    done.do(Insert(made(LEG, 70, 75)))
    done.mark_saved()
    done.undo()
    done.redo()
    why = {"sigma_deg": 1.0}
    found = [replace(i, explain=lambda: why) for i in FOUND[:3]]
    other = replace(made(LEG, 40, 44, kind=Kind.LIMB_FLIP), explain=lambda: why)
    by_hand = replace(made(LEG, 70, 75), explain=lambda: why)
    done.take_reasons([*found, other, by_hand, FOUND[3]])
    told = {j.id: j.interval.evidence for j in done.state.intervals}
    assert told == {1: why, 2: why, 3: why, 4: None, 5: None, 6: None}
    assert (done.saved, done.position) == (True, 2)
    state = done.state
    done.take_reasons([replace(i, explain=dict) for i in FOUND])
    assert done.state.find(1) is state.find(1)  # knows its own
    assert done.state.find(4).interval.evidence == {}
    same = done.state
    assert make_evidence_adder([])(same) is same
    done.undo()
    assert done.state.find(2).interval.evidence == why
    done.mark_unsaved()
    done.take_reasons(found)
    assert not done.saved


@pytest.mark.parametrize("ready", [True, False])
def test_a_detector_that_is_not_ready_is_asked_for_flips_alone(ready):
    asked = []

    def detector(method, kinds):
        asked.append((method, kinds))
        return SimpleNamespace(intervals=lambda name, tau: [(name, tau), name])

    analysis = SimpleNamespace(
        usable=lambda method: method if ready else "consistency",
        kept=lambda method: method if ready and method == "own" else None,
        detector=detector,
        chains_and_limbs=(SimpleNamespace(name=LEG), SimpleNamespace(name="Beyond")),
    )
    assert intervals_detected_at_review_tau(analysis, review().state) == ((LEG, 0.2), LEG)
    assert asked == [("own", frozenset(Kind)) if ready else ("consistency", {Kind.LIMB_FLIP})]


def test_at_another_tau_what_was_decided_stands_for_what_is_the_same_or_inside():
    def after(*found, decision=Decision.ACCEPTED):
        done = Review(start_review("own", {ARM: 0.1}, [made(ARM, 100, 110)], (ARM,)))
        if decision:
            done.do(Decide((1,), decision))
        done.do(Redetect({ARM: 0.2}, found))
        return [
            (j.id, j.interval.start, j.interval.stop, j.supported) for j in done.state.intervals
        ]

    kept = (1, 100, 110, True)
    state = Decide((1,), Decision.ACCEPTED).apply(
        start_review("own", {ARM: 0.1}, [made(ARM, 100, 110)], (ARM,))
    )
    again = Redetect({ARM: 0.2}, (made(ARM, 100, 110),)).apply(state)
    assert again.find(1) is state.find(1)  # nobody needs to draw it again
    assert after(made(ARM, 100, 120)) == [kept]  # IoU of one half
    assert after(made(ARM, 100, 121)) == [(1, 100, 110, False), (2, 100, 121, True)]
    assert after(made(ARM, 106, 111)) == [kept]  # 80 % of it lie inside
    assert after(made(ARM, 107, 111)) == [(1, 100, 110, False), (2, 107, 111, True)]
    assert after(made(ARM, 100, 104), made(ARM, 105, 109)) == [kept]
    assert after() == [(1, 100, 110, False)]
    flip = made(ARM, 100, 110, kind=Kind.LIMB_FLIP)
    assert after(flip) == [(1, 100, 110, False), (2, 100, 110, True)]
    # What nobody touched is replaced by what shares most frames with it, or goes.
    assert after(made(ARM, 90, 101), made(ARM, 105, 130), decision=None) == [
        (2, 90, 101, True),
        (1, 105, 130, True),
    ]
    assert after(made(ARM, 110, 120), decision=None) == [(2, 110, 120, True)]
    assert after(decision=None) == []


def test_another_tau_leaves_other_chains_and_names_its_method():
    done = review()
    leg = done.state.of_chain(LEG)
    done.do(Redetect({ARM: 0.3}, (*FOUND[1:4], made(LEG, 0, 3)), method="paper"))
    assert done.state.method == "paper"
    assert dict(done.state.tau) == {ARM: 0.3, LEG: 0.2}
    assert done.state.of_chain(LEG) == leg
    assert [j.id for j in done.state.of_chain(ARM)] == [3, 4, 2]
    done.do(Redetect({ARM: 0.3, LEG: 0.1}, ()))
    assert done.state.method == "paper"
    assert len(done.history) == 2
    assert "paper" in done.history[0]
    done.do(Insert(made(ARM, 0, 4)))
    done.do(Redetect({ARM: 0.4}, ()))
    assert done.state.intervals[0].supported  # no detector is asked about it


def test_chains_that_go_take_their_intervals_along():
    done = review()
    done.do(ChangeChains(AS_FOUND, {"New": 0.5, ARM: 0.1}, ("New",), (made("New", 0, 3),)))
    state = done.state
    assert list(state.chain_order) == ["New", ARM]
    assert [(j.id, j.interval.chain) for j in state.intervals] == [
        (6, "New"), (3, ARM), (4, ARM), (2, ARM),
    ]  # fmt: skip
    assert dict(state.tau) == {"New": 0.5, ARM: 0.1}
    other = Rig(remove=(LEG,))
    assert ChangeChains(other, {ARM: 0.1}, (), ()).apply(state).rig is other
    assert ChangeChains(AS_FOUND, {}, (), (), "Add a chain").text == "Add a chain"
    with pytest.raises(ValueError, match="no chain 'Gone'"):
        done.do(ChangeChains(AS_FOUND, {ARM: 0.1}, ("Gone",), ()))


def test_a_decided_error_of_the_whole_body_moves_to_the_new_first_chain():
    def step(chain, start=20, stop=30):
        return made(chain, start, stop, kind=Kind.BODY_STEP)

    def after(tau, found=(), moved=None):
        steps = step(ARM), step(ARM, 60, 62), step(LEG)
        done = Review(start_review("own", {ARM: 0.1, LEG: 0.2}, steps, (ARM, LEG)))
        done.do(Decide((1,), Decision.REJECTED, "Ada"))
        done.do(
            ChangeChains(AS_FOUND, tau, tuple({i.chain for i in found}), found, "", moved or {})
        )
        return {
            (j.interval.chain, j.interval.start, j.decision == Decision.REJECTED, j.supported)
            for j in done.state.intervals
        }

    leg = (LEG, 20, False, True)
    # The first chain is removed, and "New" is now the first.
    new = {"New": 0.5, LEG: 0.2}
    found = step("New"), step("New", 60, 62)
    there = {("New", 20, True, True), ("New", 60, False, True), leg}
    assert after(new, found, {ARM: "New"}) == there
    assert after(new | {ARM: 0.1}, (*found, made(ARM, 0, 3)), {ARM: "New"}) == there | {
        (ARM, 0, False, True)
    }
    # The step is not found again: the decision stays, and what nobody decided goes.
    lost = made("New", 0, 3)
    assert after(new, (lost,), {ARM: "New"}) == {
        ("New", 20, True, False), ("New", 0, False, True), leg,
    }  # fmt: skip
    assert after(new, (), {ARM: "New"}) == {("New", 20, True, True), leg}
    # As in earlier journals, nothing moves unless the command says so.
    assert after({LEG: 0.2}) == {leg}
    assert after({}, (), {ARM: "New"}) == set()


def test_an_earlier_review_is_matched_by_the_frames_in_common():
    now = review().state
    earlier = (
        Judged(1, made(ARM, 12, 30), Decision.ACCEPTED, reviewer="Ada", note="a"),
        Judged(2, made(ARM, 18, 25), Decision.REJECTED, reviewer="Bo"),
        Judged(3, made(ARM, 55, 70, 30.0), edited=True),
        Judged(4, made(LEG, 80, 90), Decision.REJECTED),
        Judged(5, made(LEG, 60, 70), by_hand=True),
        Judged(6, made("Gone", 5, 9), Decision.ACCEPTED),
        Judged(7, made(LEG, 5, 9)),
    )
    other_clip = with_earlier_decisions(earlier, now)
    assert [(j.id, j.interval.start, j.decision.value) for j in other_clip.intervals] == [
        (3, 10, "accepted"), (4, 30, "undecided"), (2, 55, "undecided"),
        (1, 5, "undecided"), (5, 40, "undecided"), (6, 60, "undecided"),
    ]  # fmt: skip
    taken = other_clip.find(3)
    assert (taken.reviewer, taken.note, taken.interval.stop) == ("Ada", "a", 20)
    assert other_clip.find(2).edited
    assert (other_clip.find(6).by_hand, other_clip.find(6).supported) == (True, True)
    assert other_clip.next_id == 7
    same = CarryOver(earlier, same_clip=True).apply(now)
    alone = [(j.id, j.interval.start, j.supported) for j in same.intervals if j.id > 5]
    assert alone == [(6, 18, False), (8, 60, True), (7, 80, False)]
    assert same.next_id == 9
    # Once more: nothing comes twice, and what was touched here stays.
    own = Decide((3,), Decision.REJECTED, "Cy").apply(same)
    again = with_earlier_decisions(earlier, own, same_clip=True)
    assert [j.id for j in again.intervals] == [j.id for j in own.intervals]
    assert again.find(3).reviewer == "Cy"
    texts = (CarryOver(earlier).text, CarryOver(earlier, same_clip=True).text)
    assert texts == ("Carry over decisions", "Add decisions")


def test_of_two_earlier_intervals_with_as_many_frames_in_common_the_first_counts():
    earlier = [Judged(k, made(ARM, a, a + 8), note=str(k)) for k, a in ((1, 5), (3, 17))]
    taken = with_earlier_decisions(earlier, review().state).find(3)
    assert taken.note == "1"
    # One frame in common is enough, none is not.
    near = [Judged(1, made(ARM, 19, 25), Decision.ACCEPTED), Judged(2, made(ARM, 60, 70), note="x")]
    after = with_earlier_decisions(near, review().state)
    assert (after.find(3).decision, after.find(2).note) == (Decision.ACCEPTED, "")
