"""One way from a clip to its intervals: what is asked of whom, once, and what is told."""

import inspect
import math
import threading
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import refused
from tests.twistcore.two_people import two_people
from twistcore.analysis import clip_analysis as module
from twistcore.analysis.clip_analysis import (
    ALL_KINDS,
    REPAIRED,
    ClipAnalysis,
    _same_frames,
    analyse,
    detect,
)
from twistcore.detection import Interval, Kind
from twistcore.detection.protocol import DetectorInfo
from twistcore.detection.registry import Detectors
from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.rig import OwnChain, Rig
from twistcore.skeleton.rotation import rotate, twist_angle
from twistcore.skeleton.signals import (
    TwistSignals,
    azimuth_increments,
    signals_of_chains,
    twist_signals,
)

TAU = 0.25


INFO = DetectorInfo("told", "told", "nothing", has_confidence=False)


@dataclass
class Told:
    """A detector that says of every chain at which τ it was asked."""

    name: str = "told"
    info: DetectorInfo = INFO
    made: int = 0
    followed: float = 1.0
    open: bool = False
    asked: list = field(default_factory=list)

    def analyse(self, motion, chains, tell):
        self.made += 1
        self.chains = [c.name for c in chains]
        tell(0.5)
        return self

    def automatic_tau(self, chain):
        return TAU + 0.01 * self.chains.index(chain)

    def strength(self, chain):
        return np.full(3, float(self.chains.index(chain)))

    def intervals(self, chain, tau):
        self.asked.append((chain, tau))
        later = Interval(chain, 30, 40, np.full(10, tau))
        first = Interval(chain, 10, 20, np.full(10, tau), followed=self.followed, open=self.open)
        return first, later


@pytest.fixture
def told(monkeypatch):
    detector = Told()
    made = {"consistency": detector, "told": Told()}
    monkeypatch.setattr(Detectors, "__getitem__", lambda _, name: made[name])
    monkeypatch.setattr(Detectors, "__iter__", lambda _: iter(made))
    return detector


class Flips:
    """What would be known of limbs."""

    def __init__(self, start=11, stop=20):
        self.at = start, stop

    def automatic_tau(self, limb):
        return 0.9

    def strength(self, limb):
        return np.full(3, 7.0)

    def intervals(self, limb, tau):
        start, stop = self.at
        return (Interval(limb, start, stop, np.full(stop - start, tau), kind=Kind.LIMB_FLIP),)


@pytest.fixture
def clip(walk, told, monkeypatch):
    """An analysis of a walk whose detectors are made up."""

    def of_limbs(motion, limbs):
        assert motion is walk.motion
        assert limbs == made.limbs
        return Flips(50, 60)

    monkeypatch.setattr(module, "analyse_limbs", of_limbs)
    jump = Interval("LeftArm", 5, 6, np.zeros(1), kind=Kind.LONE_JUMP, open=True)

    def jumps(_motion, chains, _refined=None):
        return {c.name: (jump,) if c.name == "LeftArm" else () for c in chains}

    monkeypatch.setattr("twistcore.detection.lone_jumps.lone_jumps", jumps)
    made = analyse(walk)
    return made


def names(some):
    return [c.name for c in some]


# What is looked at


def test_of_a_clip_all_chains_and_limbs_are_looked_at(walk):
    found = analyse(walk)
    chains = find_chains(walk.motion)
    limbs = find_limbs(walk.motion, chains)
    assert names(found.chains) == names(chains)
    assert names(found.limbs) == names(limbs)
    assert names(found.chains_and_limbs) == names((*chains, *limbs))
    assert found.name == walk.name
    assert analyse(walk.motion).name == "motion"
    assert found.chain(limbs[0].name).name == limbs[0].name


def test_chains_are_named_or_given_and_bring_their_limb_along(walk):
    limb = analyse(walk).limbs[0]
    parent = walk.motion.skeleton.names[limb.parent]
    named = analyse(walk, [parent])
    assert (names(named.chains), names(named.limbs)) == ([parent], [limb.name])
    alone = analyse(walk, [limb.name])
    assert (names(alone.chains), names(alone.limbs)) == ([], [limb.name])
    one, other = analyse(walk).chains[3], analyse(walk).chains[1]
    given = analyse(walk, [one, limb, other])
    assert (names(given.chains), names(given.limbs)) == (names([one, other]), [limb.name])
    rig = Rig((), ("RightLeg",))
    for some in ([one], [one.name], None):
        looked_at = analyse(walk, some, rig)
        assert (looked_at.motion, looked_at.name) == (walk.motion, "walk.bvh")
        assert looked_at.rig == rig
    mixed = analyse(walk, [one, other.name])
    assert set(names(mixed.chains)) == {one.name, other.name}
    assert analyse(walk, []).chains_and_limbs == ()
    with pytest.raises(TwistError, match=r"walk.bvh: .*'Tail'.*LeftArm"):
        analyse(walk, ["Tail"])
    with refused(TwistError, "motion:", "'Tail'"):
        analyse(walk.motion, ["Tail"])
    with pytest.raises(TwistError, match="–"):
        ClipAnalysis(walk.motion, []).chain("Tail")


@pytest.mark.parametrize("what", ["walk.bvh", None, 3])
def test_what_is_no_clip_is_refused(what):
    with refused(TypeError, type(what).__name__):
        analyse(what)


# Detectors


def test_a_detector_is_asked_once_and_kept(clip, told):
    assert repr(clip).startswith("<ClipAnalysis walk.bvh: 10 chains, ")
    assert clip.kept("consistency") is None
    progress = []
    assert clip.by(tell=progress.append) is clip.by() is told
    assert (told.made, progress) == (1, [0.5])
    assert clip.kept("consistency") is told
    assert repr(clip) == "<ClipAnalysis walk.bvh: 10 chains, consistency>"
    assert clip.by("told") is not told
    assert repr(clip).endswith("consistency, told>")
    assert clip.flips is clip.flips
    with refused(TwistError, "'x'", "consistency, told"):
        clip.by("x")
    with pytest.raises(TwistError, match="'x'"):
        clip.detector("x")


def test_two_threads_make_a_detector_once(clip, told):
    inside, go = threading.Event(), threading.Event()
    made = told.analyse

    def slowly(motion, chains, tell):
        inside.set()
        go.wait(10.0)
        return made(motion, chains, tell)

    told.analyse = slowly
    threads = [threading.Thread(target=clip.by) for _ in range(2)]
    threads[0].start()
    assert inside.wait(10.0)
    threads[1].start()
    go.set()
    for thread in threads:
        thread.join()
    assert told.made == 1


def test_lone_jumps_are_sought_in_what_the_other_kinds_leave(clip, monkeypatch):
    seen = []

    def refiner(motion, chains, intervals):
        seen.append((motion, names(chains), [(i.chain, i.start, i.kind) for i in intervals]))
        return "repaired"

    sought = []
    monkeypatch.setattr(module, "refiner", refiner)
    monkeypatch.setattr(
        "twistcore.detection.lone_jumps.lone_jumps", lambda *given: sought.append(given) or {}
    )
    assert clip.jumps() is clip.jumps()
    ((motion, chains, intervals),) = seen
    assert motion is clip.motion
    assert chains == names(clip.chains_and_limbs)
    assert len(intervals) == 2 * len(clip.chains) + len(clip.limbs)
    assert sought == [(clip.motion, clip.chains, "repaired")]


# Kinds and thresholds


def test_kinds_say_what_is_asked(clip, told):
    counter = clip.detect(kinds="counter-twist")
    assert {i.kind for i in counter} == {Kind.COUNTER_TWIST}
    assert list(counter.tau) == names(clip.chains) == names(counter.chains)
    assert counter.limbs == ()
    flips = clip.detect(kinds=[Kind.LIMB_FLIP])
    assert [i.chain for i in flips] == names(clip.limbs) == list(flips.tau)
    assert (flips.chains, names(flips.limbs)) == ((), names(clip.limbs))
    jumps = clip.detect(kinds=["lone jump"])
    assert [(i.chain, i.kind) for i in jumps] == [("LeftArm", Kind.LONE_JUMP)]
    assert list(jumps.tau) == names(clip.chains)
    every = clip.detect()
    assert len(every) == len(counter) + len(flips) + len(jumps)
    assert names(every.chains_and_limbs) == names(clip.chains_and_limbs)
    of_arm = [i.start for i in every if i.chain == "LeftArm"]
    assert of_arm == [5, 10, 30]
    assert len(clip.detect(kinds=[])) == 0
    assert {kind for kind in Kind if not kind.repairable} == ALL_KINDS - REPAIRED
    expected = (
        "'flip' is not a kind of error; expected one of counter-twist, carried roll, limb flip"
    )
    with pytest.raises(TwistError, match=expected):
        clip.detect(kinds=["flip", "lone jump"])


def test_a_detection_is_a_sequence_that_says_what_it_is(clip):
    found = clip.detect(kinds="counter-twist")
    assert list(found) == [found[k] for k in range(len(found))]
    assert repr(found) == "<Detection walk.bvh: 20 intervals by consistency>"
    one = replace(found, intervals=found.intervals[:1], method="told")
    assert repr(one) == "<Detection walk.bvh: 1 interval by told>"
    assert (found.analysis, found.method) == (clip, "consistency")


def test_a_threshold_is_for_all_chains_or_by_name_else_the_detectors_own(clip, told):
    own = dict(clip.detect().tau)
    of_chains = {n: TAU + 0.01 * k for k, n in enumerate(names(clip.chains))}
    assert own == of_chains | dict.fromkeys(names(clip.limbs), 0.9)
    given = clip.detect(tau_radians=0.5).tau
    assert {given[n] for n in names(clip.chains)} == {0.5}
    assert {given[n] for n in names(clip.limbs)} == {0.9}
    assert clip.detect(tau_degrees=30.0).tau["LeftArm"] == pytest.approx(math.pi / 6.0)
    limb = clip.limbs[0].name
    some = clip.detect(tau_degrees={"LeftArm": 60, limb: 90}).tau
    assert some == own | {"LeftArm": pytest.approx(math.pi / 3), limb: pytest.approx(math.pi / 2)}
    told.asked.clear()
    clip.detect(kinds="counter-twist", tau_radians={"LeftArm": 0.125})
    assert dict(told.asked) == {n: own[n] for n in names(clip.chains)} | {"LeftArm": 0.125}
    with pytest.raises(TwistError, match="τ"):
        clip.detect(tau_radians=0.1, tau_degrees=5.0)
    with pytest.raises(TwistError, match=r"walk\.bvh: .*'Tail'"):
        clip.detect(tau_radians={"Tail": 0.1})


def test_chains_and_limbs_are_asked_by_name_as_one_detector(clip):
    both = clip.detector()
    chain, limb = clip.chains[2].name, clip.limbs[1].name
    assert (both.automatic_tau(chain), both.automatic_tau(limb)) == (TAU + 0.02, 0.9)
    assert (both.strength(chain)[0], both.strength(limb)[0]) == (2.0, 7.0)
    assert [i.chain for i in both.intervals(limb, 0.7)] == [limb]
    with pytest.raises(TwistError, match="'Tail'"):
        both.strength("Tail")


@pytest.mark.parametrize(
    ("frames", "followed", "is_open", "left"),
    [
        ((10, 20), 0.5, False, 0),
        ((11, 21), 0.5, False, 0),
        ((9, 19), 0.5, False, 0),
        ((12, 20), 0.5, False, 1),
        ((10, 22), 0.5, False, 1),
        ((10, 20), 1.0, False, 1),
        ((10, 20), 0.5, True, 1),
        ((30, 40), 0.5, False, 1),
    ],
)
def test_what_a_child_does_not_turn_back_is_no_flip_of_the_limb(
    clip, told, monkeypatch, frames, followed, is_open, left
):
    told.followed, told.open = followed, is_open
    monkeypatch.setattr(module, "analyse_limbs", lambda *_: Flips(*frames))
    limb = clip.limbs[0]
    clip.by()
    detector = clip.detector(kinds=REPAIRED)
    assert len(detector.intervals(limb.name, 0.5)) == left
    assert len(clip.detector(kinds=[Kind.LIMB_FLIP]).intervals(limb.name, 0.5)) == 1


def test_a_limb_alone_has_the_flips_that_it_has_among_all(clip, told, monkeypatch):
    told.followed = 0.5
    monkeypatch.setattr(module, "analyse_limbs", lambda *_: Flips(10, 20))
    assert len(clip.detector(kinds=REPAIRED).intervals(clip.limbs[0].name, 0.5)) == 0
    assert told.made == 1  # where a flip is found the detector of chains is asked


def test_frames_are_the_same_if_both_ends_are_no_more_than_one_apart():
    def at(start, stop):
        return Interval("a", start, stop, np.zeros(stop - start))

    for start, stop, same in ((10, 20, 1), (9, 21, 1), (11, 19, 1), (8, 20, 0), (10, 22, 0)):
        assert _same_frames(at(10, 20), at(start, stop)) is bool(same)
        assert _same_frames(at(start, stop), at(10, 20)) is bool(same)


def test_detect_is_all_of_it_at_once(walk, told):
    found = detect(walk, ["LeftArm"], "told", kinds="counter-twist", tau_radians=0.5)
    assert [(i.chain, i.start, i.offset[0]) for i in found] == [
        ("LeftArm", 10, 0.5), ("LeftArm", 30, 0.5)
    ]  # fmt: skip
    assert found.method == "told"
    assert detect(walk, ["LeftArm"], "told", kinds="limb flip").intervals == ()
    assert detect(walk, ["LeftArm"], kinds="counter-twist", tau_degrees=90.0)[0].offset[
        0
    ] == pytest.approx(math.pi / 2)


# What is kept


def test_signals_poses_and_reliabilities_are_made_once(walk):
    one = analyse(walk)
    assert list(one.signals) == names(one.chains)
    assert one.signals is one.signals
    assert one.poses is one.poses
    for name, value in one.reliability.items():
        assert value == np.median(one.signals[name].azimuth_reliability)
    assert list(one.reliability) == names(one.chains)


def test_a_rig_of_other_chains_takes_along_only_what_was_made(walk):
    before = analyse(walk)
    rig = Rig((OwnChain(("Spine", "Spine1", "Neck1")),), ("LeftArm",))
    fresh = before.with_rig(rig)
    assert (fresh.name, fresh.rig, fresh.motion) == (before.name, rig, before.motion)
    assert not {"signals", "poses"} & vars(fresh).keys()
    assert before.with_rig(before.rig) is before
    of = before.signals
    assert "poses" not in vars(before.with_rig(rig))
    after = before.with_rig(rig)
    assert list(after.signals) == names(after.chains)
    assert all(after.signals[n] is of[n] for n in after.signals if n in of)
    assert "LeftArm" not in after.signals
    assert "Spine" in after.signals
    poses = before.poses
    assert before.with_rig(rig).poses is poses


def test_other_chains_leave_chosen_ones_and_people_chosen(walk, tmp_path):
    chosen = analyse(walk, "LeftForeArm")
    after = chosen.with_rig(Rig((), ("RightArm",)))
    assert names(after.chains_and_limbs) == names(chosen.chains_and_limbs) == ["LeftForeArm"]
    assert after.chosen
    assert "RightArm" not in names(after.every_chain)
    assert names(after.every_chain) == names(analyse(walk, rig=after.rig).chains)
    assert after.unexamined == ()
    with pytest.raises(TwistError, match="the rig has none of the chains LeftForeArm"):
        chosen.with_rig(Rig((), ("LeftForeArm",)))


def test_other_chains_leave_other_people_out():
    clip = parse_bvh(two_people(), "pair.bvh")
    first, _ = analyse(clip).people
    one = analyse(clip, people=first)
    gone = one.chains[0].name
    after = one.with_rig(Rig((), (gone,)))
    assert {c.person for c in after.chains_and_limbs} == {first}
    assert names(after.chains) == [n for n in names(one.chains) if n != gone]
    assert {u.person for u in after.unexamined} <= {first}


def test_the_kinds_in_the_signature_read_as_all():
    kinds = inspect.signature(detect).parameters["kinds"].default
    assert kinds is None
    clip = read_bvh(ASSETS / "walk_injected.bvh")
    assert len(detect(clip, kinds=None)) == len(detect(clip, kinds=list(Kind))) > 0


# Signals


def test_signals_of_a_turning_joint_are_its_turns(walk):
    motion = walk.motion
    told = []
    chains = find_chains(motion)[:3]
    found = signals_of_chains(motion, chains, told.append)
    assert told == [0.0, 1 / 3, 2 / 3]
    assert list(found) == names(chains)
    for chain in chains:
        one, again = found[chain.name], twist_signals(motion, chain)
        for column in vars(one):
            np.testing.assert_array_equal(getattr(one, column), getattr(again, column))
        np.testing.assert_allclose(np.cumsum(one.dtheta_c), one.theta_c)
        turned = np.exp(1j * (one.theta_p[0] + np.cumsum(one.dtheta_p)))
        np.testing.assert_allclose(turned, np.exp(1j * one.theta_p), atol=1e-9)
        assert one.dtheta_p[0] == one.dtheta_c[0] == 0.0
        assert (np.abs(one.dtheta_p) <= math.pi).all()
        for t in range(0, motion.frames, 50):
            a = chain.axis if chain.axis.ndim == 1 else chain.axis[t]
            arm = chain.arm if chain.arm.ndim == 1 else chain.arm[t]
            q = motion.rotations[t]
            v = rotate(q[chain.child], arm)
            assert one.theta_p[t] == twist_angle(q[chain.parent], a)
            bent = np.linalg.norm(np.cross(v, a))
            assert one.azimuth_reliability[t] == pytest.approx(bent, abs=1e-9)
            p = q[chain.parent]
            assert one.swing_reliability[t] == pytest.approx(math.hypot(p[0], p[1:] @ a))
        peak = math.degrees(one.strength.max())
        assert repr(one) == f"<TwistSignals: {motion.frames} frames, m up to {peak:.1f}°>"


def test_an_axis_may_vary_over_time_and_the_signals_are_the_same(walk):
    chain = find_chains(walk.motion)[0]
    moving = replace(chain, axis=np.tile(chain.axis, (walk.motion.frames, 1)))
    one, other = (twist_signals(walk.motion, c) for c in (chain, moving))
    for column in vars(one):
        np.testing.assert_allclose(getattr(one, column), getattr(other, column), atol=1e-9)


def test_without_frames_there_is_nothing_to_say():
    none = np.zeros(0)
    assert repr(TwistSignals(*[none] * 7)) == "<TwistSignals: 0 frames, m up to 0.0°>"
    turns = azimuth_increments(np.array([[1.0, 0, 0], [0, 2.0, 0], [0, 0, 0]]), np.eye(3)[2])
    np.testing.assert_allclose(turns, [0.0, math.pi / 2, 0.0])


@pytest.mark.thorough
def test_a_chain_asked_for_has_the_intervals_of_the_whole_clip():
    """An error shows in the chains beside it: one alone would be explained otherwise."""
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    whole = analyse(motion).detect()
    assert len(whole) > 4
    for chain in find_chains(motion):
        alone = analyse(motion, [chain.name]).detect()
        names = {c.name for c in alone.chains_and_limbs}
        assert chain.name in names
        told = [(i.chain, i.start, i.stop, i.delta, i.kind) for i in whole if i.chain in names]
        assert [(i.chain, i.start, i.stop, i.delta, i.kind) for i in alone] == told
