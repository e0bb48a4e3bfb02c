"""Some damaged files of every kind; `python -m tests.fuzz all --number 10000` tries many."""

from tests.fuzz.trial import FAILED, Report, kinds, tried
from tests.tiers import examples, parametrize

NUMBER, SEED = examples(60), 2026


@parametrize("kind", kinds().values(), quick=3, ids=lambda kind: kind.name)
def test_damaged_files_are_read_or_refused_in_a_sentence(kind, tmp_path):
    report = Report(kind.name, SEED)
    for case in range(NUMBER):
        folder = tmp_path / str(case)
        folder.mkdir()
        report.add(tried(kind, SEED, case, folder))
    assert not report.failures, "\n".join(f"{one.case}: {one.told}" for one in report.failures)
    assert not set(FAILED) & report.counts.keys()
    assert report.counts["refused"] or kind.name == "settings"  # which are never refused
    assert report.counts["read"]
