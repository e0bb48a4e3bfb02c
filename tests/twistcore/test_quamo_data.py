"""Metrics by hand, noise, the 24 joints, resampling, and poses from .npz."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.quality.figure import foot_contact_mask, foot_slide, quality_of_positions
from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.formats.smpl.pose_files import PosesError
from twistcore.formats.smpl.poses_clip import read_smpl_poses_as_clip
from twistcore.formats.smpl.skeleton import (
    ANKLES,
    CMU_UNIT,
    MIRROR,
    PARENTS,
    TOES,
    find_network_joints,
    make_smpl_skeleton,
    metres_per_unit,
    smpl_joint_positions,
)
from twistcore.quamo.resample import (
    apply_sample_corrections,
    interpolate_poses_at_times,
    network_sample_times,
)
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import (
    exponential,
    geodesic_angle,
    logarithm,
    normalise,
    quaternion_from_axis_angle,
    slerp,
)
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise, gaussian_smoothed_noise
from twistcore.study.quamo.pose_errors import pose_metrics, procrustes
from twistcore.study.quamo.rivals import mean_rotation_offset, rotate_joints_by_fitted_offsets
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence, read_cmu_bvh_sequence_folder


@pytest.fixture(scope="module")
def dance():
    return read_cmu_bvh_sequence(ASSETS / "dance.bvh")


def figure(frames=6):
    return np.random.default_rng(0).normal(0.0, 300.0, (1, 24, 3)).repeat(frames, axis=0)


def test_metrics_of_a_shift_are_global_alone():
    truth = figure()
    found = pose_metrics(truth + np.array([3.0, 0.0, 4.0]), truth)
    assert found.mpjpe == pytest.approx(0.0, abs=1e-9)
    assert found.p_mpjpe == pytest.approx(0.0, abs=1e-9)
    assert (found.g_mpjpe, found.gre) == (pytest.approx(5.0), pytest.approx(5.0))
    assert (found.accel, found.g_accel) == (0.0, pytest.approx(0.0, abs=1e-9))


def test_mpjpe_leaves_the_root_out_and_accel_is_a_second_difference():
    truth = figure()
    found = truth.copy()
    found[3, 5] += [23.0, 0.0, 0.0]
    e = pose_metrics(found, truth)
    assert e.mpjpe == pytest.approx(1.0 / 6.0)  # 23 mm over 23 joints and 6 frames
    # In frames 2, 3, 4 the second difference is 23, −46, 23; there are 4 of them.
    assert e.accel == pytest.approx((23.0 + 46.0 + 23.0) / 23.0 / 4.0)
    assert e.g_accel == pytest.approx((23.0 + 46.0 + 23.0) / 24.0 / 4.0)
    assert e.g_mpjpe == pytest.approx(23.0 / 24.0 / 6.0)


def test_procrustes_undoes_a_similarity_and_never_reflects():
    truth = figure()
    turn = Rotation.from_rotvec([0.3, -1.0, 0.4]).as_matrix()
    assert procrustes(2.5 * truth @ turn.T + 7.0, truth) == pytest.approx(truth)
    mirrored = truth * np.array([-1.0, 1.0, 1.0])
    placed = procrustes(mirrored, truth)
    assert np.linalg.norm(placed - truth, axis=-1).mean() > 50.0


def test_foot_slide_counts_feet_on_the_ground_that_move_20_mm():
    places = np.zeros((11, 24, 3))
    for joint in (*ANKLES, *TOES):
        places[:, joint, 1] = 50.0
    left, right = (ANKLES[0], TOES[0]), (ANKLES[1], TOES[1])
    places[5:, left, 0] = 20.0  # one slide of exactly 20 mm
    places[7:, right, 2] = 19.9  # too small
    contact = foot_contact_mask(places)
    assert contact.all()
    assert foot_slide(places, contact) == pytest.approx(10.0)
    lifted = places.copy()
    lifted[5:, left, 1] = 100.0
    assert foot_slide(lifted, foot_contact_mask(lifted)) == 0.0


def test_quality_needs_no_truth():
    places = figure(8)
    shaken = places + np.random.default_rng(1).normal(0.0, 5.0, places.shape)
    assert quality_of_positions(places).deviation is None
    assert quality_of_positions(places).jitter == pytest.approx(0.0, abs=1e-9)
    assert quality_of_positions(shaken, places).jitter > 10.0
    assert 5.0 < quality_of_positions(shaken, places).deviation < 15.0


def test_wandering_noise_has_unit_size_and_its_time_scale():
    x = gaussian_smoothed_noise(4000, (40,), np.random.default_rng(0), 0.04)
    assert x.std() == pytest.approx(1.0, abs=0.05)
    lag = 19  # 0.75 s: the correlation of a Gaussian kernel with itself at σ is e^(−1/4)
    assert (x[lag:] * x[:-lag]).mean() == pytest.approx(np.exp(-0.25), abs=0.06)


@parametrize("systematic", [False, True])
@parametrize(("level", "mpjpe", "accel"), [("A", 56.0, 18.0), ("B", 47.0, 9.0)])
def test_noise_is_calibrated_and_seeded(level, mpjpe, accel, systematic):
    found = []
    for name in ("walk", "dance", "basketball"):
        s = read_cmu_bvh_sequence(ASSETS / f"{name}.bvh")
        truth = s.places_mm(s.q, s.r)
        for seed in range(8):
            noise = Noise(LEVELS[level], systematic)
            q, r = add_pose_noise(s.q, s.r, noise, np.random.default_rng(seed))
            e = pose_metrics(s.places_mm(q, r), truth)
            found.append((e.mpjpe, e.accel))
    again = add_pose_noise(s.q, s.r, noise, np.random.default_rng(7))
    assert (again[0] == q).all()
    assert (add_pose_noise(s.q, s.r, noise, np.random.default_rng(8))[0] != q).any()
    mean = np.mean(found, axis=0)
    assert mean[0] == pytest.approx(mpjpe, rel=0.12)
    assert mean[1] == pytest.approx(accel, rel=0.15)


def test_the_systematic_part_stands_still_and_is_redrawn(dance):
    means = []
    for seed in range(2):
        noise = Noise(LEVELS["A"], systematic=True)
        q, _ = add_pose_noise(dance.q, dance.r, noise, np.random.default_rng(seed))
        means.append(mean_rotation_offset([(q, dance.q)]))
    assert np.degrees(np.abs(means[0])).mean() > 1.0
    assert abs(np.corrcoef(means[0].ravel(), means[1].ravel())[0, 1]) < 0.5


def test_bursts_freeze_a_limb(dance):
    q, _ = add_pose_noise(dance.q, dance.r, Noise(LEVELS["B"]), np.random.default_rng(3))
    frozen, _ = add_pose_noise(
        dance.q, dance.r, Noise(LEVELS["B"], bursts=60.0), np.random.default_rng(3)
    )
    assert ((np.diff(frozen, axis=0) == 0.0).all(axis=2)).sum() > 5
    assert not (np.diff(q, axis=0) == 0.0).all(axis=2).any()


def test_the_24_joints_of_a_clip_stand_where_the_clip_has_them(walk):
    topology = find_network_joints(walk.skeleton)
    motion = walk.motion.sliced(1, 60)
    places = smpl_joint_positions(
        topology.offsets, topology.reduced(motion.rotations), motion.positions[:, 0]
    )
    theirs = forward_kinematics(motion)[1][:, topology.joints]
    # Joints below a folded one: it is held at rest where it carries them.
    below_folded = [15, 22, 23]
    others = [k for k in range(24) if k not in below_folded]
    assert places[:, others] == pytest.approx(theirs[:, others], abs=1e-9)
    away = np.abs(places[:, below_folded] - theirs[:, below_folded]).max()
    assert away < 0.02 * walk.skeleton.height
    again = forward_kinematics(
        Motion(
            make_smpl_skeleton(topology.offsets),
            topology.reduced(motion.rotations),
            (0,),
            motion.positions[:, :1],
            0.01,
        )
    )[1]
    assert places == pytest.approx(again)


def test_reduced_and_restored_are_inverse(walk):
    topology = find_network_joints(walk.skeleton)
    rotations = walk.motion.rotations[:50]
    back = topology.restored(topology.reduced(rotations), rotations)
    assert geodesic_angle(back, rotations).max() < 1e-7


def test_mirroring_keeps_the_tree():
    assert [MIRROR[MIRROR[k]] for k in range(24)] == list(range(24))
    for k, parent in enumerate(PARENTS):
        assert parent < 0 or PARENTS[MIRROR[k]] == MIRROR[parent]


def test_a_skeleton_without_the_24_joints_is_refused_and_units_are_asked_for(walk):
    assert metres_per_unit(walk.skeleton) == CMU_UNIT
    assert metres_per_unit(walk.skeleton, 0.01) == 0.01
    small = parse_bvh(
        b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
        b"End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.04\n0 0 0\n",
        ASSETS / "small.bvh",
    ).skeleton
    with pytest.raises(TwistError, match="24 joints"):
        find_network_joints(small)
    with pytest.raises(TwistError, match="--unit"):
        metres_per_unit(small)


def test_slerp_is_scipys_and_samples_are_those_of_25_hz(walk):
    q = walk.motion.rotations[:, 18]
    times = network_sample_times(len(q), 1.0 / 120.0)
    assert np.diff(times) == pytest.approx(4.8)
    ours = interpolate_poses_at_times(q[:, None], np.zeros((len(q), 3)), times)[0][:, 0]
    from scipy.spatial.transform import Slerp

    theirs = Slerp(np.arange(len(q)), Rotation.from_quat(q, scalar_first=True))(times)
    assert geodesic_angle(ours, theirs.as_quat(scalar_first=True)).max() < 1e-6
    half = slerp(q[:1], q[5:6], np.array([0.5]))
    assert geodesic_angle(half, q[:1]) == pytest.approx(geodesic_angle(half, q[5:6]))


def test_no_correction_carried_back_changes_nothing_and_a_constant_one_all(walk):
    q, r = walk.motion.rotations, walk.motion.positions[:, 0]
    times = network_sample_times(len(q), walk.motion.frame_time)
    q_in, r_in = interpolate_poses_at_times(q, r, times)
    same = apply_sample_corrections(q, r, times, q_in, r_in, q_in, r_in)
    assert geodesic_angle(same[0], q).max() < 1e-7
    assert same[1] == pytest.approx(r)
    offset = np.full((q.shape[1], 3), 0.1)
    turned = apply_sample_corrections(
        q, r, times, q_in, r_in, rotate_joints_by_fitted_offsets(q_in, offset), r_in + 2.0
    )
    assert geodesic_angle(turned[0], rotate_joints_by_fitted_offsets(q, offset)).max() < 1e-7
    assert turned[1] == pytest.approx(r + 2.0)


def test_a_folder_without_clips_is_refused(tmp_path):
    with pytest.raises(TwistError, match="BVH"):
        read_cmu_bvh_sequence_folder(tmp_path)


def test_composed_bvh_reads_back_as_the_same_motion(dance):
    motion = Motion(make_smpl_skeleton(dance.offsets), dance.q, (0,), dance.r[:, None], 0.04)
    clip = parse_bvh(bvh_text(motion).encode(), ASSETS / "new.bvh")
    assert clip.warnings == ()
    assert clip.motion.frame_time == pytest.approx(0.04)
    order = [clip.skeleton.names.index(name) for name in motion.skeleton.names]
    there, here = forward_kinematics(clip.motion)[1][:, order], forward_kinematics(motion)[1]
    assert there == pytest.approx(here, abs=1e-4)


def write_poses(path, sequence, **changes):
    arrays = {
        "poses": logarithm(sequence.q).reshape(len(sequence.q), -1),
        "trans": sequence.r,
        "mocap_framerate": np.array(25.0),
        "offsets": sequence.offsets,
    } | changes
    np.savez(path, **{k: v for k, v in arrays.items() if v is not None})
    return path


def test_poses_from_npz_are_the_clip_they_were_made_of(dance, tmp_path):
    clip = read_smpl_poses_as_clip(write_poses(tmp_path / "a.npz", dance), up="y")
    topology = find_network_joints(clip.skeleton)
    found = topology.reduced(clip.motion.rotations)
    assert np.degrees(geodesic_angle(found, dance.q)).max() < 1e-3
    assert clip.motion.positions[:, 0] == pytest.approx(dance.r + dance.offsets[0], abs=1e-5)
    from_template = read_smpl_poses_as_clip(
        write_poses(tmp_path / "b.npz", dance, offsets=None),
        up="y",
        template=ASSETS / "dance.bvh",
    )
    offsets = find_network_joints(from_template.skeleton).offsets
    assert offsets == pytest.approx(dance.offsets, abs=1e-5)


def test_z_up_is_turned_upright_and_52_joints_keep_the_body(dance, tmp_path):
    turn = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), 0.5 * np.pi)
    from twistcore.skeleton.rotation import multiply, rotate

    q = dance.q.copy()
    q[:, 0] = multiply(turn, q[:, 0])
    poses = np.zeros((len(q), 156))
    poses[:, :66] = logarithm(q[:, :22]).reshape(len(q), 66)
    path = write_poses(tmp_path / "a.npz", dance, poses=poses, trans=rotate(turn, dance.r))
    clip = read_smpl_poses_as_clip(path)
    found = find_network_joints(clip.skeleton).reduced(clip.motion.rotations)
    assert np.degrees(geodesic_angle(found[:, :22], dance.q[:, :22])).max() < 1e-3
    assert clip.motion.positions[:, 0] == pytest.approx(dance.r + dance.offsets[0], abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"poses": None}, "'poses'"),
        ({"trans": None}, "'trans'"),
        ({"poses": np.zeros((4, 70))}, r"\(frames, 72\)"),
        ({"poses": np.zeros((4, 72))}, "trans"),
        ({"mocap_framerate": None}, "--fps"),
        ({"mocap_framerate": np.array(0.0)}, "fps"),
        ({"offsets": None}, "--template"),
        ({"offsets": np.zeros((22, 3))}, "offsets"),
        ({"poses": np.array([["x"] * 72])}, "numbers"),
    ],
)
def test_bad_poses_are_refused_in_one_sentence(changes, what, dance, tmp_path):
    path = write_poses(tmp_path / "bad.npz", dance, **changes)
    with pytest.raises(PosesError, match=what) as caught:
        read_smpl_poses_as_clip(path)
    assert "bad.npz" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nan_and_files_that_are_no_npz_are_refused(dance, tmp_path):
    poses = logarithm(dance.q).reshape(len(dance.q), -1)
    poses[3, 5] = np.nan
    with pytest.raises(PosesError, match="frame 3"):
        read_smpl_poses_as_clip(write_poses(tmp_path / "nan.npz", dance, poses=poses))
    text = tmp_path / "text.npz"
    text.write_text("HIERARCHY")
    with pytest.raises(PosesError, match=r"\.npz"):
        read_smpl_poses_as_clip(text)


def test_mean_offset_of_a_known_one():
    q = normalise(np.random.default_rng(0).standard_normal((30, 24, 4)))
    offset = np.random.default_rng(1).normal(0.0, 0.1, (24, 3))
    assert mean_rotation_offset([(rotate_joints_by_fitted_offsets(q, offset), q)]) == pytest.approx(
        -offset, abs=1e-9
    )
    assert exponential(np.zeros(3)).tolist() == [1.0, 0.0, 0.0, 0.0]
