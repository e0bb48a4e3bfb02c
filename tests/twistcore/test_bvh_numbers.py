"""Numbers are read to the last bit, or refused with their place."""

import pickle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples, parametrize
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.bvh.clip import token_spans
from twistcore.formats.bvh.numbers import (
    LARGEST,
    BadNumberError,
    _exact,
    _read_block,
    _spans,
    parse_motion_numbers,
)
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import multiply, quaternion_from_euler, rotate

decimals = st.decimals(-9999, 9999, allow_nan=False, places=6).map(lambda d: f"{d:.6f}")
exponents = st.tuples(decimals, st.sampled_from("eE"), st.integers(-330, 90)).map(
    lambda parts: "{}{}{:+d}".format(*parts)
)
any_plain = st.one_of(
    decimals,
    exponents,
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


@settings(max_examples=examples(150))
@given(st.lists(decimals, min_size=1, max_size=60), st.data())
def test_uniform_decimals_are_exact(tokens, data):
    text = text_of(tokens, data)
    np.testing.assert_array_equal(parse_motion_numbers(text, 0).values, [float(t) for t in tokens])


@settings(max_examples=examples(150))
@given(st.lists(any_plain, min_size=1, max_size=60), st.data())
def test_any_decimals_are_exact(tokens, data):
    text = text_of(tokens, data)
    numbers = parse_motion_numbers(text, 0)
    np.testing.assert_array_equal(numbers.values, [float(t) for t in tokens])
    lines = text.decode().replace("\r\n", "\n\n").replace("\r", "\n").split("\n")
    np.testing.assert_array_equal(numbers.lines, np.cumsum([len(x.split()) for x in lines])[:-1])


def assert_read_as_by_float(text):
    """The numbers to the bit and the line breaks, or the same first token that is none."""
    outcomes = []
    for read in (lambda: parse_motion_numbers(text, 0), lambda: _exact(text, 0, len(text))):
        try:
            numbers = read()
        except BadNumberError as error:
            outcomes.append(error.args)
        else:
            outcomes.append((numbers.values.tobytes(), numbers.lines.tolist()))
    assert outcomes[0] == outcomes[1]


@settings(max_examples=examples(300))
@given(st.binary(max_size=12), st.text("0123456789.-+eE \n\r\t\x0b\x0c\x1c", max_size=60))
def test_any_bytes(odd, text):
    assert_read_as_by_float(b"1.5 " + text.encode() + odd + b"\n2")


def numbers_of_every_length():
    """One of each sign, count of digits before the point and count of decimals."""
    rng = np.random.default_rng(5)
    for sign in ("", "-", "+"):
        for whole in range(10):
            for behind in range(11):
                digits = "".join(map(str, rng.integers(0, 10, whole + behind)))
                if digits:
                    yield f"{sign}{digits[:whole]}.{digits[whole:]}"
                    yield f"{sign}{digits[:whole]}{digits[whole:]}"


@pytest.mark.parametrize("usual", ["1.5", "-23.123456"])
@pytest.mark.parametrize("gap", [" ", "\n", "\r\n", "\t", "  ", "\v"])
def test_numbers_of_every_length_among_usual_ones(usual, gap):
    tokens = [t for odd in numbers_of_every_length() for t in (usual, odd, usual)]
    assert_read_as_by_float(gap.join(tokens).encode())


@parametrize(
    "text",
    [
        b"1.5 -23.123456 7.000001\n0.25 1.125 ",
        b"12.34567812 -1.0 123456.5\t9.9 0.0 0.5 ",
        b"1.500 -23.125\r\n0.250 -0.000 ",
    ],
)
def test_any_byte_anywhere_in_a_usual_number(text):
    for at in range(len(text)):
        for byte in range(256):
            damaged = text[:at] + bytes([byte]) + text[at + 1 :]
            assert_read_as_by_float(damaged + b"1.500 " * 9)


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
        parse_motion_numbers(text, 0)
    at = len(" ".join([*tokens[:place], ""]).encode())
    assert caught.value.offset == at
    assert text[at:].startswith(caught.value.token)


def test_blocks_meet_without_a_seam(monkeypatch):
    monkeypatch.setattr("twistcore.formats.bvh.numbers._BLOCK", 97)
    rng = np.random.default_rng(1)
    for form in ("%.6f", "%.4g"):
        values = rng.normal(0, 60, 5000)
        tokens = [form % v for v in values]
        text = "".join(t + (" ", "\n", " \r\n")[k % 3] for k, t in enumerate(tokens)).encode()
        numbers = parse_motion_numbers(text, 0)
        np.testing.assert_array_equal(numbers.values, [float(t) for t in tokens])


@pytest.mark.parametrize("odd", [b"3", b"+3.5e1", b"1e99"])
def test_line_breaks_are_counted_from_the_start_of_the_text(monkeypatch, odd):
    """In later blocks, too, and where the text goes on behind a header."""
    monkeypatch.setattr("twistcore.formats.bvh.numbers._BLOCK", 31)
    rows = [b"1.25 -7.5 " + odd, b"", b"0.5"] * 9
    head = b"Frame Time: 0.1\n"
    numbers = parse_motion_numbers(head + b"\n".join(rows) + b"\n", len(head))
    assert numbers.lines.tolist() == np.cumsum([len(r.split()) for r in rows]).tolist()
    assert numbers.lines.dtype == np.int64
    by_float = _exact(head + b"\n".join(rows) + b"\n", len(head), len(head) + 500)
    np.testing.assert_array_equal(by_float.lines, numbers.lines)
    np.testing.assert_array_equal(by_float.values, numbers.values)
    part = _exact(b"1.5 2.5\n3.5 4.5\n", 4, 12)
    assert (part.values.tolist(), part.lines.tolist()) == ([2.5, 3.5], [1])


@pytest.mark.parametrize("start", [0, 4000])
@pytest.mark.parametrize(("token", "many"), [("-1.123456 ", 5000), ("1 ", 30000), ("12.5\n", 20)])
def test_room_is_made_for_somewhat_more_numbers_than_there_are(monkeypatch, start, token, many):
    """Guessed from the first of them; where they stand closer later on, room is added."""
    monkeypatch.setattr("twistcore.formats.bvh.numbers._BLOCK", 20000)
    text = b"x" * start + token.encode() * many
    room = parse_motion_numbers(text, start).values.base
    assert many <= room.size <= 1.08 * many + 80
    closer = b"x" * start + b"-1.123456 " * 2000 + b"1 " * 50000
    numbers = parse_motion_numbers(closer, start)
    assert numbers.values.tolist() == [-1.123456] * 2000 + [1.0] * 50000
    assert 52000 <= numbers.values.base.size <= 1.125 * 52000


@pytest.mark.parametrize("gap", [b" ", b"\n", b"\t", b"\r\n"])
def test_blocks_are_as_long_as_wanted_and_end_behind_a_number(monkeypatch, gap):
    monkeypatch.setattr("twistcore.formats.bvh.numbers._BLOCK", 40)
    text = b"head " + gap.join([b"1.5", b"-2.25", b"1234567"] * 30)
    spans = list(_spans(text, 5, len(text)))
    assert (spans[0][0], spans[-1][1]) == (5, len(text))
    for (a, b), (c, _) in pairwise(spans):
        assert b == c
        assert 40 <= b - a <= 40 + 9
        assert text[b - 1 : b] in b" \n\t\r"
    assert list(_spans(text, 5, 30)) == [(5, 30)]
    reported = []
    parse_motion_numbers(text, 5, reported.append)
    assert reported == pytest.approx([(b - 5) / (len(text) - 5) for _, b in spans])


def test_exponents_and_plus_signs_are_read_together_and_only_what_is_left_one_by_one():
    fine = np.frombuffer(b"+3.5e1 1E5\t-2.5e-7\n", dtype=np.uint8)
    found = _read_block(fine)
    assert found.values.tolist() == [35.0, 1e5, -2.5e-7]
    assert found.lines.tolist() == [3]
    for odd in (b"1.5 abc ", b"1e5 1e100 ", b"1e5 1-2 "):
        assert _read_block(np.frombuffer(odd, dtype=np.uint8)) is None


def test_of_no_text_there_are_no_numbers():
    for text, start in ((b"", 0), (b"Frame", 5)):
        numbers = parse_motion_numbers(text, start)
        assert (len(numbers.values), len(numbers.lines)) == (0, 0)
        assert numbers.lines.dtype == np.int64


def test_a_bad_number_keeps_its_place_from_process_to_process():
    with pytest.raises(BadNumberError) as caught:
        parse_motion_numbers(b"1.5 2.5 abc", 0)
    sent = pickle.loads(pickle.dumps(caught.value))
    assert (sent.offset, sent.token) == (8, b"abc")


def test_token_spans_are_those_of_split(monkeypatch):
    monkeypatch.setattr("twistcore.formats.bvh.clip._BLOCK", 13)
    for text in (b"1 2.5\n -3  4\r\n", b"  1 2", b"", b"   ", b"1", b"123456789012345 6 7"):
        starts, ends = token_spans(text, 0)
        assert [text[a:b] for a, b in zip(starts, ends, strict=True)] == text.split()


MIXED = b"""HIERARCHY
ROOT a { OFFSET 1 2 3 CHANNELS 5 Zrotation Xposition Yposition Zposition Xrotation
  JOINT b { OFFSET 0 1 0 CHANNELS 0
    JOINT c { OFFSET 0 1.5 0 CHANNELS 3 Yrotation Xrotation Zrotation } }
  JOINT d { OFFSET 1 0 0 CHANNELS 1 Yrotation } }
ROOT e { OFFSET 0 0 9 CHANNELS 4 Xrotation Yrotation Xrotation Zposition }
MOTION
Frames: 3
Frame Time: .01
1 2 3 4 5.5 -60 70 80.25 9 10 -11 12 13
1 2 3 4 5.5 -60 70 80.25 9 1e1 -11 12 13
+1 2 3 4 5.5 -60 70 80.25 9 10 -11 12 -0
"""


@pytest.mark.parametrize("clip", [read_bvh(ASSETS / "walk.bvh"), parse_bvh(MIXED)])
def test_rotations_are_those_of_the_reference_to_the_bit(clip):
    for joint, layout in enumerate(clip.channels):
        angles = np.radians(clip.values[:, list(layout.rotation)])
        expected = quaternion_from_euler(layout.order, angles)
        np.testing.assert_array_equal(clip.motion.rotations[:, joint], expected)


@pytest.mark.parametrize("clip", [read_bvh(ASSETS / "dance.bvh"), parse_bvh(MIXED)])
def test_kinematics_are_those_of_one_joint_after_another(clip):
    motion = clip.motion
    rotations, positions = forward_kinematics(motion)
    for joint, parent in enumerate(motion.skeleton.parents):
        q, p = motion.rotations[:, joint], motion.translation(joint)
        if parent >= 0:
            q = multiply(rotations[:, parent], q)
            p = positions[:, parent] + rotate(rotations[:, parent], p)
        np.testing.assert_allclose(rotations[:, joint], q, atol=1e-12)
        np.testing.assert_allclose(positions[:, joint], np.broadcast_to(p, q[:, :3].shape), 1e-12)
