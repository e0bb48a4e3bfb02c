"""SMPL-X in parts, AIST++ and ROMP: read where AMASS is, rewritten in place, and nothing is run."""

import io
import pickle
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.tiers import parametrize
from tests.twistcore import pose_layout_files as files
from tests.twistcore.amass_files import amass_arrays
from twistcore.analysis.clip_analysis import analyse
from twistcore.batch.inputs import find_input_clips
from twistcore.cli import main
from twistcore.errors import NpzError, TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion, write_clip
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.formats.npz import PklClip, parse_pkl
from twistcore.formats.npz.pickled_arrays import read_pickle, read_pickle_with_offsets
from twistcore.formats.reading import is_clip, is_clip_without_motion, read_clip
from twistcore.skeleton.rotation import geodesic_angle

WALK = read_bvh(ASSETS / "walk_injected.bvh")
FOUND = {  # the interval of the BVH, by the same chain's name on SMPL's joints
    {"LeftForeArm": "left_elbow", "RightUpLeg": "right_hip"}[i.chain]: (i.start, i.stop)
    for i in analyse(WALK).detect()
}
SHORT = WALK.motion.sliced(0, 30)


def loaded(data):
    with np.load(io.BytesIO(data)) as arrays:
        return dict(arrays)


def corrected(path, out, capsys):
    """What `refine` writes, and the clip that is in it."""
    assert main(["refine", str(path), "-o", str(out)]) == 0
    assert "8 of 8 intervals" in capsys.readouterr().out
    return read_clip(out)


def assert_only_intervals_differ(before, after):
    """Rotations of the two clips are the same bits but where something was found."""
    analysis = analyse(before)
    frames = np.zeros(before.motion.rotations.shape[:2], dtype=bool)
    for i in analysis.detect():
        chain = next(c for c in analysis.chains if c.name == i.chain)
        frames[i.start : i.stop, list(chain.changed_joints(before.motion.skeleton))] = True
    differ = (before.motion.rotations != after.motion.rotations).any(axis=-1)
    assert differ.any()
    assert not (differ & ~frames).any()
    assert not list(analyse(after).detect())


# -- SMPL-X in parts -------------------------------------------------------------------------------


@pytest.mark.parametrize("packed", [False, True], ids=["stored", "packed"])
@pytest.mark.parametrize("smplx", [False, True], ids=["AMASS's names", "smplx's names"])
@parametrize(("hands", "face", "joints"), [(True, True, 55), (True, False, 52), (False, False, 22)])
def test_parts_without_the_whole_are_read_and_written(
    hands, face, joints, smplx, packed, tmp_path, capsys
):
    path, out = tmp_path / "walk_stageii.npz", tmp_path / "out.npz"
    arrays = files.stageii(WALK.motion, smplx=smplx, hands=hands, face=face)
    (np.savez_compressed if packed else np.savez)(path, **arrays)
    clip = read_clip(path)
    assert (clip.format, len(clip.skeleton), clip.frames) == ("npz", joints, 344)
    assert clip.motion.fps == pytest.approx(120.0, rel=1e-4)
    whole = amass_arrays(WALK.motion, 55)["poses"]
    np.testing.assert_array_equal(clip.poses[:, :66], whole[:, :66])
    assert {i.chain: (i.start, i.stop) for i in analyse(clip).detect()} == FOUND
    assert not is_clip_without_motion(path)
    assert create_file_patch_for_motion(clip, clip.motion).data == path.read_bytes()
    after = corrected(path, out, capsys)
    assert_only_intervals_differ(clip, after)
    was, now = loaded(path.read_bytes()), loaded(out.read_bytes())
    body = "body_pose" if smplx else "pose_body"
    assert [name for name in was if was[name].tobytes() != now[name].tobytes()] == [body]
    with zipfile.ZipFile(path) as one, zipfile.ZipFile(out) as other:
        assert one.namelist() == other.namelist()


def test_parts_may_have_dtypes_and_shapes_of_their_own(tmp_path, capsys):
    arrays = files.stageii(WALK.motion, hands=False, face=False)
    arrays["root_orient"] = arrays["root_orient"].reshape(344, 1, 3)
    body = arrays["pose_body"].astype(np.float32).reshape(344, 21, 3)
    arrays["pose_body"] = np.asfortranarray(body)
    arrays["trans"] = arrays["trans"].reshape(344, 1, 3)
    np.savez(tmp_path / "a.npz", **arrays)
    clip = read_clip(tmp_path / "a.npz")
    assert_only_intervals_differ(clip, corrected(tmp_path / "a.npz", tmp_path / "b.npz", capsys))


def test_hands_in_other_numbers_are_named_and_left(tmp_path):
    arrays = files.stageii(SHORT, smplx=True, hands=False, face=False)
    arrays |= {"left_hand_pose": np.ones((30, 6)), "right_hand_pose": np.ones((30, 6))}
    np.savez(tmp_path / "a.npz", **arrays)
    clip = read_clip(tmp_path / "a.npz")
    assert len(clip.skeleton) == 22
    said = " ".join(map(str, clip.warnings))
    assert "'left_hand_pose'" in said


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"pose_body": np.zeros((2, 30, 63))}, "quamo refine"),
        ({"pose_body": np.zeros((30, 21, 3, 3))}, "quamo refine"),
        ({"pose_body": np.zeros((29, 63))}, "29 and 30"),
        ({"pose_body": np.full((30, 63), np.nan)}, "'pose_body'"),
        ({"trans": np.zeros((30, 2))}, "(30, 2)"),
    ],
)
def test_parts_that_are_no_poses_are_refused_in_a_sentence(other, said, tmp_path):
    np.savez(tmp_path / "a.npz", **files.stageii(SHORT, hands=False, face=False) | other)
    with pytest.raises(NpzError) as found:
        read_clip(tmp_path / "a.npz")
    assert said in str(found.value)


# -- AIST++ ----------------------------------------------------------------------------------------


@parametrize("protocol", [3, 4, 5], quick=2)
@parametrize("dtype", [np.float32, np.float64, ">f8"], quick=2)
def test_a_pickle_of_aist_is_read_and_rewritten_in_place(dtype, protocol, tmp_path, capsys):
    path, out = tmp_path / "gBR_sBM.pkl", tmp_path / "out.pkl"
    files.write_aist(path, WALK.motion, protocol, dtype)
    clip = read_clip(path)
    assert isinstance(clip, PklClip)
    assert (clip.format, len(clip.skeleton), clip.motion.fps) == ("pkl", 24, pytest.approx(60.0))
    assert any("60" in str(w) for w in clip.warnings)
    places = amass_arrays(WALK.motion, 24)["trans"]
    np.testing.assert_allclose(clip.motion.positions[:, 0] - clip.rest, places, atol=1e-5)
    assert create_file_patch_for_motion(clip, clip.motion).data == path.read_bytes()
    assert main(["refine", str(path), "-o", str(out), "--fps", "120"]) == 0
    assert "8 of 8 intervals" in capsys.readouterr().out
    was, now = path.read_bytes(), out.read_bytes()
    assert len(was) == len(now)
    before, after = pickle.loads(was), pickle.loads(now)
    assert list(before) == list(after)
    for name in ("smpl_scaling", "smpl_trans"):
        assert before[name].tobytes() == after[name].tobytes()
    assert after["smpl_poses"].dtype == before["smpl_poses"].dtype
    assert_only_intervals_differ(read_clip(path, fps=120.0), read_clip(out, fps=120.0))


def test_the_place_is_written_in_the_file_s_units(tmp_path):
    path = files.write_aist(tmp_path / "a.pkl", SHORT)
    clip = read_clip(path)
    positions = clip.motion.positions.copy()
    positions[5:9] += 0.25
    moved = replace(clip.motion, positions=positions)
    after = pickle.loads(create_file_patch_for_motion(clip, moved).data)["smpl_trans"]
    np.testing.assert_allclose(
        after - clip.trans, files.SCALING * (positions - clip.motion.positions)[:, 0], atol=1e-3
    )


def test_the_same_names_in_an_npz_are_read(tmp_path):
    np.savez(tmp_path / "a.npz", **files.aist(SHORT))
    clip = read_clip(tmp_path / "a.npz")
    assert (clip.format, clip.frames, len(clip.skeleton)) == ("npz", 30, 24)


@pytest.mark.parametrize("protocol", [0, 1, 2])
def test_a_pickle_that_cannot_be_rewritten_in_place_says_so_and_is_left(protocol, tmp_path, capsys):
    path, out = tmp_path / "a.pkl", tmp_path / "out.pkl"
    files.write_aist(path, WALK.motion, protocol)
    assert main(["detect", str(path)]) == 0
    capsys.readouterr()
    before = path.read_bytes()
    assert main(["refine", str(path), "-o", str(out), "--fps", "120"]) == 2
    assert names_in_one_line(capsys.readouterr().err, "protocol", " 3")
    assert path.read_bytes() == before
    assert not out.exists()


class Bomb:
    """Writes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_nothing_in_a_pickle_is_run(tmp_path):
    found = files.aist(SHORT) | {"smpl_loss": Bomb(tmp_path / "ran")}
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(found))
    clip = read_clip(tmp_path / "a.pkl")
    write_clip(clip, clip.motion, tmp_path / "b.pkl")
    assert not (tmp_path / "ran").exists()
    (tmp_path / "c.pkl").write_bytes(pickle.dumps({"smpl_poses": Bomb(tmp_path / "ran")}))
    with pytest.raises(NpzError):
        read_clip(tmp_path / "c.pkl")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (pickle.dumps([1.0]), "pickle"),
        (pickle.dumps({"a": 1}), "found a"),
        (pickle.dumps({"poses": np.zeros((3, 72))}), "'trans'"),
        (pickle.dumps({"smpl_poses": [[1.0]], "smpl_trans": 0}), "'smpl_poses'"),
        (pickle.dumps({"smpl_poses": np.zeros((3, 70))}), "(3, 70)"),
        (b"", "pickle"),
        (b"\x80\x04nonsense", "pickle"),
        (b"\x1f\x8b\x08\x00", "gzip"),
    ],
)
def test_other_pickles_are_refused_in_a_sentence(data, said, tmp_path):
    (tmp_path / "a.pkl").write_bytes(data)
    with pytest.raises(NpzError) as found:
        read_clip(tmp_path / "a.pkl")
    assert said in str(found.value)
    assert "\n" not in str(found.value)


def test_in_a_folder_a_pickle_without_poses_is_no_clip(tmp_path):
    files.write_aist(tmp_path / "dance.pkl", SHORT)
    (tmp_path / "SMPL_NEUTRAL.pkl").write_bytes(pickle.dumps({"v_template": np.zeros((9, 3))}))
    assert is_clip(tmp_path / "dance.pkl")
    assert [p.name for p in clip_paths_in_folder(tmp_path)] == ["dance.pkl"]
    assert [s.name for s in find_input_clips([str(tmp_path)]).sources] == ["dance.pkl"]


@pytest.mark.parametrize("protocol", range(6))
def test_where_the_bytes_of_arrays_are_is_known(protocol):
    rng = np.random.default_rng(protocol)
    some = [
        rng.normal(size=(4, 3)),
        np.asfortranarray(rng.normal(size=(300, 72))),
        rng.normal(size=2),
    ]
    data = pickle.dumps({"a": some, "b": some[1]}, protocol=protocol)
    found, places = read_pickle_with_offsets(data)
    for here, there in zip(some, found["a"], strict=True):
        np.testing.assert_array_equal(here, there)
        start = places.of(there)
        assert (start is None) == (protocol < 3)
        if start is not None:
            assert data[start : start + here.nbytes] == here.tobytes("A")
    assert places.of(np.zeros(3)) is None
    assert list(read_pickle(data)) == ["a", "b"]


# -- ROMP ------------------------------------------------------------------------------------------


@parametrize("packed", [False, True], ids=["stored", "packed"])
@parametrize("others", [(7,), (), (3, 9)], ids=["two persons", "alone", "three"])
def test_a_video_of_romp_is_read_and_rewritten_in_place(others, packed, tmp_path, capsys):
    path, out = tmp_path / "video_results.npz", tmp_path / "out.npz"
    # Others leave before the end: the person seen in most frames is meant.
    found = files.romp(WALK.motion, others=others)
    for frame in list(found["results"].values())[300:]:
        for name in frame if others else ():
            frame[name] = frame[name][-1:]
    files.write_romp(path, found, packed=packed)
    clip = read_clip(path, fps=120.0)
    assert (clip.format, clip.frames, len(clip.skeleton)) == ("npz", 344, 24)
    assert {i.chain: (i.start, i.stop) for i in analyse(clip).detect()} == FOUND
    said = " ".join(map(str, clip.warnings))
    assert (f"{len(others) + 1} people" in said) == bool(others)
    assert create_file_patch_for_motion(clip, clip.motion).data == path.read_bytes()
    assert main(["refine", str(path), "-o", str(out), "--fps", "120"]) == 0
    assert "8 of 8 intervals" in capsys.readouterr().out
    after = read_clip(out, fps=120.0)
    assert_only_intervals_differ(clip, after)
    with np.load(out, allow_pickle=True) as arrays:  # of our own making
        results, sequences = (arrays[name].item() for name in ("results", "sequence_results"))
    own = np.array([frame["smpl_thetas"][-1] for frame in results.values()])
    np.testing.assert_array_equal(own, after.poses)
    np.testing.assert_array_equal(np.array(sequences[1]["smpl_thetas"]), own)
    for frame, before in zip(results.values(), found["results"].values(), strict=True):
        np.testing.assert_array_equal(frame["smpl_thetas"][:-1], before["smpl_thetas"][:-1])
        np.testing.assert_array_equal(frame["cam_trans"], before["cam_trans"])


def test_half_precision_lists_of_persons_are_read(tmp_path, capsys):
    path = files.write_romp(tmp_path / "video_results.npz", files.older_romp(WALK.motion))
    clip = read_clip(path, fps=120.0)
    assert (clip.poses.dtype, clip.frames) == (np.float16, 344)
    assert main(["refine", str(path), "-o", str(tmp_path / "out.npz"), "--fps", "120"]) == 0
    after = read_clip(tmp_path / "out.npz", fps=120.0)
    assert (after.poses != clip.poses).any()


@pytest.mark.parametrize("track_id", [[1], {"a": 1}, np.arange(2), None])
def test_a_track_id_that_is_no_number_is_ignored(tmp_path, track_id):
    found = files.older_romp(SHORT)
    for frame in found["results"].values():
        frame[0]["track_id"] = track_id
    clip = read_clip(files.write_romp(tmp_path / "video_results.npz", found), fps=30.0)
    assert clip.frames == SHORT.frames


def test_frames_without_the_person_are_filled_in_and_named(tmp_path):
    absent = (3, 10, 11)
    whole = amass_arrays(SHORT, 24, np.float32)["poses"]
    path = files.write_romp(tmp_path / "w.npz", files.romp(SHORT, absent=absent))
    clip = read_clip(path)
    there = [k for k in range(30) if k not in absent]
    np.testing.assert_array_equal(clip.poses[there], whole[there])
    assert geodesic_angle(clip.motion.rotations[3], clip.motion.rotations[2]).max() < 0.5
    assert any("3 of 30 frames" in str(w) for w in clip.warnings)
    turned = clip.motion.rotations.copy()
    turned[2:5, 18] = [1.0, 0.0, 0.0, 0.0]
    after = create_file_patch_for_motion(clip, clip.motion.with_rotations(turned)).data
    (tmp_path / "x.npz").write_bytes(after)
    again = read_clip(tmp_path / "x.npz")
    assert not again.poses[[2, 4], 54:57].any()
    np.testing.assert_array_equal(again.poses[5:10], clip.poses[5:10])


def test_a_file_without_places_stands_still(tmp_path):
    path = files.write_romp(tmp_path / "v.npz", files.romp(SHORT, place=False))
    clip = read_clip(path)
    assert np.ptp(clip.motion.positions, axis=0).max() == 0.0
    moved = replace(clip.motion, positions=clip.motion.positions + 1.0)
    assert create_file_patch_for_motion(clip, moved).data == path.read_bytes()


def test_several_persons_whom_nobody_tracked_are_refused(tmp_path):
    path = files.write_romp(tmp_path / "v.npz", files.romp(SHORT, others=(4,), tracked=False))
    with refused(NpzError, "'track_ids'"):
        read_clip(path)


def test_a_frame_of_a_video_alone_is_no_clip_of_a_folder(tmp_path):
    files.write_romp(tmp_path / "video_results.npz", files.romp(SHORT))
    frame = next(iter(files.romp(SHORT)["results"].values()))
    files.write_romp(tmp_path / "00000000.npz", {"results": frame})
    assert [p.name for p in clip_paths_in_folder(tmp_path)] == ["video_results.npz"]
    assert read_clip(tmp_path / "00000000.npz").frames == 1  # named itself it is read


def test_what_objects_name_is_not_run(tmp_path):
    found = files.romp(SHORT)
    found["results"]["00000003.png"]["bomb"] = Bomb(tmp_path / "ran")
    clip = read_clip(files.write_romp(tmp_path / "v.npz", found))
    assert clip.frames == 30
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("found", [{}, [], {"a": 1}, {"a": {"smpl_thetas": 3}}, 7, {"a": [1, {}]}])
def test_results_of_something_else_are_refused_in_a_sentence(found, tmp_path):
    held = np.empty((), dtype=object)
    held[()] = found
    np.savez(tmp_path / "v.npz", results=held)
    with refused(TwistError, "'poses' and 'trans'"):
        read_clip(tmp_path / "v.npz")


def test_a_pickle_in_memory_is_a_clip():
    assert parse_pkl(pickle.dumps(files.aist(SHORT))).frames == 30
