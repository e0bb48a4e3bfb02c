"""What VTK draws: solid bodies, the ghost, its outline, a shadow, the ground, triads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from pyvistaqt import QtInteractor
from vtkmodules.vtkRenderingCore import vtkLight

from inspector.theme import Theme
from inspector.viewport.bodies import Bone, Soup, build_soup, collapse, find_bones, place
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera, figure_size, guess_up
from inspector.viewport.ground import Ground, ground_mesh, lowest, shadow_points
from inspector.viewport.paint import ghost_paint, mix, mixed_hex, paint, palette
from twistcore.chain import Chain
from twistcore.motion import Motion
from twistcore.rotation import Array, matrix_from_quaternion

_GHOST_GROWN = 1.09  # the ghost lies around a solid body of the same pose, not in its faces
_AXES = np.array([[225, 72, 64], [74, 168, 84], [64, 118, 235]], dtype=np.uint8)  # x, y, z


@dataclass(frozen=True, eq=False)
class Pose:
    """What one frame looks like.

    rotations (joints, 4), positions (joints, 3): the solid figure; roles (bones,), of paint.Role;
    ghost: rotations (joints, 4) of the other figure, with which of its bones are drawn,
    (bones,), or None.
    """

    rotations: Array
    positions: Array
    roles: NDArray[np.int64]
    ghost: tuple[Array, NDArray[np.bool_]] | None = None


class Scene:
    """The meshes and actors of one clip in a plotter; built anew for another clip."""

    def __init__(
        self,
        plotter: QtInteractor,
        motion: Motion,
        chains: tuple[Chain, ...],
        positions: Array,
        theme: Theme,
    ) -> None:
        self._plotter = plotter
        self.up = guess_up(positions, chains, motion.skeleton)
        self.height = figure_size(positions, motion.skeleton)
        self.bones: tuple[Bone, ...] = find_bones(motion, self.up, self.height)
        self.ground: Ground = lowest(positions, self.up, self.height)
        self.bodies = build_soup(self.bones)
        self._ghosts = build_soup(self.bones, grown=_GHOST_GROWN, joints=False)
        self._grid = ground_mesh(self.ground)
        self._body = _mesh(self.bodies, faces=True)
        self._ghost = _mesh(self._ghosts, faces=True)
        self._outline = _mesh(self._ghosts, faces=False)
        self._shadow = _mesh(self.bodies, faces=True)
        self._triads = _triad_mesh()
        self._painted: bytes | None = None
        self._actors: dict[str, pv.Actor] = {}
        self.with_triads = True
        self._add_actors()
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take over colours; the next pose is painted in them."""
        self._colours = palette(theme)
        self._painted = None
        back = background(theme)
        set_background(self._plotter, back)
        ink, fade = mix(theme.line, theme.soft, 0.30), 0.85 * self._grid["fade"][:, None]
        self._grid["rgb"][:] = (fade * ink + (1.0 - fade) * back).astype(np.uint8)
        self._grid.GetPointData().GetArray("rgb").Modified()
        shade = mixed_hex(theme.window, "#000000", 0.38 if theme.dark else 0.13)
        self._actors["shadow"].prop.color = shade
        self._actors["outline"].prop.color = theme.before
        self._ghost["rgba"][:] = ghost_paint(self._ghosts, theme)
        self._ghost.GetPointData().GetArray("rgba").Modified()

    def draw(self, pose: Pose) -> None:
        """Move and paint everything for a pose; the caller asks for the repaint."""
        points = place(self.bodies, pose.rotations, pose.positions)
        _move(self._body, points)
        _move(self._shadow, shadow_points(points, self.ground))
        roles = pose.roles.tobytes()
        if roles != self._painted:
            self._painted = roles
            self._body["rgb"][:] = paint(self.bodies, self._colours, pose.roles)
            self._body.GetPointData().GetArray("rgb").Modified()
        visible = pose.ghost is not None and bool(pose.ghost[1].any())
        for name in ("ghost", "outline"):
            self._actors[name].visibility = visible
        if pose.ghost is not None and visible:
            rotations, drawn = pose.ghost
            around = place(self._ghosts, rotations, pose.positions)
            around = collapse(around, self._ghosts, pose.positions, drawn)
            _move(self._ghost, around)
            _move(self._outline, around)

    def draw_triads(self, pose: Pose, chain: Chain | None) -> None:
        """The axes of the chain's P and C, as the solid figure has them."""
        shown = chain is not None and self.with_triads
        self._actors["triads"].visibility = shown
        if chain is None or not shown:
            return
        joints = [chain.parent, chain.child]
        axes = matrix_from_quaternion(pose.rotations[joints]).transpose(0, 2, 1)  # rows: x, y, z
        start = np.repeat(pose.positions[joints], 3, axis=0)
        stop = start + 0.06 * self.height * axes.reshape(6, 3)
        _move(self._triads, np.stack([start, stop], axis=1).reshape(12, 3))

    def show_from(self, camera: OrbitCamera) -> None:
        """Look through the camera."""
        vtk = self._plotter.renderer.GetActiveCamera()
        vtk.SetPosition(*camera.position)
        vtk.SetFocalPoint(*camera.target)
        vtk.SetViewUp(*camera.axes[1])
        vtk.SetViewAngle(float(np.degrees(VIEW_ANGLE)))
        # Everything lies on the ground's disc or near the figure; asking VTK for the bounds of
        # all actors would cost more than the frame's own arithmetic.
        reach = np.linalg.norm(camera.position - self.ground.centre)
        reach += self.ground.radius + 2.0 * self.height
        vtk.SetClippingRange(max(0.02 * camera.distance, 1e-4 * reach), reach)

    def hide_bodies(self, hidden: bool) -> None:
        """For tests and measurements: everything but the bodies stays."""
        for name in ("body", "ghost", "outline", "shadow", "triads"):
            self._actors[name].visibility = not hidden

    def remove(self) -> None:
        """Take every actor out of the plotter."""
        for actor in self._actors.values():
            self._plotter.remove_actor(actor, render=False)
        self._actors.clear()

    def _add_actors(self) -> None:
        flat = {"render": False, "reset_camera": False, "show_scalar_bar": False}
        unlit = {**flat, "lighting": False}
        add = self._plotter.add_mesh
        self._actors = {
            "grid": add(self._grid, scalars="rgb", rgb=True, line_width=1, **unlit),
            "shadow": add(self._shadow, color="#888888", **unlit),
            "body": add(
                self._body,
                scalars="rgb",
                rgb=True,
                ambient=0.66,
                diffuse=0.50,
                specular=0.10,
                specular_power=18,
                **flat,
            ),
            "ghost": add(self._ghost, scalars="rgba", rgb=True, culling="back", **unlit),
            "outline": add(self._outline, color="#888888", line_width=2, **unlit),
            "triads": add(self._triads, scalars="rgb", rgb=True, line_width=3, **unlit),
        }
        for actor in self._actors.values():
            actor.SetPickable(False)


def background(theme: Theme) -> Array:
    """The colour behind everything, (3,) in 0…255. A gradient would cost 3 ms a frame."""
    return mix(theme.surface, theme.window, 0.6)


def set_background(plotter: QtInteractor, colour: Array) -> None:
    """One colour, (3,) in 0…255."""
    plotter.renderer.SetBackground(*(colour / 255.0))


def set_lights(plotter: QtInteractor) -> None:
    """A key light from above the camera's left and a faint fill: two lights are cheap."""
    plotter.remove_all_lights()
    for place_, strength in (((-0.7, 0.9, 1.0), 0.85), ((0.8, -0.2, 0.6), 0.30)):
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*place_)
        light.SetIntensity(strength)
        plotter.renderer.AddLight(light)


def _mesh(soup: Soup, *, faces: bool) -> pv.PolyData:
    points = np.zeros(soup.vertices.shape, dtype=np.float32)
    mesh = pv.PolyData(points, faces=soup.faces) if faces else pv.PolyData(points, lines=soup.edges)
    mesh["rgb"] = np.full((len(points), 3), 128, dtype=np.uint8)
    mesh["rgba"] = np.full((len(points), 4), 128, dtype=np.uint8)
    return mesh


def _triad_mesh() -> pv.PolyData:
    lines = np.array([[2, 2 * k, 2 * k + 1] for k in range(6)]).ravel()
    mesh = pv.PolyData(np.zeros((12, 3), dtype=np.float32), lines=lines)
    mesh["rgb"] = np.repeat(np.tile(_AXES, (2, 1)), 2, axis=0)
    return mesh


def _move(mesh: pv.PolyData, points: Array) -> None:
    mesh.points[:] = points
    mesh.GetPoints().Modified()
    mesh.Modified()
