"""Clips made to cost much time or memory are read, or refused, for what their size allows."""

import bz2
import io
import lzma
import pickle
import re
import struct
import time
import tracemalloc
import zipfile
import zlib

import numpy as np
import pytest

from tests.twistcore import amc_files
from twistcore.amc import parse_amc, parse_asf
from twistcore.bvh import parse_bvh
from twistcore.bvh.compose import bvh_text
from twistcore.chain import find_chains
from twistcore.clip import rewritten
from twistcore.errors import AmcError, BvhError, NpzError, TwistError
from twistcore.formats import is_other_data
from twistcore.limb import find_limbs
from twistcore.npz import parse_npz
from twistcore.npz.vector_branch import continuous_vectors
from twistcore.quamo.pose_files import read_names
from twistcore.quamo.pose_layouts import find_poses
from twistcore.rotation import geodesic_angle

SLOW = 2.0  # seconds of processor time; by the square of their size all of these take minutes
XYZ = "Xrotation Yrotation Zrotation"


def spent(work):
    """What it gave, or its error, and the seconds of processor time."""
    begun = time.process_time()
    try:
        found = work()
    except TwistError as error:
        found = error
    return found, time.process_time() - begun


def bvh(inside, rows="1 2 3\n", *, seconds="0.01", frames=1):
    head = f"HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS 3 {XYZ}\n{inside}\n}}\n"
    return f"{head}MOTION\nFrames: {frames}\nFrame Time: {seconds}\n{rows}".encode()


def joint(name, inside=""):
    return f"JOINT {name}\n{{\nOFFSET 0 1 0\n{inside}\n}}\n"


HOSTILE = {
    "many OFFSETs": lambda: bvh("OFFSET 1 2 3\n" * 20_000),
    "many CHANNELS": lambda: bvh("CHANNELS 1 Xposition\n" * 20_000, "1 " * 20_003),
    "one number a line": lambda: bvh("CHANNELS 1 Xposition\n" * 20_000, "1\n" * 20_003 + "1 1\n"),
    "many End Sites": lambda: bvh("End Site\n{\nOFFSET 0 1 0\n}\n" * 20_000),
    "one name": lambda: bvh(joint("a") * 5_000 + "".join(joint(f"a #{k}") for k in range(5_000))),
    "names of many words": lambda: bvh(joint("a " * 30_000) * 4),
    "one line": lambda: bvh(
        (joint("a") * 5_000).replace("\n", " ").replace("JOINT a", "JOINT a\n")
    ),
    "empty lines": lambda: bvh("\n" * 1_000_000, "\n" * 1_000_000 + "1 2 3" + "\n" * 1_000_000),
    "a long Frame Time": lambda: bvh("", seconds="9" * 300_000 + "x"),
    "a long number": lambda: bvh("", "1 2 " + "9" * 300_000 + "x"),
    "a long OFFSET": lambda: bvh("OFFSET 1 2 " + "9" * 300_000 + "x"),
    "a long block": lambda: bvh("", "1 2 0." + "3" * 3_000_000),
    "many chains": lambda: bvh(joint("a", joint("b", joint("c", joint("d")))) * 2_000),
    "many positions": lambda: bvh(
        joint("a", "CHANNELS 1 Xposition") * 5_000, " ".join("1" * 5_003)
    ),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_time_grows_with_the_size_of_a_bvh_not_with_its_square(what):
    data = HOSTILE[what]()

    def work():
        clip = parse_bvh(data)
        find_limbs(clip.motion, find_chains(clip.motion))
        bvh_text(clip.motion)
        return clip

    found, seconds = spent(work)
    assert seconds < SLOW
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


def test_a_nested_figure_is_written_for_its_joints_not_for_the_square_of_their_depth():
    depth = 3000
    inside = "".join(f"JOINT j{k}\n{{\nOFFSET 0 1 0\n" for k in range(depth)) + "}" * depth
    text = bvh_text(parse_bvh(bvh(inside)).motion)
    assert len(text) < 4000 * depth
    assert len(parse_bvh(text.encode()).skeleton) == depth + 1


def test_numbers_with_exponents_are_rewritten_in_one_go():
    rows = 20_000
    clip = parse_bvh(bvh("", "1.5e+0 2.5E1 35e-1\n" * rows, frames=rows))
    motion = clip.motion.with_rotations(clip.motion.rotations[::-1] * [1.0, -1.0, 1.0, 1.0])
    patch, seconds = spent(lambda: rewritten(clip, motion))
    assert seconds < 5 * SLOW  # 60,000 numbers on the best branch; their exponents were hours
    assert parse_bvh(patch.data).frames == rows


def test_a_pose_of_every_joint_in_every_frame_is_not_made_of_next_to_no_numbers():
    """120 kB of text ask for 3.5 GB."""
    joints, frames = 2_000, 20_000
    with pytest.raises(BvhError, match=r"channels in more joints: 20000 frames of 2001 joints"):
        parse_bvh(bvh(joint("a") * joints, "1 2 3\n" * frames, frames=frames))
    with pytest.raises(AmcError, match="channels in more joints"):
        parse_amc(b"1\nroot 0\n" * frames, parse_asf(many_bones(joints)))


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


def test_time_grows_with_the_size_of_a_skeleton_and_an_amc_not_with_its_square():
    asf, seconds = spent(lambda: parse_asf(many_bones(10_000, b"odd 1")))
    assert seconds < SLOW
    assert len(asf.skeleton) == 10_001
    assert str(asf.warnings[-1]) == "9960 more warnings are not shown."
    few = parse_asf(many_bones(2))
    backwards = b"".join(b"%d\nroot 1\n" % k for k in range(30_000, 0, -1))
    clip, seconds = spent(lambda: parse_amc(b":odd " * 30_000 + b"\n" + backwards, few))
    assert seconds < SLOW
    assert clip.frames == 30_000
    assert len(clip.warnings) < 50
    long = b"1\nroot " + b"9" * 300_000 + b"x\n"
    assert spent(lambda: parse_amc(long, few))[1] < SLOW


def test_hostile_figures_of_an_amc_are_those_of_its_skeleton():
    found = parse_amc(amc_files.amc(full=False), parse_asf(amc_files.asf(full=False)))
    assert found.frames == amc_files.FRAMES


# -- archives --------------------------------------------------------------------------------------


POSES = {"poses": np.zeros((4, 66)), "trans": np.zeros((4, 3))}


def npy(array):
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=True)
    return file.getvalue()


def header(descr, shape, order=False, raw=b""):
    """An .npy that says so of itself."""
    text = repr({"descr": descr, "fortran_order": order, "shape": shape}).encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + raw


def packed(compress=zipfile.ZIP_STORED, **members):
    """An archive of members of these bytes; trans is there unless it is given."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", compress) as archive:
        for name, raw in ({"trans": npy(POSES["trans"])} | members).items():
            archive.writestr(f"{name}.npy", raw)
    return out.getvalue()


def both_readers(data, folder):
    """The sentences of the readers of clips and of poses."""
    (folder / "a.npz").write_bytes(data)
    is_other_data(folder / "a.npz")
    told = []
    with pytest.raises(NpzError) as error:
        parse_npz(data, folder / "a.npz")
    told.append(str(error.value))
    with pytest.raises(TwistError) as error:
        find_poses(folder / "a.npz", read_names(folder / "a.npz"))
    told.append(str(error.value))
    assert not any("\n" in one for one in told)
    return told


class Bomb:
    """What a pickle runs when it is unpacked."""

    ran = False

    def __reduce__(self):
        return exec, ("import tests.twistcore.test_hostile_clips as t; t.Bomb.ran = True",)


@pytest.mark.parametrize(
    ("poses", "expected"),
    [
        (header("<f8", (10**18, 66)), "whole array 'poses'"),
        (header("<f8", (0, 10**18)), "whole array 'poses'"),
        (header("<f8", (10**30,)), "whole array 'poses'"),
        (header("<f8", (-1, 66), raw=b"\0" * 528), "whole array 'poses'"),
        (header("<f8", (1,) * 70, raw=b"\0" * 8), "whole array 'poses'"),
        (header("<f8", (4, 66.0), raw=b"\0" * 2112), "whole array 'poses'"),
        (header("<f8", "no shape"), "whole array 'poses'"),
        (header("nothing", (4, 66)), "whole array 'poses'"),
        (header([("x", "<f8")], (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("(66,)<f8", (4,), raw=b"\0" * 2112), "whole array 'poses'"),
        (header("|S8", (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("<M8[s]", (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("|V0", (4, 66)), "whole array 'poses'"),
        (npy(np.array([Bomb()], dtype=object)), "objects, which only a program that is run"),
        (b"\x93NUMPY\x09\x00" + npy(POSES["poses"])[8:], "whole array 'poses'"),
        (npy(POSES["poses"])[:-1], "whole array 'poses'"),
        (npy(POSES["poses"]) + b"x", "whole array 'poses'"),
        (b"\x93NUMPY\x01\x00\x10\x27" + b"(" * 10_000, "whole array 'poses'"),
        (b"\x93NUMPY\x01\x00\x04\x00" + b"'''\n", "whole array 'poses'"),
        (b"", "whole array 'poses'"),
    ],
)  # fmt: skip
def test_an_array_that_is_none_is_refused_in_a_sentence(poses, expected, tmp_path):
    clip, _ = both_readers(packed(poses=poses), tmp_path)
    assert expected in clip
    assert not Bomb.ran


def test_objects_beside_the_poses_are_never_unpacked(tmp_path):
    members = {"poses": npy(POSES["poses"]), "fps": npy(25.0), "other": npy([Bomb()])}
    data = packed(**members)
    assert parse_npz(data).frames == 4
    (tmp_path / "a.npz").write_bytes(data)
    assert len(find_poses(tmp_path / "a.npz", read_names(tmp_path / "a.npz")).rotations) == 4
    (tmp_path / "a.pkl").write_bytes(pickle.dumps({"poses": Bomb()}))
    with pytest.raises(TwistError, match=r"expected numbers in 'poses'"):
        find_poses(tmp_path / "a.pkl", read_names(tmp_path / "a.pkl"))
    assert not Bomb.ran


def test_numbers_are_the_same_by_row_by_column_and_in_either_byte_order():
    values = np.random.default_rng(0).normal(size=(4, 66))
    for dtype in ("<f8", ">f8", "<f4", ">f4", "<f2"):
        for order in "CF":
            array = np.asarray(values.astype(dtype), order=order)
            clip = parse_npz(packed(poses=npy(array)))
            np.testing.assert_array_equal(clip.poses, array)
            motion = clip.motion.with_rotations(clip.motion.rotations[::-1].copy())
            again = parse_npz(rewritten(clip, motion).data)
            assert (again.poses.dtype, again.poses.shape) == (array.dtype, (4, 66))
            assert geodesic_angle(again.motion.rotations, motion.rotations).max() < 0.01


def bomb(size, compress=zipfile.ZIP_DEFLATED, name="poses"):
    return packed(
        compress, **{name: header("<f4", (size // 660, 165), raw=b"\0" * (size // 660 * 660))}
    )


def peak_of(work):
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", ["poses", "dmpls"])
def test_an_archive_that_unpacks_to_a_thousand_times_its_size_is_refused_unread(name, tmp_path):
    data = bomb(50_000_000, name=name)
    clip, poses = both_readers(data, tmp_path)
    assert re.search("expected arrays of at most 3. MiB in so small a file, found 47 MiB", clip)
    assert poses == clip
    assert peak_of(lambda: both_readers(data, tmp_path)) < 4 * len(data) + 4_000_000


def test_no_more_is_unpacked_than_the_directory_says(tmp_path):
    """The directory tells of 4 kB where 50 MB come."""
    data = bytearray(bomb(50_000_000))
    at = data.rindex(b"PK\x01\x02")
    data[at + 24 : at + 28] = struct.pack("<I", 4096)
    for told in both_readers(bytes(data), tmp_path):
        assert "expected" in told
    assert peak_of(lambda: both_readers(bytes(data), tmp_path)) < 8 * len(data) + 4_000_000


def test_few_bytes_that_become_many_numbers_are_refused():
    data = packed(zipfile.ZIP_DEFLATED, poses=header("<f2", (60_000, 165), raw=b"\0" * 19_800_000))
    with pytest.raises(NpzError, match="expected arrays of at most 33 MiB"):
        parse_npz(data)


def test_compressed_pickles_unpack_within_the_same_bound(tmp_path):
    for squeeze in (zlib.compress, bz2.compress, lambda raw: lzma.compress(raw, preset=0)):
        data = squeeze(b"\x80\x04" + b"\0" * 40_000_000)
        (tmp_path / "a.pkl").write_bytes(data)
        with pytest.raises(TwistError, match=r"expected at most 3\d MiB unpacked"):
            read_names(tmp_path / "a.pkl")


@pytest.mark.parametrize("compress", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compression_that_numpy_does_not_use_is_refused_unread(compress, tmp_path):
    for told in both_readers(packed(compress, poses=npy(POSES["poses"])), tmp_path):
        assert "expected arrays stored or deflated, as numpy does" in told


def test_members_inside_one_another_are_refused(tmp_path):
    """One local header tells of the other's: thousands of names for the same bytes."""
    data = bytearray(packed(poses=npy(POSES["poses"])))
    first, second = (k for k in range(len(data)) if data[k : k + 4] == b"PK\x01\x02")
    del first
    data[second + 42 : second + 46] = struct.pack("<I", 40)
    for told in both_readers(bytes(data), tmp_path):
        assert "expected arrays beside each other" in told


@pytest.mark.parametrize(
    "name", ["/poses", "../poses", "..\\poses", "C:/poses", "a/poses", "poses\n"]
)
def test_a_member_s_name_is_a_name_and_no_path(name, tmp_path):
    for told in both_readers(packed(**{name: npy(POSES["poses"])}), tmp_path):
        assert "expected" in told
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_a_name_twice_and_an_encrypted_member_are_refused(tmp_path):
    twice = packed(poses=npy(POSES["poses"]), posex=b"").replace(b"posex", b"poses")
    for told in both_readers(twice, tmp_path):
        assert "found two of one name" in told
    data = bytearray(packed(poses=npy(POSES["poses"])))
    data[data.rindex(b"PK\x01\x02") + 8] |= 1
    for told in both_readers(bytes(data), tmp_path):
        assert "not encrypted" in told


@pytest.mark.parametrize("at", range(0, 60, 4))
def test_a_damaged_directory_is_another_file_or_none_and_never_ends_the_program(at, tmp_path):
    good = packed(poses=npy(POSES["poses"]))
    for place in (0, good.rindex(b"PK\x01\x02"), good.rindex(b"PK\x05\x06")):
        data = bytearray(good)
        data[place + at : place + at + 4] = b"\xff\xfe\x80\x7f"
        (tmp_path / "a.npz").write_bytes(data)
        is_other_data(tmp_path / "a.npz")
        for work in (lambda d=bytes(data): parse_npz(d), lambda: read_names(tmp_path / "a.npz")):
            spent(work)  # raises what is no TwistError


def test_poses_by_persons_and_rows_take_time_for_their_size(tmp_path):
    rows = 9_000
    ids = np.arange(rows, dtype=float)
    names = {
        "smpl_thetas": np.zeros((rows, 72)),
        "cam_trans": np.zeros((rows, 3)),
        "track_ids": ids,
    }
    found, seconds = spent(lambda: find_poses(tmp_path, names, "7"))
    assert len(found.rotations) == 1
    assert seconds < SLOW
    names = {k: np.zeros((20_000, *v.shape[1:])) for k, v in names.items()}
    with pytest.raises(TwistError, match="at most 10000 persons, found 20000"):
        find_poses(tmp_path, names | {"track_ids": np.arange(20_000.0)})
    with pytest.raises(TwistError, match="at most 10000 persons, found 20000"):
        find_poses(
            tmp_path, {"poses": np.zeros((20_000, 1, 72)), "trans": np.zeros((20_000, 1, 3))}
        )


def test_vectors_of_thousands_of_turns_are_corrected_in_bounded_memory():
    q = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    far = np.full((3, 3), 9e5)
    assert peak_of(lambda: continuous_vectors(q, far, far[0], far[1])) < 1_000_000
