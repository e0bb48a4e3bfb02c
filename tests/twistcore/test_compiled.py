"""Compiled loops give the bits of the numpy code, and nobody depends on them."""

import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.twistcore.test_bvh_numbers import any_plain, decimals, text_of
from twistcore import compiled
from twistcore.bvh import euler_branch, parse_bvh, patched, read_bvh
from twistcore.bvh.numbers import BadNumberError, read_numbers
from twistcore.errors import BvhError
from twistcore.motion import forward_kinematics


@contextmanager
def with_loops(loops):
    """The process as it is with these loops, or before warm() with None."""
    before = compiled._loops, compiled._tried
    compiled._loops, compiled._tried = loops, True
    try:
        yield
    finally:
        compiled._loops, compiled._tried = before


@pytest.fixture(scope="module")
def both():
    """A function that runs another both ways."""
    assert compiled.warm()
    loops = compiled.loops()

    def run(function):
        with with_loops(loops):
            fast = function()
        with with_loops(None):
            return fast, function()

    return run


def bits(values):
    return np.ascontiguousarray(values).view(np.uint64)


def read(text):
    try:
        numbers = read_numbers(text, 0)
    except BadNumberError as error:
        return error.offset, error.token
    return bits(numbers.values), numbers.lines


def assert_same(one, other):
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a, b)


exponents = st.tuples(decimals, st.sampled_from("eE"), st.integers(-330, 310)).map(
    lambda parts: "{}{}{:+d}".format(*parts)
)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.one_of(decimals, any_plain, exponents), min_size=1, max_size=60), st.data())
def test_numbers(both, tokens, data):
    text = text_of(tokens, data)
    fast, slow = both(lambda: read(text))
    assert_same(fast, slow)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=12), st.text("0123456789.-+eE \n\r\t\x0b\x0c\x1c", max_size=60))
def test_any_bytes(both, odd, text):
    text = b"1.5 " + text.encode() + odd + b"\n2"
    fast, slow = both(lambda: read(text))
    assert_same(fast, slow)


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
def test_numbers_of_every_length_among_usual_ones(both, usual, gap):
    tokens = [t for odd in numbers_of_every_length() for t in (usual, odd, usual)]
    fast, slow = both(lambda: read(gap.join(tokens).encode()))
    assert_same(fast, slow)
    np.testing.assert_array_equal(fast[0], bits(np.array([float(t) for t in tokens])))


def test_any_byte_anywhere_in_a_usual_number(both):
    texts = (b"1.5 -23.123456 7.000001\n0.25 1.125 ", b"12.34567812 -1.0 123456.5\t9.9 0.0 0.5 ")
    damaged = [
        text[:at] + bytes([byte]) + text[at + 1 :] + b"1.5 " * 9
        for text in texts
        for at in range(len(text))
        for byte in range(256)
    ]
    for fast, slow in zip(*both(lambda: [read(text) for text in damaged]), strict=True):
        assert_same(fast, slow)


@pytest.mark.parametrize("name", ["walk", "dance", "basketball"])
def test_motion_and_kinematics_of_a_clip(both, name):
    def run():
        motion = read_bvh(ASSETS / f"{name}.bvh").motion
        return [bits(a) for a in (motion.rotations, motion.positions, *forward_kinematics(motion))]

    assert_same(*both(run))


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


def test_joints_with_any_number_of_channels(both):
    def run():
        motion = parse_bvh(MIXED).motion
        return [bits(a) for a in (motion.rotations, motion.positions, *forward_kinematics(motion))]

    assert_same(*both(run))


@pytest.mark.parametrize("damage", [b"nan", b"1.2.3", b"1e999", b"\x00", b"1 2", b""])
def test_the_message_is_the_same(both, damage):
    data = MIXED.replace(b"80.25", damage, 2).replace(damage, b"80.25", 1)

    def run():
        with pytest.raises(BvhError) as caught:
            parse_bvh(data, "x.bvh")
        return [str(caught.value)]

    assert_same(*both(run))


def test_written_bytes(both):
    rng = np.random.default_rng(3)
    data = (ASSETS / "walk.bvh").read_bytes()
    head, sep, rows = data.partition(b"Frame Time")
    # Every spacing and form that a token may have.
    rows = rows.replace(b" -", b"\t -").replace(b"1 ", b"1e0 ", 500)
    clip = parse_bvh(head + sep + rows)
    changed = rng.random(clip.motion.rotations.shape[:2]) < 0.05
    changed &= clip.skeleton.rotatable
    rotations = np.where(changed[..., None], np.roll(clip.motion.rotations, 7, 0), 0.0)
    motion = clip.motion.with_rotations(rotations + ~changed[..., None] * clip.motion.rotations)
    fast, slow = both(lambda: patched(clip, motion, changed).data)
    assert fast == slow
    assert fast != clip.data


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 40), st.booleans(), st.booleans(), st.integers(0, 2**32))
def test_the_path_of_euler_angles(both, n, with_before, with_after, seed):
    rng = np.random.default_rng(seed)
    solutions = rng.uniform(-4.0, 4.0, (n, 2, 3))
    edges = [rng.uniform(-4.0, 4.0, 3) if given else None for given in (with_before, with_after)]
    assert_same(*both(lambda: [euler_branch._cheapest_path(solutions, *edges)]))


def test_a_process_that_reads_little_never_imports_numba():
    code = (
        "import sys; from twistcore.bvh import read_bvh; from twistcore.compiled import loops\n"
        f"read_bvh({str(ASSETS / 'walk.bvh')!r}).motion\n"
        "sys.exit('numba' in sys.modules or loops() is not None)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_reading_much_begins_the_compiled_loops(monkeypatch):
    monkeypatch.setattr(compiled, "_loops", None)
    monkeypatch.setattr(compiled, "_tried", False)
    monkeypatch.setattr(compiled, "_read", 0)
    data = (ASSETS / "walk.bvh").read_bytes()
    monkeypatch.setattr(compiled, "BREAK_EVEN", 1.5 * len(data))
    for _ in range(2):
        parse_bvh(data)
        assert compiled.loops() is None
    parse_bvh(data)
    assert compiled.loops() is not None


def test_without_numba_reading_goes_on(monkeypatch):
    monkeypatch.setattr(compiled, "_loops", None)
    monkeypatch.setattr(compiled, "_tried", False)
    monkeypatch.setitem(sys.modules, "numba", None)  # as if it were not installed
    assert not compiled.warm()
    assert len(parse_bvh(MIXED).values) == 3


def test_a_cache_that_cannot_be_written_costs_time_only(tmp_path):
    """Neither the folder of the source nor the person's own takes the cache."""
    blocker = tmp_path / "file"
    blocker.write_text("")
    code = (
        "import numba.core.caching as c\n"
        "c.CacheImpl._locator_classes = [c.UserProvidedCacheLocator]\n"
        "from twistcore.compiled import warm\n"
        "import sys; sys.exit(not warm())"
    )
    env = {"NUMBA_CACHE_DIR": str(blocker / "below"), "PATH": ""}
    done = subprocess.run([sys.executable, "-c", code], env=env, check=False)
    assert done.returncode == 0
