"""Draw the gizmo, which shows the teaching tab's symbols in 3D on top of the figure."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF
from vtkmodules.vtkRenderingCore import vtkRenderer
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.language import tr, translate_core_sentence
from inspector.session.open_clip import Show
from inspector.teaching import gizmo_joints
from inspector.teaching.equation_table import NEAR_SWING
from inspector.teaching.gizmo_family import add_swing_axis_fan
from inspector.teaching.gizmo_handles import place_gizmo_handles
from inspector.teaching.gizmo_hold import Hold
from inspector.teaching.gizmo_labels import Labels
from inspector.teaching.gizmo_shapes import (
    BOLD,
    CLEAR,
    SOLID,
    THIN,
    GizmoPart,
    Sketch,
    sketch_gizmo,
)
from inspector.teaching.symbols import MARKS, symbol_family_colour
from inspector.teaching.taught_frame import TaughtFrame
from inspector.viewport.bone_colours import rgb
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.frame_drawing import altered_pose
from inspector.viewport.lights import background
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.scene import AXES, Scene
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.viewport import Viewport
from inspector.widgets.labels import bold, coloured_rich_text
from inspector.widgets.typeset import Typesetter
from twistcore.skeleton.rotation import Array, conjugate, multiply, rotate

_WIDTHS = {BOLD: 3.0, THIN: 1.6}
_DIMMED = 0.22  # brightness of parts that are not highlighted, if other parts are
_FAMILY = tr("Swing near 180°: one pose, many pairs (<b>n</b>, θp)")
# The parts that are highlighted together with a symbol.
_TOGETHER = {
    "q": ("a", "w", "alpha", "theta_p", "n"),
    "swing": ("alpha", "n", "a", "w"),
    "twist": ("theta_p",),
    "product": ("dtheta_p", "dtheta_c"),
    "m": ("dtheta_p", "dtheta_c", "v", "ideal"),
    "err": ("dtheta_p", "dtheta_c", "v", "ideal"),
    "offset": ("theta_p", "dtheta_p"),
    "taken": ("theta_p",),
    "parent_after": ("a", "w", "alpha", "theta_p", "n"),
    "child_after": ("v", "across"),
    "check": ("v",),
}


def highlighted_gizmo_symbols(symbol: str) -> frozenset[str]:
    """Return the symbols whose gizmo parts are highlighted together with `symbol`.

    For '', the result is empty.
    """
    return frozenset((symbol, *_TOGETHER.get(symbol, ()))) if symbol else frozenset()


class GizmoGuest:
    """The gizmo of the teaching tab.

    The 3D view shows the gizmo on top of the figure while the tab is visible.
    """

    def __init__(self, viewport: Viewport, taught: TaughtFrame, typesetter: Typesetter) -> None:
        self._viewport, self._taught = viewport, taught
        self.labels = Labels(viewport, typesetter)
        self.hold = Hold(viewport, taught)
        self._pieces: dict[str, Piece] = {}
        self._parts: list[GizmoPart] = []  # between frames, only the points of the parts change
        self._layer: vtkOpenGLRenderer | None = None
        self._below: vtkRenderer | None = None
        self._triads = Piece(gizmo_joints.POINTS, lines=gizmo_joints.LINES).unlit(width=2.0)
        self._triads.paint(np.repeat(np.tile(AXES, (3, 1)), 2, axis=0))
        self._painted: tuple[object, ...] = ()

    # -- called by the view -------------------------------------------------------------------

    def pose(self, scene: Scene, show: Show) -> Pose:
        """Return the pose to draw: the captured pose or the edited one.

        The edited pose is drawn together with the captured pose, which appears as a ghost.
        """
        what_if = None if show == Show.BEFORE else self._taught.pose()
        return altered_pose(self._taught.document, scene, what_if)

    def legend(self) -> str:
        """Return the legend of the 3D view as rich text."""
        theme, chain, stage = self._viewport.theme, self._taught.chain, self._taught.stage
        name = (
            f"{bold(translate_core_sentence(chain.label))}&nbsp;&nbsp; "
            if chain is not None
            else ""
        )
        captured = f"{coloured_rich_text('□', theme.before)}&nbsp;{tr('as captured')}"
        if stage is not None:
            return (
                f"{name}{captured}&nbsp;&nbsp; "
                f"{coloured_rich_text('■', theme.after)}&nbsp;{_stage_words(stage)}"
            )
        d = self._taught.quantities
        near = d is not None and d.swing_reliability < NEAR_SWING
        family = f"<br>{_FAMILY}" if near else ""
        if not self._taught.what_if.changes:
            return f"{name}{tr('as captured')}{family}"
        altered = f"{coloured_rich_text('■', theme.after)}&nbsp;{tr('what if')}"
        return f"{name}{captured}&nbsp;&nbsp; {altered}{family}"

    def draw(self, scene: Scene, pose: Pose, camera: OrbitCamera) -> None:
        """Draw the gizmo and its labels for a pose."""
        shapes = self._shapes(scene, pose)
        if shapes is None:
            self.leave()
            return
        self._attend(scene, shapes)
        for look, piece in self._pieces.items():
            piece.move(np.vstack([part.points for part in shapes.parts if part.look == look]))
        chain, d = self._taught.chain, self._taught.quantities
        assert chain is not None
        assert d is not None
        parent = chain.parent
        self.hold.show_places(
            place_gizmo_handles(d, pose.rotations[parent], pose.positions[parent], shapes.unit)
        )
        self._triads.show(self._viewport.drawing.looks.triads)
        self._triads.move(gizmo_joints.triads(chain, pose.rotations, pose.positions, shapes.unit))
        self._paint()
        width, height = self._viewport.picture_size()
        left = self._viewport.width() - width
        legend = self._viewport.overlays.legend
        self.labels.show_marks(
            shapes.marks, camera, QRectF(left, 0, width, height), self._viewport.theme,
            highlighted_gizmo_symbols(self._taught.lit), QRectF(legend.geometry()),
        )  # fmt: skip

    def aim(self, scene: Scene) -> tuple[Array, Array] | None:
        """Return the gizmo's points, (n, 3), and the best direction from which to see them, (3,).

        From this direction, the swing and the dial of the twist are clearly visible. Returns None
        if no chain is selected.
        """
        d, chain = self._taught.quantities, self._taught.chain
        shapes = self._shapes(scene, pose := self.pose(scene, Show.BOTH))
        if shapes is None or d is None or chain is None:
            return None
        points = [p.points for p in shapes.parts if p.look != CLEAR]
        # A counter-twist does not move the grandchild
        if (data := self._taught.document.data) is not None:
            own = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
            points.append(data.positions[self._taught.document.frame, own])
        q_parent = pose.rotations[chain.parent]
        along = rotate(q_parent, d.a)
        normal = rotate(multiply(q_parent, conjugate(d.q)), d.n)
        ahead = scene.facing(pose.positions, chain.person)
        body = list(scene.people.get(chain.person, ())) or slice(None)
        outward = pose.positions[chain.child] - pose.positions[body].mean(axis=0)
        outward = outward / max(float(np.linalg.norm(outward)), 1e-9)
        around, above = np.meshgrid(np.radians(np.arange(0, 360, 10)), np.radians((0, 15, 30, 45)))
        aside = np.cross(scene.up, ahead)
        level = np.cos(around)[..., None] * ahead + np.sin(around)[..., None] * aside
        seen = np.cos(above)[..., None] * level + np.sin(above)[..., None] * scene.up
        seen = seen.reshape(-1, 3)
        slant = 0.75 if d.swing_reliability < NEAR_SWING else 0.5  # the fan of normals is open
        worth = np.abs(seen @ normal) + 1.4 * np.minimum(np.abs(seen @ along), slant)
        worth += 0.35 * (seen @ outward) + 0.25 * (seen @ ahead)
        return np.vstack(points), seen[int(np.argmax(worth))]

    def leave(self) -> None:
        """Remove the gizmo from the 3D view."""
        self.labels.hide()
        self.hold.leave()
        for piece in self._pieces.values():
            piece.remove()
        self._triads.remove()
        self._pieces, self._painted = {}, ()
        view = self._viewport.view
        if self._layer is not None and view is not None and view.ren_win is not None:
            self._layer.RemoveAllViewProps()
            self._layer.ReleaseGraphicsResources(view.ren_win)
            view.ren_win.RemoveRenderer(self._layer)
        self._layer = self._below = None

    # -- drawing ------------------------------------------------------------------------------

    def _shapes(self, scene: Scene, pose: Pose) -> Sketch | None:
        """Return the shapes of the gizmo for a pose, or None if no chain is selected."""
        d, chain = self._taught.quantities, self._taught.chain
        if d is None or chain is None:
            return None
        parent, child = pose.positions[chain.parent], pose.positions[chain.child]
        reach = 0.0
        if chain.grandchild >= 0:
            reach = float(np.linalg.norm(pose.positions[chain.grandchild] - child))
        q_parent = pose.rotations[chain.parent]
        staged = self._taught.stage is not None
        shapes = sketch_gizmo(d, q_parent, parent, child, reach, 0.06 * scene.height, staged=staged)
        add_swing_axis_fan(shapes, d, q_parent, parent)
        gizmo_joints.name_joints(shapes, chain, pose.positions)
        return shapes

    def _attend(self, scene: Scene, shapes: Sketch) -> None:
        """Create the gizmo's layer over the last image of the 3D view, unless it already exists."""
        below = scene.renderers()[-1]
        if self._layer is not None and self._below is below:
            return
        self.leave()
        assert self._viewport.view is not None
        window = self._viewport.view.ren_win
        assert window is not None
        # The layer has its own depth buffer, so that no limb hides the gizmo.
        layer = vtkOpenGLRenderer()
        layer.SetLayer(1)
        layer.InteractiveOff()
        layer.SetUseOIT(False)
        layer.SetActiveCamera(below.GetActiveCamera())
        layer.SetViewport(*below.GetViewport())
        window.SetNumberOfLayers(max(2, window.GetNumberOfLayers()))
        window.AddRenderer(layer)
        self._layer, self._below = layer, below
        self._parts = shapes.parts
        for look in (BOLD, THIN, SOLID, CLEAR):
            count, cells = 0, []
            for part in self._parts:
                if part.look == look:
                    cells.append(count + part.cells)
                    count += len(part.points)
            joined = np.concatenate(cells)
            if look in _WIDTHS:
                piece = Piece(count, lines=joined).unlit(width=_WIDTHS[look])
            elif look == SOLID:
                piece = Piece(count, faces=joined).unlit()
            else:
                piece = Piece(count, faces=joined, channels=4).unlit().blended()
            self._pieces[look] = piece.add_to(layer)
        self._triads.add_to(layer)

    def _paint(self) -> None:
        theme, lit = self._viewport.theme, highlighted_gizmo_symbols(self._taught.lit)
        if (theme, lit) == self._painted:
            return
        self._painted = theme, lit
        paper = background(theme)
        inks: dict[str, list[Array]] = {look: [] for look in self._pieces}
        for part in self._parts:
            strength = part.share * (1.0 if not lit or part.symbol in lit else _DIMMED)
            ink = rgb(symbol_family_colour(MARKS[part.symbol].family, theme))
            clear = np.array([*ink, round(255 * strength)])
            seen = clear if part.look == CLEAR else (paper + strength * (ink - paper)).round()
            inks[part.look].append(np.tile(seen, (len(part.points), 1)))
        for look, piece in self._pieces.items():
            piece.paint(np.vstack(inks[look]))


def _stage_words(stage: float) -> str:
    """Return the legend for a stage of the parent's rotation.

    Stages from 0 to 1 are shares of the swing, and from 1 to 2 shares of the twist.
    """
    if stage <= 0.0:
        return tr("no rotation: bone along <b>a</b>")
    if stage <= 1.0:
        return tr("swing: {percent:.0f}&nbsp;%", percent=100.0 * stage)
    return tr("swing, then twist: {percent:.0f}&nbsp;%", percent=100.0 * (stage - 1.0))
