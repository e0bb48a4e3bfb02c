"""Files as AMASS has them, made of a BVH clip: the same figure on SMPL's joints, z up, metres."""

import numpy as np

from twistcore.formats.npz.body import BODIES
from twistcore.formats.smpl.rest_pose import smpl_rest_pose_change
from twistcore.formats.smpl.skeleton import CMU_UNIT, PARENTS, find_network_joints
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    conjugate,
    logarithm,
    multiply,
    quaternion_from_axis_angle,
    rotate,
)

UPRIGHT = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), 0.5 * np.pi)  # from y up to z up


def loaded(path):
    with np.load(path) as arrays:
        return dict(arrays)


def amass_arrays(motion: Motion, joints=52, dtype=np.float64, *, own=True, tilt=None):
    """The arrays of a file; own: with 'J', the joints at rest, else a reader knows only β.

    tilt: how bones rest off the axes of a T-pose, (24, 4).

    CMU rests with legs apart: its rotations are told anew as of a T-pose, so that joints stay where
    they are, bones and all.
    """
    topology = find_network_joints(motion.skeleton)
    offsets, q = CMU_UNIT * topology.offsets, topology.reduced(motion.rotations)
    a = smpl_rest_pose_change(offsets).turns
    a = a if tilt is None else multiply(tilt, a)
    turned = multiply(q, conjugate(a))
    at_rest = offsets.copy()
    for j, parent in enumerate(PARENTS):
        if parent >= 0:
            turned[:, j] = multiply(a[parent], turned[:, j])
            at_rest[j] = rotate(a[parent], offsets[j])
    at_rest[0] = [0.002, -0.2, 0.03]
    turned[:, 0] = multiply(UPRIGHT, turned[:, 0])
    places = rotate(UPRIGHT, CMU_UNIT * motion.positions[:, 0]) - at_rest[0]
    body = min(joints, 24 if joints == 24 else 22)
    poses = np.zeros((motion.frames, 3 * joints), dtype=dtype)
    poses[:, : 3 * body] = logarithm(turned[:, :body]).reshape(motion.frames, -1)
    parents = BODIES[body].parents
    rest = np.zeros((body, 3))
    for j, parent in enumerate(parents.tolist()):
        rest[j] = at_rest[j] + (rest[parent] if parent >= 0 else 0.0)
    arrays = {
        "trans": places.astype(dtype),
        "gender": np.array("neutral"),
        "mocap_framerate": np.array(motion.fps),
        "betas": np.linspace(-1.0, 1.0, 16),
        "dmpls": np.random.default_rng(0).normal(size=(motion.frames, 8)),
        "poses": poses,
    }
    if joints == 55:
        arrays |= {
            "root_orient": poses[:, :3],
            "pose_body": poses[:, 3:66],
            "pose_hand": poses[:, 75:],
            # As AMASS has it: objects, which nobody may unpack unasked.
            "markers_latent_vids": np.array({"ARIEL": 3, "C7": 7}, dtype=object),
        }
    return arrays | ({"J": rest} if own else {})


def write_amass(path, motion, joints=52, dtype=np.float64, *, own=True, packed=False):
    """Such a file; packed: compressed."""
    save = np.savez_compressed if packed else np.savez
    save(path, **amass_arrays(motion, joints, dtype, own=own))
    return path
