"""What detection costs: what is loaded, what is computed again, what is kept."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.messages import names_in_one_line
from tests.twistcore.test_soft_errors import clip
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import bends, cuts, noise_bursts
from twistcore.detection import lone_jumps as module
from twistcore.detection.bends import bend_steps
from twistcore.detection.consistency import detector as consistency
from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.pairing import Block
from twistcore.detection.cuts import find_cuts
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.interval import Kind
from twistcore.detection.limbs import Limbs
from twistcore.detection.lone_jumps import lone_jumps
from twistcore.detection.noise_bursts import joint_noise_level, largest_joint_and_ancestor_noise
from twistcore.detection.soft_errors import (
    search_soft_errors,
    soft_intervals,
    soft_search_budget,
    unsearched_frames_sentences,
)
from twistcore.detection.soft_onset import SOFT
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.notes import UNSEARCHED
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import Array, multiply, quaternion_from_axis_angle
from twistcore.synthesis import InjectedError, inject

ASSETS = Path(__file__).parents[2] / "assets"
_DETECT = """
import sys
from twistcore.cli.command_line import main
assert main(["detect", sys.argv[1]]) == 0
print(sorted({".".join(name.split(".")[:2]) for name in sys.modules}), file=sys.stderr)
"""


def test_detecting_in_an_ordinary_clip_loads_nothing_slow() -> None:
    clip = ASSETS / "walk.bvh"
    done = subprocess.run(
        [sys.executable, "-c", _DETECT, str(clip)], check=True, capture_output=True, text=True
    )
    loaded = done.stderr.splitlines()[-1]
    assert "twistcore.detection" in loaded
    for slow in (
        "scipy",
        "twistcore.tuning",
        "twistcore.review",
        "twistcore.formats.npz",
        "twistcore.formats.amc",
    ):
        assert f"'{slow}" not in loaded


def test_cuts_are_sought_once_each(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    steps = cuts.bend_steps
    monkeypatch.setattr(cuts, "bend_steps", lambda motion: calls.append(motion) or steps(motion))
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    assert analyse(motion).detect().notes is not None
    assert sum(one is motion for one in calls) == 1


def test_a_caller_may_change_the_cuts_it_was_given() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    find_cuts(motion)[:] = True
    assert not find_cuts(motion).all()


def test_noise_of_quiet_joints_takes_no_memory() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    joints = range(len(motion.skeleton))
    largest_joint_and_ancestor_noise(motion, joints)
    kept = [noise_bursts._of_joint(motion, joint) for joint in joints]
    assert all(one.strides == (0,) for one in kept)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_quick_look_leaves_out_no_noise(fps: float, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, some = np.random.default_rng(1), 0
    looks = [noise_bursts._may_be_mostly_true, lambda _mask, _width: True]
    for trial in range(60):
        turns = rng.normal(size=(300, 3)) * rng.uniform(1.0, 9.0)
        turns[: rng.integers(300)] *= 0.1
        turns = np.diff(turns, axis=0, prepend=0.0) if trial % 2 else turns
        found = []
        for look in looks:
            monkeypatch.setattr(noise_bursts, "_may_be_mostly_true", look)
            found.append(joint_noise_level(turns, fps))
        assert np.array_equal(*found)
        some += found[0].any()
    assert 5 < some < 55


def test_bends_are_the_same_by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    whole = bend_steps(motion)
    monkeypatch.setattr(bends, "_BLOCK", 7)
    assert np.array_equal(bend_steps(motion), whole)
    for few in (1, 2):
        assert bend_steps(motion.sliced(0, few)).shape == (len(whole), few - 1)


def test_a_table_of_pairs_keeps_only_what_gains() -> None:
    rng = np.random.default_rng(1)
    gain = np.where(rng.random((64, 576)) < 0.01, rng.uniform(0.1, 9.0, (64, 576)), -np.inf)
    follows = np.where(np.isfinite(gain), rng.integers(0, 3, gain.shape), 0).astype(np.int8)
    block = Block.of(64, 0, gain, follows)
    assert np.array_equal(block.gain, gain)
    assert np.array_equal(block.follows, follows)
    kept = sum(v.nbytes for v in vars(block).values() if isinstance(v, np.ndarray))
    assert kept < 0.05 * gain.nbytes


def test_the_signals_of_edges_of_any_width_take_bounded_memory() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    witnesses = ChainSignals.of(motion, analyse(motion).chains[0])
    for width in range(1, motion.frames // 2):
        witnesses.beyond_pace("x", width)
    assert sum(len(v) for v in witnesses._series.values()) <= 1 << 18
    again = ChainSignals.of(motion, analyse(motion).chains[0]).beyond_pace("x", 1)
    assert np.array_equal(witnesses.beyond_pace("x", 1), again, equal_nan=True)


def test_a_level_up_to_the_end_of_a_clip_is_kept_once() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    chain = next(c for c in analyse(motion).chains if c.name == "LeftArm")
    start = motion.frames // 2 + 20
    level = InjectedError(chain.name, start, motion.frames, np.full(motion.frames - start, 0.9))
    known = analyse(inject(motion, [chain], [level])).by()
    assert isinstance(known, ConsistencyAnalysis)
    (found,) = known.chains[chain.name].between_edges(known.automatic_tau(chain.name))
    assert (found.start, found.stop) == (start, motion.frames)
    assert found.offset.strides == (0,)
    assert found.delta == pytest.approx(0.9, abs=0.02)


def test_lone_jumps_look_at_the_room_only_where_a_joint_turns_fast(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []
    in_room = module.joint_world_rotations

    def counted(motion: Motion, joint: int, at: NDArray[np.intp]) -> Array:
        asked.append(len(at))
        return in_room(motion, joint, at)

    monkeypatch.setattr(module, "joint_world_rotations", counted)
    motion = read_bvh(ASSETS / "walk.bvh").motion
    chains = analyse(motion).chains
    assert not any(lone_jumps(motion, chains).values())
    assert sum(asked) == 0
    rotations, joint = motion.rotations.copy(), chains[0].parent
    axis = own_bone_axis(motion.skeleton, joint)
    assert axis is not None
    turn = quaternion_from_axis_angle(axis, np.array(2.5))
    rotations[200, joint] = multiply(rotations[200, joint], turn)
    jumps = lone_jumps(motion.with_rotations(rotations), chains)
    assert any(i.start == 200 for own in jumps.values() for i in own)
    assert 0 < sum(asked) < 40


def test_a_search_whose_budget_is_spent_says_what_it_left(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = clip("walk.bvh", "rich")
    chain = next(c for c in analyse(motion).chains if c.name == "RightForeArm")
    ramp = np.minimum(1.0, np.minimum(np.arange(1, 31), np.arange(30, 0, -1)) / 9.0)
    dirty = inject(motion, [chain], [InjectedError(chain.name, 150, 180, 0.7 * ramp)])
    found = analyse(dirty).detect()
    assert [i.chain for i in found if i.evidence and i.evidence["follows"] == SOFT] == [chain.name]
    assert not any(note.kind == UNSEARCHED for note in found.notes)
    monkeypatch.setattr(soft_intervals, "BUDGET", 0.0)
    cut_short = analyse(dirty).detect()
    assert not any(i.evidence and i.evidence["follows"] == SOFT for i in cut_short)
    said = [note.text for note in cut_short.notes if note.kind == UNSEARCHED]
    assert any(chain.name in text for text in said)
    some = analyse(dirty).detect(kinds=[Kind.LIMB_FLIP])
    assert not any(note.kind == UNSEARCHED for note in some.notes)


def test_what_was_left_is_told_by_limb_and_of_much_the_first() -> None:
    sentences = unsearched_frames_sentences(
        {"LeftArm": [(3, 9), (20, 21)], "LeftForeArm": [(3, 9), (20, 21)], "LeftLeg": [(1, 2)] * 9}
    )
    assert names_in_one_line(sentences[0], "3–9, 20–21 (LeftArm, LeftForeArm)")
    assert "1–2 … (LeftLeg)" in sentences[1]


def test_the_budget_goes_by_the_size_of_a_clip() -> None:
    assert (
        soft_search_budget(1000, 30)
        == 2.0 * soft_search_budget(500, 30)
        == 3.0 * soft_search_budget(1000, 10)
        > 0.0
    )
    assert (
        soft_search_budget(1, 30) == soft_search_budget(40, 30) > 0.0
    )  # every clip costs something


def test_all_limbs_share_one_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    given = []

    def seek(*limbs: Any) -> soft_intervals.Searched:
        given.append(limbs[-1])
        return search_soft_errors(*limbs)

    monkeypatch.setattr(consistency, "search_soft_errors", seek)
    motion = read_bvh(ASSETS / "walk.bvh").motion
    analyse(motion).detect()
    assert len(given) == 2  # arms, then legs
    assert sum(given) == pytest.approx(soft_search_budget(motion.frames, len(motion.skeleton)))


def test_limbs_of_a_long_clip_are_taken_one_by_one_with_the_same_jumps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    asked, rotation = [], consistency.counter_rotation

    def noted(limbs: Limbs, *rest: Any) -> CounterRotation:
        asked.append(limbs.count)
        return rotation(limbs, *rest)

    monkeypatch.setattr(consistency, "counter_rotation", noted)
    together = analyse(motion).by()
    assert set(asked) == {2}
    asked.clear()
    monkeypatch.setattr(consistency, "LONG", 0)
    alone = analyse(motion).by()
    assert set(asked) == {1}
    assert isinstance(together, ConsistencyAnalysis)
    assert isinstance(alone, ConsistencyAnalysis)
    for name, chain in together.chains.items():
        other = alone.chains[name]
        for field, values in vars(chain.limb).items():
            assert np.array_equal(values[chain.row], getattr(other.limb, field)[other.row])
