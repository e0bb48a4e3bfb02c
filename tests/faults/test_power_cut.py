"""A journal and a session cut at any byte, or with what a disk leaves behind a cut: zeros, rubbish.

Some places here; `python -m benchmarks.power_cuts` takes every byte.
"""

import os
import random
import stat
from contextlib import closing

import pytest

from benchmarks.power_cuts import cut_journal, cut_session, made_journal
from tests.twistcore.reviews import CLIP, fresh
from twistcore.review import Decide, Decision, Journal


@pytest.fixture(scope="module")
def journal(tmp_path_factory):
    return made_journal(tmp_path_factory.mktemp("journal"), seed=1)


@pytest.mark.thorough
def test_a_journal_cut_at_some_bytes(journal, tmp_path):
    whole = journal.data
    lines = [k + 1 for k, byte in enumerate(whole) if byte == 10]
    places = {0, 1, len(whole), *lines, *(k - 1 for k in lines)}
    places |= set(random.Random(0).sample(range(len(whole)), 60))
    assert cut_journal(journal, sorted(places), tmp_path) == len(places) * 4


@pytest.mark.thorough
def test_a_session_cut_at_some_bytes(tmp_path):
    assert cut_session(tmp_path, step=211) > 50


def test_an_entry_is_on_the_disk_before_the_next_and_the_name_before_the_first(
    tmp_path, monkeypatch
):
    synced = []
    real = os.fsync

    def note(handle):
        synced.append((stat.S_IFMT(os.fstat(handle).st_mode), os.fstat(handle).st_size))
        real(handle)

    monkeypatch.setattr("os.fsync", note)
    path = tmp_path / "j"
    with closing(Journal(path, CLIP, fresh().state)) as journal:
        first, folder = synced
        assert first == (stat.S_IFREG, path.stat().st_size)
        assert folder[0] == stat.S_IFDIR or os.name != "posix"
        for judged in fresh().state.intervals[:3]:
            synced.clear()
            journal.do(Decide((judged.id,), Decision.ACCEPTED))
            assert synced == [(stat.S_IFREG, path.stat().st_size)]
