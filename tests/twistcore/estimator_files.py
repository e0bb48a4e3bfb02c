"""Files as estimators of poses from video write them, made from a clip's rotations."""

import pickle
import sys
import types
import zlib

import numpy as np

from twistcore.skeleton.rotation import logarithm, matrix_from_quaternion, multiply, rotate
from twistcore.skeleton.rotation import quaternion_from_axis_angle as about

X = np.array([1.0, 0.0, 0.0])
UPRIGHT = {"y": 0.0, "z": 0.5 * np.pi, "-y": -np.pi}  # from y up to a file's axes


def seen(q, r, up):
    """Rotations and places with another axis up."""
    turn = about(X, UPRIGHT[up])
    q = q.copy()
    q[:, 0] = multiply(turn, q[:, 0])
    return q, rotate(turn, r)


def vectors(q):
    return logarithm(q).reshape(len(q), -1).astype(np.float32)


class NumpyArrayWrapper:
    """What joblib writes before an array's bytes; found under joblib's name while writing."""


NumpyArrayWrapper.__module__ = "joblib.numpy_pickle"


class _Joblib(pickle._Pickler):
    def __init__(self, file):
        super().__init__(file, protocol=4)
        self.file = file

    def save(self, obj, *rest):
        if not isinstance(obj, np.ndarray) or obj.dtype.hasobject:
            return super().save(obj, *rest)
        stand_in = NumpyArrayWrapper()
        vars(stand_in).update(
            subclass=np.ndarray, shape=obj.shape, order="C", dtype=obj.dtype, allow_mmap=True,
            numpy_array_alignment_bytes=16,
        )  # fmt: skip
        super().save(stand_in)
        self.framer.commit_frame(force=True)
        padding = 16 - (self.file.tell() + 1) % 16
        self.file.write(bytes([padding]) + b"\xff" * padding + obj.tobytes())
        return None


def write_joblib(path, thing, compress=False):
    """As joblib.dump does, which need not be installed."""
    module = types.ModuleType("joblib.numpy_pickle")
    module.NumpyArrayWrapper = NumpyArrayWrapper
    had = {n: sys.modules.get(n) for n in ("joblib", "joblib.numpy_pickle")}
    sys.modules.update({"joblib": types.ModuleType("joblib"), "joblib.numpy_pickle": module})
    try:
        with path.open("wb") as file:
            _Joblib(file).dump(thing)
    finally:
        for name, old in had.items():
            sys.modules.pop(name) if old is None else sys.modules.update({name: old})
    if compress:
        path.write_bytes(zlib.compress(path.read_bytes()))
    return path


# -- a writer a layout: path without suffix, rotations (frames, 24, 4), places, y up -> the file ---


def amass(path, q, r):
    q, r = seen(q, r, "z")
    return _npz(path, poses=vectors(q), trans=r, mocap_framerate=np.array(25.0), betas=np.zeros(16))


def amass_smplx(path, q, r):
    q, r = seen(q, r, "z")
    poses = np.zeros((len(q), 165))
    poses[:, :66] = vectors(q[:, :22])
    parts = {"root_orient": poses[:, :3], "pose_body": poses[:, 3:66]}
    return _npz(path, poses=poses, trans=r, mocap_frame_rate=np.array(25.0), **parts)


def smplx(path, q, r):
    hands = {"left_hand_pose": np.zeros((len(q), 45)), "jaw_pose": np.zeros((len(q), 3))}
    parts = {"global_orient": vectors(q[:, :1]), "body_pose": vectors(q[:, 1:22])}
    return _npz(path, **parts, transl=r, **hands)


def matrices(path, q, r):
    q, r = seen(q, r, "-y")
    m = matrix_from_quaternion(q).astype(np.float32)
    return _npz(path, global_orient=m[:, :1], body_pose=m[:, 1:], pred_cam_t=r)


def all_matrices(path, q, r):
    q, r = seen(q, r, "z")
    return _npz(path, poses=matrix_from_quaternion(q), trans=r, fps=np.array(25))


def world_and_camera(path, q, r):
    """A dict by person, with a second one who was seen in four frames."""
    camera, place = seen(q, r, "-y")
    record = {
        "pose": vectors(camera), "trans": place + 3.0, "pose_world": vectors(q), "trans_world": r,
        "betas": np.zeros((len(q), 10)), "frame_ids": np.arange(len(q)),
    }  # fmt: skip
    persons = {np.int64(0): record, np.int64(7): {k: v[:4] for k, v in record.items()}}
    return write_joblib(path.with_suffix(".pkl"), persons)


def lists_by_frame(path, q, r):
    """Lists of persons by frame, one of them carried on where nobody was seen, compressed."""
    q, r = seen(q, r, "-y")
    m = matrix_from_quaternion(q).astype(np.float32)
    frames = {}
    for k in range(len(q)):
        smpl = {"global_orient": m[k, :1], "body_pose": m[k, 1:], "betas": np.zeros(10)}
        frames[f"img/{k:06d}.jpg"] = {
            "time": k, "tid": [2, 9], "tracked_time": [0, 3], "smpl": [smpl, smpl],
            "camera": [r[k].astype(np.float32), np.zeros(3)], "mask": [{"size": [4, 4]}],
        }  # fmt: skip
    return write_joblib(path.with_suffix(".pkl"), frames, compress=True)


def rows(path, q, r):
    """A row for every person in every frame, in a dict inside of an .npz."""
    q, r = seen(q, r, "-y")
    n = len(q)
    thetas = np.repeat(vectors(q), 2, axis=0)
    outputs = {
        "smpl_thetas": np.concatenate([0.0 * thetas[:, :3], thetas[:, 3:]], axis=1),
        "world_global_rots": thetas[:, :3], "world_trans": np.repeat(r, 2, axis=0)[:, None],
        "cam_trans": np.zeros((2 * n, 3)), "track_ids": np.tile([0, 1], n),
        "reorganize_idx": np.repeat(np.arange(n), 2), "center_confs": np.ones(2 * n),
    }  # fmt: skip
    return _npz(path, outputs=np.array(outputs, dtype=object), imgpaths=np.array(["a.jpg"]))


def person_axis(path, q, r):
    q, r = seen(q, r, "-y")
    parts = {"root_orient": vectors(q[:, :1]), "pose_body": vectors(q[:, 1:22]), "trans": r}
    both = {k: np.stack([np.zeros_like(v), v]) for k, v in parts.items()}
    return _npz(path, **both, betas=np.zeros((2, 16)), floor_plane=np.zeros((1, 3)))


def one_array(path, q, r):
    """A dict in an .npy."""
    q, r = seen(q, r, "-y")
    arrays = {"pred_rotmat": matrix_from_quaternion(q), "pred_trans": r[:, None]}
    np.save(path, np.array(arrays | {"frame": 30 + np.arange(len(q))}, dtype=object))
    return path.with_suffix(".npy")


def camera_and_world_dicts(path, q, r):
    inside = {"global_orient": vectors(q[:, :1]), "body_pose": vectors(q[:, 1:22]), "transl": r}
    with path.with_suffix(".pkl").open("wb") as file:
        pickle.dump({"smpl_params_global": inside, "K_fullimg": np.eye(3)}, file)
    return path.with_suffix(".pkl")


def _npz(path, **arrays):
    np.savez(path.with_suffix(".npz"), **arrays)
    return path.with_suffix(".npz")


# The writer, the person to ask for, whether the file has a rate, and its note.
LAYOUTS = {
    "amass": (amass, None, True, "z axis is taken as up"),
    "amass, SMPL-X": (amass_smplx, None, True, "z axis is taken as up"),
    "SMPL-X": (smplx, None, False, "the figure is then upright"),
    "matrices": (matrices, None, False, "depth was not measured"),
    "all matrices": (all_matrices, None, True, "z axis is taken as up"),
    "world and camera": (world_and_camera, "0", False, "y axis is taken as up (as usual in this"),
    "lists by frame": (lists_by_frame, None, False, "depth was not measured"),
    "rows": (rows, "1", False, "-y axis is taken as up (as usual in this"),
    "person axis": (person_axis, "1", False, "-y axis is taken as up (the figure is then"),
    "one array": (one_array, None, False, "-y axis is taken as up (as usual in this"),
    "dicts of world and camera": (camera_and_world_dicts, None, False, "y axis is taken as up"),
}
