"""The correction in the image before it: the fin of a bone, and the joints that will move."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport.bodies import FIN
from inspector.viewport.bone_colours import mix, rgb
from inspector.viewport.mesh_actor import Piece, segments
from inspector.viewport.striped_skin import FIN_PARTS, Skin, fin_of
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array

_STILL = 0.01  # of the figure's height; joints that move less are in place
_JOINTS = 4


class CorrectedOutline:
    """The fin after correction, and a line through the limb where its joints will be."""

    def __init__(
        self, skin: Skin, skeleton: Skeleton, height: float, renderer: vtkRenderer
    ) -> None:
        self._skin, self._skeleton, self._still = skin, skeleton, _STILL * height
        faces = np.arange(len(FIN_PARTS)).reshape(-1, 4)
        self.fin = Piece(len(FIN_PARTS), faces=faces).unlit()
        self.line = Piece(_JOINTS, lines=segments(np.arange(_JOINTS)), channels=0).unlit(width=5.0)
        for piece in (self.fin, self.line):
            piece.show(False)
            piece.add_to(renderer)

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self.line.tint(rgb(theme.after))
        dark = mix(theme.after, "#000000", 0.25)
        edge = (FIN_PARTS == FIN)[:, None]
        self.fin.paint(np.where(edge, rgb(theme.after), dark).astype(np.uint8))

    def draw(self, chain: Chain | None, before: Array, after: tuple[Array, Array]) -> None:
        """Draw the correction of a chain or limb, or nothing for None.

        `before` has the positions before the correction, (joints, 3). `after` has the global
        rotations (joints, 4) and positions after it.
        """
        is_bone = chain is not None and not isinstance(chain, Limb)
        fin = fin_of(self._skin, chain, *after) if chain is not None and is_bone else None
        self.fin.show(fin is not None)
        if fin is not None:
            self.fin.move(fin)
        joints = [] if chain is None else self._joints(chain)
        moved = np.linalg.norm(after[1][joints] - before[joints], axis=-1) > self._still
        self.line.show(bool(moved.any()))
        if moved.any():
            self.line.move(after[1][joints])

    def _joints(self, chain: Chain) -> list[int]:
        """Return the joints of a chain or limb and the longest bone below it, (4,)."""
        last = chain.end if isinstance(chain, Limb) else chain.grandchild
        joints = [chain.parent, chain.child, last if last >= 0 else chain.child]
        below = self._skeleton.children[joints[-1]]
        lengths = [float(np.linalg.norm(self._skeleton.offsets[joint])) for joint in below]
        return [*joints, below[int(np.argmax(lengths))] if below else joints[-1]]

    def remove(self) -> None:
        """Remove the outline from the view."""
        self.fin.remove()
        self.line.remove()
