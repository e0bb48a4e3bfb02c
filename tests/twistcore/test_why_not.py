"""Why nothing is found: every peak past τ has its reason, and none contradicts the curve."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import reasons as judge
from benchmarks.reasons import contradictions, wrong
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import Detection, analyse, detect
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.analysis.why_not import (
    Why,
    peaks_above_tau_outside_intervals,
    why_frame_bounds_no_interval,
    why_peaks_lack_interval,
)
from twistcore.cli import main
from twistcore.detection import Interval, Kind
from twistcore.detection.consistency import chain_analysis
from twistcore.detection.evidence import Judgement
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.synthesis import add_twist_from_opposite_side

CLIPS = sorted(path.stem for path in ASSETS.glob("*.bvh"))
WALK = read_bvh(ASSETS / "walk.bvh").motion
ARM = "LeftArm"


def chain_of(motion, name):
    return next(c for c in find_chains(motion) if c.name == name)


def turned(motion, joint, axis, degrees, start, stop=None):
    """The motion with one joint turned about an axis of its own in some frames."""
    q = motion.rotations.copy()
    turn = quaternion_from_axis_angle(axis, math.radians(degrees))
    q[start:stop, joint] = multiply(q[start:stop, joint], turn)
    return replace(motion, rotations=q)


def twisted(motion, name, degrees, start, stop=None):
    """The motion with a counter-twist."""
    offset = np.zeros(motion.frames)
    offset[start:stop] = math.radians(-degrees)
    return remove_twist(motion, find_chains(motion), {name: offset})


def shaken(motion, degrees, seed=0):
    """The motion with noise in every joint."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(*motion.rotations.shape[:2], 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.radians(rng.normal(scale=degrees, size=axis.shape[:2]))
    turn = np.concatenate([np.cos(angle / 2)[..., None], np.sin(angle / 2)[..., None] * axis], -1)
    return replace(motion, rotations=multiply(motion.rotations, turn))


def only_one(found, name, frame):
    (reason,) = [r for r in why_peaks_lack_interval(found, name) if r.frame == frame]
    assert not list(contradictions(found, reason))
    return reason


@parametrize("share", [1.0, 0.5, 0.1], quick=2)
@pytest.mark.parametrize("method", ["consistency", "paper"])
@parametrize("clip", CLIPS, quick=2)
def test_every_peak_past_tau_has_a_reason_that_the_curve_bears_out(clip, method, share):
    analysis = analyse(read_bvh(ASSETS / f"{clip}.bvh"))
    automatic = analysis.detect(method).tau
    found = analysis.detect(method, tau_radians={n: share * t for n, t in automatic.items()})
    for name in found.tau:
        reasons, lines = wrong(found, name)
        assert lines == []
        assert [r.frame for r in reasons] == peaks_above_tau_outside_intervals(found, name)


@parametrize("method", ["consistency", "paper"])
@parametrize("clip", ["kick", "walk_injected"])
def test_at_any_frame_there_is_a_reason(clip, method):
    found = detect(read_bvh(ASSETS / f"{clip}.bvh"), method=method)
    for name in list(found.tau)[-4:]:  # chains of a leg, and the limbs
        for frame in range(0, found.analysis.motion.frames):
            assert not list(contradictions(found, why_frame_bounds_no_interval(found, name, frame)))


def test_motion_and_jumps_that_do_not_pair_in_a_shaken_clip():
    analysis = analyse(shaken(WALK, 0.6))
    automatic = analysis.detect().tau
    found = analysis.detect(tau_radians={n: 0.6 * t for n, t in automatic.items()})
    seen = set()
    for name in found.tau:
        reasons, lines = wrong(found, name)
        assert lines == []
        seen |= {r.why for r in reasons}
        for r in reasons:
            if r.why == Why.MOTION and "gain" in r.numbers:
                assert r.numbers["gain"] < 10.0
                assert "σ" in r.text
            assert r.suspicious == (r.why in {Why.MOTION, Why.UNEQUAL, Why.NO_PARTNER, Why.OTHER})
    assert {Why.MOTION, Why.UNEQUAL, Why.ONE_JOINT} <= seen


def test_only_one_joint_turns():
    arm = chain_of(WALK, ARM)
    for degrees, suspicious in ((30.0, False), (100.0, True)):
        found = detect(turned(WALK, arm.parent, arm.axis, degrees, 200), kinds={Kind.COUNTER_TWIST})
        reason = only_one(found, ARM, 200)
        assert reason.why == Why.ONE_JOINT
        assert reason.suspicious is suspicious  # faster than a body
        assert math.degrees(reason.strength) == pytest.approx(degrees, abs=0.5)
        assert reason.text.startswith(f"{degrees:.0f}") or reason.text.startswith(
            f"{degrees - 1:.0f}"
        )
        assert names_in_one_line(reason.text, "frame 200", "τ = 1.5°", "LeftArm +")


def test_a_lone_jump_is_named_in_its_own_chain_and_beside():
    arm = chain_of(WALK, ARM)
    found = detect(turned(WALK, arm.parent, arm.axis, 100.0, 200))
    (jump,) = [i for i in found if i.kind == Kind.LONE_JUMP]
    assert (jump.chain, jump.start, jump.joint) == (ARM, 200, ARM)
    assert names_in_one_line(
        why_frame_bounds_no_interval(found, ARM, 200).text, "200 of LeftArm (+"
    )
    shoulder = why_frame_bounds_no_interval(found, "LeftShoulder", 200)  # LeftArm is its child
    assert shoulder.why == Why.IMAGE
    assert names_in_one_line(shoulder.text, "LeftArm", "frame 200 (+")


def test_the_clips_first_frame_may_be_called_1():
    arm = chain_of(WALK, ARM)
    found = detect(turned(WALK, arm.parent, arm.axis, 30.0, 200), kinds={Kind.COUNTER_TWIST})
    (reason,) = [r for r in why_peaks_lack_interval(found, ARM, first=1) if r.frame == 200]
    assert "frame 201" in reason.text


def test_a_neighbours_error_is_named():
    found = detect(twisted(WALK, "LeftForeArm", 60.0, 150, 170), kinds={Kind.COUNTER_TWIST})
    reason = why_frame_bounds_no_interval(found, ARM, 150)  # the forearm is the upper arm's child
    assert reason.why == Why.IMAGE
    assert reason.strength < reason.tau
    assert names_in_one_line(reason.text, "LeftForeArm ", "frames 150–170")


def test_the_edges_of_a_limbs_flip_are_named():
    found = detect(read_bvh(ASSETS / "kick.bvh"))
    flip = next(i for i in found if i.kind == Kind.LIMB_FLIP)
    thigh = flip.chain.split("-")[0]
    at = [r for r in why_peaks_lack_interval(found, thigh) if r.frame in (flip.start, flip.stop)]
    assert len(at) == 2
    assert {r.why for r in at} == {Why.IMAGE}
    assert all(r.numbers["of"] == flip.chain and not r.suspicious for r in at)


def test_inside_and_at_the_edges_of_an_interval():
    found = detect(twisted(WALK, ARM, 60.0, 150, 170), kinds={Kind.COUNTER_TWIST})
    (interval,) = [i for i in found if i.chain == ARM]
    assert (interval.start, interval.stop) == (150, 170)
    for frame in (150, 160):
        reason = why_frame_bounds_no_interval(found, ARM, frame)
        assert reason.why == Why.INTERVAL
        assert names_in_one_line(reason.text, f" {frame} ", "150–170 (+60.0°)")
    reason = why_frame_bounds_no_interval(found, ARM, 170)
    assert reason.why == Why.INTERVAL
    assert "frames 150–170 (+60.0°)" in reason.text
    assert "above τ" in why_frame_bounds_no_interval(found, ARM, 170).text
    assert "below τ" in why_frame_bounds_no_interval(found, ARM, 160).text
    assert peaks_above_tau_outside_intervals(found, ARM) == peaks_above_tau_outside_intervals(
        detect(WALK), ARM
    )


def test_what_the_review_has_elsewhere():
    found = detect(twisted(WALK, ARM, 60.0, 150, 170), kinds={Kind.COUNTER_TWIST})
    moved = Interval(ARM, 250, 260, np.zeros(10))
    other = Detection(found.analysis, found.method, found.tau, (moved,))
    assert [r.why for r in why_peaks_lack_interval(other, ARM) if r.frame in (150, 170)] == [
        Why.MOVED,
        Why.MOVED,
    ]


def test_cuts_and_what_is_too_short_between_them():
    rng = np.random.default_rng(3)
    q = add_twist_from_opposite_side(
        WALK, find_chains(WALK)
    ).rotations.copy()  # a silent joint would tell all the same
    for start in (150, 158):
        axis = rng.normal(size=(q.shape[1], 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        for joint, a in enumerate(axis):
            turn = quaternion_from_axis_angle(a, 0.9)
            q[start:, joint] = multiply(q[start:, joint], turn)
    arm = chain_of(WALK, ARM)
    motion = twisted(replace(WALK, rotations=q), ARM, 40.0, 153, 155)
    found = detect(motion, kinds={Kind.COUNTER_TWIST})
    assert arm.name in found.tau
    for frame in (0, 150, 158):
        reason = why_frame_bounds_no_interval(found, ARM, frame)
        assert reason.why == Why.CUT
        assert reason.strength == 0.0
    for frame in (153, 155):
        reason = only_one(found, ARM, frame)
        assert reason.why == Why.SHORT
        assert "frames 150–158" in reason.text


def test_a_jump_that_nothing_takes_back():
    found = detect(twisted(WALK, ARM, 60.0, 170), kinds={Kind.COUNTER_TWIST})
    (interval,) = [i for i in found if i.chain == ARM]  # open: clear enough alone
    bare = Detection(found.analysis, found.method, found.tau, ())
    assert interval.open
    assert why_frame_bounds_no_interval(bare, ARM, 170).why == Why.MOVED
    # In noise it is not that clear.
    noisy = detect(shaken(twisted(WALK, ARM, 14.0, 150), 1.0), tau_degrees=3.0)
    reason = only_one(noisy, ARM, 150)
    assert reason.why == Why.NO_PARTNER
    assert reason.suspicious
    assert 10.0 <= reason.numbers["gain"] < 20.0
    assert names_in_one_line(reason.text, "τ", "(LeftArm +")


def test_below_tau_the_sizes_are_told_apart():
    found = detect(twisted(WALK, ARM, 2.0, 150, 170), tau_degrees=2.001, kinds={Kind.COUNTER_TWIST})
    reason = why_frame_bounds_no_interval(found, ARM, 150)
    assert reason.why == Why.BELOW
    size, frame, tau = numbers(reason.text)[:3]
    assert frame == 150
    assert size < tau


def test_limbs_say_what_a_jump_costs():
    found = detect(read_bvh(ASSETS / "kick.bvh"))
    limb = found.limbs[0].name
    low = found.analysis.detect(tau_radians={n: 0.1 * t for n, t in found.tau.items()})
    peak_reasons = [r for c in low.limbs for r in why_peaks_lack_interval(low, c.name)]
    assert {r.why for r in peak_reasons} <= {Why.MOTION, Why.NO_PARTNER, Why.OTHER, Why.IMAGE}
    motion = [r for r in peak_reasons if r.why == Why.MOTION]
    assert motion
    assert all(r.numbers["cost_flip"] >= r.numbers["spares"] for r in motion)
    assert why_frame_bounds_no_interval(found, limb, 0).why == Why.CUT


def test_a_name_that_there_is_not():
    with pytest.raises(TwistError):
        why_frame_bounds_no_interval(detect(WALK), "Tail", 3)


def test_explain_says_the_reasons(capsys):
    clip = str(ASSETS / "kick.bvh")
    assert main(["detect", clip, "--json", "--explain"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert main(["detect", clip, "--explain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert document["peaks"]
    for peak in document["peaks"]:
        assert peak["strength_deg"] >= peak["tau_deg"]
        assert peak["reason"] in list(Why)
        assert f"    {peak['text']}" in lines
    assert main(["detect", clip, "--json"]) == 0
    assert "peaks" not in json.loads(capsys.readouterr().out)


@pytest.mark.thorough
def test_the_script_counts_them(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("sys.argv", ["reasons", str(ASSETS), "--json", str(tmp_path / "out.json")])
    assert judge.main() == 0
    counted = json.loads((tmp_path / "out.json").read_text())
    assert counted["wrong"] == []
    assert sum(counted["counts"]["consistency"].values()) > 0
    assert sum(counted["counts"]["paper"].values()) == 0  # each of its events opens an interval
    assert capsys.readouterr().out


def test_what_all_the_evidence_takes_for_motion_is_no_find_and_the_answer_says_so(monkeypatch):
    motion = twisted(WALK, ARM, 40.0, 150, 170)
    twists = {Kind.COUNTER_TWIST}
    (found,) = detect(motion, kinds=twists)
    motion_it_is = Judgement(-4.0, ("such turns occur often",), {}, motion=True)
    monkeypatch.setattr(chain_analysis, "judgement_of", lambda *_, **__: motion_it_is)
    without = detect(motion, kinds=twists)
    assert not without.intervals
    (taken,) = without.analysis.by().taken_for_motion(ARM, without.tau[ARM])
    assert (taken.start, taken.stop) == (found.start, found.stop)
    for frame in (150, 170):
        reason = why_frame_bounds_no_interval(without, ARM, frame)
        assert reason.why == Why.MOTION
        assert (reason.numbers["start"], reason.numbers["stop"]) == (150, 170)
        assert "often" in reason.text
    assert why_frame_bounds_no_interval(without, ARM, 300).why != Why.MOTION
