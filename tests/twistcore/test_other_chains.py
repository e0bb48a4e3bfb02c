"""From the chains of a review to others: which τ they get and which are looked at again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.review import Decide, Decision, Review, start_review
from twistcore.review.other_chains import chain_change_command
from twistcore.skeleton.rig import AS_FOUND, Rig

A = new_constant_offset_interval("A", 10, 20, 0.5)


def analysis(found, automatic=0.1, rig=AS_FOUND):
    """What is asked of an analysis; found: intervals by chain."""
    detector = SimpleNamespace(
        automatic_tau=lambda _: automatic,
        intervals=lambda name, _: tuple(found[name]),
    )
    chains = tuple(SimpleNamespace(name=name, person=name[0]) for name in found)
    known = {"usable": lambda method: method, "detector": lambda _: detector}
    known["search"] = lambda _: SimpleNamespace(chosen=chains)
    return SimpleNamespace(chains_and_limbs=chains, rig=rig, **known)


def state(**tau):
    return start_review("own", tau, (), tau)


def test_a_chain_that_stays_keeps_its_tau_unless_nobody_chose_it():
    before = analysis({"A": [A], "B": []})
    same = chain_change_command(before, analysis({"A": [A], "B": []}), state(A=0.7, B=0.1))
    assert (dict(same.tau), same.again, same.what) == ({"A": 0.7, "B": 0.1}, (), "")
    other = chain_change_command(
        before, analysis({"A": [A], "B": []}, 0.2), state(A=0.7, B=0.1), "x"
    )
    assert (dict(other.tau), other.what) == ({"A": 0.7, "B": 0.2}, "x")
    unknown = chain_change_command(before, analysis({"A": [A], "B": []}), state(B=0.7))
    assert (dict(unknown.tau), unknown.again) == ({"A": 0.1, "B": 0.7}, ("A",))
    not_there = chain_change_command(analysis({"B": []}), analysis({"A": [A]}), state(A=0.7, B=0.1))
    assert (dict(not_there.tau), not_there.again) == ({"A": 0.1}, ("A",))


def test_new_chains_and_those_with_other_intervals_are_looked_at_again():
    b = new_constant_offset_interval("B", 1, 3, 0.1)
    rig = Rig(remove=("Gone",))
    after = analysis({"New": [A], "A": [A], "B": [b, b]}, rig=rig)
    command = chain_change_command(analysis({"A": [A], "B": [b]}), after, state(A=0.7, B=0.7))
    assert (command.again, command.rig) == (("New", "B"), rig)
    assert command.found == (A, b, b)


@pytest.mark.parametrize(
    "change",
    [{"start": 9}, {"stop": 21}, {"confidence": 0.5}, {"open": True}, {"kind": Kind.LIMB_FLIP},
     {"carried": True}, {"offset": np.full(10, 0.6)}],
    ids=str,
)  # fmt: skip
def test_any_difference_counts(change):
    before, after = analysis({"A": [A]}), analysis({"A": [replace(A, **change)]})
    assert chain_change_command(before, after, state(A=0.7)).again == ("A",)
    alike = analysis({"A": [replace(A, offset=A.offset.copy(), residual=1.0)]})
    assert chain_change_command(before, alike, state(A=0.7)).again == ()


def test_only_decided_errors_of_a_body_move_and_only_to_the_same_person():
    def step(chain):
        return replace(A, chain=chain, kind=Kind.BODY_STEP)

    def moved(decided, *names):
        found = {"A1": [step("A1")], "A2": [], "B1": [step("B1")], "B2": []}
        tau = dict.fromkeys(found, 0.1)
        review = Review(start_review("own", tau, (step("A1"), step("B1")), tau))
        for judged in review.state.intervals:
            if judged.interval.chain in decided:
                review.do(Decide((judged.id,), Decision.REJECTED, "Ada"))
        first = {name[0]: name for name in reversed(names)}
        after = {name: [step(name)] if first[name[0]] == name else [] for name in names}
        command = chain_change_command(analysis(found), analysis(after), review.state)
        review.do(command)
        kept = {j.interval.chain for j in review.state.intervals if j.kept}
        assert kept == {command.moved.get(name, name) for name in decided} & after.keys()
        assert len(review.state.intervals) == len(first)
        review.undo()
        assert {j.interval.chain for j in review.state.intervals if j.kept} == set(decided)
        return command.moved

    assert moved(["B1"], "A2", "B1", "B2") == {}
    assert moved(["A1", "B1"], "A2", "B2") == {"A1": "A2", "B1": "B2"}
    assert moved(["A1"], "A0", "A1", "B1") == {"A1": "A0"}
    assert moved(["B1"], "A1", "A2") == {}
    assert moved([], "A2", "B2") == {}
