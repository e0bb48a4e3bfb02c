"""Letting the driver compile its shaders while nobody waits, before the first clip is there."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport.mesh_actor import Piece

_TRIANGLE = np.array([3, 0, 1, 2])
_LINE = np.array([2, 0, 1])


def specimens(renderer: vtkRenderer, paper: np.ndarray) -> list[Piece]:
    """One small piece of every kind that a figure is made of, in the colour of the paper, (3,)."""
    made = [
        Piece(3, faces=_TRIANGLE).lit(),
        Piece(3, faces=_TRIANGLE, channels=0).unlit(),
        Piece(3, faces=_TRIANGLE, channels=4).unlit(back_faces=False).blended(),
        Piece(3, lines=_LINE).unlit(width=2.0),
        Piece(3, lines=_LINE, channels=0).unlit(width=2.0),
    ]
    for piece in made:
        piece.points[:] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]
        width = min(3, piece.colours.shape[1])
        piece.colours[:, :width] = paper[:width]
        piece.tint(paper)
        piece.moved()
        piece.painted()
        piece.add_to(renderer)
    return made
