"""A mesh with its VTK actor. Its points and colours are updated in place in every frame.

For speed, numpy views of the VTK arrays are created once, and plain VTK mappers draw the arrays.
VTK is only notified of changes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

Index = NDArray[np.int64]


class Piece:
    """A mesh with moving vertices. Its faces, (n, 3) or (n, 4), or lines, (n, 2), are constant.

    `channels` is the number of channels of the vertex colours, 3 or 4. If it is 0, the whole mesh
    has a single colour, which `tint` sets.
    """

    def __init__(
        self,
        vertices: int,
        *,
        faces: ArrayLike | None = None,
        lines: ArrayLike | None = None,
        channels: int = 3,
        normals: bool = False,
    ) -> None:
        self._mesh = vtkPolyData()
        points = vtkPoints()  # single precision
        points.SetNumberOfPoints(vertices)
        self._mesh.SetPoints(points)
        self._data = points.GetData()
        self.points: NDArray[np.float32] = vtk_to_numpy(self._data)
        self.points[:] = 0.0
        if faces is not None:
            self._mesh.SetPolys(_cells(faces))
        if lines is not None:
            self._mesh.SetLines(_cells(lines))
        self._mapper = vtkPolyDataMapper()
        self._mapper.SetInputData(self._mesh)
        self.colours: NDArray[np.uint8] = np.full((vertices, max(channels, 1)), 128, np.uint8)
        self._scalars = None
        if channels:
            self._scalars = numpy_to_vtk(self.colours)
            self._mesh.GetPointData().SetScalars(self._scalars)
        else:
            self._mapper.ScalarVisibilityOff()
        self._normals = None
        if normals:
            self.normals: NDArray[np.float32] = np.zeros((vertices, 3), np.float32)
            self._normals = numpy_to_vtk(self.normals)
            self._normals.SetName("Normals")
            self._mesh.GetPointData().SetNormals(self._normals)
        self.actor = vtkActor()
        self.actor.SetMapper(self._mapper)
        self.actor.PickableOff()
        self._renderers: list[vtkRenderer] = []

    def unlit(self, *, width: float = 1.0, back_faces: bool = True) -> Piece:
        """Turn off lighting, and return the mesh. `width` is the width of its lines in pixels."""
        prop = self.actor.GetProperty()
        prop.LightingOff()
        prop.SetLineWidth(width)
        if not back_faces:
            prop.BackfaceCullingOn()
        return self

    def lit(self) -> Piece:
        """Use slight lighting and gloss, so that faces are distinguishable, and return the mesh."""
        prop = self.actor.GetProperty()
        prop.SetAmbient(0.70)
        prop.SetDiffuse(0.50)
        prop.SetSpecular(0.10)
        prop.SetSpecularPower(18)
        return self

    def blended(self) -> Piece:
        """Draw the mesh after all opaque meshes, even if it is opaque now, and return the mesh."""
        self.actor.ForceTranslucentOn()
        return self

    def tint(self, colour: ArrayLike) -> None:
        """Set the colour of a mesh without vertex colours, (3,) in 0…255."""
        self.actor.GetProperty().SetColor(*(np.asarray(colour, dtype=float) / 255.0))

    def move(self, points: ArrayLike, normals: ArrayLike | None = None) -> None:
        """Set the positions and, if the mesh has normals, the normals of the vertices.

        Both arrays are (vertices, 3).
        """
        self.points[:] = points
        self._data.Modified()
        if self._normals is not None and normals is not None:
            self.normals[:] = normals
            self._normals.Modified()
        self._mesh.Modified()

    def paint(self, colours: ArrayLike) -> None:
        """Set the colours of the vertices, (vertices, channels) in 0…255."""
        self.colours[:] = colours
        if self._scalars is not None:
            self._scalars.Modified()
            self._mesh.Modified()

    def show(self, shown: bool) -> None:
        """Show or hide the mesh."""
        if bool(self.actor.GetVisibility()) != shown:
            self.actor.SetVisibility(shown)

    @property
    def shown(self) -> bool:
        """True if the mesh is visible."""
        return bool(self.actor.GetVisibility())

    def add_to(self, renderer: vtkRenderer) -> Piece:
        """Add the mesh to a renderer, and return the mesh."""
        renderer.AddActor(self.actor)
        self._renderers.append(renderer)
        return self

    def remove(self) -> None:
        """Remove the mesh from all renderers."""
        for renderer in self._renderers:
            renderer.RemoveActor(self.actor)
        self._renderers.clear()


def add_warm_up_meshes(renderer: vtkRenderer, paper: NDArray[np.float64]) -> list[Piece]:
    """Add and return a small mesh of each kind, invisible in the background colour `paper`, (3,).

    If these meshes are drawn before the first clip is opened, the OpenGL driver has already
    compiled the shaders for the clip.
    """
    triangle, line = [[0, 1, 2]], [[0, 1]]
    made = [
        Piece(3, faces=triangle).lit(),
        Piece(3, faces=triangle, channels=0).unlit(),
        Piece(3, faces=triangle, channels=4).unlit(back_faces=False).blended(),
        Piece(3, lines=line).unlit(width=2.0),
        Piece(3, lines=line, channels=0).unlit(width=2.0),
    ]
    for piece in made:
        piece.move([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
        piece.paint([*paper, 128.0][: piece.colours.shape[1]])
        piece.tint(paper)
        piece.add_to(renderer)
    return made


def segments(lines: Index) -> Index:
    """Split polylines into line segments, (n, 2). Each row of point indices is a polyline."""
    return np.stack([lines[..., :-1], lines[..., 1:]], axis=-1).reshape(-1, 2)


def _cells(corners: ArrayLike) -> vtkCellArray:
    cells, found = vtkCellArray(), np.asarray(corners, dtype=np.int64)
    cells.SetData(found.shape[1], numpy_to_vtkIdTypeArray(found.ravel(), deep=True))
    return cells
