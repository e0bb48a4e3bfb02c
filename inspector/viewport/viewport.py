"""The 3D view of the document: the figure before and after correction, and its camera."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from PySide6.QtCore import QEvent, QObject, QSize, QTimer, Signal
from PySide6.QtGui import QCloseEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QToolTip, QWidget
from pyvistaqt import QtInteractor

from inspector.language import tr
from inspector.session.document import Document
from inspector.viewport import opengl
from inspector.viewport.bone_under_mouse import Pointing
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.camera_moves import Aim, Steering
from inspector.viewport.dashed_figure import Companion
from inspector.viewport.dial import Dial
from inspector.viewport.frame_drawing import FrameDrawing, Guest
from inspector.viewport.lights import background, make_plotter
from inspector.viewport.mesh_actor import Piece, add_warm_up_meshes
from inspector.viewport.navigation import Navigation
from inspector.viewport.overlays import EMPTY, Overlays
from inspector.viewport.scene import Scene
from inspector.viewport.signs import show_signs
from inspector.widgets.labels import plain_text
from inspector.widgets.later import RedrawRequests
from inspector.widgets.theme import Colours, Theme

_HINT = QSize(400, 400)  # preferred size of the view if OpenGL is available
# Delay after a change of intervals, so that tables and curves are painted first while the user
# drags the threshold τ
_AFTER_CURVES_MS = 12
_WARM_MS = 60  # delay between showing the view and drawing the warm-up meshes
_MOST_COVERED = 0.25  # limit of the share of the height that is treated as covered by the legend
_REST_MS = 400  # time without changes of the image before screen readers get a new description
_FIGURE_MS = 30  # delay of building the figure, so that tables and curves of a clip come first


class Viewport(Steering):
    """The 3D view of the document. A click on a bone selects its chain.

    All changes in one iteration of the event loop are drawn together. Call `close()` before the
    window is destroyed, because the render window must be finalised while its OpenGL context
    exists.

    Attributes
    ----------
    colours
        The object that provides the theme and reports its changes.
    view
        The OpenGL widget, or None without OpenGL.
    drawing
        The drawing of the current frame, with the display options.
    pointing
        The handler of clicks on bones and of movements of the mouse over bones.
    overlays
        The widgets over the image.
    dial
        The dial with which the user changes the offset of the selected interval.
    """

    interval_painted = Signal()  # the view was painted while an interval was selected

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__(document)
        self.colours = colours
        self.view: QtInteractor | None = None
        self.drawing = FrameDrawing(document)
        self.pointing = Pointing(self, self.drawing)
        self._scale = 1.0
        # The interval that was selected when the scene was last drawn, and the one when the view
        # was last painted on the screen
        self._drawn: int | None = None
        self._painted: int | None = None
        self._drawn_frame = self._painted_frame = 0  # the frames at those two times
        self._stale = RedrawRequests(self)
        self._stale.due.connect(self.refresh)
        self._timer = QTimer(self, singleShot=True, interval=_AFTER_CURVES_MS)
        self._timer.timeout.connect(self.refresh)
        self._builder = QTimer(self, singleShot=True, interval=_FIGURE_MS)
        self._builder.timeout.connect(self._build)
        self._specimens: list[Piece] = []
        self._warmed = False
        self._warmer = QTimer(self, singleShot=True, interval=_WARM_MS)
        self._warmer.timeout.connect(self._warm_up)
        self._make_view()
        self.overlays = Overlays(self)  # created after the view, to be above it
        self.dial = Dial(document, self.overlays.clock, self)
        self._rest = QTimer(self, singleShot=True, interval=_REST_MS)
        self._rest.timeout.connect(self._describe)
        self.setAccessibleName(tr("3D view of the figure"))
        self.setMinimumSize(160, 120)
        document.opened.connect(self._opened)
        document.chains_changed.connect(self._take_chains)
        document.intervals_changed.connect(self._reviewed)
        document.frame_changed.connect(self._schedule)
        document.chain_changed.connect(self._schedule)
        document.interval_changed.connect(self._schedule)
        document.show_changed.connect(self._schedule)
        document.tracked_changed.connect(self._reviewed)
        document.person_changed.connect(self.show_person)
        colours.follow(self._colour)
        self._opened()

    # -- called by the window -----------------------------------------------------------------

    @property
    def theme(self) -> Theme:
        """The current theme."""
        return self.colours.theme

    def _colour(self, theme: Theme) -> None:
        self.overlays.colour(theme, self.font().pointSizeF() * self._scale)
        if self._scene:
            self._scene.colour(theme)
        elif self.view:
            self.view.renderer.SetBackground(*(background(theme) / 255.0))
        self._schedule()

    def set_scale(self, scale: float) -> None:
        """Set the size of the text over the image, relative to the normal size."""
        self._scale = scale
        self._colour(self.theme)

    def look(self, **changes: Any) -> None:
        """Change display options. The keyword arguments are fields of :class:`Looks`."""
        self.drawing.looks = looks = replace(self.drawing.looks, **changes)
        self._place_overlays()
        if self.scene is not None and looks.split != self.scene.split:
            self.scene.set_split(looks.split)
            if self._framed:
                self.set_view(self._framed)
        self._schedule()

    def look_like(self, other: Viewport) -> None:
        """Copy the display options and the camera of another view of the same clip."""
        self.look(**vars(other.drawing.looks))
        self.take_view(other)

    def invite(self, guest: Guest | None) -> None:
        """Let a feature determine the pose in the view and draw into the view.

        A previous guest is removed. None only removes it.
        """
        if self.drawing.guest is not None and guest is not self.drawing.guest:
            self.drawing.guest.leave()
        self.drawing.guest = guest
        self._schedule()

    def accompany(self, companion: Companion) -> None:
        """Draw the figure that `companion` provides as a third figure in each frame."""
        self.drawing.companion = companion
        companion.changed.connect(self._schedule)

    # -- drawing ------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Draw the document's current state. Qt's next repaint shows it on the screen."""
        self._timer.stop()
        self._stale.take()
        if self.view is None:
            return
        if (scene := self.scene) is not None:
            self._follow_figure(scene)
            assert self.camera is not None
            self.drawing.draw(scene, self.camera, self._turn[1] if self._turn else self.camera)
            self._drawn, self._drawn_frame = self.document.interval_id, self.document.frame
            self.overlays.show_legend(self.drawing.legend(scene, self.theme))
            show_signs(self.overlays, self.drawing, scene, self.camera, self.picture_size())
            self._rest.start()
        self._repaint()

    def _repaint(self) -> None:
        """Schedule a repaint by Qt. The `update` method of pyvista would render immediately."""
        if self.view is not None:
            QWidget.update(self.view)

    def _schedule(self) -> None:
        if not self._builder.isActive():
            self._stale.mark()

    @property
    def pending(self) -> bool:
        """True if the image does not yet show the latest changes."""
        return self._stale.pending or self._timer.isActive() or self._builder.isActive()

    def has_painted_interval(self) -> bool:
        """Return True if the selected interval has been painted, or if the view is hidden."""
        return self.is_hidden or self.document.interval_id in (None, self._painted)

    @property
    def is_hidden(self) -> bool:
        """True if the view is not visible in the window."""
        return self.view is None or self.view.visibleRegion().isEmpty()

    @property
    def painted_frame(self) -> int | None:
        """The frame that was last painted, or None if the selected interval was not selected then.

        It is also None if the view is hidden.
        """
        painted = not self.is_hidden and self._painted == self.document.interval_id
        return self._painted_frame if painted else None

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Record which interval the view paints. All events are passed on."""
        if event.type() == QEvent.Type.Paint:
            self._painted, self._painted_frame = self._drawn, self._drawn_frame
            if self._painted is not None:
                self.interval_painted.emit()
        return False

    # -- opening and changing clips -----------------------------------------------------------

    def _opened(self) -> None:
        self._drawn = self._painted = None
        data = self.document.data
        self._stop_turning()
        self._builder.stop()
        self._end_warm_up()
        if self.drawing.guest is not None:
            self.drawing.guest.leave()
        if self._scene is not None:
            self._scene.remove()
            self._scene = None
        usable = self.view is not None
        self.overlays.notice.setText(EMPTY if usable else opengl.missing_3d_view_message())
        self.overlays.notice.setVisible(data is None or not usable)
        if data is not None and usable:
            self._builder.start()
        self._place_overlays()
        self._schedule()

    def _take_chains(self) -> None:
        if self._scene is not None and self.document.data is not None:
            self._scene.take_chains(self.document.data)
        self._schedule()

    def _build(self) -> None:
        """Build the figure of the open clip. If the figure is already built, create the camera.

        The timer calls this method twice, so the window can respond between the two steps.
        """
        if self._scene is None:
            assert self.view is not None
            self._scene = Scene(self.view, self.document, self.theme)
            self._scene.set_split(self.drawing.looks.split)
            self._builder.start()
            return
        self._builder.stop()
        scene = self._scene
        ahead = scene.facing(scene.data.positions[0])
        self.camera = OrbitCamera(np.zeros(3), 0.0, 0.0, scene.height, scene.up, ahead)
        self._anchor = self._anchored = None
        self.set_view("iso")
        self._schedule()

    def _warm_up(self) -> None:
        """Draw the warm-up meshes or, when called again by the timer, remove them.

        As a result, the OpenGL driver has compiled the shaders before the first clip is opened.
        """
        if self._specimens:
            for piece in self._specimens:
                piece.remove()
            self._specimens = []
            self._repaint()  # with the lights, the meshes are slightly visible
        elif self.view is not None and self._scene is None:
            self._specimens = add_warm_up_meshes(self.view.renderer, background(self.theme))
            self.view.renderer.reset_camera(render=False)
            self._warmer.start()
            self._repaint()

    def _end_warm_up(self) -> None:
        self._warmer.stop()
        if self._specimens:
            self._warm_up()

    def _complete(self) -> None:
        """Build the figure and its camera now if the timer has not built them yet."""
        while self._builder.isActive():
            self._build()

    def _reviewed(self) -> None:
        """Draw the frame again, after a delay, if its corrections have changed.

        Most small changes of the threshold τ do not change the corrections of the current frame.
        """
        trails = self._scene.trails if self._scene is not None else None
        if trails is not None:
            trails.forget()
        elif self.drawing.is_current():
            return
        if not self._timer.isActive() and not self._builder.isActive():
            self._timer.start()

    def _aim(self, scene: Scene) -> Aim | None:
        guest = self.drawing.guest
        return guest.aim(scene) if guest else None

    # -- widgets and Qt events ----------------------------------------------------------------

    def _make_view(self) -> None:
        """Create the OpenGL widget, or set `view` to None if OpenGL is not available."""
        self.view = make_plotter(self)
        if self.view is None:
            return
        navigation = Navigation(self.view)
        navigation.steered.connect(self.steer)
        navigation.clicked.connect(self.pointing.click)
        navigation.hovered.connect(self.pointing.hover)
        self.view.setAccessibleName(tr("3D view of the figure"))
        self.view.installEventFilter(self)
        self.view.setGeometry(self.rect())

    def _describe(self) -> None:
        """Use the legend text as the view's description for screen readers."""
        if self.view is not None:
            self.view.setAccessibleDescription(plain_text(self.overlays.legend.text()))

    def _covered(self) -> float:
        return min(self.overlays.top / max(self.height(), 1), _MOST_COVERED)

    def _place_overlays(self) -> None:
        looks = self.drawing.looks
        self.overlays.place(
            drawing=self.document.data is not None and self.view is not None,
            by_offset=looks.by_offset,
            split=looks.split,
        )

    def sizeHint(self) -> QSize:
        """Return the preferred size of VTK's widget as the preferred size of the view.

        The view has no layout that could compute this size, because every change to a label would
        then lay out the whole window.
        """
        return super().sizeHint() if self.view is None else _HINT

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Place the overlays, and fit the current named view to the new size."""
        super().resizeEvent(event)
        if self.view is not None:
            self.view.setGeometry(self.rect())
        self._place_overlays()
        if self._framed:
            self.set_view(self._framed)
        if self._scene is not None:
            self._schedule()  # labels of a guest have positions in pixels
        QToolTip.hideText()  # the position of the bone's name is also in pixels

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the changes that were made while the view was hidden."""
        super().showEvent(event)
        if self._scene is not None:
            self._schedule()
        elif not self._warmed:
            self._warmed = True
            self._warmer.start()

    def changeEvent(self, event: QEvent) -> None:
        """Fit the legend to a new font."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.overlays.fit()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Disconnect from the document, and close the render window."""
        self._timer.stop()
        self._rest.stop()
        self._builder.stop()
        self._end_warm_up()
        self._stop_turning()
        self.document.disconnect(self)
        if self.view is not None:
            self.invite(None)
            if self._scene is not None:
                self._scene.remove()
            self._scene = None
            self.view.close()
            # Qt deletes the surface with the window. A stale Python reference to it was once
            # mistaken for an action of the next window at the same address.
            self.view._surface = None
            self.view = None
        super().closeEvent(event)
