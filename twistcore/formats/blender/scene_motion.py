"""Convert a scene's bones to a motion with the axes and the unit of BVH files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from twistcore.errors import TwistError
from twistcore.formats.blender.process import SUFFIXES, TIME_LIMIT, Handover, read_scene
from twistcore.formats.bvh import write_motion
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array, conjugate, multiply, normalise, rotate

_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # rotates Z up to Y up
_STRETCHED = 1e-3
# Share of the height; a bone that moves farther from its rest position has position channels.
_MOVED = 1e-5


@dataclass(frozen=True, eq=False)
class Converted:
    """A scene's motion, and notes about data that the motion cannot represent."""

    motion: Motion
    notes: tuple[str, ...]


def write_as_bvh(
    source: Path,
    output: Path,
    blender: str,
    *,
    unit: float | None = None,
    take: str | None = None,
    figure: str | None = None,
    fps: float | None = None,
    time_limit: float = TIME_LIMIT,
) -> tuple[Handover, Converted]:
    """Read a scene with Blender and write its skeleton's motion as a BVH file.

    Parameters
    ----------
    source
        The scene file.
    output
        The BVH file to write.
    blender
        The program, from :func:`find_blender`.
    unit
        Length unit of the BVH in metres. By default, it depends on the scene's format.
    take, figure, fps, time_limit
        The same as in :func:`read_scene`.

    Raises
    ------
    TwistError
        If the scene cannot be read or converted.
    """
    scene = read_scene(source, blender, take=take, figure=figure, fps=fps, time_limit=time_limit)
    try:
        found = motion_from_scene(scene, unit or SUFFIXES[source.suffix.lower()])
    except TwistError as error:
        raise TwistError(f"{source}: {error}") from None
    write_motion(found.motion, output)
    return scene, found


def motion_from_scene(scene: Handover, unit: float) -> Converted:
    """Convert a scene's bones to a motion with the same poses.

    In the rest pose of the result, no joint is rotated, and offsets are the differences between the
    heads of bones. Bones that move relative to their parents have position channels. `unit` is the
    length unit of the result in metres.

    Raises TwistError if a bone is mirrored or has a scale of 0.
    """
    rest, _ = _turned(scene.rest)
    turned, sizes = _turned(scene.poses)
    globally = _quaternions(_UP @ turned @ np.swapaxes(rest, -1, -2) @ _UP.T)
    heads = scene.poses[..., :3, 3] @ _UP.T / unit
    rest_heads = scene.rest[:, :3, 3] @ _UP.T / unit
    tails = scene.tails @ _UP.T / unit
    local, places = globally.copy(), heads.copy()
    offsets = rest_heads.copy()
    for joint, parent in enumerate(scene.parents.tolist()):
        if parent >= 0:
            back = conjugate(globally[:, parent])
            local[:, joint] = normalise(multiply(back, globally[:, joint]))
            places[:, joint] = rotate(back, heads[:, joint] - heads[:, parent])
            offsets[joint] = rest_heads[joint] - rest_heads[parent]
    leaves = sorted(set(range(len(scene.names))) - set(scene.parents.tolist()))
    ends = tuple((j, _three(tails[j] - rest_heads[j])) for j in leaves)
    skeleton = Skeleton(scene.names, scene.parents, offsets, ends)
    moved = np.abs(places - offsets).max(axis=(0, 2)) > _MOVED * skeleton.height
    positioned = tuple(np.flatnonzero(moved | (scene.parents < 0)).tolist())
    motion = Motion(skeleton, local, positioned, places[:, list(positioned)], 1.0 / scene.fps)
    return Converted(motion, _notes(scene, sizes, moved))


def _turned(matrices: Array) -> tuple[Array, Array]:
    """Split bone matrices (…, 4, 4) into rotations (…, 3, 3) and the scales of the axes (…, 3).

    Raises TwistError if a bone is mirrored or has a scale of 0.
    """
    m = matrices[..., :3, :3]
    sizes = np.linalg.norm(m, axis=-2)
    if not np.isfinite(m).all() or (sizes < 1e-12).any():
        raise TwistError("expected bones with a scale other than 0, found a bone with scale 0")
    if (np.linalg.det(m / sizes[..., None, :]) <= 0.0).any():
        raise TwistError("expected bones that are not mirrored, found a bone with a negative scale")
    return m / sizes[..., None, :], sizes


def _quaternions(matrices: Array) -> Array:
    """Convert rotation matrices (…, 3, 3) to quaternions (…, 4), w first."""
    flat = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    return np.asarray(flat, dtype=np.float64).reshape(*matrices.shape[:-2], 4)


def _three(vector: Array) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z


def _notes(scene: Handover, sizes: Array, moved: NDArray[np.bool_]) -> tuple[str, ...]:
    notes = []
    _, rest_sizes = _turned(scene.rest)
    off = np.abs(sizes / rest_sizes - 1.0) > _STRETCHED
    stretched = np.asarray(off.any(axis=(0, 2)))
    if stretched.any():
        names = _listed(scene, stretched)
        notes.append(f"the scale of {names} is left out, because a BVH cannot store scale")
    moving = moved & (scene.parents >= 0)
    if moving.any():
        notes.append(
            f"{_listed(scene, moving)} move relative to their parents and get position channels"
        )
    return tuple(notes)


def _listed(scene: Handover, which: NDArray[np.bool_]) -> str:
    names = [scene.names[j] for j in np.flatnonzero(which).tolist()]
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
