"""Where a child turns back only in part, P's own jumps say how wrong P is; the share is told."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore import detect
from twistcore.analysis.clip_analysis import analyse
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.synthesis import InjectedError, inject

FILE = read_bvh(ASSETS / "basketball.bvh").motion
CLIP = FILE.sliced(1, FILE.frames)
CHAINS = {c.label: c for c in find_chains(CLIP)}
QUIET_CHILD = ["Left Arm", "Right UpLeg"]


def wrong(label, share, degrees=70.0, ramp=0, leak=0.0, at=200):
    """The clip with an error of 12 frames, which sets in and ends over `ramp` more."""
    up = np.arange(1, ramp + 1) / (ramp + 1)
    offset = np.radians(degrees) * np.concatenate([up, np.ones(12), up[::-1]])
    noise = np.radians(leak) * np.random.default_rng(0).standard_normal(len(offset))
    missing = (1.0 - share) * offset + noise
    error = InjectedError(CHAINS[label].name, at, at + len(offset), offset, missing)
    return inject(CLIP, tuple(CHAINS.values()), [error]), error


@pytest.mark.parametrize("share", [0.8, 0.5])
@pytest.mark.parametrize("label", [*QUIET_CHILD, "Left Shoulder", "Right ForeArm"])
def test_the_level_is_what_p_itself_shows(label, share):
    motion, error = wrong(label, share)
    found = [i for i in detect(motion, kinds={Kind.COUNTER_TWIST}) if i.start >= 100]
    assert [(i.chain, i.start, i.stop) for i in found] == [(error.chain, error.start, error.stop)]
    np.testing.assert_allclose(found[0].offset, error.offset, rtol=0.04)
    assert found[0].followed == pytest.approx(share, abs=0.03)
    assert found[0].evidence["child_follows"] == found[0].followed


@pytest.mark.parametrize("leak", [0.0, 0.5])
@parametrize("label", list(CHAINS), quick=4)
def test_a_child_that_follows_is_said_to(label, leak):
    motion, error = wrong(label, 1.0, leak=leak)
    (found,) = (i for i in detect(motion) if i.start < error.stop and error.start < i.stop)
    assert found.followed == found.evidence["child_follows"] == 1.0
    np.testing.assert_allclose(found.offset, error.offset, rtol=0.03)


@pytest.mark.parametrize("label", QUIET_CHILD)
def test_near_half_a_turn_signs_say_nothing(label):
    for degrees in (178.0, -178.0):
        motion, error = wrong(label, 0.8, degrees)
        (found,) = (i for i in detect(motion, [error.chain], kinds={Kind.COUNTER_TWIST}))
        off = np.angle(np.exp(1j * (found.offset - error.offset)))
        assert np.abs(off).max() < np.radians(5.0)


def test_what_the_child_does_not_turn_back_is_no_flip_of_the_limb():
    motion, error = wrong("Left Arm", 0.5, 150.0)
    limb = next(k for k in find_limbs(CLIP, tuple(CHAINS.values())) if k.name == "LeftArm-LeftHand")
    analysis = analyse(motion)
    alone = analysis.detect(kinds={Kind.LIMB_FLIP})
    assert (error.start, error.stop) in [(i.start, i.stop) for i in alone if i.chain == limb.name]
    together = [i for i in analysis.detect() if i.start < error.stop and error.start < i.stop]
    assert [i.chain for i in together] == [error.chain]


@pytest.mark.parametrize(
    ("label", "degrees", "at"),
    # Of the last one three frames of each onset are found as edges, and doubted again.
    [("Left Arm", 100.0, 300), ("Right UpLeg", 100.0, 250), ("Left Arm", 150.0, 200)],
)
def test_softer_errors_of_a_silent_child_are_as_large_as_p_shows(label, degrees, at):
    for share in (1.0, 0.8):
        motion, error = wrong(label, share, degrees, ramp=8, at=at)
        found = detect(motion, [error.chain], kinds={Kind.COUNTER_TWIST})
        (own,) = (i for i in found if i.start < error.stop and error.start < i.stop)
        assert own.followed == pytest.approx(share, abs=0.05)
        assert np.abs(own.offset).max() == pytest.approx(np.abs(error.offset).max(), rel=0.06)


def test_detect_explain_says_by_how_much_the_child_turns_back(tmp_path, capsys):
    for share, said in ((0.8, True), (1.0, False)):
        clip = tmp_path / f"{share}.bvh"
        write_motion(wrong("Left Arm", share)[0], clip)
        main(["detect", str(clip), "--explain"])
        told = capsys.readouterr().out
        assert ("the child turns back by 80%" in told) == said
        assert "the child turns back by 1" not in told
