"""What is learned from verdicts: precision, recall, τ for one chain or all, confidence."""

import json
import math
import shutil
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis import analyse, detect
from twistcore.bvh import read_bvh
from twistcore.cli import main
from twistcore.errors import FormatError
from twistcore.review import Decide, Decision, Review, write_session
from twistcore.review.model import Judged, constant
from twistcore.review.session import session_document, session_from_document
from twistcore.rig import skeleton_mark
from twistcore.tuning import GRID, Profile, Tuned, read_profile, write_profile
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.learned_confidence import (
    LearnedConfidence,
    Seen,
    held_out,
    learned,
    reliability,
    seen,
)
from twistcore.tuning.learned_profile import learned_profile
from twistcore.tuning.profile import TauReasons
from twistcore.tuning.verdict_curve import verdict_curve, wilson
from twistcore.tuning.verdicts_of import (
    JudgedClip,
    Verdict,
    found_by_tau,
    judged_clip,
    judged_in,
    performer_of,
    sessions_in,
)

INJECTED = ASSETS / "walk_injected.bvh"
TAU = np.degrees(GRID)


def verdict(strength, *, error, chain="LeftArm", confidence=0.9):
    """One that is found at every τ up to `strength` degrees."""
    size = math.radians(strength)
    return Verdict(chain, 10, 20, error, strength >= TAU, confidence, size)


def clip(name, verdicts, reviewed=0.5, chains=("LeftArm",)):
    seen_from = dict.fromkeys(chains, math.radians(reviewed))
    return JudgedClip(name, "consistency", "rig", "", 0.1, seen_from, tuple(verdicts))


def folder(errors, natural, clips=20, chain="LeftArm", reviewed=0.5):
    """Strengths in degrees, dealt out to so many clips."""
    every = [verdict(s, error=True, chain=chain) for s in errors]
    every += [verdict(s, error=False, chain=chain) for s in natural]
    return [clip(f"c{k}", every[k::clips], reviewed, (chain,)) for k in range(clips)]


# --- precision and recall ----------------------------------------------------------------------


def test_precision_and_recall_are_counts_of_what_is_found():
    curve = verdict_curve(folder([1.0, 4.0, 9.0, 9.0], [2.0, 9.0]))
    assert curve.counts == (4, 2)
    at = [curve.at(math.radians(t)) for t in (0.6, 3.0, 6.0, 20.0)]
    np.testing.assert_allclose(curve.recall[at], [1.0, 0.75, 0.5, 0.0])
    np.testing.assert_allclose(curve.precision[at][:3], [4 / 6, 3 / 4, 2 / 3])
    assert np.isnan(curve.precision[at[3]])  # nothing is found: nothing is known


def test_few_verdicts_leave_a_wide_interval_and_none_the_widest():
    low, high = wilson(np.array([0, 5, 9, 90]), np.array([0, 5, 10, 100]))
    # By hand, z = 1.6449: 5 of 5 from 5 / (5 + z²) on; 9 of 10 and 90 of 100 by the quadratic.
    assert (low[0], high[0]) == (0.0, 1.0)
    assert low[1] == pytest.approx(5 / (5 + 1.6449**2))
    for k, (share, n) in enumerate(((0.9, 10), (0.9, 100)), 2):
        for end in (low[k], high[k]):
            assert (end - share) ** 2 == pytest.approx(1.6449**2 * end * (1 - end) / n)
    assert high[2] - low[2] > 2.5 * (high[3] - low[3])


def test_the_interval_of_recall_holds_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(3)
    held = 0
    for _ in range(400):
        low, high = wilson(np.array(rng.binomial(30, 0.8)), np.array(30))
        held += low <= 0.8 <= high
    assert 0.86 <= held / 400 <= 0.95


# --- a τ from verdicts -------------------------------------------------------------------------


def test_tau_goes_above_what_is_rejected_and_stays_below_what_is_accepted():
    rng = np.random.default_rng(1)
    clips = folder(rng.uniform(9, 90, 60), rng.uniform(1, 6, 60))
    suggestion = verdict_curve(clips).suggested()
    assert 6.0 <= math.degrees(suggestion.tau) <= 9.5
    assert suggestion.low <= suggestion.tau <= suggestion.high
    # Where nothing is rejected there is no reason to go above the smallest errors looked for.
    calm = verdict_curve(folder(rng.uniform(9, 90, 60), []))
    assert math.degrees(calm.suggested().tau) == pytest.approx(2.0, abs=0.2)
    assert math.degrees(calm.suggested(smallest=math.radians(5)).tau) == pytest.approx(5, abs=0.5)


def test_an_alarm_costs_what_a_person_says_it_does():
    # 10 of 40 errors lie among 60 rejected intervals in 20 clips, three alarms a clip.
    clips = folder([3.0] * 10 + [30.0] * 30, [4.0] * 60)
    curve = verdict_curve(clips)
    assert math.degrees(curve.suggested(price=0.05).tau) < 4.0  # 25 points of recall against 15
    assert math.degrees(curve.suggested(price=0.2).tau) > 4.0  # against 60


def test_below_the_tau_that_was_reviewed_at_nothing_is_suggested():
    clips = folder([1.2] * 5 + [30.0] * 20, [], reviewed=4.0)
    assert math.degrees(verdict_curve(clips).suggested().tau) >= 4.0


def test_few_errors_suggest_nothing_and_more_verdicts_make_it_surer():
    assert verdict_curve(folder([30.0] * 9, [3.0] * 30)).suggested() is None
    rng = np.random.default_rng(2)

    def width(n):
        errors, natural = rng.lognormal(2.3, 0.8, n), rng.lognormal(0.9, 0.6, n)
        s = verdict_curve(folder(errors, natural, clips=n // 4)).suggested(price=0.3)
        return s.high / s.low

    assert np.mean([width(400) for _ in range(6)]) < np.mean([width(40) for _ in range(6)])


def test_a_suggestion_is_the_same_each_time():
    rng = np.random.default_rng(5)
    curve = verdict_curve(folder(rng.uniform(2, 30, 40), rng.uniform(1, 6, 40)))
    first, again, other = curve.suggested(), curve.suggested(), curve.suggested(seed=9)
    assert vars(first) == vars(again)
    assert other.tau == first.tau


# --- one τ for all, or not ---------------------------------------------------------------------


def together(*folders):
    """Clips with the verdicts of several chains."""
    out = []
    for parts in zip(*folders, strict=True):
        reviewed = {k: t for p in parts for k, t in p.reviewed.items()}
        verdicts = tuple(v for p in parts for v in p.verdicts)
        out.append(replace(parts[0], reviewed=reviewed, verdicts=verdicts))
    return out


def test_chains_that_are_alike_share_a_tau():
    wrong = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        alike = [
            folder(rng.lognormal(2.5, 0.8, 40), rng.lognormal(0.6, 0.5, 10), chain=f"c{k}")
            for k in range(6)
        ]
        shared = common_tau(together(*alike))
        wrong += any(c.apart for c in shared.chains)
    assert wrong <= 1
    assert next(shared.words()).startswith("One τ of")
    assert "will do for all chains:" in next(shared.words())


def test_a_chain_with_twists_of_its_own_gets_its_own_tau_and_the_reason():
    rng = np.random.default_rng(4)
    plain = [folder(rng.uniform(2, 60, 40), [], chain=f"c{k}") for k in range(4)]
    noisy = folder(rng.uniform(12, 60, 40), rng.uniform(2.5, 9, 30), chain="LeftForeArm")
    shared = common_tau(together(*plain, noisy))
    assert [c.chain for c in shared.chains if c.apart] == ["LeftForeArm"]
    assert math.degrees(shared.tau("LeftForeArm")) > 6.0
    assert shared.tau("c1") == shared.common.tau
    words = list(shared.words())
    assert "all chains but 1" in words[0]
    assert "LeftForeArm needs" in words[1]
    assert "of 30 intervals rejected fewer" in words[1]


def test_a_chain_in_which_everything_is_rejected_gets_its_own_tau():
    rng = np.random.default_rng(6)
    plain = [folder(rng.uniform(2, 60, 60), [], chain=f"c{k}") for k in range(4)]
    twists = folder([], [*rng.uniform(2.5, 9, 60), 40.0], chain="LeftForeArm")
    shared = common_tau(together(*plain, twists))
    assert [c.chain for c in shared.chains if c.apart] == ["LeftForeArm"]
    # Not above the one at 40°: errors of the others tell what it would miss.
    assert 6.0 < math.degrees(shared.tau("LeftForeArm")) < 12.0
    assert math.degrees(shared.common.tau) < 3.0


def test_errors_of_other_chains_alone_set_none_apart():
    large = folder([30.0] * 20 + [2.6] * 10, [4.0] * 200, clips=10, chain="L")
    few = folder([5.0, 7, 9, 12, 15, 20, 25, 30, 45, 60], [], clips=10, chain="X")
    shared = common_tau(together(large, few))
    assert [c.chain for c in shared.chains if c.apart] == []
    assert all(c.gain == 0.0 for c in shared.chains)
    assert not any("it ." in words for words in shared.words())


# --- confidence --------------------------------------------------------------------------------


def listed(n, rng, truth, clips=20):
    """Intervals whose chance to be accepted is `truth` of their confidence."""
    c = 1.0 / (1.0 + np.exp(-rng.normal(2.5, 1.5, n)))
    return Seen(c, rng.random(n) < truth(c), rng.integers(clips, size=n).astype(float))


def test_of_nothing_the_builtin_map_is_kept_and_few_verdicts_move_it_little():
    c = np.array([0.1, 0.5, 0.9, 0.99])
    none = Seen(np.zeros(0), np.zeros(0, bool), np.zeros(0))
    np.testing.assert_allclose(learned(none).of(c), c)
    one = learned(Seen(np.array([0.9]), np.array([False]), np.zeros(1)))
    assert np.abs(one.of(c) - c).max() < 0.5
    assert LearnedConfidence()(None) is None


def test_the_map_is_found_again_and_keeps_the_order():
    truth = LearnedConfidence(-1.0, 0.7)
    given = listed(20_000, np.random.default_rng(0), truth.of)
    found = learned(given)
    assert (found.shift, found.scale) == pytest.approx((-1.0, 0.7), abs=0.08)
    assert found.accepted + found.rejected == 20_000
    assert (np.diff(found.of(np.linspace(0.01, 0.99, 50))) > 0).all()
    # A detector that knows nothing is not turned round, whatever a person says.
    against = learned(Seen(given.confidence, given.confidence < 0.9, given.clip))
    assert against.scale > 0


def test_held_out_confidences_see_nothing_of_their_clip():
    rng = np.random.default_rng(0)
    given = listed(400, rng, lambda c: 0.8 * c)
    before = reliability(given.confidence, given.accepted)
    after = reliability(held_out(given), given.accepted)
    assert after.error < 0.5 * before.error
    # The verdicts of one clip turned round: its own confidences are as before.
    odd = given.clip == 7
    other = Seen(given.confidence, given.accepted ^ odd, given.clip)
    np.testing.assert_array_equal(held_out(other)[odd], held_out(given)[odd])
    assert (held_out(other)[~odd] != held_out(given)[~odd]).any()


def test_it_is_said_what_was_held_out():
    rng = np.random.default_rng(0)
    natural = [replace(v, confidence=0.6) for v in folder([], [2.0] * 10, clips=1)[0].verdicts]
    for clips, what in ((4, "points on clips held out"), (1, "on verdicts of its one clip held")):
        some = folder(rng.uniform(9, 90, 40), [], clips)
        some[0] = replace(some[0], verdicts=(*some[0].verdicts, *natural))
        assert what in learned_profile(some, common_tau(some)).told_of_confidence()


def test_what_is_needed_for_a_tau_is_what_is_asked():
    large = folder([30.0] * 12, [], clips=4, chain="L")
    few = folder([], [3.0, 3.0, 3.0], clips=4, chain="X")
    both = together(large, few)
    own = verdict_curve(both, "X")
    assert own.needed == (0, 2)  # the errors of others will do, three verdicts will not
    assert not own.enough
    assert verdict_curve(folder([30.0] * 4, [3.0] * 9)).needed == (6, 0)
    more = together(large, folder([], [3.0] * 5, clips=4, chain="X"))
    assert verdict_curve(more, "X").enough


def test_reliability_counts_bins():
    p = np.array([0.05, 0.95, 0.95, 0.95, 1.0])
    got = reliability(p, np.array([False, True, True, False, True]))
    assert [b.count for b in got.bins] == [1, 4]
    assert got.bins[1].was == pytest.approx(0.75)
    assert got.bins[1].low < 0.75 < got.bins[1].high
    assert got.error == pytest.approx((0.05 + 4 * abs(0.9625 - 0.75)) / 5)


# --- from reviews ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "performer"),
    [
        ("05_03.bvh", "05"),
        ("143_12.bvh", "143"),
        ("walk_injected.bvh", ""),
        ("walk1_subject5.bvh", "subject5"),
        ("2024_05.bvh", ""),
    ],
)
def test_a_performer_is_told_by_a_name(name, performer):
    assert performer_of(name) == performer


@pytest.fixture(scope="module")
def analysis():
    return analyse(read_bvh(INJECTED))


def judged_state(analysis, said, **more):
    """The review of what is found, decided by `said`(k)."""
    state = Review.of(detect(read_bvh(INJECTED))).state
    with_time = {"decided_at": "2026-01-01T00:00:00+00:00", **more}
    every = [replace(j, decision=said(k), **with_time) for k, j in enumerate(state.intervals)]
    return state.with_intervals(every)


def test_verdicts_are_accepted_or_rejected_and_what_nobody_said_is_none(analysis):
    decisions = Decision.ACCEPTED, Decision.REJECTED, Decision.UNDECIDED
    state = judged_state(analysis, lambda k: decisions[k % 3])
    told = judged_clip(analysis, state)
    wanted = [j for j in state.intervals if j.decision != Decision.UNDECIDED]
    assert len(told.verdicts) == len(wanted) > 3
    assert [v.error for v in told.verdicts] == [j.decision == Decision.ACCEPTED for j in wanted]
    assert told.rig == skeleton_mark(analysis.motion.skeleton)
    first = wanted[0].interval
    left = judged_clip(analysis, replace(state, left_out=((first.start, first.start + 1),)))
    assert len(left.verdicts) < len(told.verdicts)
    assert left.minutes == pytest.approx(told.minutes - analysis.motion.frame_time / 60.0)
    automatic = judged_state(analysis, lambda _: Decision.ACCEPTED, decided_at="")
    assert judged_clip(analysis, automatic).verdicts == ()
    sure = judged_state(analysis, lambda _: Decision.UNDECIDED)
    ids = tuple(j.id for j in sure.intervals)
    sure = Decide(ids, Decision.ACCEPTED, "me", "2026-01-01T00:00:00+00:00", True).apply(sure)
    kept = session_from_document(session_document(read_bvh(INJECTED), sure)).state
    for state in (sure, kept):  # or a learned confidence would confirm itself
        assert judged_clip(analysis, state).verdicts == ()
    looked = Decide(ids[:1], Decision.ACCEPTED, "me", "2026-01-02T00:00:00+00:00").apply(kept)
    assert len(judged_clip(analysis, looked).verdicts) == 1


def half_judged(analysis, said=lambda _: Decision.ACCEPTED):
    """The review of the first chain that has anything listed; all others wait."""
    state = judged_state(analysis, said)
    first = state.intervals[0].interval.chain
    open_again = [
        j if j.interval.chain == first else replace(j, decision=Decision.UNDECIDED)
        for j in state.intervals
    ]
    return first, state.with_intervals(open_again)


def test_chains_that_nobody_has_judged_are_none_without_an_alarm(analysis):
    first, state = half_judged(analysis)
    told = judged_clip(analysis, state)
    assert told.reviewed.keys() == {first}
    assert told.looked_at == 1.0
    done = judged_clip(analysis, judged_state(analysis, lambda _: Decision.REJECTED))
    assert done.reviewed.keys() == {c.name for c in analysis.chains}  # in these nothing was listed


def test_a_lower_tau_alone_is_no_look(analysis):
    state = judged_state(analysis, lambda _: Decision.REJECTED)
    chain = "LeftForeArm"
    before = judged_clip(analysis, state)
    low = before.reviewed[chain] / 4.0
    listed = analysis.by().intervals(chain, before.reviewed[chain])
    free = [t for t in range(0, 300, 9) if not any(i.start < t + 5 and t < i.stop for i in listed)]
    waits = [Judged(900 + k, constant(chain, t, t + 5, low)) for k, t in enumerate(free)]
    tau = {**state.tau, chain: low}
    lowered = replace(state, tau=tau).with_intervals((*state.intervals, *waits))
    after = judged_clip(analysis, lowered)
    assert after.reviewed[chain] >= before.reviewed[chain]
    assert after.shares[chain] == 1.0  # nothing that waits is listed at the τ that was looked at


def test_of_a_chain_decided_in_part_only_that_part_was_looked_at(analysis):
    state = judged_state(analysis, lambda _: Decision.REJECTED)
    own = state.of_chain("LeftForeArm")
    assert len(own) == 3
    strongest = max(own, key=lambda j: abs(j.interval.largest))
    part = [
        replace(j, decision=Decision.UNDECIDED) if j is strongest else j for j in state.intervals
    ]
    told = judged_clip(analysis, state.with_intervals(part))
    assert told.shares["LeftForeArm"] == pytest.approx(2 / 3)


def test_a_chain_set_apart_has_no_share_in_the_common_ones_minutes():
    errors = [3.0] * 10 + [*np.linspace(5.0, 40.0, 30)]
    plain = [folder(errors, [4.0] * 60, chain=f"c{k}") for k in range(4)]
    rng = np.random.default_rng(4)
    noisy = folder(rng.uniform(20, 60, 40), rng.uniform(6, 15, 60), chain="X")
    shared = common_tau(together(*plain, noisy), price=0.09)
    assert [c.chain for c in shared.chains if c.apart] == ["X"]
    assert shared.common.tau == verdict_curve(together(*plain)).suggested(price=0.09).tau


def test_where_a_verdict_is_found_is_what_the_detector_finds(analysis):
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    for v in judged_clip(analysis, state).verdicts:
        for k in range(0, len(GRID), 6):
            found = analysis.by().intervals(v.chain, float(GRID[k]))
            same = any((i.start, i.stop) == (v.start, v.stop) for i in found)
            assert v.found[k] == same
    # The strongest jump beside it bounds what finds it: no τ above that does.
    strengths = [np.degrees(analysis.by().strength(v.chain)).max() for v in told(analysis, state)]
    for v, strength in zip(told(analysis, state), strengths, strict=True):
        assert not v.found[strength < TAU].any()


def told(analysis, state):
    return judged_clip(analysis, state).verdicts


def test_an_error_made_by_hand_is_missed_at_every_tau_unless_it_is_found(analysis):
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    hand = Judged(
        99, constant("LeftUpLeg", 300, 310, 0.5), Decision.ACCEPTED, by_hand=True, reviewer="me"
    )
    told = judged_clip(analysis, state.with_intervals((*state.intervals, hand)))
    (mine,) = (v for v in told.verdicts if v.by_hand)
    assert not mine.found.any()
    assert mine.confidence is None
    curve = verdict_curve([told])
    assert curve.recall.max() == pytest.approx(1 - 1 / len(told.verdicts))
    assert len(seen([told])) == len(told.verdicts) - 1


class Lists:
    """A detector that lists the same at every τ."""

    def __init__(self, *spans):
        self.spans = spans

    def intervals(self, chain, tau):
        return tuple(constant(chain, start, stop, 0.5) for start, stop in self.spans)


@pytest.mark.parametrize(
    ("spans", "found"),
    [
        ([(10, 20), (40, 60)], (True, True)),
        ([(10, 15), (58, 80)], (True, True)),  # half of the error; any of what is natural
        ([(10, 14)], (False, False)),  # too little of the error
        ([(0, 30)], (False, False)),  # and too much
        ([(19, 45)], (False, True)),  # belongs to the one that it shares most with
    ],
)
def test_an_error_has_to_be_found_and_an_alarm_only_to_sound(spans, found):
    judged = [constant("A", 10, 20, 0.5), constant("A", 40, 60, 0.5)]
    by_tau = found_by_tau(judged, [True, False], Lists(*spans), "A")
    assert tuple(by_tau.all(axis=1)) == found
    assert tuple(by_tau.any(axis=1)) == found


def test_sessions_of_a_folder(tmp_path, analysis):
    path = shutil.copy(INJECTED, tmp_path / "05_01.bvh")
    clip = read_bvh(path)
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    write_session(tmp_path / "05_01.twist.json", clip, state)
    write_session(tmp_path / "05_01_refined.replay.json", clip, state)
    (tmp_path / "other.json").write_text("{}")
    ((found, session),) = sessions_in(tmp_path)
    told = judged_in(found, session)
    assert told.performer == "05"
    assert len(told.verdicts) == len(state.intervals)
    assert judged_in(found, session, "Ann").performer == "Ann"
    document = session_document(clip, state)
    for k, name in enumerate(("", "/")):  # of no clip at all
        (tmp_path / f"none{k}.json").write_text(json.dumps(document | {"clip": name}))
    assert len(list(sessions_in(tmp_path))) == 1
    shutil.copy(ASSETS / "walk.bvh", path)
    with pytest.raises(Exception, match="another version"):
        judged_in(found, session)


# --- the command -------------------------------------------------------------------------------


@pytest.fixture
def judged_folder(tmp_path, analysis):
    """Two clips of performer 05, judged: 14 accepted and two rejected."""
    for k in (1, 2):
        path = shutil.copy(INJECTED, tmp_path / f"05_0{k}.bvh")
        state = judged_state(analysis, lambda n: Decision(("rejected", "accepted")[n > 0]))
        write_session(tmp_path / f"05_0{k}.twist.json", read_bvh(path), state)
    return tmp_path


def test_tune_by_verdicts_writes_a_profile(judged_folder, tmp_path, capsys):
    output = tmp_path / "p.toml"
    assert main(["tune", str(judged_folder), "--verdicts", "-o", str(output)]) == 0
    said = capsys.readouterr().out
    assert "14 accepted and 2 rejected intervals in 2 clips" in said
    assert "Confidence stays the detector's: 20 verdicts on it or more are needed." in said
    profile = read_profile(output)
    clip = read_bvh(INJECTED)
    assert profile.rig == skeleton_mark(clip.motion.skeleton)
    assert (profile.performer, profile.method) == ("05", "consistency")
    assert profile.tau.keys() == {c.name for c in analyse(clip).chains}
    assert profile.confidence is None
    tau = set(profile.tau.values())
    assert math.radians(1.5) <= min(tau)


def test_tune_by_verdicts_says_what_is_missing(judged_folder, tmp_path, capsys):
    output = str(tmp_path / "p.toml")
    for more, told in (
        (["--performer", "06"], "no session is of performer '06'"),
        (["--seeds", "5"], "--seeds: expected none with --verdicts"),
        (["--method", "paper"], "judged on what the consistency detector lists"),
    ):
        command = ["tune", str(judged_folder), "--verdicts", "-o", output, *more]
        assert main(command) == 2
        assert told in capsys.readouterr().err
    (judged_folder / "05_02.twist.json").unlink()
    assert main(["tune", str(judged_folder), "--verdicts", "-o", output]) == 2
    assert "10 accepted intervals or more to learn τ from, found 7" in capsys.readouterr().err
    assert main(["tune", str(INJECTED), "--verdicts", "-o", output]) == 2
    assert "expected a folder of clips with their sessions" in capsys.readouterr().err
    assert main(["tune", str(INJECTED), "--performer", "05", "-o", output]) == 2
    assert "--performer: expected --verdicts, too" in capsys.readouterr().err
    assert not (tmp_path / "p.toml").exists()


# --- profiles ----------------------------------------------------------------------------------

WHOSE = Profile({}, "", "ab12", 'Ann "A"', LearnedConfidence(-0.25, 0.75, 180, 20))


def written(path, **more):
    tau = {"LeftArm": Tuned(4.5, math.nan, math.nan, math.nan)}
    write_profile(path, tau, "clips", "consistency", **more)
    return path


def test_a_profile_keeps_whose_it_is_and_the_learned_confidence(tmp_path):
    reasons = {"LeftArm": TauReasons(9, 1, 3.0, 6.0)}
    got = read_profile(written(tmp_path / "p.toml", whose=WHOSE, verdicts=reasons))
    assert got == replace(WHOSE, tau={"LeftArm": math.radians(4.5)}, method="consistency")
    assert "tau_low_deg = 3.0000" in (tmp_path / "p.toml").read_text()


def test_readers_of_earlier_versions_read_it(tmp_path):
    """They take tau_deg and detector of every table of the document, and nothing else."""
    path = written(tmp_path / "p.toml", whose=WHOSE, verdicts={"LeftArm": TauReasons(9, 1)})
    document = tomllib.loads(path.read_text("utf-8"))
    assert {name: float(t["tau_deg"]) for name, t in document.items()} == {"LeftArm": 4.5}
    assert {t["detector"] for t in document.values()} == {"consistency"}


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("confidence = 3", "expected confidence with a shift"),
        ("confidence = { shift = 0.1, scale = 0.0 }", "a scale above 0"),
        ("confidence = { shift = nan, scale = 1.0 }", "a shift within ±30"),
        ("confidence = { shift = 0.1, scale = 1.0, accepted = -1 }", "whole numbers"),
        ("rig = 4", "expected a text for rig"),
        (f"confidence = {{ shift = 1{400 * '0'}, scale = 1.0 }}", "a shift within ±30"),
        (f"[RightArm]\ntau_deg = 1{400 * '0'}", "a table with tau_deg"),
    ],
)
def test_a_damaged_profile_says_what_was_expected(tmp_path, line, told):
    path = tmp_path / "p.toml"
    path.write_text(f"[LeftArm]\ntau_deg = 2.0\n{line}\n")
    with pytest.raises(FormatError, match=told):
        read_profile(path)


def test_two_rigs_in_one_profile_are_refused(tmp_path):
    path = tmp_path / "p.toml"
    path.write_text('[A]\ntau_deg = 2.0\nrig = "a"\n[B]\ntau_deg = 2.0\nrig = "b"\n')
    with pytest.raises(FormatError, match="expected one rig in all tables, found 2"):
        read_profile(path)
