"""Move the camera: to a named view, to a limb, along with the figure, or with the mouse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QVariantAnimation
from PySide6.QtWidgets import QWidget

from inspector.session.document import Document
from inspector.viewport.bodies import pose_soup_vertices
from inspector.viewport.camera import (
    VIEW_ANGLE,
    OrbitCamera,
    interpolate_cameras,
    rotate_to_named_view,
)
from inspector.viewport.frame_drawing import pictured_chain
from inspector.viewport.limb_side import best_limb_error_view, limb_joints
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Style
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import Array

_EDGE = 0.03  # share of the image along its border that is treated as outside
_TINY = 0.03  # share of the image's height; a smaller limb is hardly visible
_HALF_VIEW = float(np.tan(VIEW_ANGLE / 2.0))

Aim = tuple[Array, Array]  # points to show, (n, 3), and the unit vector to the camera, (3,)


class Steering(QWidget):
    """A widget with a camera that can be moved. Subclasses redraw the image in `_schedule`."""

    follow = True
    _scene: Scene | None = None
    _camera: OrbitCamera | None = None
    _framed = "iso"  # the named view to restore after resizing; '' after a manual move
    _anchor: Chain | None = None  # the limb to follow; None for the root
    _anchored: Array | None = None
    _turn: tuple[OrbitCamera, OrbitCamera] | None = None  # start and end of a running animation

    def __init__(self, document: Document) -> None:
        super().__init__()
        self.document = document
        self._turning = QVariantAnimation(self, startValue=0.0, endValue=1.0)
        self._turning.valueChanged.connect(self._turned)

    def _schedule(self) -> None:
        raise NotImplementedError

    def _complete(self) -> None:
        """Finish building the scene of the open clip."""
        raise NotImplementedError

    @property
    def scene(self) -> Scene | None:
        """The scene, or None if no clip is open or OpenGL is not available."""
        self._complete()
        return self._scene

    @property
    def camera(self) -> OrbitCamera | None:
        """The camera of the open clip or, if no clip is open, of the previous clip."""
        self._complete()
        return self._camera

    @camera.setter
    def camera(self, camera: OrbitCamera | None) -> None:
        self._camera = camera

    @property
    def turning(self) -> bool:
        """True while an animation rotates the camera towards a limb."""
        return self._turn is not None

    def set_view(self, name: str) -> None:
        """Show one of camera.VIEWS, relative to the direction in which the figure faces."""
        scene = self.scene
        if self.camera is None or scene is None:
            return
        self._stop_turning()
        frame = self.document.frame
        facing = scene.facing(scene.data.positions[frame], self.document.person)
        turned = rotate_to_named_view(self.camera, name, facing)
        self.camera = turned.framing(
            self._around(scene, frame), self._aspect(), covered=self._covered()
        )
        self._framed = name
        self._hold(None)
        self._schedule()

    def show_person(self) -> None:
        """Show the whole figure of the selected person, or of all people, in the last named view.

        If the camera has been moved since that view was selected, use the view "iso".
        """
        self.set_view(self._framed or "iso")

    def focus_chain(self, milliseconds: int = 0) -> None:
        """Rotate the camera to the best view of the roll of the selected chain.

        The rotation is animated and takes `milliseconds`. A new call during the animation starts
        from the current direction.
        """
        chain = pictured_chain(self.document)
        start, scene = self.camera, self.scene
        if start is None or chain is None or scene is None:
            return
        goal = self._towards(chain, scene, start)
        if goal is None:
            return
        self._stop_turning()
        self._framed = ""
        self._hold(chain)
        if milliseconds > 0 and self.isVisible():
            self._turn = replace(start, ahead=goal.ahead).looking_from(start.direction), goal
            self._turning.setDuration(milliseconds)
            self._turning.start()
        else:
            self.camera = goal
        self._schedule()

    def sees_chain(self) -> bool:
        """Return True if the selected limb or bone is in the image and large enough to see."""
        chain, camera, scene = pictured_chain(self.document), self.camera, self.scene
        if chain is None or camera is None or scene is None or self.turning:
            return True
        poses = [self.document.pose(self.document.frame, after=a)[1] for a in (False, True)]
        count = 2 if type(chain) is Chain else None  # only the bone; it may fill the image
        joints = np.vstack([limb_joints(chain, positions)[:count] for positions in poses])
        size = np.array(self.picture_size())
        pixels, depth = camera.project(joints, *self.picture_size())
        ahead = (camera.position - joints) @ camera.direction
        inside = (pixels > _EDGE * size) & (pixels < (1.0 - _EDGE) * size)
        reach = np.linalg.norm(np.ptp(joints, axis=0)) / (2.0 * depth.mean() * _HALF_VIEW)
        return bool(inside.all() and (ahead > 0.0).all() and reach > _TINY)

    def take_view(self, other: Steering) -> None:
        """Copy the camera of another view of the same clip and frame."""
        self._stop_turning()
        self.camera, self._framed, self.follow = other.camera, "", other.follow
        self._hold(other._anchor)

    def set_follow(self, on: bool) -> None:
        """Set whether the camera follows the figure at a constant direction and distance."""
        self.follow = on
        self._hold(self._anchor)

    # -- the best view of a limb --------------------------------------------------------------

    def _aim(self, scene: Scene) -> Aim | None:
        """Return the points and the direction to show, or None to show the selected limb."""
        return None

    def _towards(self, chain: Chain, scene: Scene, camera: OrbitCamera) -> OrbitCamera | None:
        """Return a camera that shows the result of `_aim` or, if that is None, the limb."""
        if (aim := self._aim(scene)) is not None:
            return camera.looking_from(aim[1]).framing(aim[0], self._aspect(), margin=1.25)
        data, frame = scene.data, self.document.frame
        before = data.rotations[frame], data.positions[frame]
        after = self.document.pose(frame, after=True)
        above = -1
        if scene.style == Style.SKIN and chain.segment in ("ForeArm", "Leg"):
            # The skin of the bone above is twisted as well.
            above = int(data.motion.skeleton.parents[chain.parent])
        facing = scene.facing(after[1], chain.person)
        side = best_limb_error_view(
            chain, scene.bodies, before, after, facing, scene.up,
            skeleton=data.motion.skeleton, height=scene.height, above=above,
            body=scene.people.get(chain.person, ()),
        )  # fmt: skip
        return (
            None
            if side is None
            else side.camera(camera, scene.height, self._aspect(), covered=self._covered())
        )

    def _turned(self, share: float) -> None:
        if self._turn is not None:
            smooth = share * share * (3.0 - 2.0 * share)
            self.camera = interpolate_cameras(*self._turn, smooth)
            self._schedule()
            if share >= 1.0:
                self._turn = None

    def _stop_turning(self) -> None:
        """Stop the animation of the camera."""
        self._turn = None
        self._turning.stop()

    def _around(self, scene: Scene, frame: int) -> Array:
        """Return points (n, 3) on the people to show, from this frame to 0.25 s later.

        The movement of each root joint during this time is subtracted.
        """
        data, soup = scene.data, scene.shapes.bodies
        bodies = pose_soup_vertices(soup, data.rotations[frame], data.positions[frame])
        stop = frame + max(2, round(0.25 * data.motion.fps))
        parts = []
        for joints in self._listed(scene):
            some = data.positions[frame:stop, list(joints)]
            level = some[:, :1] - some[:1, :1]
            parts += [bodies[np.isin(soup.joint, joints)], (some - level).reshape(-1, 3)]
        return np.vstack(parts)

    def _listed(self, scene: Scene) -> list[tuple[int, ...]]:
        """Return the joints of the selected person, or of each person if none is selected."""
        one = scene.people.get(self.document.person)
        return list(scene.people.values()) if one is None else [one]

    def _aspect(self) -> float:
        """Return the width of an image divided by its height."""
        return self.picture_size()[0] / max(self.height(), 1)

    def _covered(self) -> float:
        """Return the share of the image's height that the legend covers at the top."""
        return 0.0

    def picture_size(self) -> tuple[int, int]:
        """Return the width and the height of one image in pixels. A split view has two images."""
        halves = 2 if self.scene is not None and self.scene.split else 1
        return self.width() // halves, self.height()

    # -- following ----------------------------------------------------------------------------

    def _hold(self, chain: Chain | None) -> None:
        """Make the camera follow the limb `chain` or, if it is None, the root joints."""
        self._anchor = chain
        self._anchored = self._followed(self.scene) if self.scene is not None else None

    def _followed(self, scene: Scene) -> Array:
        """Return the point that the camera follows, (3,).

        This is the middle of the followed limb. If no limb is followed, it is the mean position of
        the people's root joints, projected to height 0.
        """
        positions = scene.data.positions[self.document.frame]
        if self._anchor is not None:
            middle: Array = limb_joints(self._anchor, positions).mean(axis=0)
            return middle
        root = positions[[joints[0] for joints in self._listed(scene)]].mean(axis=0)
        level: Array = root - (root @ scene.up) * scene.up
        return level

    def _follow_figure(self, scene: Scene) -> None:
        if not self.follow or self.camera is None or self._anchored is None:
            return
        here = self._followed(scene)
        step = here - self._anchored
        if step.any():
            self._anchored = here
            self.camera = self.camera.moved(step)
            if self._turn is not None:
                start, stop = self._turn
                self._turn = start.moved(step), stop.moved(step)

    # -- mouse --------------------------------------------------------------------------------

    def steer(self, move: Callable[[OrbitCamera], OrbitCamera]) -> None:
        """Apply `move` to the camera. This is called when the user moves the camera."""
        if self.camera is not None:
            self._stop_turning()
            self.camera = move(self.camera)
            self._framed = ""
            self._schedule()
