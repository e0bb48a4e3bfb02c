"""What is learned from verdicts: precision, recall, τ for one chain or all, confidence."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from twistcore.tuning import GRID
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.learned_confidence import (
    ConfidenceVerdicts,
    LearnedConfidence,
    confidence_reliability_by_bin,
    cross_validated_confidence,
    fit_confidence_to_verdicts,
)
from twistcore.tuning.learned_profile import learned_profile
from twistcore.tuning.verdict_curve import tau_curve_from_verdicts, wilson_bounds
from twistcore.tuning.verdicts_of import (
    JudgedClip,
    Verdict,
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
    curve = tau_curve_from_verdicts(folder([1.0, 4.0, 9.0, 9.0], [2.0, 9.0]))
    assert curve.counts == (4, 2)
    at = [curve.at(math.radians(t)) for t in (0.6, 3.0, 6.0, 20.0)]
    np.testing.assert_allclose(curve.recall[at], [1.0, 0.75, 0.5, 0.0])
    np.testing.assert_allclose(curve.precision[at][:3], [4 / 6, 3 / 4, 2 / 3])
    assert np.isnan(curve.precision[at[3]])  # nothing is found: nothing is known


def test_few_verdicts_leave_a_wide_interval_and_none_the_widest():
    low, high = wilson_bounds(np.array([0, 5, 9, 90]), np.array([0, 5, 10, 100]))
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
        low, high = wilson_bounds(np.array(rng.binomial(30, 0.8)), np.array(30))
        held += low <= 0.8 <= high
    assert 0.86 <= held / 400 <= 0.95


# --- a τ from verdicts -------------------------------------------------------------------------


def test_tau_goes_above_what_is_rejected_and_stays_below_what_is_accepted():
    rng = np.random.default_rng(1)
    clips = folder(rng.uniform(9, 90, 60), rng.uniform(1, 6, 60))
    suggestion = tau_curve_from_verdicts(clips).suggested()
    assert 6.0 <= math.degrees(suggestion.tau) <= 9.5
    assert suggestion.low <= suggestion.tau <= suggestion.high
    # Where nothing is rejected there is no reason to go above the smallest errors looked for.
    calm = tau_curve_from_verdicts(folder(rng.uniform(9, 90, 60), []))
    assert math.degrees(calm.suggested().tau) == pytest.approx(2.0, abs=0.2)
    assert math.degrees(calm.suggested(smallest=math.radians(5)).tau) == pytest.approx(5, abs=0.5)


def test_an_alarm_costs_what_a_person_says_it_does():
    # 10 of 40 errors lie among 60 rejected intervals in 20 clips, three alarms a clip.
    clips = folder([3.0] * 10 + [30.0] * 30, [4.0] * 60)
    curve = tau_curve_from_verdicts(clips)
    assert math.degrees(curve.suggested(price=0.05).tau) < 4.0  # 25 points of recall against 15
    assert math.degrees(curve.suggested(price=0.2).tau) > 4.0  # against 60


def test_below_the_tau_that_was_reviewed_at_nothing_is_suggested():
    clips = folder([1.2] * 5 + [30.0] * 20, [4.5] * 60, reviewed=4.0)
    assert math.degrees(tau_curve_from_verdicts(clips).suggested().tau) >= 4.5


def test_a_suggestion_does_not_go_beyond_what_was_judged():
    """Eleven large errors, judged first of many: they do not say that small ones do not matter."""
    curve = tau_curve_from_verdicts(folder([40.0 + k for k in range(11)], [], reviewed=30.0))
    assert curve.enough
    assert curve.suggested() is None
    assert numbers(curve.one_sided_sentence) == pytest.approx([30.0, 40.0], abs=1.0)
    shared = common_tau(folder([40.0 + k for k in range(11)], [], reviewed=30.0))
    assert shared.common is None
    # Rejected intervals below the errors do.
    justified = tau_curve_from_verdicts(folder([40.0] * 20, [32.0] * 60, reviewed=30.0)).suggested()
    assert 32.0 <= math.degrees(justified.tau) <= 40.0


def test_a_suggestion_names_the_smallest_error_and_all_that_costs_the_same():
    clips = folder(np.linspace(40.0, 60.0, 20), [5.0] * 20, reviewed=1.5)
    suggestion = tau_curve_from_verdicts(clips).suggested(price=1.0)
    assert math.degrees(suggestion.least) == pytest.approx(40.0)
    assert math.degrees(suggestion.low) == pytest.approx(5.0, rel=0.12)
    assert math.degrees(suggestion.high) == pytest.approx(40.0, rel=0.12)
    last = list(common_tau(clips, price=1.0).words())[-1]
    assert numbers(last)[0] == 40.0


def test_few_errors_suggest_nothing_and_more_verdicts_make_it_surer():
    assert tau_curve_from_verdicts(folder([30.0] * 9, [3.0] * 30)).suggested() is None
    rng = np.random.default_rng(2)

    def width(n):
        errors, natural = rng.lognormal(2.3, 0.8, n), rng.lognormal(0.9, 0.6, n)
        s = tau_curve_from_verdicts(folder(errors, natural, clips=n // 4)).suggested(price=0.3)
        return s.high / s.low

    assert np.mean([width(400) for _ in range(6)]) < np.mean([width(40) for _ in range(6)])


def test_a_suggestion_is_the_same_each_time():
    rng = np.random.default_rng(5)
    curve = tau_curve_from_verdicts(folder(rng.uniform(2, 30, 40), rng.uniform(1, 6, 40)))
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


@pytest.mark.thorough
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
    assert "τ" in next(shared.words())


def test_a_chain_with_twists_of_its_own_gets_its_own_tau_and_the_reason():
    rng = np.random.default_rng(4)
    plain = [folder(rng.uniform(2, 60, 40), [], chain=f"c{k}") for k in range(4)]
    noisy = folder(rng.uniform(12, 60, 40), rng.uniform(2.5, 9, 30), chain="LeftForeArm")
    shared = common_tau(together(*plain, noisy))
    assert [c.chain for c in shared.chains if c.apart] == ["LeftForeArm"]
    assert math.degrees(shared.tau("LeftForeArm")) > 6.0
    assert shared.tau("c1") == shared.common.tau
    words = list(shared.words())
    assert numbers(words[0])[-1] == 1
    assert names_in_one_line(words[1], "LeftForeArm", "30 rejected intervals")


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
    assert not any("it ." in words for words in shared.words())


def test_a_chain_set_apart_has_no_share_in_the_common_ones_minutes():
    errors = [3.0] * 10 + [*np.linspace(5.0, 40.0, 30)]
    plain = [folder(errors, [4.0] * 60, chain=f"c{k}") for k in range(4)]
    rng = np.random.default_rng(4)
    noisy = folder(rng.uniform(20, 60, 40), rng.uniform(6, 15, 60), chain="X")
    shared = common_tau(together(*plain, noisy), price=0.09)
    assert [c.chain for c in shared.chains if c.apart] == ["X"]
    assert shared.common.tau == tau_curve_from_verdicts(together(*plain)).suggested(price=0.09).tau


# --- confidence --------------------------------------------------------------------------------


def listed(n, rng, truth, clips=20):
    """Intervals whose chance to be accepted is `truth` of their confidence."""
    c = 1.0 / (1.0 + np.exp(-rng.normal(2.5, 1.5, n)))
    return ConfidenceVerdicts(
        c, rng.random(n) < truth(c), rng.integers(clips, size=n).astype(float)
    )


def test_of_nothing_the_builtin_map_is_kept_and_few_verdicts_move_it_little():
    c = np.array([0.1, 0.5, 0.9, 0.99])
    none = ConfidenceVerdicts(np.zeros(0), np.zeros(0, bool), np.zeros(0))
    np.testing.assert_allclose(fit_confidence_to_verdicts(none).of(c), c)
    one = fit_confidence_to_verdicts(
        ConfidenceVerdicts(np.array([0.9]), np.array([False]), np.zeros(1))
    )
    assert np.abs(one.of(c) - c).max() < 0.5
    assert LearnedConfidence()(None) is None


def test_the_map_is_found_again_and_keeps_the_order():
    truth = LearnedConfidence(-1.0, 0.7)
    given = listed(20_000, np.random.default_rng(0), truth.of)
    found = fit_confidence_to_verdicts(given)
    assert (found.shift, found.scale) == pytest.approx((-1.0, 0.7), abs=0.08)
    assert found.accepted + found.rejected == 20_000
    assert (np.diff(found.of(np.linspace(0.01, 0.99, 50))) > 0).all()
    # A detector that knows nothing is not turned round, whatever a person says.
    against = fit_confidence_to_verdicts(
        ConfidenceVerdicts(given.confidence, given.confidence < 0.9, given.clip)
    )
    assert against.scale > 0


def test_held_out_confidences_see_nothing_of_their_clip():
    rng = np.random.default_rng(0)
    given = listed(400, rng, lambda c: 0.8 * c)
    before = confidence_reliability_by_bin(given.confidence, given.accepted)
    after = confidence_reliability_by_bin(cross_validated_confidence(given), given.accepted)
    assert after.error < 0.5 * before.error
    # The verdicts of one clip turned round: its own confidences are as before.
    odd = given.clip == 7
    other = ConfidenceVerdicts(given.confidence, given.accepted ^ odd, given.clip)
    np.testing.assert_array_equal(
        cross_validated_confidence(other)[odd], cross_validated_confidence(given)[odd]
    )
    assert (
        cross_validated_confidence(other)[~odd] != cross_validated_confidence(given)[~odd]
    ).any()


def test_it_is_said_what_was_held_out():
    rng = np.random.default_rng(0)
    natural = [replace(v, confidence=0.6) for v in folder([], [2.0] * 10, clips=1)[0].verdicts]
    sentences = []
    for clips in (4, 1):
        some = folder(rng.uniform(9, 90, 40), [], clips)
        some[0] = replace(some[0], verdicts=(*some[0].verdicts, *natural))
        sentences.append(learned_profile(some, common_tau(some)).confidence_sentence())
    assert sentences[0] != sentences[1]


def test_what_is_needed_for_a_tau_is_what_is_asked():
    large = folder([30.0] * 12, [], clips=4, chain="L")
    few = folder([], [3.0, 3.0, 3.0], clips=4, chain="X")
    both = together(large, few)
    own = tau_curve_from_verdicts(both, "X")
    assert own.needed == (0, 2)  # the errors of others will do, three verdicts will not
    assert not own.enough
    assert tau_curve_from_verdicts(folder([30.0] * 4, [3.0] * 9)).needed == (6, 0)
    more = together(large, folder([], [3.0] * 5, clips=4, chain="X"))
    assert tau_curve_from_verdicts(more, "X").enough


def test_reliability_counts_bins():
    p = np.array([0.05, 0.95, 0.95, 0.95, 1.0])
    got = confidence_reliability_by_bin(p, np.array([False, True, True, False, True]))
    assert [b.count for b in got.bins] == [1, 4]
    assert got.bins[1].was == pytest.approx(0.75)
    assert got.bins[1].low < 0.75 < got.bins[1].high
    assert got.error == pytest.approx((0.05 + 4 * abs(0.9625 - 0.75)) / 5)
