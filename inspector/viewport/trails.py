"""The trails of hands and feet around a frame, before and after correction and tracking.

A twist correction does not move any joint [Choi26 §3.2], so the trails before and after correction
coincide unless the clip is tracked.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.session.document import Document
from inspector.viewport.bone_colours import mix, rgb
from inspector.viewport.mesh_actor import Piece, segments
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array

REACH = 1.0  # seconds before and after the frame
_NEARER = 0.004  # relative to the distance from the eye


def end_effectors(motion: Motion, chains: tuple[Chain, ...]) -> NDArray[np.int64]:
    """Return the joints of the hands and feet, (n,).

    If no limbs are known, return the leaf joints of the skeleton.
    """
    found = {c.child for c in chains if c.segment in ("ForeArm", "Leg")}
    if not found:
        found = {joint for joint, _ in motion.skeleton.ends}
    return np.array(sorted(found), dtype=np.int64)


class Trails:
    """The trails as fading lines: a broad one before correction, a thin one after it on top."""

    def __init__(self, document: Document, renderers: list[vtkRenderer]) -> None:
        """Create the lines.

        There are one or two renderers. If there are two, the first shows the trails before
        correction and the second the trails after correction.
        """
        data = document.data
        assert data is not None
        self._document, self._data = document, data
        # Number of frames before and after the current frame
        self._length = max(1, round(REACH * data.motion.fps))
        self._joints = end_effectors(data.motion, find_chains(data.motion))
        self._stops = 2 * self._length + 1
        count = len(self._joints) * self._stops
        lines = segments(np.arange(count).reshape(-1, self._stops))
        self.before = Piece(count, lines=lines).unlit(width=5.0).add_to(renderers[0])
        self.after = Piece(count, lines=lines).unlit(width=2.0).add_to(renderers[-1])
        self._drawn: tuple[int, bytes] = (-1, b"")
        self._known: tuple[int, int, Array, Array] | None = None
        self.apart = 0.0  # largest distance between the two trails, in the unit of the file

    def colour(self, theme: Theme, background: Array) -> None:
        """Apply the theme's colours. The lines fade to the colour `background`, (3,)."""
        fade = np.linspace(1.0, -1.0, self._stops)
        strength = np.where(fade >= 0.0, 1.0 - 0.35 * fade, 1.0 + 0.75 * fade)[:, None]
        for piece, colour in (
            (self.before, rgb(theme.before)),
            (self.after, mix(theme.after, "#ffffff", 0.25 if theme.dark else 0.0)),
        ):
            line = strength * colour + (1.0 - strength) * background
            piece.paint(np.tile(line, (len(self._joints), 1)).astype(np.uint8))

    def forget(self) -> None:
        """Discard the computed positions. Called when the corrections have changed."""
        self._known = None
        self._drawn = (-1, b"")

    def draw(self, frame: int, eye: Array, *, before: bool, after: bool) -> None:
        """Draw the trails around a frame, as seen from the point `eye`, (3,)."""
        self.before.show(before)
        self.after.show(after)
        if self._drawn == (frame, eye.tobytes()):
            return
        self._drawn = (frame, eye.tobytes())
        first, second = self._around(frame)
        self.apart = float(np.linalg.norm(first - second, axis=2).max()) if first.size else 0.0
        # The corrected trail is moved toward the eye, so it is drawn on top but does not shift in
        # the image.
        for piece, way in ((self.before, first), (self.after, second + _NEARER * (eye - second))):
            piece.move(way.transpose(1, 0, 2).reshape(-1, 3))

    def _around(self, frame: int) -> tuple[Array, Array]:
        """Return the trails before and after correction, (stops, joints, 3) each.

        A stop is one of the frames around `frame`. For stops outside the clip, its first or last
        frame is repeated. Several seconds are computed together and cached for playback.
        """
        frames = self._document.frames
        low, high = max(frame - self._length, 0), min(frame + self._length + 1, frames)
        if self._known is None or not (self._known[0] <= low and high <= self._known[1]):
            start, stop = max(low - self._length, 0), min(high + 4 * self._length, frames)
            before = self._data.positions[start:stop, self._joints]
            if (tracked := self._document.tracked) is None:
                after = self._document.corrected.joint_paths(self._joints, start, stop)
            else:
                after = forward_kinematics(tracked.sliced(start, stop))[1][:, self._joints]
            self._known = start, stop, before, after
        start, _, before, after = self._known
        at = np.clip(np.arange(frame - self._length, frame + self._length + 1), 0, frames - 1)
        return before[at - start], after[at - start]

    def remove(self) -> None:
        """Remove the trails from the image."""
        self.before.remove()
        self.after.remove()
