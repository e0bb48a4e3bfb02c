"""Poses as other data sets than AMASS have them, made of a BVH clip: parts, AIST++, ROMP."""

import pickle

import numpy as np

from tests.twistcore.amass_files import amass_arrays

PARTS = {  # of the package smplx, by the name that AMASS has for the same
    "root_orient": "global_orient",
    "pose_body": "body_pose",
    "trans": "transl",
    "pose_jaw": "jaw_pose",
}
SCALING = 93.77886


def stageii(motion, *, smplx=False, hands=True, face=True, dtype=np.float64):
    """SMPL-X in parts, without 'poses'; smplx: by the names of that package."""
    arrays = amass_arrays(motion, 55, dtype)
    poses = arrays.pop("poses")
    del arrays["pose_hand"], arrays["markers_latent_vids"], arrays["dmpls"]
    if face:
        arrays |= {"pose_jaw": poses[:, 66:69], "pose_eye": poses[:, 69:75]}
    if hands:
        arrays["pose_hand"] = poses[:, 75:]
    if smplx:
        arrays = {PARTS.get(name, name): value for name, value in arrays.items()}
        if hands:
            hand = arrays.pop("pose_hand")
            arrays |= {"left_hand_pose": hand[:, :45], "right_hand_pose": hand[:, 45:]}
        if face:
            eyes = arrays.pop("pose_eye")
            arrays |= {"leye_pose": eyes[:, :3], "reye_pose": eyes[:, 3:]}
    arrays["mocap_frame_rate"] = arrays.pop("mocap_framerate")
    return arrays | {"surface_model_type": np.array("smplx"), "num_betas": np.array(16)}


def aist(motion, dtype=np.float32):
    """What a pickle of AIST++ holds."""
    arrays = amass_arrays(motion, 24, np.float64)
    return {
        "smpl_loss": 1.59,
        "smpl_poses": arrays["poses"].astype(dtype),
        "smpl_scaling": np.array([SCALING], dtype=np.float32),
        "smpl_trans": (SCALING * arrays["trans"]).astype(dtype),
    }


def write_aist(path, motion, protocol=pickle.HIGHEST_PROTOCOL, dtype=np.float32):
    """Such a file."""
    path.write_bytes(pickle.dumps(aist(motion, dtype), protocol=protocol))
    return path


def romp(motion, *, tracked=True, others=(), absent=(), place=True):
    """`results` and `sequence_results` of ROMP's video_results.npz.

    others: who else is in each frame, before the person of the motion, who is 1; absent: frames
    without that person.
    """
    arrays = amass_arrays(motion, 24, np.float32)
    results, sequences = {}, {}
    for k, (pose, where) in enumerate(zip(arrays["poses"], arrays["trans"], strict=True)):
        ids = [*others, *([] if k in absent else [1])]
        poses = [np.full(72, 0.01 * who, np.float32) if who != 1 else pose for who in ids]
        frame = {"smpl_thetas": np.array(poses, np.float32).reshape(-1, 72)}
        frame |= {"smpl_betas": np.zeros((len(ids), 10), np.float32), "center_confs": np.ones(3)}
        if place:
            frame["cam_trans"] = np.array([where] * len(ids), np.float32).reshape(-1, 3)
        if tracked:
            frame["track_ids"] = np.array(ids, dtype=np.int32)
        results[f"{k:08d}.png"] = frame
        for row, who in enumerate(ids):
            own = sequences.setdefault(np.int32(who), {"frame_id": []})
            own["frame_id"].append(k)
            for name in frame:
                own.setdefault(name, []).append(frame[name][min(row, len(frame[name]) - 1)])
    return {"results": results} | ({"sequence_results": sequences} if tracked else {})


def older_romp(motion):
    """A list of persons in each frame, by names of ROMP before 2022, in half precision."""
    arrays = amass_arrays(motion, 24, np.float16)
    rows = zip(arrays["poses"], arrays["trans"], strict=True)
    return {
        "results": {
            f"img/{k:06d}.jpg": [{"cam": np.ones(3, np.float16), "poses": pose, "trans": where}]
            for k, (pose, where) in enumerate(rows)
        }
    }


def write_romp(path, found, *, packed=False):
    """Dicts as objects of an .npz."""
    save = np.savez_compressed if packed else np.savez
    save(path, **{name: np.array(value, dtype=object) for name, value in found.items()})
    return path
