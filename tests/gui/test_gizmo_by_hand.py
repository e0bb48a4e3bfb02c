"""Swing and twist taken hold of with the mouse, in 3D."""

import contextlib
import shutil

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import differing, needs_real_screen, real_screen, watched

pytestmark = pytest.mark.thorough

HOLD = "window.teaching.gizmo.hold"
SOME = np.array([30.0, 20.0])  # pixels
CURSOR = "window.viewport.view.cursor().shape().name"


@contextlib.contextmanager
def at_the_arm(folder, look, size=(1440, 900), **how):
    """The program with the teaching tab shown, the left arm selected, and a frame of the walk."""
    clip = shutil.copy(ASSETS / "walk_injected.bvh", folder / "walk.bvh")
    with (
        real_screen(folder, size=size, look=look) as screen,
        watched(screen, folder, clip, **how) as p,
    ):
        screen.key("ctrl+l")
        p.until("window.teaching.typesetter.done")
        p.until("len(window.document.data.chains) > 1")
        arm = p.ask("[c.name for c in window.document.data.chains].index('LeftArm')")
        screen.click(p.ask(f"row(window.chains.table, {arm})"))
        p.until("window.document.chain == 'LeftArm'")
        p.settle()
        screen.key("ctrl+j")
        screen.shown("Go to frame")
        screen.type("90")
        screen.key("Return")
        p.until(f"window.document.frame == 90 - window.document.first_frame and {HOLD}.places")
        screen.shown("Twist Inspector$")
        screen.key("f")  # the dial is seen at a slant
        p.settle()
        yield p


def place(p, point):
    """Pixel of the screen at which a point of the handles is."""
    spot = p.ask(
        f"window.viewport.camera.project({HOLD}.places.{point}, *window.viewport.picture_size())"
        "[0].tolist()"
    )
    left, top, wide, _ = p.rect("window.viewport")
    scale = wide / p.ask("window.viewport.width()")
    return np.array([left, top]) + scale * np.array(spot)


def pixels(*points):
    return [tuple(round(v) for v in point) for point in points]


def what_if(p, name):
    return p.ask(f"window.taught.what_if.{name}")


@needs_real_screen
@pytest.mark.parametrize("scale", [1, 2])
def test_w_is_dragged_and_the_bone_and_the_slider_follow(tmp_path, look, scale):
    size = (1440 * scale, 900 * scale)
    with at_the_arm(tmp_path, look, size, scale=scale) as p:
        seen = p.screen.picture(p.rect("window.viewport")).copy()
        start = place(p, "tip") + 9.0 * scale * np.array([1.0, 0.0])  # beside its middle
        p.screen.use("mousemove", *pixels(start)[0])
        p.until(f"{CURSOR} == 'OpenHandCursor'")
        end = start + scale * np.array([70.0, -60.0])
        alpha, w = p.ask("[window.taught.quantities.alpha, window.taught.quantities.w.tolist()]")
        p.screen.drag(*pixels(start, end))
        p.settle()
        assert p.ask("window.taught.what_if.toward is not None")
        tip = place(p, "tip") + 9.0 * scale * np.array([1.0, 0.0])
        assert tip == pytest.approx(end, abs=3.0)
        now = p.ask("window.taught.quantities.alpha")
        assert np.dot(p.ask("window.taught.quantities.w.tolist()"), w) < np.cos(np.radians(15.0))
        shown = p.ask("window.teaching.what_if.sliders['swing'].value()")
        assert shown == pytest.approx(10.0 * np.degrees(now), abs=1.0)
        assert what_if(p, "twist") == 0.0
        assert differing(p.screen.steady_picture(p.rect("window.viewport")), seen) > 3_000
        p.screen.click(p.rect("window.teaching.what_if.reset"))
        p.until("not window.taught.what_if.changes")
        assert p.ask("window.taught.quantities.alpha") == pytest.approx(alpha)


@needs_real_screen
def test_the_dial_twists_and_with_ctrl_the_child_counters(tmp_path, look):
    with at_the_arm(tmp_path, look) as p:
        start, middle = place(p, "hand_tip"), place(p, "centre")
        way = start - middle
        end = middle + np.array([way[1], -way[0]]) + 0.5 * way
        theta = p.ask("window.taught.quantities.theta_p")
        p.screen.drag(*pixels(start, end))
        p.settle()
        twist = what_if(p, "twist")
        assert abs(twist) > np.radians(15.0)
        assert not what_if(p, "counter")
        turned = p.ask("window.taught.quantities.theta_p") - theta
        assert np.exp(1j * turned) == pytest.approx(np.exp(1j * twist), abs=1e-6)
        assert p.ask("window.taught.quantities.strength") < np.radians(2.0)
        # The hand is under the mouse: on the ring's plane, its way from the middle is the mouse's.
        hand = place(p, "hand_tip") - place(p, "centre")
        to_mouse = np.array(pixels(end)[0]) - place(p, "centre")
        assert hand @ to_mouse / np.linalg.norm(hand) / np.linalg.norm(to_mouse) > 0.98

        p.screen.click(p.rect("window.teaching.what_if.reset"))
        p.until("not window.taught.what_if.changes")
        p.settle()
        p.screen.use("keydown", "ctrl")
        p.screen.drag(*pixels(place(p, "hand_tip"), end))
        p.screen.use("keyup", "ctrl")
        p.settle()
        assert what_if(p, "counter")
        assert p.ask("window.teaching.what_if.counter.isChecked()")
        assert p.ask("window.taught.quantities.strength") > np.radians(10.0)


@needs_real_screen
def test_esc_puts_it_back_and_ctrl_counts_while_it_is_held(tmp_path, look):
    with at_the_arm(tmp_path, look) as p:
        start, middle = place(p, "hand_tip"), place(p, "centre")
        end = middle + np.array([start[1] - middle[1], middle[0] - start[0]])
        p.screen.use("mousemove", *pixels(start)[0], "mousedown", 1)
        for share in (0.3, 0.6, 1.0):
            p.screen.use("mousemove", *pixels(start + share * (end - start))[0])
        p.until("window.taught.what_if.changes and not window.taught.what_if.counter")
        assert p.ask(f"{HOLD}.knobs.words.startswith('θp ')")
        assert p.ask(CURSOR) == "ClosedHandCursor"
        p.screen.use("keydown", "ctrl")
        p.until("window.taught.what_if.counter")
        p.screen.use("keyup", "ctrl")
        p.until("not window.taught.what_if.counter")
        p.screen.key("Escape")
        p.until("not window.taught.what_if.changes")
        p.screen.use("mousemove_relative", "--", 20, 20)
        p.settle()
        assert not p.ask("window.taught.what_if.changes")
        p.screen.use("mouseup", 1)
        p.settle()
        assert not p.ask("window.taught.what_if.changes")
        assert not p.ask(f"{HOLD}.held")


@needs_real_screen
def test_beside_the_handles_the_camera_orbits(tmp_path, look):
    with at_the_arm(tmp_path, look) as p:
        left, top, wide, high = p.rect("window.viewport")
        corner = np.array([left + wide - 40.0, top + high - 40.0])
        for point in ("tip", "hand_tip", "centre"):
            assert np.linalg.norm(place(p, point) - corner) > 60.0
        azimuth = p.ask("window.viewport.camera.azimuth")
        p.screen.drag(*pixels(corner, corner - [80.0, 30.0]))
        p.settle()
        assert abs(p.ask("window.viewport.camera.azimuth") - azimuth) > 0.3
        assert not p.ask("window.taught.what_if.changes")
        # With Shift a handle is let through, too: the picture moves.
        before = place(p, "tip")
        p.screen.use("keydown", "shift")
        p.screen.drag(*pixels(before, before + SOME))
        p.screen.use("keyup", "shift")
        p.settle()
        assert place(p, "tip") == pytest.approx(before + SOME, abs=4.0)
        assert not p.ask("window.taught.what_if.changes")
        # Behind another tab there is nothing to take.
        p.screen.key("ctrl+t")
        p.until("not window.taught.active")
        p.settle()
        p.screen.drag(*pixels(before, before + SOME))
        p.settle()
        assert not p.ask("window.taught.what_if.changes")
        assert not p.ask(f"{HOLD}.knobs.isVisible()")
