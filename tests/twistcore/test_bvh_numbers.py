"""Numbers are read to the last bit, or refused with their place."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from twistcore.bvh import read_bvh
from twistcore.bvh.clip import token_spans
from twistcore.bvh.numbers import LARGEST, BadNumberError, read_numbers
from twistcore.rotation import quaternion_from_euler

decimals = st.decimals(-9999, 9999, allow_nan=False, places=6).map(lambda d: f"{d:.6f}")
any_plain = st.one_of(
    decimals,
    st.integers(-(10**17), 10**17).map(str),
    st.floats(-LARGEST, LARGEST, exclude_min=True, exclude_max=True).map(repr),
    st.floats(-180, 180).map(lambda v: f"{v:.4f}"),
    st.sampled_from(
        ["0", "-0", "-0.000000", ".5", "-.25", "5.", "+3.5", "1e5", "2E-07", "00012.5"]
    ),
)
gaps = st.sampled_from([" ", "\n", "\r\n", "\t", "  ", " \n", "\r"])


def text_of(tokens, draw):
    return "".join(t + draw.draw(gaps) for t in tokens).encode()


@settings(max_examples=150, deadline=None)
@given(st.lists(decimals, min_size=1, max_size=60), st.data())
def test_uniform_decimals_are_exact(tokens, data):
    text = text_of(tokens, data)
    np.testing.assert_array_equal(read_numbers(text, 0).values, [float(t) for t in tokens])


@settings(max_examples=150, deadline=None)
@given(st.lists(any_plain, min_size=1, max_size=60), st.data())
def test_any_decimals_are_exact(tokens, data):
    text = text_of(tokens, data)
    numbers = read_numbers(text, 0)
    np.testing.assert_array_equal(numbers.values, [float(t) for t in tokens])
    lines = text.decode().replace("\r\n", "\n\n").replace("\r", "\n").split("\n")
    np.testing.assert_array_equal(numbers.lines, np.cumsum([len(x.split()) for x in lines])[:-1])


@pytest.mark.parametrize(
    "token",
    ["nan", "inf", "-Infinity", "1_000", "0x10", "１", "1.2.3", "1-2", "--1", "-", "+", ".", "-.",
     "1e", "e5", "1e5.0", "1e999", "1e100", "4,0", "1\x002", "\x01", "\xa0", "1d5", "1f"],
)  # fmt: skip
@pytest.mark.parametrize("place", [0, 7, 500])
@pytest.mark.parametrize("usual", ["1.250000", "1.25 3"])
def test_what_is_no_number_is_named_with_its_place(token, place, usual):
    tokens = [usual] * 600
    tokens[place] = token
    text = " ".join(tokens).encode()
    with pytest.raises(BadNumberError) as caught:
        read_numbers(text, 0)
    at = len(" ".join([*tokens[:place], ""]).encode())
    assert caught.value.offset == at
    assert text[at:].startswith(caught.value.token)


def test_blocks_meet_without_a_seam(monkeypatch):
    monkeypatch.setattr("twistcore.bvh.numbers._BLOCK", 97)
    rng = np.random.default_rng(1)
    for form in ("%.6f", "%.4g"):
        values = rng.normal(0, 60, 5000)
        tokens = [form % v for v in values]
        text = "".join(t + (" ", "\n", " \r\n")[k % 3] for k, t in enumerate(tokens)).encode()
        numbers = read_numbers(text, 0)
        np.testing.assert_array_equal(numbers.values, [float(t) for t in tokens])


def test_token_spans_are_those_of_split(monkeypatch):
    monkeypatch.setattr("twistcore.bvh.clip._BLOCK", 13)
    for text in (b"1 2.5\n -3  4\r\n", b"  1 2", b"", b"   ", b"1", b"123456789012345 6 7"):
        starts, ends = token_spans(text, 0)
        assert [text[a:b] for a, b in zip(starts, ends, strict=True)] == text.split()


def test_rotations_are_those_of_the_reference_to_the_bit():
    clip = read_bvh(ASSETS / "walk.bvh")
    for joint, layout in enumerate(clip.channels):
        angles = np.radians(clip.values[:, list(layout.rotation)])
        expected = quaternion_from_euler(layout.order, angles)
        np.testing.assert_array_equal(clip.motion.rotations[:, joint], expected)
