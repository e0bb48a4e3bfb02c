"""The 3D view of the document: a figure of oriented bones before and after, and its camera."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt, QTimer, Signal, SignalInstance
from PySide6.QtGui import QCloseEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QToolTip, QVBoxLayout, QWidget
from pyvistaqt import QtInteractor

from inspector.session.document import Document, Show
from inspector.viewport import legend as overlay
from inspector.viewport import opengl as driver
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.camera_moves import Steering
from inspector.viewport.dashed_figure import Companion
from inspector.viewport.mesh_actor import Piece, specimens
from inspector.viewport.navigation import Navigation
from inspector.viewport.picking import bone_at
from inspector.viewport.pose import pose_of
from inspector.viewport.scene import Scene, background, set_background, set_lights
from inspector.viewport.solid_and_ghost import Pose, Style
from inspector.widgets.theme import Theme
from twistcore.chain import Chain
from twistcore.figure import heading
from twistcore.rotation import Array

_MARGIN = 10  # pixels between the legend and the corner
_AFTER_CURVES_MS = 12  # a dragged τ paints tables and curves first, the picture behind them
_WARM_MS = 60  # after the window has been shown
_FIGURE_MS = 30  # a clip opens with tables and curves; the figure comes in turns of its own


class Guest(Protocol):
    """Who draws something of their own into the view, and says which pose is seen with it."""

    def pose(self, scene: Scene, show: Show) -> Pose:
        """The figure, instead of before, after or both."""

    def legend(self) -> str:
        """Rich text instead of the legend's."""

    def draw(self, scene: Scene, pose: Pose, camera: OrbitCamera) -> None:
        """Draw along with every picture."""

    def aim(self, scene: Scene) -> tuple[Array, Array] | None:
        """Points (n, 3) to be framed and the unit vector (3,) to look from, for the focus."""

    def leave(self) -> None:
        """Take everything out: the scene goes, or the guest is sent away."""


class Viewport(Steering):
    """Draws the document's frame; emits nothing, a click on a bone selects its chain there.

    Any number of changes in one turn of the event loop end in one picture, of the last of them.
    Call `close()` before the window goes: the render window must be finalised while its OpenGL
    context lives.
    """

    _stale = Signal()

    def __init__(self, document: Document, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.document = document
        self.theme = theme
        self.view: QtInteractor | None = None
        self._style, self._split, self._trails = Style.WEDGES, False, False
        self._by_offset, self._triads, self._names = False, True, True
        self._scale = 1.0
        self._drawn_offsets: tuple[float, ...] = ()
        # Queued it comes before Qt's next repaint: one repaint for the picture and the plots.
        self._stale.connect(self.refresh, Qt.ConnectionType.QueuedConnection)
        self._asked = False
        self._timer = QTimer(self, singleShot=True, interval=_AFTER_CURVES_MS)
        self._guest: Guest | None = None
        self._companion: Companion | None = None
        self._timer.timeout.connect(self.refresh)
        self._builder = QTimer(self, singleShot=True, interval=_FIGURE_MS)
        self._builder.timeout.connect(self._build)
        self._specimens: list[Piece] = []
        self._warmed = False
        self._warmer = QTimer(self, singleShot=True, interval=_WARM_MS)
        self._warmer.timeout.connect(self._warm)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self._make_view(layout)
        self._notice = overlay.make_notice(self)
        self.legend = overlay.make_legend(self)
        self.scale = overlay.OffsetScale(self)
        self._divider = overlay.make_divider(self)
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
        points = self.font().pointSizeF() * self._scale
        self.legend.setStyleSheet(overlay.legend_style(theme, points))
        self.legend.adjustSize()
        self._divider.setStyleSheet(f"background: {theme.line}")
        self.scale.set_theme(theme)
        if self._scene:
            self._scene.set_theme(theme)
        elif self.view:
            set_background(self.view, background(theme))
        self._schedule()

    def set_scale(self, scale: float) -> None:
        """Larger type over the picture, 1 as usual."""
        self._scale = scale
        self.set_theme(self.theme)

    def set_style(self, style: Style) -> None:
        """Wedge bones or skinned limbs."""
        self._style = style
        self._schedule()

    def set_side_by_side(self, on: bool) -> None:
        """Before on the left and after on the right, seen by one camera."""
        self._split = on
        self._take_split()
        self._place_overlays()
        if self._framed:
            self.set_view(self._framed)
        self._schedule()

    def set_trails(self, on: bool) -> None:
        """Show the ways of hands and feet a second before and after the frame."""
        self._trails = on
        self._schedule()

    def set_colour_by_offset(self, on: bool) -> None:
        """Colour bones by the size of their twist error at the frame."""
        self._by_offset = on
        self._place_overlays()
        self._schedule()

    def set_triads(self, on: bool) -> None:
        """Show the axes of the selected chain's parent and child."""
        self._triads = on
        self._schedule()

    def set_names(self, on: bool) -> None:
        """Say which bone is under the mouse."""
        self._names = on

    def look_like(self, other: Viewport) -> None:
        """Take over how another view of the same clip looks at it."""
        self.set_style(other._style)
        self.set_side_by_side(other._split)
        self.set_trails(other._trails)
        self.set_colour_by_offset(other._by_offset)
        self.set_triads(other._triads)
        self.take_view(other)

    def invite(self, guest: Guest | None) -> None:
        """Let a guest draw along from now on, or nobody."""
        if self._guest is not None and guest is not self._guest:
            self._guest.leave()
        self._guest = guest
        self._schedule()

    def accompany(self, companion: Companion) -> None:
        """Draw a third figure along with before and after, whenever there is one."""
        self._companion = companion
        companion.changed.connect(self._schedule)

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Draw what the document says now; the picture follows with Qt's next repaint."""
        self._timer.stop()
        self._asked = False
        if self.view is None:
            return
        scene, document = self.scene, self.document
        if scene is not None and document.data is not None:
            self._drawn_offsets = self._offsets()
            self._go_along()
            scene.set_style(self._style)
            if (scene.trails is not None) != self._trails:
                scene.set_trails(self._trails)
            if scene.split:
                pose = self.pose(Show.AFTER)
                scene.draw(self.pose(Show.BEFORE), pose)
            else:
                pose = self.pose()
                scene.draw(pose)
            seen = self._guest is None and (scene.split or document.show != Show.BEFORE)
            third = self._companion.pose(document.frame) if self._companion and seen else None
            scene.draw_companion(third, pose)
            triads = self._triads and self._guest is None
            scene.draw_triads(pose, self._chain() if triads else None)
            if scene.trails is not None and self.camera is not None:
                both = scene.split or document.show == Show.BOTH
                scene.trails.draw(
                    document.frame,
                    self.camera.position,
                    before=both or document.show == Show.BEFORE,
                    after=both or document.show == Show.AFTER,
                )
            if self.camera is not None:
                scene.show_from(self.camera)
                if self._guest is not None:
                    self._guest.draw(scene, pose, self.camera)
            self._update_legend()
        QWidget.update(self.view)

    def pose(self, show: Show | None = None) -> Pose:
        """What is to be seen of the document's frame, by its choice of before, after or both."""
        assert self.scene is not None
        chosen = self.document.show if show is None else show
        if self._guest is not None:
            return self._guest.pose(self.scene, Show.BOTH if show is None else show)
        return pose_of(self.document, self.scene, chosen, self._chain(), self._by_offset)

    def _update_legend(self) -> None:
        document, chain, scene = self.document, self._chain(), self.scene
        degrees = 0.0
        if chain is not None:
            degrees = float(np.degrees(document.offset(chain.name)[document.frame]))
        name = chain.label if chain is not None else ""
        show = "split" if scene is not None and scene.split else document.show
        text = overlay.legend_text(self.theme, show, name, degrees)
        if self._guest is not None:
            text = self._guest.legend()
        elif scene is not None and scene.accompanied:
            text += overlay.companion_text(self.theme)
        if scene is not None and scene.trails is not None:
            text += overlay.trails_text(scene.trails.apart / scene.height)
        if text != self.legend.text():
            self.legend.setText(text)
            self.legend.adjustSize()

    def _schedule(self) -> None:
        if not self._asked and not self._builder.isActive():
            self._asked = True
            self._stale.emit()

    @property
    def pending(self) -> bool:
        """Whether a picture is still to be drawn."""
        return self._asked or self._timer.isActive() or self._builder.isActive()

    def _offsets(self) -> tuple[float, ...]:
        """What the review takes out of every chain at the frame, radians."""
        document = self.document
        chains = document.data.chains if document.data else ()
        return tuple(float(document.offset(c.name)[document.frame]) for c in chains)

    # -- the clip -----------------------------------------------------------------------------

    def _opened(self) -> None:
        data = self.document.data
        self._stop_turning()
        self._builder.stop()
        self._cool()
        if self._guest is not None:
            self._guest.leave()
        if self._scene is not None:
            self._scene.remove()
            self._scene = None
        usable = self.view is not None
        self._notice.setText(overlay.EMPTY if usable else driver.complaint())
        self._notice.setVisible(data is None or not usable)
        if data is not None and usable:
            self._builder.start()
        self._place_overlays()
        self._schedule()

    def _build(self) -> None:
        """The figure of the clip that is open; in the turn after, its camera and the picture."""
        data = self.document.data
        assert data is not None
        assert self.view is not None
        if self._scene is None:
            self._scene = Scene(self.view, self.document, self.theme)
            self._scene.set_split(self._split)
            self._builder.start()
            return
        self._builder.stop()
        up = self._scene.up
        facing = heading(data.positions[0], data.chains, up)
        self.camera = OrbitCamera(np.zeros(3), 0.0, 0.0, self._scene.height, up, facing)
        self._anchor = self._anchored = None
        self.set_view("iso")
        self._schedule()

    def _warm(self) -> None:
        """Draw specimens once, and the turn after take them out again."""
        if self._specimens:
            for piece in self._specimens:
                piece.remove()
            self._specimens = []
            QWidget.update(self.view)  # the light makes them differ from the paper a little
        elif self.view is not None and self._scene is None:
            self._specimens = specimens(self.view.renderer, background(self.theme))
            self.view.reset_camera(render=False)
            self._warmer.start()
            QWidget.update(self.view)

    def _cool(self) -> None:
        self._warmer.stop()
        if self._specimens:
            self._warm()

    def _complete(self) -> None:
        """Whoever asks for the figure before its turn gets it whole."""
        while self._builder.isActive():
            self._build()

    def _take_split(self) -> None:
        if self.scene is not None:
            self.scene.set_split(self._split)

    def _reviewed(self) -> None:
        """Draw again where the picture changes: most steps of τ leave this frame alone."""
        trails = self._scene.trails if self._scene is not None else None
        if trails is not None:
            trails.forget()
        elif self._offsets() == self._drawn_offsets:
            return
        if not self._timer.isActive() and not self._builder.isActive():
            self._timer.start()

    def _towards(self, chain: Chain) -> OrbitCamera | None:
        """To what a guest has to show, else to the limb's best side."""
        aim = self._guest.aim(self.scene) if self._guest and self.scene else None
        if aim is None or self.camera is None:
            return super()._towards(chain)
        return self.camera.looking_from(aim[1]).framing(aim[0], self._aspect(), margin=1.25)

    # -- mouse --------------------------------------------------------------------------------

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
        size = self.picture_size()
        point = np.array([at.x() % max(size[0], 1), at.y()])
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
            (document.intervals_changed, self._reviewed),
            (document.chain_changed, self._schedule),
            (document.interval_changed, self._schedule),
            (document.show_changed, self._schedule),
        )

    def _place_overlays(self) -> None:
        drawing = self.document.data is not None and self.view is not None
        self.legend.setVisible(drawing)
        self.legend.move(_MARGIN, _MARGIN)
        self._notice.setGeometry(self.rect())
        self.scale.setVisible(drawing and self._by_offset)
        self.scale.move(_MARGIN, self.height() - self.scale.height() - _MARGIN)
        self._divider.setVisible(drawing and self._split)
        self._divider.setGeometry(self.width() // 2 - 1, 0, 2, self.height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the legend in its corner, the notice in the middle, the preset in frame."""
        super().resizeEvent(event)
        self._place_overlays()
        if self._framed:
            self.set_view(self._framed)

    def showEvent(self, event: QShowEvent) -> None:
        """Catch up."""
        super().showEvent(event)
        self._schedule()
        if self._scene is None and not self._warmed:
            self._warmed = True
            self._warmer.start()

    def changeEvent(self, event: QEvent) -> None:
        """A larger font makes a larger legend."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.legend.adjustSize()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Stop listening and let the render window go."""
        self._timer.stop()
        self._builder.stop()
        self._cool()
        self._stop_turning()
        if self._listening:  # Qt delivers a second close event to a widget closed twice
            self._listening = False
            for signal, slot in self._listened():
                signal.disconnect(slot)
        if self.view is not None:
            self.invite(None)
            if self._scene is not None:
                self._scene.remove()
            self._scene = None
            self.view.close()
            self.view = None
        super().closeEvent(event)
