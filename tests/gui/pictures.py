"""What tests of the 3D view look at: its pictures, as arrays."""

import numpy as np
from PySide6.QtGui import QImage

from inspector.session.opening import analyse_file
from tests.conftest import ASSETS
from twistcore.detection import Interval
from twistcore.review import Decide, Decision, Insert

WALK, INJECTED = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh"
FRAME = 100


def settle(qtbot, view):
    """Let the view draw what it was told."""
    qtbot.waitUntil(lambda: not view.pending)
    qtbot.wait(30)


def picture(qtbot, view):
    """What the window shows, (height, width, 3), without the legend and the signs."""
    settle(qtbot, view)
    overlays = view.overlays
    signs = (
        overlays.legend, overlays.angle, overlays.whole, overlays.clock, *overlays.sides.values()
    )  # fmt: skip
    shown = [sign for sign in signs if not sign.isHidden()]
    for sign in shown:
        sign.hide()
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    for sign in shown:
        sign.show()
    lines = np.frombuffer(image.constBits(), dtype=np.uint8)
    lines = lines.reshape(image.height(), image.bytesPerLine())[:, : 3 * image.width()]
    return lines.reshape(image.height(), image.width(), 3).astype(np.int16)


def changed(one, other, by=24):
    """Which pixels differ visibly, (height, width)."""
    return np.abs(one - other).max(axis=2) >= by


def limb_pixels(qtbot, view, joint):
    """The pixels of the bones on a joint: what changes when they alone are not drawn."""
    whole = picture(qtbot, view)
    soup = view.scene.shapes.bodies
    mine = np.isin(soup.bone, [k for k, b in enumerate(view.scene.bones) if b.parent == joint])
    kept = soup.vertices[mine].copy()
    soup.vertices[mine] = 0.0  # no area: not drawn
    view.refresh()
    without = picture(qtbot, view)
    soup.vertices[mine] = kept
    view.refresh()
    return changed(whole, without, by=8)


def show_instead(document, view, path):
    """Another clip of the same figure, as the view showed the first one; nothing to correct."""
    camera = view.camera
    document.show_clip(analyse_file(path))
    reject_all(document)
    document.select_chain("LeftForeArm")
    document.go_to(FRAME)
    view.set_follow(False)
    view.camera = camera
    view.refresh()


def reject_all(document):
    if document.intervals:
        document.do(Decide(tuple(j.id for j in document.intervals), Decision.REJECTED))


def insert_twist(document, chain="LeftForeArm", degrees=90.0):
    document.do(Insert(Interval(chain, FRAME - 2, FRAME + 3, np.full(5, np.radians(degrees)))))


def grabbed(qtbot, view):
    """What any widget shows now, (height, width, 3), as whole numbers with a sign."""
    qtbot.wait(60)
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def near(image, ink, by=40):
    """How many pixels have a colour."""
    wanted = np.array([int(ink[k : k + 2], 16) for k in (1, 3, 5)])
    return int((np.abs(image - wanted).max(axis=2) < by).sum())
