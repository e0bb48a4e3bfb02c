"""The gizmo in the 3D view: its pieces in a layer above the figure, its labels above all."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPixmap, QRegion
from PySide6.QtWidgets import QWidget
from vtkmodules.vtkRenderingCore import vtkRenderer
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.session.open_clip import Show
from inspector.teaching.gizmo_shapes import BOLD, CLEAR, SOLID, THIN, Mark, Part, Sketch, sketch
from inspector.teaching.symbols import MARKS, colour
from inspector.teaching.taught_frame import TaughtFrame
from inspector.viewport.bone_colours import rgb
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.frame_drawing import altered_pose
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.scene import Scene, background
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.viewport import Viewport
from inspector.widgets.labels import inked
from inspector.widgets.theme import Theme
from inspector.widgets.typeset import EM, Formula, Typesetter
from twistcore.rotation import Array, conjugate, multiply, rotate

_WIDTHS = {BOLD: 3.0, THIN: 1.6}
_DIMMED = 0.22  # of what is not lit, beside what is
_SIZE = 1.25  # of a label, in heights of the program's font
_APART = 4.0  # pixels between two labels
_HALO = 2.5  # pixels around a label's letters
_GAP = 15.0  # pixels from what it names to a label's middle
# What lights up along with a symbol.
_TOGETHER = {
    "q": ("a", "w", "alpha", "theta_p", "n"),
    "swing": ("alpha", "n", "a", "w"),
    "twist": ("theta_p",),
    "product": ("dtheta_p", "dtheta_c"),
    "m": ("dtheta_p", "dtheta_c", "v", "ideal"),
}


def lit_parts(symbol: str) -> frozenset[str]:
    """The parts of the gizmo that a symbol lights up; none: all are as bright."""
    return frozenset((symbol, *_TOGETHER.get(symbol, ()))) if symbol else frozenset()


class GizmoGuest:
    """What the teaching tab draws into a 3D view; a guest of it while the tab is shown."""

    def __init__(self, viewport: Viewport, taught: TaughtFrame, typesetter: Typesetter) -> None:
        self._viewport, self._taught = viewport, taught
        self.labels = Labels(viewport, typesetter)
        self._pieces: dict[str, Piece] = {}
        self._parts: list[Part] = []  # their symbols and sizes are the same in every frame
        self._layer: vtkOpenGLRenderer | None = None
        self._below: vtkRenderer | None = None
        self._painted: tuple[object, ...] = ()

    # -- what the view asks -------------------------------------------------------------------

    def pose(self, scene: Scene, show: Show) -> Pose:
        """The captured figure; with a what-if that one, the captured one as its ghost."""
        what_if = None if show == Show.BEFORE else self._taught.pose()
        return altered_pose(self._taught.document, scene, what_if)

    def legend(self) -> str:
        """Rich text for the corner."""
        theme, chain = self._viewport.theme, self._taught.chain
        name = f"<b>{chain.label}</b>&nbsp;&nbsp; " if chain is not None else ""
        if not self._taught.what_if.changes:
            return f"{name}as captured"
        captured = f"{inked('□', theme.before)}&nbsp;as captured"
        return f"{name}{captured}&nbsp;&nbsp; {inked('■', theme.after)}&nbsp;what if"

    def draw(self, scene: Scene, pose: Pose, camera: OrbitCamera) -> None:
        """Move, paint and label everything for the pose."""
        shapes = self._shapes(scene, pose)
        if shapes is None:
            self.leave()
            return
        self._attend(scene, shapes)
        for look, piece in self._pieces.items():
            piece.move(np.vstack([part.points for part in shapes.parts if part.look == look]))
        self._paint()
        width, height = self._viewport.picture_size()
        left = self._viewport.width() - width
        self.labels.show_marks(
            shapes.marks, camera, QRectF(left, 0, width, height), self._viewport.theme,
            lit_parts(self._taught.lit),
        )  # fmt: skip

    def aim(self, scene: Scene) -> tuple[Array, Array] | None:
        """All of the gizmo, from where the swing is seen flat and the dial at a slant."""
        d, chain = self._taught.quantities, self._taught.chain
        shapes = self._shapes(scene, pose := self.pose(scene, Show.BOTH))
        if shapes is None or d is None or chain is None:
            return None
        points = np.vstack([p.points for p in shapes.parts if p.look != CLEAR])
        q_parent = pose.rotations[chain.parent]
        along = rotate(q_parent, d.a)
        normal = rotate(multiply(q_parent, conjugate(d.q)), d.n)
        ahead = scene.facing(pose.positions)
        outward = pose.positions[chain.child] - pose.positions.mean(axis=0)
        outward = outward / max(float(np.linalg.norm(outward)), 1e-9)
        around, above = np.meshgrid(np.radians(np.arange(0, 360, 10)), np.radians((0, 15, 30, 45)))
        aside = np.cross(scene.up, ahead)
        level = np.cos(around)[..., None] * ahead + np.sin(around)[..., None] * aside
        seen = np.cos(above)[..., None] * level + np.sin(above)[..., None] * scene.up
        seen = seen.reshape(-1, 3)
        worth = np.abs(seen @ normal) + 1.4 * np.minimum(np.abs(seen @ along), 0.5)
        worth += 0.35 * (seen @ outward) + 0.25 * (seen @ ahead)
        return points, seen[int(np.argmax(worth))]

    def leave(self) -> None:
        """Take everything out of the view."""
        self.labels.hide()
        for piece in self._pieces.values():
            piece.remove()
        self._pieces, self._painted = {}, ()
        view = self._viewport.view
        if self._layer is not None and view is not None and view.ren_win is not None:
            self._layer.RemoveAllViewProps()
            self._layer.ReleaseGraphicsResources(view.ren_win)
            view.ren_win.RemoveRenderer(self._layer)
        self._layer = self._below = None

    # -- drawing ------------------------------------------------------------------------------

    def _shapes(self, scene: Scene, pose: Pose) -> Sketch | None:
        """The gizmo of a pose; nothing without a chain."""
        d, chain = self._taught.quantities, self._taught.chain
        if d is None or chain is None:
            return None
        parent, child = pose.positions[chain.parent], pose.positions[chain.child]
        reach = 0.0
        if chain.grandchild >= 0:
            reach = float(np.linalg.norm(pose.positions[chain.grandchild] - child))
        q_parent = pose.rotations[chain.parent]
        return sketch(d, q_parent, parent, child, reach, 0.06 * scene.height)

    def _attend(self, scene: Scene, shapes: Sketch) -> None:
        """Pieces and a layer over the right-hand picture, made when there are none."""
        below = scene.renderers()[-1]
        if self._layer is not None and self._below is below:
            return
        self.leave()
        assert self._viewport.view is not None
        window = self._viewport.view.ren_win
        assert window is not None
        # A layer of its own: its depth begins anew, so that no limb hides the gizmo.
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

    def _paint(self) -> None:
        theme, lit = self._viewport.theme, lit_parts(self._taught.lit)
        if (theme, lit) == self._painted:
            return
        self._painted = theme, lit
        paper = background(theme)
        inks: dict[str, list[Array]] = {look: [] for look in self._pieces}
        for part in self._parts:
            strength = part.share * (1.0 if not lit or part.symbol in lit else _DIMMED)
            ink = rgb(colour(MARKS[part.symbol].family, theme))
            clear = np.array([*ink, round(255 * strength)])
            seen = clear if part.look == CLEAR else (paper + strength * (ink - paper)).round()
            inks[part.look].append(np.tile(seen, (len(part.points), 1)))
        for look, piece in self._pieces.items():
            piece.paint(np.vstack(inks[look]))


class Labels(QWidget):
    """Symbols over the 3D view, typeset like the equations, each beside what it names."""

    def __init__(self, viewport: QWidget, typesetter: Typesetter) -> None:
        super().__init__(viewport)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._typesetter = typesetter
        self._placed: list[tuple[Formula, QRectF, str, bool]] = []
        self._pixmaps: dict[tuple[object, ...], QPixmap] = {}
        self.hide()

    def show_marks(
        self,
        marks: list[Mark],
        camera: OrbitCamera,
        picture: QRectF,
        theme: Theme,
        lit: frozenset[str],
    ) -> None:
        """Place the labels in a picture of the view, none over another."""
        view = self.parentWidget()
        assert view is not None
        if self.geometry() != view.rect():
            self.setGeometry(view.rect())
        self._paper = QColor(*background(theme).round().astype(int).tolist())
        self._scale = _SIZE * self.fontMetrics().height() / EM
        covered = self._region()
        self._placed = []
        if not marks or not self._typesetter.done:
            self.hide()
            return
        size = (round(picture.width()), round(picture.height()))
        at, _ = camera.project(np.stack([m.at for m in marks]), *size)
        away, _ = camera.project(np.stack([m.away for m in marks]), *size)
        corner = np.array([picture.left(), picture.top()])
        for mark, here, other in zip(marks, at, away, strict=True):
            formula = self._typesetter.formula(MARKS[mark.symbol].tex)
            if formula is None:
                continue
            way = here - other
            long = float(np.hypot(*way))
            way = way / long if long > 1.0 else np.array([0.7071, -0.7071])
            box = self._free(here + corner, way, formula)
            bright = not lit or mark.symbol in lit or (mark.symbol == "real" and "v" in lit)
            ink = colour(MARKS[mark.symbol].family, theme)
            self._placed.append((formula, box, ink, bright))
        if not self.isVisible():
            self.show()
            self.raise_()
        self.update(covered + self._region())

    def _free(self, at: Array, way: Array, formula: Formula) -> QRectF:
        """A place beside a point that no earlier label takes, the wanted side first."""
        wide = formula.box.width() * self._scale
        high = formula.box.height() * self._scale
        wanted = np.arctan2(way[1], way[0])
        box = QRectF()
        for gap in (_GAP, 1.8 * _GAP, 2.6 * _GAP):
            for turn in (0.0, 0.6, -0.6, 1.2, -1.2, 2.0, -2.0, 3.1):
                angle = wanted + turn
                x = at[0] + (gap + 0.3 * wide) * np.cos(angle) - 0.5 * wide
                y = at[1] + gap * np.sin(angle) - 0.5 * high
                box = QRectF(x, y, wide, high)
                room = box.adjusted(-_APART, -_APART, _APART, _APART)
                if not any(room.intersects(taken) for _, taken, _, _ in self._placed):
                    return box
        return box

    def paintEvent(self, event: QPaintEvent) -> None:
        """Every label where it was placed."""
        painter = QPainter(self)
        for formula, box, ink, bright in self._placed:
            painter.drawPixmap(
                box.topLeft() - QPointF(_HALO, _HALO), self._drawn(formula, ink, bright)
            )

    def _drawn(self, formula: Formula, ink: str, bright: bool) -> QPixmap:
        """A label on a halo of the background's colour; stroked once, not for every frame."""
        ratio = self.devicePixelRatioF()
        key = (formula, ink, bright, self._scale, self._paper.rgb(), ratio)
        if key not in self._pixmaps:
            size = formula.box.size() * self._scale + QSizeF(2.0 * _HALO, 2.0 * _HALO)
            pixmap = QPixmap((size * ratio).toSize() + QSize(1, 1))
            pixmap.setDevicePixelRatio(ratio)
            pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(pixmap)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.translate(_HALO, _HALO)
            painter.scale(self._scale, self._scale)
            painter.translate(-formula.box.topLeft())
            painter.setOpacity(1.0 if bright else 0.3)
            halo = QPen(self._paper, 2.0 * _HALO / self._scale)
            halo.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
            painter.strokePath(formula.path, halo)
            painter.fillPath(formula.path, QColor(ink))
            painter.end()
            self._pixmaps[key] = pixmap
        return self._pixmaps[key]

    def _region(self) -> QRegion:
        """What the labels cover."""
        region = QRegion()
        for _, box, _, _ in self._placed:
            region += box.adjusted(-_HALO, -_HALO, _HALO, _HALO).toAlignedRect()
        return region
