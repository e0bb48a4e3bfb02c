"""Damaged files end in a motion or a BvhError: never another exception, never a hang."""

import contextlib
import random
import time

import pytest

from benchmarks.bvh_fuzz import SLOW, damaged, outcome
from tests.conftest import ASSETS
from twistcore.bvh import parse_bvh
from twistcore.chain import find_chains
from twistcore.errors import BvhError

SOURCES = [(ASSETS / f"{name}.bvh").read_bytes()[:60_000] for name in ("walk", "dance")]


@pytest.mark.parametrize("seed", range(0, 300, 10))
def test_damaged_files(seed):
    for k in range(seed, seed + 10):
        rng = random.Random(k)
        begun = time.process_time()
        assert outcome(damaged(rng.choice(SOURCES), rng)) in ("motion", "BvhError")
        assert time.process_time() - begun < SLOW


def test_deep_nesting_needs_no_recursion():
    depth = 5000
    joints = "".join(
        f"{'ROOT' if k == 0 else 'JOINT'} j{k}\n{{\nOFFSET 0 1 0\nCHANNELS {3 * (k == 0)} "
        f"{'Xrotation Yrotation Zrotation' if k == 0 else ''}\n"
        for k in range(depth)
    )
    text = f"HIERARCHY\n{joints}{'}' * depth}\nMOTION\nFrames: 1\nFrame Time: .01\n1 2 3\n"
    begun = time.process_time()
    clip = parse_bvh(text.encode())
    find_chains(clip.motion)
    assert len(clip.skeleton) == depth
    assert time.process_time() - begun < SLOW


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"CHANNELS 6", b"CHANNELS 999999999"),
        (b"Frames: 344", b"Frames: " + b"9" * 5000),
        (b"Frames: 344", b"Frames: 1_000"),
        (b"Frames: 344", "Frames: ３".encode()),
        (b"MOTION", b"MOTION" + b" " * 1_000_000 + b"\n" * 100_000),
        (b"HIERARCHY", b"HIERARCHY " + b"x " * 300_000),
        (b"HIERARCHY", b"HIERARCHY" + b"\x00"),
    ],
)
def test_absurd_declarations_cost_neither_time_nor_memory(old, new):
    source = (ASSETS / "walk.bvh").read_bytes()
    assert old in source
    begun = time.process_time()
    with contextlib.suppress(BvhError):
        parse_bvh(source.replace(old, new, 1))
    assert time.process_time() - begun < SLOW


def test_gigantic_frame_counts_are_only_told():
    source = (ASSETS / "walk.bvh").read_bytes().replace(b"Frames: 344", b"Frames: 999999999999999")
    clip = parse_bvh(source)
    assert clip.values.shape == (344, 96)
    assert clip.warnings[0].line is not None
    assert "999999999999999" in str(clip.warnings[0])
