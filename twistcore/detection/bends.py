"""Measure how much each joint bends from frame to frame, regardless of twist [Method, step 7].

The bend of a joint is the angle between the bone that leads to it and the bone that leads away from
it. In a twist error, a joint rotates about its bone and the next joint rotates back. No bone
changes its direction, so no bend changes, even if many chains have errors in the same frames. A
limb flip changes only two bends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.chain import bone_direction
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, multiply, rotate, vector_lengths

_BLOCK = 2048  # frames
_SHORTEST = 1e-6  # share of the skeleton's height; a shorter bone has no direction


def bend_steps(motion: Motion) -> Array:
    """Return the change of each root's rotation and of each joint's bend from frame to frame.

    A joint at the position of its root has no bone above it and therefore no bend. For such a
    joint, the change of its own bone's direction in the root's coordinates is returned.

    Returns
    -------
    ndarray, shape (n, frames − 1)
        One row per root, followed by one row per joint with a bone, in radians ≥ 0.
    """
    parents, q = motion.skeleton.parents, motion.rotations
    above = [bone_direction(motion, j, []) if p >= 0 else None for j, p in enumerate(parents)]
    hanging: dict[tuple[int, bool], list[tuple[list[int], Array, Array | None]]] = {}
    for joint in np.flatnonzero(parents >= 0).tolist():
        own, path = _own_bone(motion, joint, above), _path(motion, joint, above)
        if own is not None:
            of = above[path[0]]
            hanging.setdefault((len(path), of is None), []).append((path, own, of))
    roots = np.flatnonzero(parents < 0)
    groups: list[tuple[NDArray[np.int64], Array, Array | None]] = []
    for (_, on_root), alike in hanging.items():
        paths, own_bones, bones_above = zip(*alike, strict=True)
        above_all = None if on_root else _together(bones_above)
        groups.append((np.array(paths).T, _together(own_bones), above_all))
    steps = np.empty((len(roots) + sum(g[0].shape[1] for g in groups), max(motion.frames - 1, 0)))
    # Each block fits into the processor cache, and long clips need no additional memory.
    for low in range(0, motion.frames - 1, _BLOCK):
        at = slice(low, min(low + _BLOCK + 1, motion.frames))
        part = q[at]
        cosine = np.abs(np.einsum("tjc,tjc->jt", part[:-1, roots], part[1:, roots]))
        found = [2.0 * np.arccos(np.minimum(cosine, 1.0))]
        for joints_of, bones, of_all in groups:
            turned = part[:, joints_of[0]]
            for joints in joints_of[1:]:
                turned = multiply(turned, part[:, joints])
            directions = rotate(turned, bones if bones.ndim == 2 else bones[at])
            if of_all is None:
                found.append(_angles(directions[:-1], directions[1:]))
            else:
                off = of_all if of_all.ndim == 2 else of_all[at]
                found.append(np.abs(np.diff(_angles(directions, off), axis=1)))
        steps[:, low : at.stop - 1] = np.concatenate(found)
    return steps


def _own_bone(motion: Motion, joint: int, above: list[Array | None]) -> Array | None:
    """Return the direction of the longest bone below a joint, in the joint's coordinates, or None.

    The direction has the shape (3,) or (frames, 3). If all children are at the joint's position,
    the direction to the End Site is returned, or None if there is no End Site. `above` contains the
    direction of the bone above each joint, or None for a joint without such a bone.
    """
    children = [c for c in motion.skeleton.children[joint] if above[c] is not None]
    if children:
        lengths = [vector_lengths(motion.translation(c)).mean() for c in children]
        return above[children[int(np.argmax(lengths))]]
    end = motion.skeleton.end_offsets.get(joint, np.zeros(3))
    length = float(np.linalg.norm(end))
    return end / length if length > _SHORTEST * motion.skeleton.height else None


def _path(motion: Motion, joint: int, above: list[Array | None]) -> list[int]:
    """Return a joint and its ancestors at the same position, with the topmost ancestor first.

    `above` has the same meaning as in :func:`_own_bone`.
    """
    parents, path = motion.skeleton.parents, [joint]
    while above[path[0]] is None and parents[parents[path[0]]] >= 0:
        path.insert(0, int(parents[path[0]]))
    return path


def _together(directions: Sequence[Array]) -> Array:
    """Stack directions of joints, (3,) or (frames, 3), into (joints, 3) or (frames, joints, 3)."""
    stacked: Array = np.stack(np.broadcast_arrays(*directions), axis=-2)
    return stacked


def _angles(one: Array, other: Array) -> Array:
    """Return the angles between unit vectors (frames, joints, 3), in radians, (joints, frames)."""
    cosine = np.einsum("...jc,...jc->...j", one, other).T
    angles: Array = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angles
