"""The signs in the left image: the angle, the letters of the sides, and the whole figure."""

from __future__ import annotations

import numpy as np

from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.frame_drawing import FrameDrawing
from inspector.viewport.overlays import NOTHING, Overlays, sampled
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.whole_figure import miniature, miniature_size
from twistcore.skeleton.rotation import Array

_GIRTH = 0.035  # half the width of a limb with a margin, in figure heights
_BESIDE = 14.0  # pixels from a limb to the letter of its side
_HEAVY = 3  # a fan or another label weighs as much as so many bones
_THIN = 0.02  # half the width of a bone, in figure heights
_ALONG = np.linspace(0.0, 1.0, 12)
_TOO_LARGE = 0.02  # share of the picture by which a figure may be outside


def show_signs(
    overlays: Overlays,
    drawing: FrameDrawing,
    scene: Scene,
    camera: OrbitCamera,
    size: tuple[int, int],
) -> None:
    """Show the signs of the drawn pose. `size` is the size of an image in pixels."""
    thick = _GIRTH * scene.height * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0))
    sign, pose = drawing.angle_to_show(scene), drawing.left
    busy, spoke = NOTHING, None
    body = NOTHING if pose is None else _body(scene, pose, camera, size)
    if sign is None:
        overlays.show_angle("")
    else:
        bone, depth = camera.project(sign.bone, *size)
        spoke = None if sign.spoke is None else camera.project(sign.spoke, *size)[0]
        rim = camera.project(sign.rim, *size)[0]
        body = np.vstack([body[::2], *(rim,) * _HEAVY])
        text = f"{abs(sign.degrees):.0f}°"
        overlays.show_angle(text, bone, thick / float(depth.mean()), spoke, body)
        angle = sampled(overlays.angle.geometry())
        body = np.vstack([body, *(angle,) * _HEAVY])
        busy = np.vstack([bone, angle] if spoke is None else [bone, angle, spoke])
    if pose is None or drawing.guest is not None:
        overlays.show_sides({})
        overlays.show_whole(None, miniature_size(size), busy)
        return
    places = _letters(drawing, pose, camera, size, thick, spoke)
    overlays.show_sides(places, body)
    letters = [sampled(one.geometry()) for one in overlays.sides.values() if not one.isHidden()]
    busy = np.vstack([busy, body[::2], *letters])
    _show_whole(overlays, drawing, scene, pose, camera, size, busy)


def _body(scene: Scene, pose: Pose, camera: OrbitCamera, size: tuple[int, int]) -> Array:
    """Return pixels all over the bones, heads and chests of a pose, (n, 2)."""
    ends = scene.rods.ends(pose.rotations, pose.positions)
    start, stop = ends[:, 0], ends[:, 1]
    points = start[:, None] + _ALONG[:, None] * (stop - start)[:, None]
    pixels, depth = camera.project(points, *size)
    wide = np.maximum(scene.rods.width, _THIN * scene.height)[:, None]
    reach = wide * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
    across = np.stack([reach, np.zeros_like(reach)], axis=-1)
    return np.concatenate([pixels, pixels + across, pixels - across]).reshape(-1, 2)


def _letters(
    drawing: FrameDrawing,
    pose: Pose,
    camera: OrbitCamera,
    size: tuple[int, int],
    thick: float,
    spoke: Array | None,
) -> dict[str, Array]:
    """Return the pixel (2,) of each side's letter.

    A letter is next to its limb, away from the fan and from the other limb.
    """
    joints = drawing.sides()  # the selected limb is the last
    pixels, depth = camera.project(pose.positions[list(joints.values())].reshape(-1, 3), *size)
    middle = pixels.mean(axis=0) if len(pixels) else pixels
    places = {}
    for number, (side, at, far) in enumerate(zip(joints, pixels, depth, strict=True), start=1):
        here = middle if spoke is None or number < len(joints) else spoke.mean(axis=0)
        right = at[0] >= here[0]
        places[side] = at + np.array([(1.0 if right else -1.0) * (thick / far + _BESIDE), 0.0])
    return places


def _show_whole(
    overlays: Overlays,
    drawing: FrameDrawing,
    scene: Scene,
    pose: Pose,
    camera: OrbitCamera,
    size: tuple[int, int],
    busy: Array,
) -> None:
    """Show the whole figure if the image shows only a part of it."""
    count = len(scene.bones)
    own = np.isin(scene.rods.parent[:count], drawing.own_joints(scene))
    ends = scene.rods.ends(pose.rotations, pose.positions)[:count]
    pixels, _ = camera.project(ends, *size)
    spare, room = _TOO_LARGE * np.array(size), np.array(size)
    small = miniature_size(size)
    if ((pixels[own] > -spare) & (pixels[own] < room + spare)).all():
        overlays.show_whole(None, small, busy)
        return
    drawn = miniature(scene, pose, ends, own, drawing.sides(), camera, small)
    limb = pixels[pose.roles != Role.PLAIN].reshape(-1, 2)
    overlays.show_whole(drawn, small, np.vstack([busy, limb]))
