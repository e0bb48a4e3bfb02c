"""Two blind judges: their agreement, what they say together, and how reliable confidence is."""

import csv
import shutil

import pytest

from benchmarks.atlas import VERDICTS
from benchmarks.atlas import main as atlas
from benchmarks.blind_verdicts import agreed, judged, main, reliability
from tests.conftest import ASSETS
from twistcore.tuning.learned_confidence import expected_calibration_error

E, D, A = VERDICTS


def test_where_two_differ_it_is_doubtful():
    assert (agreed(E, E), agreed(A, A), agreed(E, A), agreed(D, A)) == (E, A, D, D)


def test_reliability_compares_confidence_with_the_share_of_errors():
    rows = [{"confidence": "0.9", "verdict": E}] * 9 + [{"confidence": "0.9", "verdict": A}]
    rows += [{"confidence": "0.2", "verdict": A}] * 10 + [{"confidence": "0.5", "verdict": D}] * 5
    bins = reliability(rows, 2)
    assert [(b.count, b.was) for b in bins] == [(10, 0.0), (10, 0.9)]
    assert expected_calibration_error(bins) == pytest.approx(0.1)
    assert all(b.low <= b.was <= b.high for b in bins)
    assert expected_calibration_error([]) == 0.0


@pytest.fixture
def sheets(tmp_path):
    """Blind pictures of a clip with errors, judged by two."""
    (tmp_path / "clips" / "good").mkdir(parents=True)
    shutil.copy(ASSETS / "kick.bvh", tmp_path / "clips" / "good")
    blind = tmp_path / "blind"
    atlas([str(tmp_path / "clips"), "--workers", "1", "--blind", str(blind), "--most", "4"])
    return blind


def _say(blind, name, verdicts):
    with (blind / name).open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("number", "verdict", "why"))
        writer.writerows((n, v, "") for n, v in enumerate(verdicts))


def test_judges_see_numbers_and_the_key_tells_the_rest(sheets, capsys, tmp_path):
    assert len(list(sheets.glob("*.png"))) == 4
    assert {p.stem for p in sheets.glob("*.png")} == {"000", "001", "002", "003"}
    _say(sheets, "first.csv", (E, E, A, D))
    _say(sheets, "second.csv", (E, A, A, D))
    assert [r["verdict"] for r in judged(sheets)] == [E, D, A, D]
    out = tmp_path / "verdicts.csv"
    capsys.readouterr()
    assert main([str(sheets), "--csv", str(out), "--figure", str(tmp_path / "r.png")]) == 0
    assert "4 judged by both, 3 equal" in capsys.readouterr().out
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [r["verdict"] for r in rows] == [E, D, A, D]
    assert {r["set"] for r in rows} == {"good"}


@pytest.mark.thorough
def test_a_word_that_is_no_verdict_is_named(sheets):
    _say(sheets, "first.csv", (E, E, "wrong", E))
    _say(sheets, "second.csv", (E, E, E, E))
    with pytest.raises(ValueError, match=r"first\.csv, number 2"):
        judged(sheets)
