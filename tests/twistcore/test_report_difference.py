"""Two versions of a report: errors are recognised by chain, kind and frames, not by their ids."""

import json
from dataclasses import replace

import pytest

from tests.twistcore.reviews import CHAINS, CLIP, fresh
from twistcore.cli import main
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.review import Decide, Decision
from twistcore.review.replay import accepted_motion


def written(folder, state):
    report = Report(CLIP, CHAINS, state, accepted_motion(CLIP, CHAINS, state), "walk")
    return str(write_clip_report(folder, report)[-1])


@pytest.fixture
def reports(tmp_path):
    """The second one has other ids: one error is gone, one new, one accepted, and one longer."""
    state = fresh().state
    first, second, third, *others = state.intervals
    new = replace(first, id=99, interval=new_constant_offset_interval("LeftForeArm", 2, 5, 0.5))
    long = third.interval
    longer = new_constant_offset_interval(long.chain, long.start - 1, long.stop + 1, long.delta)
    later = [
        replace(j, id=k)
        for k, j in enumerate([new, second, replace(third, interval=longer), *others], start=50)
    ]
    after = state.with_intervals(later, 100)
    after = Decide((51,), Decision.ACCEPTED, "Kim", "2026-01-02T10:00:00+00:00").apply(after)
    return written(tmp_path / "a", state), written(tmp_path / "b", after), (first, second)


def test_new_gone_and_differently_decided_errors_are_listed(reports, capsys):
    a, b, (first, second) = reports
    capsys.readouterr()
    assert main(["diff", a, b, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    shown = {one["change"]: one for one in found["changes"]}
    assert set(shown) == {"new", "gone", "decided differently"}
    assert len(found["changes"]) == 3
    assert (shown["new"]["start"], shown["new"]["before"]) == (2, None)
    assert (shown["gone"]["start"], shown["gone"]["after"]) == (first.interval.start, None)
    assert shown["decided differently"]["start"] == second.interval.start
    both = shown["decided differently"]["before"], shown["decided differently"]["after"]
    assert both == ("undecided", "accepted")
    assert found["same"] == len(fresh().state.intervals) - 2
    assert main(["diff", a, b]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert any("undecided → accepted" in line for line in lines)
    assert lines[-1].startswith("3 differences")
    assert main(["diff", a, a]) == 0
    assert capsys.readouterr().out.startswith("0 differences")


def test_reports_cannot_be_merged(reports, tmp_path, capsys):
    a, b, _ = reports
    capsys.readouterr()
    assert main(["diff", a, b, "--merge", str(tmp_path / "both.twist.json")]) == 2
    assert "--merge needs two sessions" in capsys.readouterr().err


REPORT = b'{"schema": "twistcore.report/1"'


@pytest.mark.parametrize(
    "damage", [b"{}", b"[1]", b"{", REPORT + b"}", REPORT + b', "intervals": [{}]}']
)
def test_what_is_not_a_report_is_refused_in_a_line(reports, tmp_path, capsys, damage):
    a, _, _ = reports
    (tmp_path / "other.json").write_bytes(damage)
    capsys.readouterr()
    assert main(["diff", a, str(tmp_path / "other.json")]) == 2
    shown = capsys.readouterr().err
    assert len(shown.splitlines()) == 1
    assert "is not the JSON of a clip's report" in shown
