"""Files of estimators in, one person's poses out; what cannot be read is refused in a sentence."""

import io
import os
import pickle
import tracemalloc
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers, refused
from tests.twistcore.estimator_files import (
    LAYOUTS,
    amass,
    lists_by_frame,
    matrices,
    person_axis,
    rows,
    smplx,
    vectors,
    world_and_camera,
    write_joblib,
)
from tests.twistcore.test_quamo_cli import run_quamo
from tests.twistcore.test_rest_pose import t_pose
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.formats.npz.pickled_arrays import Unreadable, read_pickle
from twistcore.formats.smpl.pose_files import PosesError
from twistcore.formats.smpl.poses_clip import read_smpl_poses_as_clip
from twistcore.formats.smpl.skeleton import find_network_joints, make_smpl_skeleton
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence


@pytest.fixture(scope="module")
def clip():
    """Twelve frames of a dance: rotations (12, 24, 4), places (12, 3), as if relative to SMPL."""
    sequence = read_cmu_bvh_sequence(ASSETS / "dance.bvh")
    return sequence.q[:12], sequence.r[:12]


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    """A BVH that rests as SMPL does."""
    path = tmp_path_factory.mktemp("template") / "t.bvh"
    q = np.tile([1.0, 0.0, 0.0, 0.0], (1, 24, 1))
    write_motion(Motion(make_smpl_skeleton(t_pose()), q, (0,), np.zeros((1, 1, 3)), 0.04), path)
    return path


def run(capsys, *words):
    return run_quamo(capsys, "refine", *words)


def read(path, template, **options):
    return read_smpl_poses_as_clip(path, template=template, unit=1.0, **{"fps": 25.0} | options)


def same(found, q, r, joints=22):
    """How far a clip is from rotations and places: degrees and metres, the largest."""
    own = find_network_joints(found.skeleton).reduced(found.motion.rotations)
    assert own.shape[:2] == q.shape[:2]
    away = np.degrees(geodesic_angle(own[:, :joints], q[:, :joints])).max()
    return away, np.abs(found.motion.positions[:, 0] - r).max()


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_file_of_each_layout_is_the_clip_it_was_made_of(name, clip, template, tmp_path):
    write, person, _, said = LAYOUTS[name]
    path = write(tmp_path / "poses", *clip)
    found = read(path, template, person=person)
    q, r = clip[0], clip[1].copy()
    if "depth" in said:
        r[:, 2] = np.median(r[:, 2])
    assert same(found, q, r) == (pytest.approx(0.0, abs=1e-3), pytest.approx(0.0, abs=1e-5))
    assert any(said in str(w) for w in found.warnings)


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_file_of_each_layout_is_tracked_and_becomes_a_bvh(name, clip, template, capsys, tmp_path):
    write, person, has_rate, said = LAYOUTS[name]
    path, out = write(tmp_path / "poses", *clip), tmp_path / "out.bvh"
    words = [path, "-o", out, "--template", template, "--unit", 1]
    words += ["--person", person] if person else []
    code, _, err = run(capsys, *words)
    if not has_rate:
        assert (code, "--fps" in err, err.count("\n"), out.exists()) == (2, True, 1, False)
        code, _, err = run(capsys, *words, "--fps", 25)
    assert code == 0
    assert f"{path}: " in err
    assert said in err
    made = read_bvh(out)
    assert made.motion.fps == pytest.approx(25.0)
    assert same(made, *clip)[0] < 30.0  # followed, with the tracker's lag


def test_a_place_with_an_axis_of_one_is_no_axis_of_persons(clip, template, tmp_path):
    path = smplx(tmp_path / "a", *clip)
    np.savez(path, **dict(np.load(path)) | {"transl": clip[1][:, None]})
    assert same(read(path, template), *clip)[0] < 1e-3


def test_the_root_stands_where_smpl_rests_it_and_not_where_a_template_does(clip, tmp_path):
    """SMPL adds its rest place in the file's axes; a template's root may rest anywhere."""
    path, rest = amass(tmp_path / "a", *clip), t_pose()
    rest[0] = [0.1, 0.2, -0.3]
    np.savez(path, **dict(np.load(path)) | {"offsets": rest})
    moved = clip[1] + [0.1, -0.3, -0.2]  # z up in the file
    assert read_smpl_poses_as_clip(path).motion.positions[:, 0] == pytest.approx(moved, abs=1e-5)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (1, 24, 1))
    template = tmp_path / "t.bvh"
    other = rest.copy()
    other[0] = [7.0, 8.0, 9.0]
    write_motion(
        Motion(make_smpl_skeleton(other), still, (0,), np.zeros((1, 1, 3)), 0.04), template
    )
    assert read(path, template).motion.positions[:, 0] == pytest.approx(moved, abs=1e-5)
    found = read(amass(tmp_path / "b", *clip), template)
    assert found.motion.positions[:, 0] == pytest.approx(clip[1], abs=1e-5)


def test_several_persons_are_named_and_one_is_chosen(clip, template, tmp_path):
    path = world_and_camera(tmp_path / "a", *clip)
    with pytest.raises(PosesError, match=r"--person.*0 \(12 frames\), 7 \(4 frames\)"):
        read(path, template)
    with pytest.raises(PosesError, match="5"):
        read(path, template, person="5")
    assert read(path, template, person="7").motion.frames == 4
    with pytest.raises(PosesError, match=r"0 \(12 frames\), 1 \(12 frames\)"):
        read(person_axis(tmp_path / "b", *clip), template)
    with pytest.raises(PosesError, match="--person"):
        read(amass(tmp_path / "c", *clip), template, person="0")


def test_several_persons_in_one_frame_are_no_frames_of_one(clip, template, tmp_path):
    for write in (smplx, person_axis):
        path = write(tmp_path / "a", *clip)
        arrays = dict(np.load(path))
        bodies = {k: v for k, v in arrays.items() if v.shape[-2:-1] == (12,)}
        one = {k: (v if v.ndim == 3 else np.stack([v, v]))[:, 3:4] for k, v in bodies.items()}
        np.savez(path, **one)
        with pytest.raises(PosesError, match=r"0 \(1 frames\), 1 \(1 frames\)"):
            read(path, template)
        found = read(path, template, person="1", up="y" if write is smplx else "-y")
        assert same(found, clip[0][3:4], clip[1][3:4])[0] < 1e-3
        np.savez(path, **{k: v[1:] for k, v in one.items()})
        assert read(path, template).motion.frames == 1


def test_who_was_not_seen_is_nobody(clip, template, tmp_path):
    """Where a person is lost, the tracker of such a file carries the last pose on."""
    path = lists_by_frame(tmp_path / "a", *clip)
    with pytest.raises(PosesError, match="9"):
        read(path, template, person="9")


def test_frames_that_are_missing_are_filled_and_told(clip, template, tmp_path):
    q, r = clip
    kept = [0, 1, 2, 3, 7, 8, 9, 11]
    record = {"pose": vectors(q[kept]), "trans": r[kept], "frame_ids": 100 + np.array(kept)}
    path = write_joblib(tmp_path / "a.pkl", {"0": record})
    found = read(path, template, up="y")
    there = replace(found, values=found.values[kept])
    assert same(there, q[kept], r[kept]) == (pytest.approx(0, abs=1e-3), pytest.approx(0, abs=1e-5))
    assert found.motion.frames == 12
    told = " ".join(map(str, found.warnings))
    assert numbers(told)[:4] == [4, 12, 3, 104]
    between = found.motion.positions[4:7, 0]
    steps = np.diff(np.concatenate([r[[3]], between, r[[7]]]), axis=0)
    assert steps == pytest.approx(np.tile((r[7] - r[3]) / 4.0, (4, 1)), abs=1e-5)


@pytest.mark.parametrize(
    ("ids", "facts"),
    [
        (np.arange(11), ("12", "11")),
        (np.arange(12)[::-1], ()),
        (np.repeat(np.arange(6), 2), ()),
        (np.arange(12) + 0.5, ()),
        (np.arange(12) * 10**9, ()),
    ],
)
def test_frame_numbers_that_mean_nothing_are_refused(ids, facts, clip, template, tmp_path):
    record = {"pose": vectors(clip[0]), "trans": clip[1], "frame_ids": ids}
    with refused(PosesError, "frame_ids", *facts):
        read(write_joblib(tmp_path / "a.pkl", {"0": record}), template)


def test_which_way_is_up_can_be_said_and_what_looks_wrong_is_told(clip, template, tmp_path):
    path = smplx(tmp_path / "a", *clip)
    down = read(path, template, up="-y")
    assert down.motion.positions[:, 0] == pytest.approx(clip[1] * [1.0, -1.0, -1.0], abs=1e-5)
    [warning] = down.warnings
    assert names_in_one_line(str(warning), "-y", "--up=y")
    assert len(read(path, template, up="y").warnings) == 0


def test_matrices_that_are_nearly_rotations_are_made_so_and_others_refused(
    clip, template, tmp_path
):
    path = matrices(tmp_path / "a", *clip)
    arrays = dict(np.load(path))
    rough = arrays["body_pose"] * 1.01
    np.savez(path, **arrays | {"body_pose": rough})
    found = read(path, template)
    assert same(found, *clip)[0] < 1e-2
    assert any("0.02" in str(w) for w in found.warnings)
    for bad in (1.5 * arrays["body_pose"], -arrays["body_pose"]):
        broken = arrays["body_pose"].copy()
        broken[4, 6] = bad[4, 6]
        np.savez(path, **arrays | {"body_pose": broken})
        with pytest.raises(PosesError, match=r"body_pose.* frame 4 of joint 6"):
            read(path, template)


def test_numbers_that_are_none_are_named_by_frame(clip, template, tmp_path):
    path = smplx(tmp_path / "a", *clip)
    arrays = dict(np.load(path))
    for name in ("global_orient", "body_pose", "transl"):
        for bad in (np.nan, np.inf, 1e30):
            broken = arrays[name].astype(np.float64)
            broken[5, -1] = bad
            np.savez(path, **arrays | {name: broken})
            with pytest.raises(PosesError, match=f"{name}.* frame 5"):
                read(path, template)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"body_pose": None}, "'body_pose'.*global_orient"),
        ({"transl": None}, "position"),
        ({"transl": np.zeros((12, 4))}, r"transl.*\(12, 3\).*\(12, 4\)"),
        ({"body_pose": np.zeros((12, 60))}, r"69.*63.*\(12, 60\)"),
        ({"body_pose": np.zeros((9, 63))}, "12.* 9"),
        ({"global_orient": np.zeros((0, 3))}, "frame"),
        ({"global_orient": np.array(1.0)}, r"\(\)"),
        ({"transl": np.array(["a"])}, "'transl'"),
        ({"body_pose": np.array([None, 1], dtype=object)}, "'body_pose'"),
        ({"transl": np.zeros((2, 12, 3))}, "2 people"),
        ({"offsets": np.full((24, 3), np.nan)}, "offsets"),
    ],
)
def test_shapes_that_are_none_of_a_layout_are_told(changes, what, clip, template, tmp_path):
    path = smplx(tmp_path / "a", *clip)
    arrays = dict(np.load(path)) | changes
    np.savez(path, **{k: v for k, v in arrays.items() if v is not None})
    with pytest.raises(PosesError, match=what) as caught:
        read(path, template)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("fps", [0.5, 1e6])
def test_a_rate_that_no_bvh_has_is_refused(fps, clip, template, tmp_path):
    with pytest.raises(PosesError, match=r"10,000"):
        read(smplx(tmp_path / "a", *clip), template, fps=fps)


class Runs:
    """What a pickle can do: run a command when it is read."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def test_a_pickle_runs_nothing(clip, template, tmp_path):
    made = tmp_path / "made"
    record = {"pose_world": vectors(clip[0]), "trans_world": clip[1], "extra": Runs(made)}
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({0: record}))
    assert same(read(path, template), *clip)[0] < 1e-3  # what is not needed does not matter
    np.savez(tmp_path / "b.npz", outputs=np.array(record | {"pose": Runs(made)}, dtype=object))
    read(tmp_path / "b.npz", template)
    path.write_bytes(pickle.dumps({0: record | {"pose_world": Runs(made)}}))
    with pytest.raises(PosesError, match=r"\(\w+.mkdir\)"):
        read(path, template)
    assert not made.exists()
    pickle.loads(pickle.dumps(Runs(made)))
    assert made.exists()  # it would have


def test_names_in_a_pickle_are_not_looked_up_and_nothing_of_ours_is_changed():
    # A state for a class, which Python's own unpickler would set as attributes of it.
    attack = b"cnumpy\ndtype\n(N}X\x05\x00\x00\x00plainK\x01stb."
    with pytest.raises(ValueError, match="pickle"):
        read_pickle(attack)
    good = pickle.dumps(np.arange(3))
    assert (read_pickle(good) == np.arange(3)).all()
    found = read_pickle(pickle.dumps([io.BytesIO(b"x"), np.float32(2.0), (1, {2: b"c"})]))
    assert isinstance(found[0], Unreadable)
    assert found[1:] == [2.0, [1, {2: b"c"}]]


@pytest.mark.parametrize("order", ["<", ">"])
def test_numbers_of_either_byte_order_are_read(order):
    given = np.linspace(-1.0, 1.0, 5).astype(f"{order}f4")
    np.testing.assert_array_equal(read_pickle(pickle.dumps(given)), given)


def test_a_length_in_a_pickle_takes_no_memory():
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="pickle"):
            read_pickle(b"\x80\x05\x96" + (1 << 27).to_bytes(8, "little") + b"few")
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "letters", ["O", "V8", "S4", "U3", "M8[s]", "f99", "(2,)f8", "f4,f4", "", "x"]
)
def test_arrays_of_anything_but_plain_numbers_are_not_made_of_bytes(letters):
    """The bytes of an array of objects would be addresses."""

    class State:
        def __reduce__(self):
            dtype = np.dtype
            kind = type("K", (), {"__reduce__": lambda _: (dtype, (letters, False, True), None)})
            function, made, _ = np.zeros(1).__reduce__()
            return function, made, (1, (1,), kind(), False, b"\x01" * 8)

    state = State()
    stream = io.BytesIO()
    pickler = pickle._Pickler(stream)
    try:
        pickler.dump(state)
    except pickle.PicklingError:
        pytest.skip("cannot be written")
    with pytest.raises(ValueError, match="pickle"):
        read_pickle(stream.getvalue())


@pytest.mark.parametrize(
    "data",
    [
        b"", b"HIERARCHY\nROOT", b"PK\x03\x04", b"\x80\x04N.", b"\x80\x04]", b"\x80\x02}q\x00.",
        b"\x80\x05\x96" + b"\xff" * 8, b"\x80\x04\x8e" + b"\xff" * 7 + b"\x7f", b"\x00" * 100,
        b"\x78\x9c" + b"\0" * 40, b"\x1f\x8b\x08", b"ZF0x" + b"\0" * 30,
        b"cos\nsystem\n(S'true'\ntR.",
    ],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".npz", ".pkl", ".pt"])
def test_files_that_are_no_poses_are_refused_in_one_sentence(
    data, suffix, template, capsys, tmp_path
):
    path, out = tmp_path / f"a{suffix}", tmp_path / "out.bvh"
    path.write_bytes(data)
    code, told, err = run(capsys, path, "-o", out, "--template", template, "--fps", 25)
    assert (code, told, err.count("\n"), out.exists()) == (2, "", 1, False)
    assert str(path) in err


def test_other_archives_are_refused(template, tmp_path):
    np.savez(tmp_path / "empty.npz")
    with pytest.raises(PosesError, match=r"empty\.npz"):
        read(tmp_path / "empty.npz", template)
    (tmp_path / "a.pkl").write_bytes(pickle.dumps({"po\nse\x1b": 1}))
    with pytest.raises(PosesError, match=r"found po\?se\? \(int\)"):
        read(tmp_path / "a.pkl", template)
    np.savez(tmp_path / "none.npz", a=np.zeros((2, 3)), b=np.array({"c": 1}, dtype=object))
    with pytest.raises(PosesError, match=r"found a \(2, 3\), b \(dict of 1\)"):
        read(tmp_path / "none.npz", template)
    with zipfile.ZipFile(tmp_path / "t.pt", "w") as archive:
        archive.writestr("archive/data.pkl", b"\x80\x02}.")
    with pytest.raises(PosesError, match=r"PyTorch.*numpy\.savez"):
        read(tmp_path / "t.pt", template)


@pytest.mark.parametrize("name", ["outputs", "smpl_params_global"])
def test_a_pickle_that_holds_itself_is_refused_in_one_sentence(name, template, tmp_path):
    names = {}
    names[name] = names
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(names))
    with pytest.raises(PosesError, match="contains itself"):
        read(tmp_path / "a.pkl", template)


@given(st.integers(0, 10**9), st.integers(1, 12))
def test_damaged_files_are_refused_or_read_never_more(tmp_path_factory, seed, changes):
    rng = np.random.default_rng(seed)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (3, 24, 1))
    folder = tmp_path_factory.getbasetemp() / "fuzz"
    folder.mkdir(exist_ok=True)
    path = (world_and_camera, rows, lists_by_frame)[seed % 3](folder / "a", q, np.zeros((3, 3)))
    data = bytearray(path.read_bytes())
    for _ in range(changes):
        data[rng.integers(min(len(data), 900))] = rng.integers(256)
    path.write_bytes(data[: rng.integers(1, len(data))] if seed % 5 == 0 else data)
    with np.errstate(all="ignore"):
        told = ""
        try:
            read(path, ASSETS / "dance.bvh", person="0")
        except TwistError as error:
            told = str(error)
    assert "\n" not in told
