"""Long work says how far it is, never backwards, and ends where nobody wants it any more."""

from itertools import pairwise

import pytest

from twistcore.detection import DETECTORS
from twistcore.formats.bvh import parse_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.signals import signals_of_chains, twist_signals
from twistcore.work.progress import Cancelled, stage_progress


def work_on(clip, name):
    """How to do something with a clip that takes a `tell`."""
    chains = find_chains(clip.motion)
    return {
        "read": lambda tell: parse_bvh(clip.data, tell=tell),
        "signals": lambda tell: signals_of_chains(clip.motion, chains, tell),
        **{m: lambda tell, m=m: DETECTORS[m].analyse(clip.motion, chains, tell) for m in DETECTORS},
    }[name]


WORK = ["read", "signals", *DETECTORS]


@pytest.mark.parametrize("name", WORK)
def test_it_is_told_how_far_work_is(dirty_walk, name):
    reported = []
    work_on(dirty_walk, name)(reported.append)
    assert reported
    assert reported[0] >= 0.0
    assert reported[-1] <= 1.0
    assert all(a <= b for a, b in pairwise(reported))


@pytest.mark.parametrize("name", WORK)
def test_work_ends_where_it_is_cancelled(dirty_walk, name):
    reported = []
    work = work_on(dirty_walk, name)
    work(reported.append)
    for last in {0, len(reported) // 2, len(reported) - 1}:
        left = iter(range(last))

        def tell(share, left=left):
            if next(left, None) is None:
                raise Cancelled

        with pytest.raises(Cancelled):
            work(tell)
        assert next(left, None) is None


def test_a_part_tells_its_share_of_the_whole():
    reported = []
    stage = stage_progress(reported.append, 0.2, 0.6)
    for share in (0.0, 0.5, 1.0):
        stage(share)
    assert reported == pytest.approx([0.2, 0.4, 0.6])


def test_who_deals_with_errors_does_not_swallow_it():
    assert not issubclass(Cancelled, Exception)


def test_signals_of_chains_are_those_of_each(walk):
    chains = find_chains(walk.motion)
    found = signals_of_chains(walk.motion, chains)
    assert list(found) == [c.name for c in chains]
    assert (found[chains[3].name].theta_c == twist_signals(walk.motion, chains[3]).theta_c).all()
