"""The names and coordinate axes of parent, child and grandchild (P, C, G) in the 3D view."""

from __future__ import annotations

import numpy as np

from inspector.teaching.gizmo_shapes import Sketch
from inspector.viewport.mesh_actor import Index
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import Array, matrix_from_quaternion

POINTS = 18  # number of points of three triads; a triad is a joint's x, y and z axis
LINES: Index = np.arange(POINTS).reshape(-1, 2)
_LONG = 0.16  # length of an axis in bone lengths


def name_joints(out: Sketch, chain: Chain, positions: Array) -> None:
    """Add a label with the name of each joint of the chain to `out`.

    The grandchild gets no label if its actual position is already labelled.
    """
    parent, child = positions[chain.parent], positions[chain.child]
    out.mark("P", parent, child)
    if chain.grandchild < 0:
        out.mark("C", child, parent)
        return
    grandchild = positions[chain.grandchild]
    out.mark("C", child, 0.5 * (parent + grandchild))
    named = any(mark.symbol == "real" for mark in out.marks)
    out.mark("G", grandchild, child, shown=not named)


def triads(chain: Chain, rotations: Array, positions: Array, unit: float) -> Array:
    """Return lines along the coordinate axes of parent, child and grandchild, (POINTS, 3).

    Each line is a pair of points. Without a grandchild, the axes of the child are repeated.
    """
    joints = [chain.parent, chain.child, max(chain.grandchild, chain.child)]
    axes = matrix_from_quaternion(rotations[joints]).transpose(0, 2, 1)  # rows: x, y, z
    start = np.repeat(positions[joints], 3, axis=0)
    lines = np.stack([start, start + _LONG * unit * axes.reshape(9, 3)], axis=1)
    return lines.reshape(POINTS, 3)
