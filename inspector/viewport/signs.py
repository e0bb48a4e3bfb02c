"""Place the signs in the left image: angle or clock, side letters, and whole figure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.clock import clock_hands, clock_size
from inspector.viewport.crowding import Crowding
from inspector.viewport.frame_drawing import FrameDrawing
from inspector.viewport.overlays import Overlays
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.whole_figure import miniature, miniature_size
from twistcore.skeleton.rotation import Array

_GIRTH = 0.030  # half the width of a limb with a margin, in figure heights
_GAP = 12.0  # pixels from a limb to the letter of its side
_ENOUGH = 30.0  # pixels; a larger distance from the fan to a letter is no further advantage
# Weights in Crowding of a pixel at the marks at both ends of the fan, and of a pixel of the fan and
# the fins; a pixel of a bone has the weight 1.
_MARKED = 60
_HEAVY = 4
# Number of pixels along and across a bone that are added to Crowding: for a plain bone, and for a
# coloured bone
_FEW, _MANY = (12, 3), (24, 9)
_BEHIND = 0.06  # in figure heights; a bone hides only points that are at least this far behind it
_THIN = 0.02  # minimum of half the width of a bone, in figure heights
_ALONG = np.linspace(0.0, 1.0, 12)[:, None]  # positions along a bone
_TOO_LARGE = 0.02  # share of the image by which a figure may extend beyond its border


def show_signs(
    overlays: Overlays,
    drawing: FrameDrawing,
    scene: Scene,
    camera: OrbitCamera,
    size: tuple[int, int],
) -> None:
    """Show the angle, the side letters and the whole figure for the last drawn pose.

    Parameters
    ----------
    overlays
        The widgets that show the signs.
    drawing
        The drawing of the frame, which provides the pose and the angle.
    scene
        The scene of the open clip.
    camera
        The camera from which the image is seen.
    size
        The width and height of an image in pixels.
    """
    sign, pose = drawing.sign, drawing.left
    turn = None if sign is None else sign.turn
    crowding = Crowding(*size)
    overlays.reserve_scale(crowding)
    if pose is not None:
        _add_body(crowding, scene, pose, camera, size)
    if sign is not None:
        crowding.add(camera.project(sign.points, *size)[0], _HEAVY)
    if turn is not None:
        marks = np.stack([turn.circle.centre + turn.circle.aside, turn.after])
        crowding.add(camera.project(marks, *size)[0], _MARKED)
    hands = None if sign is None or turn is None else clock_hands(turn, camera, sign.degrees)
    clocked = overlays.show_clock(hands, clock_size(size), crowding)
    thick = _GIRTH * scene.height * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0))
    text, bone, wide = "", np.zeros((2, 2)), 0.0
    if sign is not None and not clocked:
        bone, depth = camera.project(sign.bone, *size)
        text, wide = f"{abs(sign.degrees):.0f}°", thick / float(depth.mean())
    overlays.show_angle(text, bone, wide, crowding)
    if pose is None or drawing.guest is not None:
        overlays.show_whole(None, miniature_size(size), crowding)
        overlays.show_sides({}, crowding)
        return
    sides = dict(drawing.sides())
    if sign is not None:  # the opposite letter could be mistaken for the side of the error
        sides = dict([*sides.items()][-1:])
    _show_whole(overlays, drawing, scene, pose, camera, size, crowding, sides)
    spoke = np.zeros((0, 2)) if turn is None else camera.project(turn.spoke, *size)[0]
    letters = _letters(drawing, scene, pose, camera, size, thick, spoke)
    shown = {side: at for side, at in letters.items() if side in sides}
    overlays.show_sides(shown, crowding, wrong=sign is not None)


def _add_body(
    crowding: Crowding, scene: Scene, pose: Pose, camera: OrbitCamera, size: tuple[int, int]
) -> None:
    """Add the bones, heads and chests of a pose to the crowded parts of an image.

    More pixels are added for coloured bones, so that labels preferably cover plain bones.
    """
    ends = scene.ends(pose)
    coloured = np.zeros(len(ends), dtype=bool)
    coloured[: len(pose.roles)] = pose.roles != Role.PLAIN
    wide = np.maximum(scene.rods.width, _THIN * scene.height)
    for kind, counts in ((~coloured, _FEW), (coloured, _MANY)):
        crowding.add(_rod_pixels(ends[kind], wide[kind], camera, size, *counts))


def _rod_pixels(
    ends: Array, wide: Array, camera: OrbitCamera, size: tuple[int, int], along: int, across: int
) -> Array:
    """Return pixels that are spread over rods, (n, 2).

    Parameters
    ----------
    ends
        The ends of the rods in world space, (rods, 2, 3).
    wide
        Half the width of each rod, (rods,).
    camera
        The camera from which the image is seen.
    size
        The width and height of the image in pixels.
    along, across
        The number of pixels along and across each rod.
    """
    shares = np.linspace(0.0, 1.0, along)[:, None]
    points = ends[:, :1] + shares * (ends[:, 1:] - ends[:, :1])
    pixels, depth = camera.project(points, *size)
    reach = wide[:, None] * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
    x = pixels[..., :1] + reach[..., None] * np.linspace(-1.0, 1.0, across)
    return np.stack([x, np.broadcast_to(pixels[..., 1:], x.shape)], axis=-1).reshape(-1, 2)


def _is_hidden(
    point: Array, scene: Scene, pose: Pose, camera: OrbitCamera, size: tuple[int, int]
) -> bool:
    """Return True if a bone hides or nearly hides a point, (3,), in the image."""
    ends = scene.ends(pose)
    points = ends[:, :1] + _ALONG * (ends[:, 1:] - ends[:, :1])
    pixels, depth = camera.project(points, *size)
    at, far = camera.project(point, *size)
    reach = _GIRTH * scene.height * size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
    near = np.linalg.norm(pixels - at, axis=-1) < reach
    return bool((near & (depth < far - _BEHIND * scene.height)).any())


def _letters(
    drawing: FrameDrawing,
    scene: Scene,
    pose: Pose,
    camera: OrbitCamera,
    size: tuple[int, int],
    thick: float,
    spoke: Array,
) -> dict[str, Array]:
    """Return the pixel at which to show the letter of each side, (2,), keyed by side.

    The letters of the selected limb and its counterpart on the opposite side are placed next to
    them, as far from each other as possible. The letter of the selected limb is the last entry and
    is also placed away from the fan. The counterpart has no letter if its joint is hidden.

    Parameters
    ----------
    drawing
        The drawing of the frame, which provides the joint of each side.
    scene
        The scene of the open clip.
    pose
        The pose in the left image.
    camera
        The camera from which the image is seen.
    size
        The width and height of the image in pixels.
    thick
        The radius of a limb in pixels at a distance of 1 from the camera.
    spoke
        The pixels at the centre and at the edge of the fan, (2, 2), or (0, 2) if there is no fan.
    """
    joints = dict(drawing.sides())  # the selected limb is the last entry
    pixels, depth = camera.project(pose.positions[list(joints.values())].reshape(-1, 3), *size)
    places = {}
    for number, (side, at, far) in enumerate(zip(joints, pixels, depth, strict=True)):
        chosen = number == len(joints) - 1
        if not chosen and _is_hidden(pose.positions[joints[side]], scene, pose, camera, size):
            continue
        candidates = at + (thick / far + _GAP) * np.array([[1.0, 0.0], [-1.0, 0.0]])
        clear = np.linalg.norm(candidates[:, None] - np.delete(pixels, number, axis=0), axis=-1)
        near = np.linalg.norm(candidates[:, None] - (spoke if chosen else spoke[:0]), axis=-1)
        score = clear.sum(axis=1) + np.minimum(near, _ENOUGH).sum(axis=1)
        places[side] = candidates[int(np.argmax(score))]
    return places


def _show_whole(
    overlays: Overlays,
    drawing: FrameDrawing,
    scene: Scene,
    pose: Pose,
    camera: OrbitCamera,
    size: tuple[int, int],
    crowding: Crowding,
    sides: Mapping[str, int],
) -> None:
    """Show a small drawing of the whole figure if the image shows only a part of the figure.

    Parameters
    ----------
    overlays
        The widgets that show the signs.
    drawing
        The drawing of the frame, which provides the person to draw.
    scene
        The scene of the open clip.
    pose
        The pose in the left image.
    camera
        The camera from which the image is seen.
    size
        The width and height of the image in pixels.
    crowding
        The crowded parts of the image.
    sides
        The joint that gets the letter of each side, keyed by side.
    """
    count = len(scene.bones)
    own = np.isin(scene.rods.parent[:count], drawing.own_joints(scene))
    ends = scene.ends(pose)[:count]
    pixels, _ = camera.project(ends, *size)
    spare, room = _TOO_LARGE * np.array(size), np.array(size)
    small = miniature_size(size)
    if ((pixels[own] > -spare) & (pixels[own] < room + spare)).all():
        overlays.show_whole(None, small, crowding)
        return
    drawn = miniature(scene, pose, ends, own, sides, camera, small)
    overlays.show_whole(drawn, small, crowding)
