"""Show the name of the bone under the mouse, and select its chain or limb on a click."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, QPointF
from PySide6.QtWidgets import QToolTip

from inspector.language import tr, translate_core_sentence
from inspector.viewport.bodies import BoneSegment
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.camera_moves import Steering
from inspector.viewport.frame_drawing import FrameDrawing
from inspector.viewport.limb_circle import limb_bones
from inspector.viewport.solid_and_ghost import Pose
from inspector.widgets.labels import escape_tool_tip_text
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import Array, rotate

_REACH = 12.0  # distance in pixels from a body within which the mouse hits the body


class Pointing(QObject):
    """A mouse handler that selects clicked bones and shows the name of the bone under the mouse."""

    def __init__(self, view: Steering, drawing: FrameDrawing) -> None:
        super().__init__(view)
        self.names = True  # True to show the name of the bone under the mouse
        self._drawing = drawing

    @property
    def _view(self) -> Steering:
        """The view, which is the Qt parent.

        A Python reference is not stored, because it would keep the view and its OpenGL context
        alive.
        """
        view = self.parent()
        assert isinstance(view, Steering)
        return view

    def click(self, at: QPointF) -> None:
        """Select the chain of the bone at a point in the view, or nothing if no bone is there.

        A second click selects the limb of the bone.
        """
        found = self._next_chain(self.joint_at(at))
        if found is not None:
            self._view.document.select_chain(found.name)

    def hover(self, at: QPointF) -> None:
        """Show a tool tip with the name of the bone at a point in the view, if there is one.

        A bone has the name of its parent joint. If a click would select a whole limb, the tool tip
        also shows the name of the limb.
        """
        data = self._view.document.data
        if self.names and data is not None:
            joint = self.joint_at(at)
            name = data.motion.skeleton.names[joint] if joint is not None else ""
            found = self._next_chain(joint)
            if isinstance(found, Limb):
                name += "\n" + tr(
                    "Click to select the whole limb: {limb}",
                    limb=translate_core_sentence(found.label),
                )
            QToolTip.showText(
                self._view.mapToGlobal(at.toPoint()), escape_tool_tip_text(name), self._view
            )

    def _next_chain(self, joint: int | None) -> Chain | None:
        """Return the chain or limb that a click on the bone of a joint would select, or None."""
        data = self._view.document.data
        if joint is None or data is None:
            return None
        skeleton = data.motion.skeleton
        own = [c for c in data.analysis.chains if c.parent == joint]
        own += [
            limb
            for limb in data.analysis.limbs
            if any(joint == above for above, _ in limb_bones(limb, skeleton))
        ]
        names = [c.name for c in own]
        selected = self._view.document.chain
        at = names.index(selected) + 1 if selected in names else 0
        return own[at % len(own)] if own else None

    def joint_at(self, at: QPointF) -> int | None:
        """Return the parent joint of the bone at a point in the view, or None."""
        scene, camera = self._view.scene, self._view.camera
        if scene is None or camera is None:
            return None
        pose = self._drawing.pose(scene)
        size = self._view.picture_size()
        point = np.array([at.x() % max(size[0], 1), at.y()])
        bone = _bone_at(point, scene.bones, pose, camera, size)
        return None if bone is None else scene.bones[bone].parent


def _bone_at(
    point: Array,
    bones: tuple[BoneSegment, ...],
    pose: Pose,
    camera: OrbitCamera,
    size: tuple[int, int],
) -> int | None:
    """Return the index of the foremost bone at a pixel (2,), or None.

    `size` is the width and the height of the image.
    """
    if not bones:
        return None
    parents = np.array([b.parent for b in bones])
    joints = pose.positions[parents]
    tips = joints + rotate(pose.rotations[parents], np.array([b.tip for b in bones]))
    start, near = camera.project(joints, *size)
    stop, far = camera.project(tips, *size)
    away, where = _distance_to_segments(point, start, stop)
    depth = near + where * (far - near)
    pixels = size[1] / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
    beside = np.maximum(away - pixels * np.array([b.width for b in bones]), 0.0)
    found = int(np.lexsort((depth, np.round(beside / 3.0)))[0])
    return found if beside[found] <= _REACH else None


def _distance_to_segments(point: Array, start: Array, stop: Array) -> tuple[Array, Array]:
    """Return the distance from a point to each line segment, (n,), and the closest points on them.

    The closest points, (n,), are fractions of the segments, from 0 at the start to 1 at the end.
    """
    along = stop - start
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    where = np.clip(((point - start) * along).sum(axis=1) / length, 0.0, 1.0)
    return np.linalg.norm(start + where[:, None] * along - point, axis=1), where
