"""A preview of the correction in the left image, which shows the figure before correction."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport.bodies import FIN
from inspector.viewport.bone_colours import mix, rgb
from inspector.viewport.mesh_actor import Piece, segments
from inspector.viewport.solid_and_ghost import SAME
from inspector.viewport.striped_skin import FIN_PARTS, Skin, pose_skin_fins
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, geodesic_angle

_STILL = 0.01  # in figure heights; a joint that moves less is treated as unchanged
# In figure heights; if a bone moves farther, its corrected fin would be too far from the drawn bone
_LOOSE = 0.06
# Distance of the line from the camera, relative to the true distance: the line looks the same, but
# is in front of all bodies.
_NEARER = 0.5
_JOINTS, _FINS = 4, 2  # numbers of joints on the line and of fins


class CorrectedOutline:
    """A preview of a corrected limb: a fin for each bone, and a line through the joints."""

    def __init__(
        self, skin: Skin, skeleton: Skeleton, height: float, renderer: vtkRenderer
    ) -> None:
        self._skin, self._skeleton, self._height = skin, skeleton, height
        count = _FINS * len(FIN_PARTS)
        self.fins = Piece(count, faces=np.arange(count).reshape(-1, 4)).unlit()
        self.line = Piece(_JOINTS, lines=segments(np.arange(_JOINTS)), channels=0).unlit(width=5.0)
        for piece in (self.fins, self.line):
            piece.show(False)
            piece.add_to(renderer)

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self.line.tint(rgb(theme.after))
        dark = mix(theme.after, "#000000", 0.25)
        edge = np.tile(FIN_PARTS == FIN, _FINS)[:, None]
        self.fins.paint(np.where(edge, rgb(theme.after), dark).astype(np.uint8))

    def draw(
        self,
        chain: Chain | None,
        before: tuple[Array, Array],
        after: tuple[Array, Array],
        viewer: Array,
    ) -> None:
        """Draw the correction of a chain or limb.

        Parameters
        ----------
        chain
            The chain or limb; None hides the outline.
        before, after
            The global rotations (joints, 4) and positions (joints, 3) before and after correction.
        viewer
            The position of the camera, (3,). The line is drawn in front of all bodies.
        """
        joints = [] if chain is None else self._joints(chain)
        moved = np.linalg.norm(after[1][joints] - before[1][joints], axis=-1)
        differs = geodesic_angle(before[0][joints], after[0][joints]) > SAME
        differs[:-1] &= np.maximum(moved[:-1], moved[1:]) < _LOOSE * self._height
        turned = [joint for joint, wrong in zip(joints, differs, strict=True) if wrong]
        fins = pose_skin_fins(self._skin, turned[:_FINS], *after)[:_FINS]
        self.fins.show(bool(fins.size))
        if fins.size:
            points = np.tile(fins[0, 0], (len(self.fins.points), 1))  # faces of zero area
            points[: fins[..., 0].size] = fins.reshape(-1, 3)
            self.fins.move(points)
        shifted = np.flatnonzero(moved > _STILL * self._height)
        self.line.show(bool(shifted.size))
        if shifted.size:  # draw only the bones that have a joint that moves
            shown = np.clip(np.arange(len(joints)), shifted[0] - 1, shifted[-1] + 1)
            places = after[1][joints][shown]
            self.line.move(viewer + _NEARER * (places - viewer))

    def _joints(self, chain: Chain) -> list[int]:
        """Return the three joints of a chain or limb, and the end of the longest bone below them.

        If a joint does not exist, the joint above it is repeated.
        """
        last = chain.end if isinstance(chain, Limb) else chain.grandchild
        joints = [chain.parent, chain.child, last if last >= 0 else chain.child]
        below = self._skeleton.children[joints[-1]]
        lengths = [float(np.linalg.norm(self._skeleton.offsets[joint])) for joint in below]
        return [*joints, below[int(np.argmax(lengths))] if below else joints[-1]]

    def remove(self) -> None:
        """Remove the outline from the view."""
        self.fins.remove()
        self.line.remove()
