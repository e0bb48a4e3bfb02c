"""Track a stream of poses from a local socket, and show it in the 3D view.

    python live_figure.py CLIP.bvh [--fps 60] [--port 9763]

The clip gives the skeleton and, unless --fps is given, the rate. A sender connects to 127.0.0.1 and
writes a line of JSON for each pose, {"rotations": [[w, x, y, z], …], "position": [x, y, z]}: each
joint's quaternion relative to its parent, in the clip's order, and the root's position. See
`send_clip.py` for an example.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject
from PySide6.QtNetwork import QHostAddress, QTcpServer

import twistcore as tc
from inspector.app import make_application
from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.viewport.bone_colours import Role
from inspector.viewport.solid_and_ghost import Pose
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, Colours
from twistcore.skeleton.motion import forward_kinematics


class LiveFigure(QObject):
    """The stream's figure in a 3D view: tracked as solid, and the input as an outline."""

    def __init__(self, viewport, fps, port):
        """Listen on the port; 0 means any free port."""
        super().__init__(viewport)
        self.viewport, self.fps, self.frames = viewport, fps, 0
        self.motion = viewport.document.data.motion.sliced(0, 1)
        self.given = self.shown = self.placed(self.motion.rotations[0], self.motion.positions[0, 0])
        self.server = QTcpServer(self)
        self.server.listen(QHostAddress.SpecialAddress.LocalHost, port)
        self.server.newConnection.connect(self.welcome)
        viewport.invite(self)

    def welcome(self):
        """Connect a new sender with its own tracker."""
        tracker, sender = tc.Tracker(self.fps), self.server.nextPendingConnection()
        sender.readyRead.connect(lambda: self.read(sender, tracker))
        self.read(sender, tracker)

    def read(self, sender, tracker):
        """Track all received poses, and show the last one."""
        while sender.canReadLine():
            pose = json.loads(sender.readLine().data())
            given = pose["rotations"], pose["position"]
            self.shown = self.placed(*tracker.step(given))
            self.given = self.placed(*map(np.array, given))
            self.frames += 1
        self.viewport.refresh()

    def placed(self, rotations, position):
        """Return the global rotations and positions of a pose."""
        positions = self.motion.positions.copy()
        positions[0, 0] = position
        pose = replace(self.motion, rotations=rotations[None], positions=positions)
        return tuple(values[0] for values in forward_kinematics(pose))

    # -- what a guest of the 3D view provides

    def pose(self, scene, show):
        """Return the figure to draw."""
        (before, places), (after, positions) = self.given, self.shown
        bones = len(scene.bones)
        ghost = before, np.ones(bones, dtype=bool)
        roles = np.full(bones, Role.AFTER)
        return Pose(after, positions, roles, ghost, ghost_positions=places)

    def legend(self):
        """Return the legend."""
        return "solid: tracked · outline: input"

    def draw(self, scene, pose, camera):
        """Draw nothing in addition to the pose."""

    def aim(self, scene):
        """Leave the camera alone."""

    def leave(self):
        """Leave the view as it is."""


def main():
    """Show the stream until the window is closed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clip", type=Path)
    parser.add_argument("--fps", type=float, help="poses per second")
    parser.add_argument("--port", type=int, default=9763)
    given = parser.parse_args()
    app, document = make_application(), Document()
    document.show_clip(analyse_file(given.clip))
    viewport = Viewport(document, Colours(DARK))
    fps = given.fps or document.data.motion.fps
    live = LiveFigure(viewport, fps, given.port)
    viewport.resize(900, 700)
    viewport.show()
    app.exec()
    live.server.close()
    document.close_clip()


if __name__ == "__main__":
    main()
