"""The VTK scene of a clip: the figures and the ground, shown in one image or two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pyvistaqt import QtInteractor
from vtkmodules.vtkRenderingCore import vtkRenderer
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.session.document import Document
from inspector.session.opening import Analysed
from inspector.viewport.bodies import BoneSegment, Rods, align_bone_fronts, find_bones
from inspector.viewport.bone_colours import mix
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.corrected_outline import CorrectedOutline
from inspector.viewport.dashed_figure import DashedOutline
from inspector.viewport.ground import Ground, ground_at_lowest_joint, ground_lines
from inspector.viewport.head_and_chest import Front, heads_and_chests
from inspector.viewport.lights import background, light
from inspector.viewport.limb_circle import Circle, LimbCircle
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.solid_and_ghost import Ghost, Pose, Shapes, Solid, Style
from inspector.viewport.trails import Trails
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array, matrix_from_quaternion

AXES = np.array([[225, 72, 64], [74, 168, 84], [64, 118, 235]], dtype=np.uint8)  # x, y, z


class Scene:
    """The figures and the ground of a clip in a plotter. Each clip gets a new scene.

    Attributes
    ----------
    data
        The clip with the results of its analysis.
    people
        The joints of each person, keyed by name.
    up
        The upward direction, a unit vector (3,).
    height
        The height of the figure.
    bones
        The bones of the figures.
    fronts
        The heads and chests of all people.
    rods
        All bones, heads and chests as line segments.
    ground
        The ground below the figures.
    trails
        The trails of hands and feet, or None if they are hidden.
    shapes
        The shapes of the bodies in the current style.
    """

    def __init__(self, plotter: QtInteractor, document: Document, theme: Theme) -> None:
        data = document.data
        assert data is not None
        self._plotter = plotter
        self._document = document
        self.data: Analysed = data
        self._theme = theme
        self._limbs = find_chains(data.motion)  # not affected by chains that the user defines
        people = find_people(data.motion.skeleton)
        self.people = {person.name: person.joints for person in people}
        self.up = guess_up(data.positions, self._limbs, data.motion.skeleton)
        self.height = figure_size(data.positions, data.motion.skeleton)
        bones = find_bones(data.motion, self.up, self.height)
        self.bones: tuple[BoneSegment, ...] = align_bone_fronts(bones, self._limbs)
        self.fronts: tuple[Front, ...] = heads_and_chests(
            self._limbs, data.motion.skeleton, data.rotations, data.positions, self.height
        )
        self.rods = Rods.of(self.bodies)
        self.ground: Ground = ground_at_lowest_joint(
            data.positions, self.up, self.height, self.roots
        )
        self._left: vtkRenderer = plotter.renderer
        self._right: vtkRenderer | None = None
        points, lines, strength = ground_lines(self.ground)
        self._fade = 0.85 * strength[:, None]
        self._grid = Piece(len(points), lines=lines).unlit().add_to(self._left)
        self._grid.move(points)
        self._triads = Piece(12, lines=np.arange(12).reshape(6, 2)).unlit(width=3.0)
        self._triads.paint(np.repeat(np.tile(AXES, (2, 1)), 2, axis=0))
        self.trails: Trails | None = None
        self._seen: tuple[float, ...] = ()
        # The pose for which `ends` was last called, and the result
        self._ends: tuple[Pose, Array] | None = None
        self._other: Solid | None = None  # the solid figure in the right image
        self._third: DashedOutline | None = None  # created when needed
        self._circle: LimbCircle | None = None  # created when needed
        self._corrected: CorrectedOutline | None = None  # in the left image, if there are two
        self._dress(Style.WEDGES)
        self.colour(theme)

    # -- appearance ---------------------------------------------------------------------------

    @property
    def style(self) -> Style:
        """The style of the bodies."""
        return self.shapes.style

    @property
    def split(self) -> bool:
        """True if the figures before and after correction are in separate images."""
        return self._right is not None

    def set_style(self, style: Style) -> None:
        """Set the style of the bodies: wedges or skin."""
        if style != self.style:
            self._undress()
            self._dress(style)
            self._restore()

    def take_chains(self, data: Analysed) -> None:
        """Rebuild the figures after the user has changed the chains, which `data` contains."""
        self.data = data
        self._undress()
        self._dress(self.style)
        self._restore()

    def set_split(self, on: bool) -> None:
        """Set whether the figure before and after correction is shown in two images or in one.

        Both images share one camera.
        """
        if on == self.split:
            return
        trailing = self.trails is not None
        self.set_trails(False)
        self._undress()
        if on:
            self._right = vtkOpenGLRenderer()
            self._right.SetUseOIT(False)
            self._right.SetActiveCamera(self._left.GetActiveCamera())
            self._right.AutomaticLightCreationOff()
            light(self._right)
            self._right.SetViewport(0.5, 0.0, 1.0, 1.0)
            self._left.SetViewport(0.0, 0.0, 0.5, 1.0)
            self._grid.add_to(self._right)
            if self._plotter.ren_win is not None:
                self._plotter.ren_win.AddRenderer(self._right)
        else:
            self._drop_right()
        self._dress(self.style)
        self._restore()
        self.set_trails(trailing)

    def set_trails(self, on: bool) -> None:
        """Show or hide the trails of the hands and feet."""
        if self.trails is not None:
            self.trails.remove()
            self.trails = None
        if on:
            self.trails = Trails(self._document, self.renderers())
            self.trails.colour(self._theme, background(self._theme))

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours. The next call of `draw` colours the solid figures."""
        self._theme = theme
        self._restore()

    # -- drawing a frame ----------------------------------------------------------------------

    def draw(self, pose: Pose, after: Pose | None = None) -> None:
        """Draw the solid figure and its ghost, without repainting the view.

        Parameters
        ----------
        pose
            The pose in the left or only image.
        after
            The pose in the right image, if there is one.
        """
        self._solid.draw(pose)
        self._ghost.draw(pose)
        if self._other is not None and after is not None:
            self._other.draw(after, like=self._solid)

    def draw_companion(self, figure: tuple[Array, Array] | None, solid: Pose) -> None:
        """Draw the third figure with dashes.

        Parameters
        ----------
        figure
            The global rotations (joints, 4) and positions (joints, 3); None hides the figure.
        solid
            The pose of the solid figure. Only differences from this pose are drawn.
        """
        if figure is not None and self._third is None:
            self._third = DashedOutline(self.bones, self.height, self.renderers()[-1])
            self._third.colour(self._theme)
        if self._third is not None:
            self._third.draw(figure, solid)

    @property
    def accompanied(self) -> bool:
        """True if the third figure is visible."""
        return self._third is not None and self._third.shown

    def draw_triads(self, pose: Pose, joints: Sequence[int]) -> None:
        """Draw the coordinate axes of two joints. If `joints` (indices) is empty, hide the axes."""
        self._triads.show(bool(joints))
        if not joints:
            return
        joints = list(joints)
        axes = matrix_from_quaternion(pose.rotations[joints]).transpose(0, 2, 1)  # rows: x, y, z
        start = np.repeat(pose.positions[joints], 3, axis=0)
        stop = start + 0.06 * self.height * axes.reshape(6, 3)
        self._triads.move(np.stack([start, stop], axis=1).reshape(12, 3))

    def draw_circle(
        self,
        circle: Circle | None,
        offset: float = 0.0,
        *,
        before: bool = False,
        after: Array | None = None,
        line: bool = True,
    ) -> None:
        """Draw the circle of the selected limb or bone in the left or only image.

        The parameters are the same as in :meth:`LimbCircle.draw`. None hides the circle.
        """
        if circle is not None and self._circle is None:
            # The right image of two has no circle, since it shows only the corrected figure.
            self._circle = LimbCircle(self.height, self.renderers()[:1])
            self._circle.colour(self._theme)
        if self._circle is not None:
            self._circle.draw(circle, offset, before=before, after=after, line=line)

    def draw_corrected(
        self, chain: Chain | None, before: Pose, after: Pose, camera: OrbitCamera
    ) -> None:
        """Draw a preview of a chain's correction in the left image, if there are two images.

        Parameters
        ----------
        chain
            The chain or limb; None hides the preview.
        before, after
            The poses before and after correction.
        camera
            The camera from which the preview is seen.
        """
        if self._corrected is not None:
            start, stop = ((p.rotations, p.positions) for p in (before, after))
            self._corrected.draw(chain, start, stop, camera.position)

    def ends(self, pose: Pose) -> Array:
        """Return both ends of each body in a pose in world space, (bodies, 2, 3)."""
        if self._ends is None or self._ends[0] is not pose:
            self._ends = pose, self.rods.ends(pose.rotations, pose.positions)
        return self._ends[1]

    @property
    def bodies(self) -> tuple[BoneSegment, ...]:
        """All bones, followed by one bone for each head and chest."""
        return (*self.bones, *(front.bone for front in self.fronts))

    @property
    def circled(self) -> bool:
        """True if the circle of a limb or bone is visible."""
        return self._circle is not None and self._circle.circle.shown

    @property
    def roots(self) -> list[int]:
        """The root joint index of each person."""
        return [joints[0] for joints in self.people.values()]

    def facing(self, positions: Array, person: str = "") -> Array:
        """Return the horizontal direction in which a person faces, a unit vector (3,).

        Parameters
        ----------
        positions
            The positions of the joints, (joints, 3).
        person
            The name of the person; by default, the first person.
        """
        own = tuple(limb for limb in self._limbs if not person or limb.person == person)
        return figure_facing_direction(positions, own, self.up)

    def show_from(self, camera: OrbitCamera) -> None:
        """Set the VTK camera of all images to the given camera."""
        # All objects are on the disc of the ground or near the figure, so this distance is enough.
        # Computing the bounds of all actors with VTK would take longer than computing the frame.
        reach = float(np.linalg.norm(camera.position - self.ground.centre))
        reach += self.ground.radius + 2.0 * self.height
        near = max(0.02 * camera.distance, 1e-4 * reach)
        seen = (*camera.position, *camera.target, *camera.axes[1], near, reach)
        if seen == self._seen:
            return
        self._seen = seen
        vtk = self._left.GetActiveCamera()
        vtk.SetPosition(*camera.position)
        vtk.SetFocalPoint(*camera.target)
        vtk.SetViewUp(*camera.axes[1])
        vtk.SetViewAngle(float(np.degrees(VIEW_ANGLE)))
        vtk.SetClippingRange(near, reach)

    def remove(self) -> None:
        """Remove everything from the plotter."""
        self.set_trails(False)
        self._undress()
        self._drop_right()
        self._grid.remove()

    # -- creating and removing figures --------------------------------------------------------

    def _dress(self, style: Style) -> None:
        bodies = [front.body for front in self.fronts]
        self.shapes = Shapes(style, self.bones, self.data.chains, self.height, attached=bodies)
        self._solid = Solid(self.shapes, self.ground, self._left)
        self._ghost = Ghost(self.shapes, self._left)
        if self._right is not None:
            self._other = Solid(self.shapes, self.ground, self._right)
            self._corrected = CorrectedOutline(
                self.shapes.skin, self.data.motion.skeleton, self.height, self._left
            )
        self._triads.add_to(self.renderers()[-1])

    def _undress(self) -> None:
        for figure in self._figures():
            figure.remove()
        self._other = self._third = self._circle = self._corrected = None
        self._triads.remove()

    def _figures(self) -> list[Solid | Ghost | DashedOutline | LimbCircle | CorrectedOutline]:
        every = (
            self._solid, self._ghost, self._other, self._third, self._circle, self._corrected
        )  # fmt: skip
        return [figure for figure in every if figure is not None]

    def _restore(self) -> None:
        """Apply the theme's colours to all objects and the background."""
        back = background(self._theme)
        for renderer in self.renderers():
            renderer.SetBackground(*(back / 255.0))
        for figure in self._figures():
            figure.colour(self._theme)
        ink = mix(self._theme.line, self._theme.soft, 0.30)
        self._grid.paint((back + self._fade * (ink - back)).astype(np.uint8))
        if self.trails is not None:
            self.trails.colour(self._theme, back)

    def renderers(self) -> list[vtkRenderer]:
        """Return the renderers of the images, from left to right."""
        return [self._left] if self._right is None else [self._left, self._right]

    def _drop_right(self) -> None:
        if self._right is None:
            return
        self._grid.remove()
        self._right.RemoveAllLights()
        self._right.RemoveAllViewProps()
        window = self._plotter.ren_win
        if window is not None:
            self._right.ReleaseGraphicsResources(window)
            window.RemoveRenderer(self._right)
        self._right = None
        self._left.SetViewport(0.0, 0.0, 1.0, 1.0)
        self._grid.add_to(self._left)
