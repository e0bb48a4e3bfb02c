"""A share of the trials of clips; the whole is `python -m tests.fuzz bvh amc npz poses`."""

import pytest

from tests.fuzz.clip_kinds import KINDS
from tests.fuzz.trial import READ, REFUSED, trial

NUMBER = 100


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_damaged_clips_are_read_and_written_or_refused_in_a_sentence(kind):
    report = trial(kind, NUMBER, seed=0)
    assert not report.failures, report.failures[0].told
    assert report.counts[READ] > NUMBER / 5
    assert report.counts[REFUSED] > NUMBER / 20
