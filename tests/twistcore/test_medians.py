"""Our medians and quantiles are numpy's, to the last bit."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.ndimage import median_filter

from twistcore.skeleton import medians as medians_module
from twistcore.skeleton.medians import (
    median,
    medians,
    pad_with_edge_values,
    quantile,
    quantiles,
    running_medians,
)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 9, 10, 101, 1000])
def test_medians_and_quantiles_are_those_of_numpy(count):
    rng = np.random.default_rng(count)
    values = rng.normal(size=(3, count)).round(1)  # equal ones too
    assert median(values[0]) == np.median(values[0])
    assert median(values) == np.median(values)
    np.testing.assert_array_equal(medians(values), np.median(values, axis=1))
    np.testing.assert_array_equal(medians(values.T, 0), np.median(values, axis=1))
    for share in (0.0, 0.01, 0.15, 0.5, 0.75, 0.99, 1.0, *rng.random(20)):
        assert quantile(values[1], share) == np.quantile(values[1], share)
        np.testing.assert_array_equal(quantiles(values, share), np.quantile(values, share, axis=1))


def test_they_change_nothing_and_load_no_masked_arrays():
    values = np.array([3.0, 1.0, 2.0])
    assert (median(values), quantile(values, 0.25)) == (2.0, 1.5)
    assert values.tolist() == [3.0, 1.0, 2.0]
    code = "import sys; from twistcore.skeleton.medians import *; median([1.0, 2.0]); "
    code += "quantile([1.0], 0.5); sys.exit('numpy.ma' in sys.modules)"
    program = [sys.executable, "-c", code]
    assert subprocess.run(program, check=False).returncode == 0


@pytest.mark.parametrize("values", [np.arange(5.0), np.array([True]), np.array([3, -1])])
def test_a_signal_is_extended_by_its_outermost_values(values):
    longer = pad_with_edge_values(values, 2, 3)
    np.testing.assert_array_equal(longer, np.pad(values, (2, 3), mode="edge"))
    assert longer.dtype == values.dtype


@pytest.mark.parametrize("width", [1, 2, 21, 36])
@pytest.mark.parametrize("count", [1, 20, 36, 400])
def test_running_medians_are_those_of_scipy(monkeypatch, width, count):
    values = np.random.default_rng(count).normal(size=count).round(1)
    expected = median_filter(values, width, mode="nearest")
    np.testing.assert_array_equal(running_medians(values, width), expected)
    monkeypatch.setattr(medians_module, "_BLOCK", 100)  # several blocks
    np.testing.assert_array_equal(running_medians(values, width), expected)


def test_noise_is_measured_without_loading_scipy():
    code = (
        "import sys, numpy as np; from twistcore.detection.noise_bursts import joint_noise_level; "
    )
    code += "angles = np.random.default_rng(0).normal(0.0, 12.0, (300, 3)); angles[:200] *= 0.01; "
    code += "assert joint_noise_level(np.diff(angles, axis=0), 30.0).any(); "
    code += "sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
