"""AMASS's .npz: read by joint names, rewritten where corrected and nowhere else."""

import io
import json
import zipfile
import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from tests.twistcore.amass_files import UPRIGHT, amass_arrays, loaded, write_amass
from tests.twistcore.test_cli import run
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.quality.joint import joint_quality
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion, write_clip
from twistcore.formats.npz import NpzClip, read_npz, vector_branch
from twistcore.formats.npz.body import BODIES
from twistcore.formats.npz.vector_branch import continuous_npz_rotation_vectors
from twistcore.formats.reading import is_clip, read_clip
from twistcore.formats.smpl.skeleton import CMU_UNIT, find_network_joints
from twistcore.review import Review, write_session
from twistcore.review.replay import accepted_motion
from twistcore.skeleton.figure import guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import exponential, geodesic_angle, multiply, rotate

WALK = read_bvh(ASSETS / "walk_injected.bvh")
FOUND = {  # the interval of the BVH, by the same chain's name on SMPL's joints
    {"LeftForeArm": "left_elbow", "RightUpLeg": "right_hip"}[i.chain]: (i.start, i.stop)
    for i in analyse(WALK).detect()
}


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """SMPL-H, as most of AMASS is."""
    return write_amass(tmp_path_factory.mktemp("amass") / "walk_poses.npz", WALK.motion)


def arrays_in(path):
    """What np.load finds, objects left as the bytes of their member."""
    found = {}
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist():
            raw = archive.read(info)
            array = np.lib.format.read_array(io.BytesIO(raw)) if b"|O" not in raw[:128] else raw
            found[info.filename] = (raw, array, info.compress_type)
    return found


# -- reading ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("own", [True, False], ids=["its own body", "a template's"])
@parametrize("joints", BODIES, quick=3)
def test_every_model_s_joints_give_the_chains_limbs_and_intervals_of_the_bvh(joints, own, tmp_path):
    clip = read_clip(write_amass(tmp_path / "a.npz", WALK.motion, joints, own=own))
    assert isinstance(clip, NpzClip)
    assert (clip.format, clip.frames, clip.columns) == ("npz", 344, 3 * joints + 3)
    assert clip.motion.fps == pytest.approx(WALK.motion.fps)
    found = analyse(clip)
    labels = [chain.label for chain in found.chains]
    assert labels == [chain.label for chain in analyse(WALK).chains]
    assert len(found.limbs) == 4
    assert {i.chain: (i.start, i.stop) for i in found.detect()} == FOUND
    assert any("template" in str(w) for w in clip.warnings) != (own and joints < 52)


def test_joints_are_where_the_bvh_has_them_and_z_is_up(walk):
    clip = read_npz(walk)
    analysis, topology = analyse(clip), find_network_joints(WALK.skeleton)
    here = analysis.poses[1]
    there = CMU_UNIT * forward_kinematics(WALK.motion)[1]
    limbs = [j for c in analysis.chains for j in (c.parent, c.child, max(c.grandchild, c.child))]
    for joint in limbs:
        away = here[:, joint] - rotate(UPRIGHT, there[:, topology.joints[joint]])
        assert np.abs(away).max() < 1e-9 or joint in (13, 14, 16, 17, 18, 19, 20, 21)
    assert guess_up(here, analysis.chains, clip.skeleton).tolist() == [0.0, 0.0, 1.0]
    seen = joint_quality(clip, here, up=2)
    assert np.nanmax(seen.slides) <= 100.0
    assert seen.jitter.shape == here.shape[:2]
    assert clip.euler(0) is None


def test_a_template_stands_as_people_do():
    for body in BODIES.values():
        places = np.zeros((len(body.names), 3))
        for j, parent in enumerate(body.parents.tolist()):
            assert parent < j
            places[j] = body.offsets[j] + (places[parent] if parent >= 0 else 0.0)
        assert 1.4 < np.ptp(places[:, 1]) < 1.7
        for j, name in enumerate(body.names):
            mirrored = name.replace("left", "~").replace("right", "left").replace("~", "right")
            other = places[body.names.index(mirrored)] * [-1.0, 1.0, 1.0]
            assert places[j].tolist() == pytest.approx(other.tolist())
            assert "left" not in name or places[j, 0] > 0.0


@pytest.mark.parametrize("missing", [True, False])
def test_the_rate_is_the_file_s_or_said_to_be_assumed(missing, walk, tmp_path):
    arrays = loaded(walk)
    arrays["mocap_frame_rate"] = arrays.pop("mocap_framerate")
    if missing:
        del arrays["mocap_frame_rate"]
    np.savez(tmp_path / "a.npz", **arrays)
    clip = read_npz(tmp_path / "a.npz")
    assert clip.motion.fps == pytest.approx(30.0 if missing else 120.0, rel=1e-5)
    assumed = [str(w) for w in clip.warnings if "30 frames" in str(w)]
    assert len(assumed) == missing
    assert all("--fps" in told for told in assumed)
    assert read_npz(tmp_path / "a.npz", fps=60.0).motion.fps == pytest.approx(60.0)


# -- writing ---------------------------------------------------------------------------------------


@parametrize("packed", [False, True], ids=["stored", "packed"])
@parametrize("dtype", ["<f8", "<f4", ">f4"])
def test_refine_changes_the_poses_of_the_intervals_and_no_other_bit(
    dtype, packed, capsys, tmp_path
):
    path, out = tmp_path / "a.npz", tmp_path / "b.npz"
    write_amass(path, WALK.motion, 55, np.dtype(dtype), packed=packed)
    source = path.read_bytes()
    code, said, _ = run(capsys, "refine", path, "-o", out)
    assert (code, path.read_bytes()) == (0, source)
    assert "of 8 intervals" in said
    before, after = arrays_in(path), arrays_in(out)
    assert list(before) == list(after)
    others = [n for n in before if n[:-4] not in ("poses", "pose_body")]
    for name in others:
        assert (before[name][0], before[name][2]) == (after[name][0], after[name][2]), name
    was, now = before["poses.npy"][1], after["poses.npy"][1]
    assert (now.dtype, now.shape) == (np.dtype(dtype), was.shape)
    differ = (was.view(f"u{was.itemsize}") != now.view(f"u{was.itemsize}")).reshape(344, 55, 3)
    names = BODIES[55].names
    assert {names[j] for j in np.flatnonzero(differ.any(axis=(0, 2)))} == {
        "left_elbow", "left_wrist", "right_hip", "right_knee",
    }  # fmt: skip
    clip = analyse(read_npz(path))
    frames = np.zeros((344, 55), dtype=bool)
    for i in clip.detect():
        chain = next(c for c in clip.chains if c.name == i.chain)
        frames[i.start : i.stop, list(chain.changed_joints(clip.motion.skeleton))] = True
    assert not (differ.any(axis=2) & ~frames).any()
    # What repeats them goes with them: a reader of SMPL-X parts sees the corrected pose.
    assert after["pose_body.npy"][1].tobytes() == now[:, 3:66].tobytes()
    assert not list(analyse(read_npz(out)).detect())


def test_with_nothing_changed_the_file_is_the_same_byte_for_byte(walk, tmp_path):
    for packed in (False, True):
        path = write_amass(tmp_path / "a.npz", WALK.motion, 24, np.float16, packed=packed)
        clip = read_npz(path)
        same = clip.motion.with_rotations(clip.motion.rotations.copy())
        assert create_file_patch_for_motion(clip, same).data == path.read_bytes()


def test_a_stored_file_differs_in_the_written_numbers_and_their_check_sum_alone(walk):
    clip = read_npz(walk)
    turned = clip.motion.rotations.copy()
    turned[7, 3] = multiply(turned[7, 3], exponential(np.array([0.0, 0.3, 0.0])))
    data = create_file_patch_for_motion(clip, clip.motion.with_rotations(turned)).data
    assert len(data) == len(clip.data)
    differ = np.flatnonzero(
        np.frombuffer(data, dtype=np.uint8) != np.frombuffer(clip.data, dtype=np.uint8)
    )
    assert len(differ) <= 24 + 8


def test_an_archive_written_as_a_stream_keeps_its_check_sums_behind_the_data(walk, tmp_path):
    class Stream(io.BytesIO):  # where nobody can go back, sizes stand behind a member
        def seekable(self):
            return False

        def seek(self, *_):
            raise OSError

        def tell(self):
            raise OSError

    out = Stream()
    with zipfile.ZipFile(walk) as old, zipfile.ZipFile(out, "w") as new:
        for info in old.infolist():
            new.writestr(info.filename, old.read(info))
    (tmp_path / "a.npz").write_bytes(out.getvalue())
    clip = read_npz(tmp_path / "a.npz")
    turned = clip.motion.rotations.copy()
    turned[:, 18] = multiply(turned[:, 18], exponential(np.array([0.2, 0.0, 0.0])))
    write_clip(clip, clip.motion.with_rotations(turned), tmp_path / "b.npz")
    with zipfile.ZipFile(tmp_path / "b.npz") as archive:
        assert archive.testzip() is None
        poses = archive.read("poses.npy")
    behind = b"PK\x07\x08" + zlib.crc32(poses).to_bytes(4, "little")  # which zipfile ignores
    assert behind in (tmp_path / "b.npz").read_bytes()
    again = read_npz(tmp_path / "b.npz").motion.rotations
    assert geodesic_angle(again[:, 18], turned[:, 18]).max() < 1e-7


def test_moved_roots_are_written_into_trans_and_nothing_else(walk, tmp_path):
    clip = read_npz(walk)
    moved = clip.motion.positions.copy()
    moved[40:50, 0, 2] += 0.25
    write_clip(clip, replace(clip.motion, positions=moved), tmp_path / "b.npz")
    was, now = loaded(walk), loaded(tmp_path / "b.npz")
    assert all(was[n].tobytes() == now[n].tobytes() for n in was if n != "trans")
    assert np.flatnonzero((was["trans"] != now["trans"]).any(axis=1)).tolist() == [*range(40, 50)]
    assert np.abs(now["trans"][40:50] - was["trans"][40:50] - [0, 0, 0.25]).max() < 1e-12


# -- the branch of the vectors ---------------------------------------------------------------------


@given(
    st.integers(0, 2**32 - 1), st.integers(1, 40), st.floats(0.0, 0.15), st.integers(-2, 2),
    st.sampled_from(["both", "before", "after"]),
)  # fmt: skip
@example(0, 36, 0.140625, -2, "after")  # one turn more at the start than at the end
def test_vectors_go_on_from_their_neighbours_and_mean_the_rotation(seed, frames, step, turns, side):
    """A line of vectors that passes half turns and whole ones is found again from its rotations."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    angles = 2.0 * np.pi * turns + 1.0 + np.cumsum(np.full(frames + 2, step))
    line = angles[:, None] * axis
    q = exponential(line[1:-1]) * rng.choice([-1.0, 1.0], (frames, 1))
    own = exponential(rng.normal(size=(frames, 3)))[:, 1:]
    before, after = line[0] if side != "after" else None, line[-1] if side != "before" else None
    found = continuous_npz_rotation_vectors(q, own, before, after)
    assert geodesic_angle(exponential(found), q).max() < 1e-7
    assert np.abs(found - line[1:-1]).max() < 1e-6


def test_a_sway_around_a_half_turn_needs_few_choices(monkeypatch):
    """Each passage changes the shortest vector to the opposite side, but the path winds no turn."""
    line = (np.pi + 0.1 * np.sin(np.arange(200)))[:, None] * [0.0, 1.0, 0.0]
    grids = []
    whole = vector_branch._cheapest
    monkeypatch.setattr(
        vector_branch, "_cheapest", lambda c, cost: grids.append(c.shape) or whole(c, cost)
    )
    found = continuous_npz_rotation_vectors(exponential(line[1:-1]), line[1:-1], line[0], line[-1])
    assert np.abs(found - line[1:-1]).max() < 1e-9
    assert grids[0][1] <= 5


def test_a_clip_turned_throughout_stays_near_its_own_vectors():
    y = np.array([0.0, 1.0, 0.0])
    own = np.linspace(2.5, 4.5, 9)[:, None] * y
    wanted = own + 0.1 * y
    assert np.abs(continuous_npz_rotation_vectors(exponential(wanted), own) - wanted).max() < 1e-9


def test_no_rotation_at_all_is_written_as_the_whole_turn_that_its_neighbours_have():
    turn = np.array([0.0, 0.0, 2.0 * np.pi])
    found = continuous_npz_rotation_vectors(
        np.array([[1.0, 0, 0, 0]]), turn[None] * 0.98, turn * 0.99, turn
    )
    assert np.abs(found - turn).max() < 1e-9


# -- what is something else ------------------------------------------------------------------------

F = np.zeros((5, 3))
REFUSED = {
    "another thing": ({"a": F}, "docs/amass.md"),
    "an estimator's": ({"global_orient": F, "body_pose": F}, "`twistcore quamo refine`"),
    "no place": ({"poses": np.zeros((5, 72))}, "'trans'"),
    "width": ({"poses": np.zeros((5, 70)), "trans": F}, "72 (SMPL)"),
    "matrices": ({"poses": np.zeros((5, 24, 3, 3)), "trans": F}, "rotation vectors"),
    "whole numbers": ({"poses": np.zeros((5, 72), dtype=int), "trans": F}, "floating-point"),
    "empty": ({"poses": np.zeros((0, 72)), "trans": F[:0]}, "1 to"),
    "frames": ({"poses": np.zeros((4, 72)), "trans": F}, "(5, 3)"),
    "objects": ({"poses": np.array([None, {}]), "trans": F}, "'poses'"),
    "offsets": ({"poses": np.zeros((5, 72)), "trans": F, "J": F}, "'J'"),
    "no joints": ({"poses": np.zeros((5, 72)), "trans": F, "offsets": np.full((24, 3), np.nan)},
                  "'offsets'"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_something_else_is_refused_in_one_sentence(name, capsys, tmp_path):
    arrays, said = REFUSED[name]
    np.savez(tmp_path / "a.npz", **arrays)
    code, out, err = run(capsys, "detect", tmp_path / "a.npz")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err


def test_a_number_that_is_none_is_refused_with_its_frame(capsys, tmp_path):
    poses = np.zeros((9, 156))
    poses[6, 40] = np.nan
    np.savez(tmp_path / "a.npz", poses=poses, trans=np.zeros((9, 3)))
    _, _, err = run(capsys, "info", tmp_path / "a.npz")
    assert names_in_one_line(err, "'poses'", "nan", "frame 6")


@pytest.mark.parametrize("cut", [0, 3, 200, 5000, -10])
def test_a_damaged_file_is_refused_in_one_sentence(cut, walk, capsys, tmp_path):
    (tmp_path / "a.npz").write_bytes(walk.read_bytes()[:cut])
    code, out, err = run(capsys, "detect", tmp_path / "a.npz")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert ".npz" in err


def test_damage_within_an_array_is_told(walk, capsys, tmp_path):
    data = bytearray(walk.read_bytes())
    data[data.index(b"poses.npy") + 5000] ^= 1
    (tmp_path / "a.npz").write_bytes(data)
    _, _, err = run(capsys, "detect", tmp_path / "a.npz")
    assert names_in_one_line(err, "'poses'")


def test_damage_in_another_array_ends_the_packing_anew_with_nothing_written(capsys, tmp_path):
    path = write_amass(tmp_path / "a.npz", WALK.motion, 24, packed=True)
    data = bytearray(path.read_bytes())
    data[data.index(b"dmpls.npy") + 5000] ^= 1
    path.write_bytes(data)
    code, _, err = run(capsys, "refine", path, "-o", tmp_path / "b.npz")
    assert (code, [*tmp_path.iterdir()]) == (2, [path])
    assert names_in_one_line(err, "'dmpls'")


def test_an_array_that_would_fill_the_memory_is_refused_unread(capsys, tmp_path):
    """A member of some bytes that says it is 3 GiB."""
    np.savez_compressed(tmp_path / "a.npz", poses=np.zeros((900, 156)), trans=np.zeros((900, 3)))
    data = bytearray((tmp_path / "a.npz").read_bytes())
    at = data.index(b"PK\x01\x02")
    data[at + 24 : at + 28] = (3 << 30).to_bytes(4, "little")
    (tmp_path / "a.npz").write_bytes(data)
    _, _, err = run(capsys, "detect", tmp_path / "a.npz")
    assert names_in_one_line(err, "32 MiB", "3072 MiB")


def test_another_format_s_name_is_refused_before_anything_is_written(walk, capsys, tmp_path):
    for source, out in ((walk, "b.bvh"), (ASSETS / "walk.bvh", "b.npz")):
        code, _, err = run(capsys, "refine", source, "-o", tmp_path / out)
        assert (code, err.count("\n"), list(tmp_path.iterdir())) == (2, 1, [])
        assert f" {source.suffix}" in err
    with pytest.raises(TwistError, match=r"\.npz"):
        write_clip(read_npz(walk), read_npz(walk).motion, tmp_path / "b.BVH")


# -- commands --------------------------------------------------------------------------------------


def test_the_commands_take_it_as_they_take_a_bvh(walk, capsys, tmp_path):
    assert is_clip(walk)
    _, out, _ = run(capsys, "info", walk, "--json")
    told = json.loads(out)
    assert (told["format"], told["channels"], len(told["chains"])) == ("npz", 159, 10)
    _, out, _ = run(capsys, "detect", walk, "--json")
    assert {i["chain"]: (i["start"], i["stop"]) for i in json.loads(out)["intervals"]} == FOUND
    assert run(capsys, "signals", walk, "--csv", tmp_path / "s.csv")[0] == 0
    assert (tmp_path / "s.csv").read_text().count("\n") == 1 + 344 * 10
    corrected = tmp_path / "b.npz"
    code, _, _ = run(capsys, "refine", walk, "-o", corrected, "--report", tmp_path / "report")
    assert code == 0
    page = tmp_path / "report" / f"{walk.name}.report.html"
    assert page.exists()  # not by the stem alone, which a BVH beside it may have
    _, out, _ = run(capsys, "diff", walk, corrected, "--json")
    joints = {j["joint"] for j in json.loads(out)["joints"]}
    assert joints == {"left_elbow", "left_wrist", "right_hip", "right_knee"}


def test_a_session_is_applied_to_the_bytes_of_refine(walk, capsys, tmp_path):
    clip = read_npz(walk)
    found = analyse(clip).detect()
    review = Review.of(found)
    review.accept()
    write_session(clip, review.state, tmp_path / "a.json")
    code, _, _ = run(capsys, "apply", tmp_path / "a.json", walk, "-o", tmp_path / "b.npz")
    assert code == 0
    refined = accepted_motion(clip, found.chains_and_limbs, review.state)
    assert (tmp_path / "b.npz").read_bytes() == create_file_patch_for_motion(clip, refined).data


def test_arrays_with_an_axis_of_joints_keep_it(tmp_path):
    arrays = amass_arrays(WALK.motion.sliced(0, 30), 24)
    arrays["poses"] = np.asfortranarray(arrays["poses"].reshape(30, 24, 3))
    arrays["body_pose"] = arrays["poses"][:, 1:].copy()
    np.savez(tmp_path / "a.npz", **arrays)
    clip = read_npz(tmp_path / "a.npz")
    turned = clip.motion.rotations.copy()
    turned[3, 5] = exponential(np.array([0.1, 0.2, 0.3]))
    write_clip(clip, clip.motion.with_rotations(turned), tmp_path / "b.npz")
    now = loaded(tmp_path / "b.npz")
    assert now["poses"][3, 5].tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert now["poses"].flags.f_contiguous
    assert now["body_pose"].tobytes() == now["poses"][:, 1:].tobytes()
    differ = now["poses"] != arrays["poses"]
    assert np.argwhere(differ.any(axis=2)).tolist() == [[3, 5]]
