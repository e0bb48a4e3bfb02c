"""Clips made to cost much time or memory are read, or refused, for what their size allows."""

import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from tests.twistcore import amc_files
from tests.twistcore.processor_time import compared, grown
from twistcore.errors import AmcError, BvhError, TwistError
from twistcore.formats.amc import parse_amc, parse_asf
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.formats.clip import Clip, create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs

XYZ = "Xrotation Yrotation Zrotation"


def bvh(inside, rows="1 2 3\n", *, seconds="0.01", frames=1):
    head = f"HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS 3 {XYZ}\n{inside}\n}}\n"
    return f"{head}MOTION\nFrames: {frames}\nFrame Time: {seconds}\n{rows}".encode()


def joint(name, inside=""):
    return f"JOINT {name}\n{{\nOFFSET 0 1 0\n{inside}\n}}\n"


# By what it is: how it is made of a size, and the size.
HOSTILE = {
    "many OFFSETs": (lambda n: bvh("OFFSET 1 2 3\n" * n), 20_000),
    "many CHANNELS": (lambda n: bvh("CHANNELS 1 Xposition\n" * n, "1 " * (n + 3)), 20_000),
    "one number a line": (
        lambda n: bvh("CHANNELS 1 Xposition\n" * n, "1\n" * (n + 3) + "1 1\n"),
        20_000,
    ),
    "many End Sites": (lambda n: bvh("End Site\n{\nOFFSET 0 1 0\n}\n" * n), 20_000),
    "one name": (
        lambda n: bvh(joint("a") * n + "".join(joint(f"a #{k}") for k in range(n))),
        5_000,
    ),
    "names of many words": (lambda n: bvh(joint("a " * n) * 4), 30_000),
    "one line": (
        lambda n: bvh((joint("a") * n).replace("\n", " ").replace("JOINT a", "JOINT a\n")),
        5_000,
    ),
    "empty lines": (lambda n: bvh("\n" * n, "\n" * n + "1 2 3" + "\n" * n), 1_000_000),
    "a long Frame Time": (lambda n: bvh("", seconds="9" * n + "x"), 300_000),
    "a long number": (lambda n: bvh("", "1 2 " + "9" * n + "x"), 300_000),
    "a long OFFSET": (lambda n: bvh("OFFSET 1 2 " + "9" * n + "x"), 300_000),
    "a long block": (lambda n: bvh("", "1 2 0." + "3" * n), 3_000_000),
    "many chains": (lambda n: bvh(joint("a", joint("b", joint("c", joint("d")))) * n), 2_000),
    "many positions": (
        lambda n: bvh(joint("a", "CHANNELS 1 Xposition") * n, " ".join("1" * (n + 3))),
        5_000,
    ),
}


def read_found_and_written(data):
    """What becomes of a clip: its chains and limbs are looked for, and it is written."""
    clip = parse_bvh(data)
    find_limbs(clip.motion, find_chains(clip.motion))
    bvh_text(clip.motion)
    return clip


@parametrize("what", HOSTILE, quick=3)
def test_time_grows_with_the_size_of_a_bvh_not_with_its_square(what):
    make, size = HOSTILE[what]
    found = grown(make, read_found_and_written, size)
    if isinstance(found, TwistError):
        assert isinstance(found, BvhError)
        assert what in ("one number a line", "a long number", "a long OFFSET")
    else:
        assert len(found.warnings) < 50


def test_of_thousands_of_warnings_the_first_are_shown_and_the_rest_counted():
    clip = parse_bvh(bvh("OFFSET 1 2 3\n" * 1000))
    assert "second OFFSET" in str(clip.warnings[0])
    assert clip.warnings[0].line == 6
    assert clip.warnings[39].line == 45
    assert str(clip.warnings[40]) == "960 more warnings are not shown."


@pytest.mark.thorough
def test_a_nested_figure_is_written_for_its_joints_not_for_the_square_of_their_depth():
    depth = 3000
    inside = "".join(f"JOINT j{k}\n{{\nOFFSET 0 1 0\n" for k in range(depth)) + "}" * depth
    text = bvh_text(parse_bvh(bvh(inside)).motion)
    assert len(text) < 4000 * depth
    assert len(parse_bvh(text.encode()).skeleton) == depth + 1


def test_numbers_with_exponents_are_rewritten_in_one_go():
    """60,000 numbers on the best branch; their exponents once took hours."""

    def turned(rows):
        clip = parse_bvh(bvh("", "1.5e+0 2.5E1 35e-1\n" * rows, frames=rows))
        q = clip.motion.rotations[::-1] * [1.0, -1.0, 1.0, 1.0]
        return clip, clip.motion.with_rotations(q)

    rows = 20_000
    patch = grown(turned, lambda made: create_file_patch_for_motion(*made), rows)
    assert parse_bvh(patch.data).frames == rows


def test_a_pose_of_every_joint_in_every_frame_is_not_made_of_next_to_no_numbers():
    """120 kB of text ask for 3.5 GB."""
    joints, frames = 2_000, 20_000
    with pytest.raises(BvhError, match=r"20000 frames of 2001 joints"):
        parse_bvh(bvh(joint("a") * joints, "1 2 3\n" * frames, frames=frames))
    with pytest.raises(AmcError, match="20000 frames of"):
        parse_amc(b"1\nroot 0\n" * frames, parse_asf(many_bones(joints)))


def nested(depth):
    joints = "".join(
        f"{'ROOT' if k == 0 else 'JOINT'} j{k}\n{{\nOFFSET 0 1 0\nCHANNELS {3 * (k == 0)} "
        f"{'Xrotation Yrotation Zrotation' if k == 0 else ''}\n"
        for k in range(depth)
    )
    text = f"HIERARCHY\n{joints}{'}' * depth}\nMOTION\nFrames: 1\nFrame Time: .01\n1 2 3\n"
    return text.encode()


def test_deep_nesting_needs_no_recursion():
    def read(data):
        clip = parse_bvh(data)
        find_chains(clip.motion)
        return clip

    assert len(grown(nested, read, 5000).skeleton) == 5000


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
    absurd = source.replace(old, new, 1)
    clip = compared(lambda: parse_bvh(absurd), lambda: parse_bvh(source), most=100.0)
    assert isinstance(clip, Clip | BvhError)


def test_gigantic_frame_counts_are_only_told():
    source = (ASSETS / "walk.bvh").read_bytes().replace(b"Frames: 344", b"Frames: 999999999999999")
    clip = parse_bvh(source)
    assert clip.values.shape == (344, 96)
    assert clip.warnings[0].line is not None
    assert "999999999999999" in str(clip.warnings[0])


# -- AMC and ASF -----------------------------------------------------------------------------------


def many_bones(count, extra=b""):
    bones = b"".join(
        b"begin\nname b%d\ndirection 0 1 0\nlength 1\n%b\nend\n" % (k, extra) for k in range(count)
    )
    names = b" ".join(b"b%d" % k for k in range(count))
    return b":root\norder TX\naxis XYZ\n:bonedata\n%b:hierarchy\nbegin\nroot %b\nend\n" % (
        bones,
        names,
    )


@pytest.mark.thorough
def test_time_grows_with_the_size_of_a_skeleton_and_an_amc_not_with_its_square():
    asf = grown(lambda n: many_bones(n, b"odd 1"), parse_asf, 10_000)
    assert len(asf.skeleton) == 10_001
    assert str(asf.warnings[-1]) == "9960 more warnings are not shown."
    few = parse_asf(many_bones(2))

    def backwards(n):
        return b":odd " * n + b"\n" + b"".join(b"%d\nroot 1\n" % k for k in range(n, 0, -1))

    clip = grown(backwards, lambda data: parse_amc(data, few), 30_000)
    assert clip.frames == 30_000
    assert len(clip.warnings) < 50
    grown(lambda n: b"1\nroot " + b"9" * n + b"x\n", lambda data: parse_amc(data, few), 300_000)


def test_hostile_figures_of_an_amc_are_those_of_its_skeleton():
    found = parse_amc(amc_files.amc(full=False), parse_asf(amc_files.asf(full=False)))
    assert found.frames == amc_files.FRAMES
