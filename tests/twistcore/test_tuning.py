"""τ from noise and injected errors, and the profile that keeps it."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.cli import main
from twistcore.errors import FormatError
from twistcore.tuning import TauCurve, Tuned, read_profile, tuned, write_profile


def curve(repaired, alarms, noise=(0.01,)):
    tau = np.radians(np.arange(1.0, len(repaired) + 1))
    return TauCurve(tau, np.array(repaired, float), 1000, np.array(alarms, float), 2.0, noise)


def test_fewest_alarms_come_first_then_success_then_the_larger_tau():
    c = curve([1000, 999, 999, 998, 500], [3, 1, 0, 0, 0])
    assert np.degrees(c.suggested()) == pytest.approx(4.0)
    assert tuned(c).fsr == pytest.approx(99.8)
    assert tuned(c).alarms_per_minute == 0.0


def test_never_below_the_clips_own_noise():
    c = curve([1000, 900, 100, 0, 0], [0] * 5, noise=tuple(np.radians([2.5, 2.6, 9.0])))
    assert np.degrees(c.suggested()) == pytest.approx(3.0)
    assert np.degrees(curve([1], [0], noise=(0.5,)).suggested()) == pytest.approx(np.degrees(0.5))


def test_curves_of_clips_add():
    both = curve([10, 5], [1, 0]) + curve([20, 5], [2, 0])
    assert both.errors == 2000
    assert both.minutes == 4.0
    np.testing.assert_allclose(both.fsr, [0.015, 0.005])
    np.testing.assert_allclose(both.alarms_per_minute, [0.75, 0.0])


def test_a_profile_comes_back(tmp_path):
    path = tmp_path / "p.toml"
    names = {'odd "name" #2': Tuned(4.5, 0.1, 99.0, 0.0), "LeftArm": Tuned(1.5, 0.2, 98.0, 0.1)}
    write_profile(path, names, "clips", "paper")
    assert {k: np.degrees(v) for k, v in read_profile(path).items()} == pytest.approx(
        {'odd "name" #2': 4.5, "LeftArm": 1.5}
    )


@pytest.mark.parametrize(
    "text", ["[LeftArm]\ntau_deg = 0\n", "[LeftArm]\nx = 1\n", "LeftArm = 3", "["]
)
def test_a_damaged_profile_is_one_sentence(tmp_path, text):
    path = tmp_path / "p.toml"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read_profile(path)
    assert "\n" not in str(caught.value)


def test_the_command_writes_a_profile_that_detect_takes(tmp_path, capsys):
    out = tmp_path / "p.toml"
    words = ["tune", str(ASSETS / "walk.bvh"), "-o", str(out), "--seeds", "1", "--workers", "1"]
    assert main([*words, "--method", "paper"]) == 0
    assert len(read_profile(out)) == 10
    assert main(["detect", str(ASSETS / "walk.bvh"), "--profile", str(out)]) == 0
    assert "LeftForeArm" in capsys.readouterr().out
    assert main(["tune", str(tmp_path), "-o", str(out)]) == 2
