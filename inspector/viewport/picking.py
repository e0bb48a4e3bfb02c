"""Which bone is under the mouse: the nearest projected segment."""

from __future__ import annotations

import numpy as np

from inspector.viewport.bodies import Bone
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from twistcore.rotation import Array, rotate

REACH = 12.0  # pixels beside a body that still count


def distance_to_segments(point: Array, start: Array, stop: Array) -> tuple[Array, Array]:
    """Distance (n,) of a point (2,) to segments (n, 2), and where along them it is nearest, 0…1."""
    along = stop - start
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    where = np.clip(((point - start) * along).sum(axis=1) / length, 0.0, 1.0)
    return np.linalg.norm(start + where[:, None] * along - point, axis=1), where


def bone_at(
    point: Array,
    bones: tuple[Bone, ...],
    rotations: Array,
    positions: Array,
    camera: OrbitCamera,
    size: tuple[int, int],
) -> int | None:
    """Number of the bone at a pixel (2,), or None; of those under it, the one in front.

    rotations (joints, 4) and positions (joints, 3) of the frame; size: of the view, pixels.
    """
    if not bones:
        return None
    parents = np.array([b.parent for b in bones])
    tips = positions[parents] + rotate(rotations[parents], np.array([b.tip for b in bones]))
    start, near = camera.project(positions[parents], *size)
    stop, far = camera.project(tips, *size)
    away, where = distance_to_segments(point, start, stop)
    depth = near + where * (far - near)
    pixels = size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
    beside = np.maximum(away - pixels * np.array([b.width for b in bones]), 0.0)
    found = int(np.lexsort((depth, np.round(beside / 3.0)))[0])
    return found if beside[found] <= REACH else None
