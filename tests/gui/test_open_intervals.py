"""What the card says of an open interval: whose other side, or that one joint turns alone."""

from dataclasses import replace

from inspector.panels.detail_card import explanation
from tests.conftest import ASSETS
from twistcore import detect
from twistcore.bvh import read_bvh
from twistcore.review import Review


def test_the_card_says_why_an_interval_is_open():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = Review.of(found).state.intervals[0]
    chain = found.analysis.chain(judged.interval.chain)
    assert "open:" not in explanation(judged, chain, 0)
    interval = replace(judged.interval, open=True)
    told = explanation(replace(judged, interval=interval), chain, 0)
    assert "open: one joint alone turns" in told
    evidence = interval.evidence
    one_edge = replace(interval, explain=lambda: {**evidence, "edges": evidence["edges"][:1]})
    told = explanation(replace(judged, interval=one_edge), chain, 0)
    assert "open: the other side of the clip may be the wrong one" in told


def test_the_card_says_by_how_much_the_child_turns_back():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = Review.of(found).state.intervals[0]
    interval, chain = judged.interval, found.analysis.chain(judged.interval.chain)
    assert "turns back" not in explanation(judged, chain, 0)
    in_part = {**interval.evidence, "child_follows": 0.8}
    told = explanation(
        replace(judged, interval=replace(interval, explain=lambda: in_part)), chain, 0
    )
    assert "the child turns back by 80% of it" in told
