"""The signs in the left image: the angle, the letters of the sides, and the whole figure."""

from __future__ import annotations

import numpy as np

from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.frame_drawing import FrameDrawing
from inspector.viewport.overlays import Overlays
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.whole_figure import bone_ends, miniature, miniature_size
from twistcore.skeleton.rotation import Array

_GIRTH = 0.035  # half the width of a limb with a margin, in figure heights
_BESIDE = 14.0  # pixels from a limb to the letter of its side
_TOO_LARGE = 0.02  # share of the image by which a figure may be outside


def show_signs(
    overlays: Overlays,
    drawing: FrameDrawing,
    scene: Scene,
    camera: OrbitCamera,
    size: tuple[int, int],
) -> None:
    """Show the signs of the drawn pose. `size` is the size of an image in pixels."""
    thick = _GIRTH * scene.height * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0))
    sign, pose = drawing.angle_to_show(scene, camera), drawing.left
    busy, spoke = np.zeros((0, 2)), None
    if sign is None:
        overlays.show_angle("")
    else:
        bone, depth = camera.project(sign.bone, *size)
        spoke = None if sign.spoke is None else camera.project(sign.spoke, *size)[0]
        text = f"{abs(sign.degrees):.0f}°" + (f"  (×{sign.times})" if sign.times > 1 else "")
        overlays.show_angle(text, bone, thick / float(depth.mean()), spoke)
        corners = overlays.angle.geometry()
        box = np.array([corners.topLeft().toTuple(), corners.bottomRight().toTuple()])
        busy = np.vstack([bone, box] if spoke is None else [bone, box, spoke])
    if pose is None or drawing.guest is not None:
        overlays.show_sides({})
        overlays.show_whole(None, miniature_size(size), busy)
        return
    places = _letters(drawing, pose, camera, size, thick, spoke)
    overlays.show_sides(places)
    _show_whole(overlays, drawing, scene, pose, camera, size, np.vstack([busy, *places.values()]))


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
    joints = set(drawing.own_joints(scene))
    own = np.array([b.parent in joints for b in scene.bones], dtype=bool)
    ends = bone_ends(scene, pose)
    pixels, _ = camera.project(ends, *size)
    spare, room = _TOO_LARGE * np.array(size), np.array(size)
    small = miniature_size(size)
    if ((pixels[own] > -spare) & (pixels[own] < room + spare)).all():
        overlays.show_whole(None, small, busy)
        return
    drawn = miniature(scene, pose, ends, own, drawing.sides(), camera, small)
    limb = pixels[pose.roles != Role.PLAIN].reshape(-1, 2)
    overlays.show_whole(drawn, small, np.vstack([busy, limb]))
