"""What the card says of an open interval: whose other side, or that one joint turns alone."""

from dataclasses import fields, replace

from inspector.panels.detail_card import explanation
from tests.conftest import ASSETS
from twistcore import detect
from twistcore.analysis.clip_analysis import RESTLESS_DOUBT
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.review import Review
from twistcore.skeleton.helper import Helper


def test_the_card_begins_with_a_plain_sentence():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = next(j for j in Review.of(found).state.intervals if j.interval.frames == 16)
    chain = found.analysis.chain(judged.interval.chain)
    turned = "The left forearm is turned 21° too far for 16 frames"
    back = "the hand counter-rotates by the same angle."
    assert explanation(judged, chain, 0).startswith(f"{turned}; {back} Confidence ")
    alone = replace(judged, interval=replace(judged.interval, open=True))
    by_hand = replace(judged, by_hand=True)
    for told in (explanation(alone, chain, 0), explanation(by_hand, chain, 0)):
        assert told.startswith(f"{turned}. ")
    other = replace(chain, segment="", side="", ends=True)
    assert explanation(judged, other, 0).startswith("LeftForeArm is turned 21° too far")


def test_the_card_says_why_an_interval_is_open():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = Review.of(found).state.intervals[0]
    chain = found.analysis.chain(judged.interval.chain)
    assert "Not corrected automatically:" not in explanation(judged, chain, 0)
    interval = replace(judged.interval, open=True)
    told = explanation(replace(judged, interval=interval), chain, 0)
    one_joint = told
    evidence = interval.evidence
    one_edge = replace(interval, explain=lambda: {**evidence, "edges": evidence["edges"][:1]})
    told = explanation(replace(judged, interval=one_edge), chain, 0)
    assert told != one_joint


def test_the_card_says_by_how_much_the_child_turns_back():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = Review.of(found).state.intervals[0]
    interval, chain = judged.interval, found.analysis.chain(judged.interval.chain)
    in_part = {**interval.evidence, "child_follows": 0.8}
    told = explanation(
        replace(judged, interval=replace(interval, explain=lambda: in_part)), chain, 0
    )
    assert "80%" in told


def test_doubts_stand_for_the_other_side_of_the_clip():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    twist = Review.of(found).state.intervals[0]
    (limb, *_), chain = found.analysis.limbs, found.analysis.chain(twist.interval.chain)
    doubt = "the knee would travel a longer path"
    for kind, owner in ((Kind.LIMB_FLIP, limb), (Kind.HELPER_ROLL, helper_of(chain))):
        plain = replace(twist.interval, kind=kind, open=True, explain=dict)
        printed = explanation(replace(twist, interval=plain), owner, 0)
        assert "Not corrected automatically" in printed
        doubted = replace(plain, explain=lambda: {"doubts": [doubt]})
        printed = explanation(replace(twist, interval=doubted), owner, 0)
        assert f"Reasons for doubt: {doubt}" in printed
        assert "Not corrected automatically" not in printed


def test_a_twist_of_a_restless_clip_is_not_said_to_turn_alone():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    twist = Review.of(found).state.intervals[0]
    chain = found.analysis.chain(twist.interval.chain)
    left_open = found.analysis.left_open(twist.interval)
    printed = explanation(replace(twist, interval=left_open), chain, 0)
    assert f"Reasons for doubt: {RESTLESS_DOUBT}" in printed
    assert "Not corrected automatically:" not in printed


def helper_of(chain):
    return Helper(**{field.name: getattr(chain, field.name) for field in fields(chain)})
