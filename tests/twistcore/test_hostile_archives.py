"""Archives and pickles made to cost memory, to be run, or to be taken for something else."""

import bz2
import io
import lzma
import pickle
import re
import struct
import tracemalloc
import warnings
import zipfile
import zlib

import numpy as np
import pytest

from tests.fuzz.poses_damage import npy
from tests.twistcore.processor_time import grown, spent
from twistcore.errors import NpzError, TwistError
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.formats.npz import parse_npz
from twistcore.formats.npz.pickled_arrays import read_pickle
from twistcore.formats.npz.vector_branch import continuous_npz_rotation_vectors
from twistcore.formats.reading import is_clip_without_motion
from twistcore.formats.smpl.pose_files import read_pose_file
from twistcore.formats.smpl.pose_layouts import find_poses
from twistcore.skeleton.rotation import geodesic_angle

POSES = {"poses": np.zeros((4, 66)), "trans": np.zeros((4, 3))}


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
    is_clip_without_motion(folder / "a.npz")
    told = []
    with pytest.raises(NpzError) as error:
        parse_npz(data, folder / "a.npz")
    told.append(str(error.value))
    with pytest.raises(TwistError) as error:
        find_poses(folder / "a.npz", read_pose_file(folder / "a.npz"))
    told.append(str(error.value))
    assert not any("\n" in one for one in told)
    return told


class Bomb:
    """What a pickle runs when it is unpacked."""

    ran = False

    def __reduce__(self):
        return exec, ("import tests.twistcore.test_hostile_archives as t; t.Bomb.ran = True",)


@pytest.mark.parametrize(
    ("poses", "expected"),
    [
        (header("<f8", (10**18, 66)), "'poses'"),
        (header("<f8", (0, 10**18)), "'poses'"),
        (header("<f8", (10**30,)), "'poses'"),
        (header("<f8", (-1, 66), raw=b"\0" * 528), "'poses'"),
        (header("<f8", (1,) * 70, raw=b"\0" * 8), "'poses'"),
        (header("<f8", (4, 66.0), raw=b"\0" * 2112), "'poses'"),
        (header("<f8", "no shape"), "'poses'"),
        (header("nothing", (4, 66)), "'poses'"),
        (header([("x", "<f8")], (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("(66,)<f8", (4,), raw=b"\0" * 2112), "'poses'"),
        (header("|S8", (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("<M8[s]", (4, 66), raw=b"\0" * 2112), "floating-point"),
        (header("|V0", (4, 66)), "'poses'"),
        (npy(np.array([Bomb()], dtype=object)), "objects"),
        (b"\x93NUMPY\x09\x00" + npy(POSES["poses"])[8:], "'poses'"),
        (npy(POSES["poses"])[:-1], "'poses'"),
        (npy(POSES["poses"]) + b"x", "'poses'"),
        (b"\x93NUMPY\x01\x00\x10\x27" + b"(" * 10_000, "'poses'"),
        (b"\x93NUMPY\x01\x00\x04\x00" + b"'''\n", "'poses'"),
        (b"", "'poses'"),
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
    assert len(find_poses(tmp_path / "a.npz", read_pose_file(tmp_path / "a.npz")).rotations) == 4
    (tmp_path / "a.pkl").write_bytes(pickle.dumps({"poses": Bomb()}))
    with pytest.raises(TwistError, match="'poses'"):
        find_poses(tmp_path / "a.pkl", read_pose_file(tmp_path / "a.pkl"))
    assert not Bomb.ran


def test_numbers_are_the_same_by_row_by_column_and_in_either_byte_order():
    values = np.random.default_rng(0).normal(size=(4, 66))
    for dtype in ("<f8", ">f8", "<f4", ">f4", "<f2"):
        for order in "CF":
            array = np.asarray(values.astype(dtype), order=order)
            clip = parse_npz(packed(poses=npy(array)))
            np.testing.assert_array_equal(clip.poses, array)
            motion = clip.motion.with_rotations(clip.motion.rotations[::-1].copy())
            again = parse_npz(create_file_patch_for_motion(clip, motion).data)
            assert (again.poses.dtype, again.poses.shape) == (array.dtype, (4, 66))
            assert geodesic_angle(again.motion.rotations, motion.rotations).max() < 0.01


@pytest.mark.parametrize("where", ["poses", "trans"])
def test_a_signalling_nan_is_a_number_that_is_not_finite(where, tmp_path):
    """Converting it to another precision would warn."""
    names = {name: array.astype(np.float32) for name, array in POSES.items()}
    names[where].view(np.uint32)[1, 1] = 0x7FA00000
    data = packed(**{name: npy(array) for name, array in names.items()}, fps=npy(25.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for sentence in both_readers(data, tmp_path):
            assert "frame 1" in sentence


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
    assert re.search("3[0-9] MiB.* 47 MiB", clip)
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
    with pytest.raises(NpzError, match="33 MiB"):
        parse_npz(data)


@pytest.mark.thorough
def test_compressed_pickles_unpack_within_the_same_bound(tmp_path):
    for squeeze in (zlib.compress, bz2.compress, lambda raw: lzma.compress(raw, preset=0)):
        data = squeeze(b"\x80\x04" + b"\0" * 40_000_000)
        (tmp_path / "a.pkl").write_bytes(data)
        with pytest.raises(TwistError, match=r"3\d MiB"):
            read_pose_file(tmp_path / "a.pkl")


@pytest.mark.parametrize("compress", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compression_that_numpy_does_not_use_is_refused_unread(compress, tmp_path):
    for told in both_readers(packed(compress, poses=npy(POSES["poses"])), tmp_path):
        assert "deflated" in told


def test_members_inside_one_another_are_refused(tmp_path):
    """One local header tells of the other's: thousands of names for the same bytes."""
    data = bytearray(packed(poses=npy(POSES["poses"])))
    first, second = (k for k in range(len(data)) if data[k : k + 4] == b"PK\x01\x02")
    del first
    data[second + 42 : second + 46] = struct.pack("<I", 40)
    for told in both_readers(bytes(data), tmp_path):
        assert "expected" in told


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
        assert "expected" in told
    data = bytearray(packed(poses=npy(POSES["poses"])))
    data[data.rindex(b"PK\x01\x02") + 8] |= 1
    for told in both_readers(bytes(data), tmp_path):
        assert "encrypted" in told


@pytest.mark.parametrize("at", range(0, 60, 4))
def test_a_damaged_directory_is_another_file_or_none_and_never_ends_the_program(at, tmp_path):
    good = packed(poses=npy(POSES["poses"]))
    for place in (0, good.rindex(b"PK\x01\x02"), good.rindex(b"PK\x05\x06")):
        data = bytearray(good)
        data[place + at : place + at + 4] = b"\xff\xfe\x80\x7f"
        (tmp_path / "a.npz").write_bytes(data)
        is_clip_without_motion(tmp_path / "a.npz")
        for work in (
            lambda d=bytes(data): parse_npz(d),
            lambda: read_pose_file(tmp_path / "a.npz"),
        ):
            spent(work)  # raises what is no TwistError


def test_poses_by_persons_and_rows_take_time_for_their_size(tmp_path):
    def arrays(rows):
        return {
            "smpl_thetas": np.zeros((rows, 72)),
            "cam_trans": np.zeros((rows, 3)),
            "track_ids": np.arange(rows, dtype=float),
        }

    found = grown(arrays, lambda names: find_poses(tmp_path, names, "7"), 9_000)
    assert len(found.rotations) == 1
    names = arrays(20_000)
    with pytest.raises(TwistError, match=r"10000 .*20000"):
        find_poses(tmp_path, names | {"track_ids": np.arange(20_000.0)})
    with pytest.raises(TwistError, match=r"10000 .*20000"):
        find_poses(
            tmp_path, {"poses": np.zeros((20_000, 1, 72)), "trans": np.zeros((20_000, 1, 3))}
        )


def test_vectors_of_thousands_of_turns_are_corrected_in_bounded_memory():
    q = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    far = np.full((3, 3), 9e5)
    assert peak_of(lambda: continuous_npz_rotation_vectors(q, far, far[0], far[1])) < 1_000_000


def test_keys_that_all_hash_alike_are_refused():
    modulus = (1 << 61) - 1
    keys = {k * modulus: None for k in range(1, 500)}
    for protocol in (0, 2, 4):
        with pytest.raises(ValueError, match="pickle"):
            read_pickle(pickle.dumps(keys, protocol))
        few = {0: 1, 1 << 59: 2, "a": 1 << 80}
        assert read_pickle(pickle.dumps(few, protocol)) == few
    with pytest.raises(ValueError, match="pickle"):
        read_pickle(b"(L%dL\nNd." % modulus)
