"""The 3D view of the document: a figure of oriented bones before and after, and its camera."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QTimer, SignalInstance
from PySide6.QtGui import QCloseEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QLabel, QToolTip, QVBoxLayout, QWidget
from pyvistaqt import QtInteractor

from inspector.document import Document, Show
from inspector.theme import Theme
from inspector.viewport import driver, overlay
from inspector.viewport.bodies import place
from inspector.viewport.camera import OrbitCamera, heading, preset, roll_direction
from inspector.viewport.navigation import Navigation
from inspector.viewport.paint import Role
from inspector.viewport.picking import bone_at
from inspector.viewport.scene import Pose, Scene, background, set_background, set_lights
from twistcore.chain import Chain
from twistcore.rotation import Array, geodesic_angle, normalise, rotate

_SAME = np.radians(0.05)  # bones that differ by less are not shown apart
_MARGIN = 10  # pixels between the legend and the corner


class Viewport(QWidget):
    """Draws the document's frame; emits nothing, a click on a bone selects its chain there.

    Any number of changes in one turn of the event loop end in one picture, of the last of them.
    Call `close()` before the window goes: the render window must be finalised while its OpenGL
    context lives.
    """

    def __init__(self, document: Document, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.document = document
        self.theme = theme
        self.camera: OrbitCamera | None = None
        self.scene: Scene | None = None
        self.view: QtInteractor | None = None
        self.follow = True
        self._triads = True
        self._names = False
        self._framed = "iso"  # the preset that is kept as the view changes size; '' once moved
        self._anchor: Chain | None = None  # followed instead of the root
        self._anchored: Array | None = None
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.refresh)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self._make_view(layout)
        self._notice = overlay.make_notice(self)
        self.legend: QLabel = overlay.make_legend(self)
        self.setMinimumSize(160, 120)
        self._listening = True
        for signal, slot in self._listened():
            signal.connect(slot)
        self.set_theme(theme)
        self._opened()

    # -- what the window asks for -------------------------------------------------------------

    def set_theme(self, theme: Theme) -> None:
        """Draw in other colours."""
        self.theme = theme
        self._notice.setStyleSheet(f"color: {theme.soft}; background: transparent; font-size: 15px")
        self.legend.setStyleSheet(overlay.legend_style(theme))
        if self.scene:
            self.scene.set_theme(theme)
        elif self.view:
            set_background(self.view, background(theme))
        self._schedule()

    def set_view(self, name: str) -> None:
        """One of camera.VIEWS, relative to where the figure faces now; frames the figure."""
        data = self.document.data
        if self.camera is None or data is None or self.scene is None:
            return
        frame = self.document.frame
        facing = heading(data.positions[frame], data.chains, self.scene.up)
        self.camera = preset(self.camera, name, facing).framing(self._around(frame), self._aspect())
        self._framed = name
        self._hold(None)
        self._schedule()

    def focus_chain(self) -> None:
        """Go to the selected chain's limb, to the side from which its roll shows."""
        data, chain = self.document.data, self._chain()
        if self.camera is None or data is None or chain is None or self.scene is None:
            return
        frame = self.document.frame
        rotations, positions = self.document.pose(frame, after=True)
        limb = self._limb(chain, positions)
        bones = [b for b in self.scene.bones if b.parent == chain.parent]
        bone = min(bones, key=lambda b: b.child != chain.child, default=None)
        if bone is None:
            return
        normals = [rotate(r[chain.parent], bone.normal) for r in (rotations, data.rotations[frame])]
        outward = limb.mean(axis=0) - positions.mean(axis=0)
        size = float(np.linalg.norm(outward))
        direction = roll_direction(
            normalise(rotate(rotations[chain.parent], bone.tip)),
            normals[0],
            normals[1],
            outward / size if size > 0.0 else outward,
            heading(positions, data.chains, self.scene.up),
            self.scene.up,
        )
        pad = 0.045 * self.scene.height
        corners = np.vstack([limb + pad * e for e in (*np.eye(3), *-np.eye(3))])
        turned = self.camera.looking_from(direction)
        self.camera = turned.framing(corners, self._aspect(), margin=1.4)
        self._framed = ""
        self._hold(chain)
        self._schedule()

    def set_follow(self, on: bool) -> None:
        """Let the camera go along with the figure, at the same distance."""
        self.follow = on
        self._hold(self._anchor)

    def set_triads(self, on: bool) -> None:
        """Show the axes of the selected chain's parent and child."""
        self._triads = on
        self._schedule()

    def set_names(self, on: bool) -> None:
        """Say which bone is under the mouse."""
        self._names = on

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Draw what the document says now; the picture follows with Qt's next repaint."""
        self._timer.stop()
        if self.view is None:
            return
        if self.scene is not None and self.document.data is not None:
            self._go_along()
            pose = self.pose()
            self.scene.with_triads = self._triads
            self.scene.draw(pose)
            self.scene.draw_triads(pose, self._chain())
            if self.camera is not None:
                self.scene.show_from(self.camera)
            self._update_legend()
        QWidget.update(self.view)

    def pose(self) -> Pose:
        """What is to be seen of the document's frame, by its choice of before, after or both."""
        document, scene = self.document, self.scene
        assert document.data is not None
        assert scene is not None
        frame = document.frame
        before, positions = document.pose(frame, after=False)
        after, after_positions = document.pose(frame, after=True)
        parents = np.array([b.parent for b in scene.bones], dtype=np.int64)
        differs = (geodesic_angle(before, after) > _SAME)[parents]
        chosen = self._chosen(parents)
        roles = np.where(chosen, Role.CHOSEN, Role.PLAIN).astype(np.int64)
        roles[differs] = Role.BEFORE if document.show == Show.BEFORE else Role.AFTER
        if document.show == Show.BEFORE:
            return Pose(before, positions, roles)
        ghost = (before, differs) if document.show == Show.BOTH else None
        return Pose(after, after_positions, roles, ghost)

    def _chosen(self, parents: Array) -> Array:
        """Which bones belong to the selected chain: P→C and, where there is one, C→G; (bones,)."""
        chain = self._chain()
        if chain is None or self.scene is None:
            return np.zeros(len(parents), dtype=bool)
        pairs = {(chain.parent, chain.child), (chain.child, chain.grandchild)}
        return np.array([(b.parent, b.child) in pairs for b in self.scene.bones], dtype=bool)

    def _update_legend(self) -> None:
        document, chain = self.document, self._chain()
        degrees = 0.0
        if chain is not None:
            degrees = float(np.degrees(document.offset(chain.name)[document.frame]))
        name = chain.name if chain is not None else ""
        text = overlay.legend_text(self.theme, document.show, name, degrees)
        if text != self.legend.text():
            self.legend.setText(text)
            self.legend.adjustSize()

    def _schedule(self) -> None:
        if not self._timer.isActive():
            self._timer.start(0)

    # -- the clip -----------------------------------------------------------------------------

    def _opened(self) -> None:
        data = self.document.data
        if self.scene is not None:
            self.scene.remove()
            self.scene = None
        usable = self.view is not None
        self._notice.setText(overlay.EMPTY if usable else overlay.NO_OPENGL)
        self._notice.setVisible(data is None or not usable)
        self.legend.setVisible(data is not None and usable)
        if data is not None and self.view is not None:
            self.scene = Scene(self.view, data.motion, data.chains, data.positions, self.theme)
            up = self.scene.up
            facing = heading(data.positions[0], data.chains, up)
            self.camera = OrbitCamera(np.zeros(3), 0.0, 0.0, self.scene.height, up, facing)
            self._anchor = self._anchored = None
            self.set_view("iso")
        self._schedule()

    def _around(self, frame: int) -> Array:
        """What the figure takes up from a frame on, with the root at its place there, (n, 3)."""
        data = self.document.data
        assert data is not None
        assert self.scene is not None
        bodies = place(self.scene.bodies, data.rotations[frame], data.positions[frame])
        stop = frame + max(2, round(0.25 * data.motion.fps))
        some = data.positions[frame:stop]
        level = some[:, :1] - some[:1, :1]
        return np.vstack([bodies, (some - level).reshape(-1, 3)])

    def _chain(self) -> Chain | None:
        try:
            return self.document.find_chain(self.document.chain)
        except KeyError:
            return None

    def _limb(self, chain: Chain, positions: Array) -> Array:
        """The chain's joints, and the tip of its last bone where no grandchild says it, (n, 3)."""
        joints = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
        return positions[joints]

    # -- following ----------------------------------------------------------------------------

    def _hold(self, chain: Chain | None) -> None:
        """Follow a limb, or the root, from where it is now."""
        self._anchor = chain
        self._anchored = self._followed() if self.document.data else None

    def _followed(self) -> Array:
        """The point that the camera goes along with, (3,): a limb, or the root on the level."""
        assert self.document.data is not None
        assert self.scene is not None
        positions = self.document.data.positions[self.document.frame]
        if self._anchor is not None:
            middle: Array = self._limb(self._anchor, positions).mean(axis=0)
            return middle
        root: Array = positions[0] - (positions[0] @ self.scene.up) * self.scene.up
        return root

    def _go_along(self) -> None:
        if not self.follow or self.camera is None or self._anchored is None:
            return
        here = self._followed()
        step = here - self._anchored
        if step.any():
            self._anchored = here
            self.camera = self.camera.moved(step)

    # -- mouse --------------------------------------------------------------------------------

    def _orbit(self, azimuth: float, elevation: float) -> None:
        if self.camera is not None:
            self._moved(self.camera.orbited(azimuth, elevation))

    def _pan(self, right: float, up: float) -> None:
        if self.camera is not None:
            self._moved(self.camera.panned(right, up, self.height()))

    def _zoom(self, factor: float) -> None:
        if self.camera is not None:
            self._moved(self.camera.zoomed(factor))

    def _moved(self, camera: OrbitCamera) -> None:
        self.camera = camera
        self._framed = ""
        self._schedule()

    def _click(self, at: QPointF) -> None:
        joint = self.joint_at(at)
        for chain in self.document.data.chains if self.document.data else ():
            if chain.parent == joint:
                self.document.select_chain(chain.name)

    def _hover(self, at: QPointF) -> None:
        if self._names and self.document.data is not None and self.view is not None:
            joint = self.joint_at(at)
            name = self.document.data.motion.skeleton.names[joint] if joint is not None else ""
            QToolTip.showText(self.view.mapToGlobal(at.toPoint()), name, self.view)

    def joint_at(self, at: QPointF) -> int | None:
        """The joint whose bone is at a place in the view, or None."""
        if self.scene is None or self.camera is None:
            return None
        pose = self.pose()
        point, size = np.array([at.x(), at.y()]), (self.width(), self.height())
        bones = self.scene.bones
        bone = bone_at(point, bones, pose.rotations, pose.positions, self.camera, size)
        return None if bone is None else bones[bone].parent

    # -- Qt -----------------------------------------------------------------------------------

    def _make_view(self, layout: QVBoxLayout) -> None:
        """The OpenGL widget; without OpenGL there is none, and a notice instead."""
        if not driver.renderer_name():
            return
        view = QtInteractor(self, auto_update=False, multi_samples=driver.multisamples())
        view.setAcceptDrops(False)  # the window opens what is dropped
        view.reset_key_events()
        set_lights(view)
        # The ghost is thin and convex: plain blending does, at a tenth of the cost of VTK's
        # order-independent pass over the whole picture.
        view.renderer.SetUseOIT(False)
        navigation = Navigation(view)
        navigation.orbited.connect(self._orbit)
        navigation.panned.connect(self._pan)
        navigation.zoomed.connect(self._zoom)
        navigation.clicked.connect(self._click)
        navigation.hovered.connect(self._hover)
        layout.addWidget(view)
        self.view = view

    def _listened(self) -> tuple[tuple[SignalInstance, Callable[..., None]], ...]:
        """What the view draws again for."""
        document = self.document
        return (
            (document.opened, self._opened),
            (document.frame_changed, self._schedule),
            (document.intervals_changed, self._schedule),
            (document.chain_changed, self._schedule),
            (document.interval_changed, self._schedule),
            (document.show_changed, self._schedule),
        )

    def _aspect(self) -> float:
        return self.width() / max(self.height(), 1)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the legend in its corner, the notice in the middle, the preset in frame."""
        super().resizeEvent(event)
        self._notice.setGeometry(self.rect())
        self.legend.move(_MARGIN, _MARGIN)
        if self._framed:
            self.set_view(self._framed)

    def showEvent(self, event: QShowEvent) -> None:
        """Catch up."""
        super().showEvent(event)
        self._schedule()

    def changeEvent(self, event: QEvent) -> None:
        """A larger font makes a larger legend."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.legend.adjustSize()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Stop listening and let the render window go."""
        self._timer.stop()
        if self._listening:  # Qt delivers a second close event to a widget closed twice
            self._listening = False
            for signal, slot in self._listened():
                signal.disconnect(slot)
        if self.view is not None:
            self.scene = None
            self.view.close()
            self.view = None
        super().closeEvent(event)
