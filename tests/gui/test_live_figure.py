"""The example of docs/quamo.md: a stream of poses from a socket, tracked, in the 3D view."""

import importlib.util
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.gui.pictures import WALK, changed, picture
from twistcore.formats.bvh import read_bvh
from twistcore.quamo import HandGains, track
from twistcore.skeleton.motion import forward_kinematics

EXAMPLE = Path(__file__).parents[2] / "docs" / "example_stream"
FRAMES = 40


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def live(show_view, document):
    view = show_view(document)
    live = example("live_figure").LiveFigure(view, document.data.motion.fps, port=0)
    yield live
    live.server.close()


def test_a_stream_from_a_socket_is_tracked_and_drawn(qtbot, live):
    motion = read_bvh(WALK).motion.sliced(20, 20 + FRAMES)
    before = picture(qtbot, live.viewport)
    sender = threading.Thread(
        target=example("send_clip").send,
        args=(motion, live.server.serverPort()),
        kwargs={"seconds": 0.0},
    )
    sender.start()
    qtbot.waitUntil(lambda: live.frames == FRAMES)
    sender.join()
    found = track(motion.rotations, motion.positions[:, 0], motion.frame_time, HandGains())
    positions = motion.positions.copy()
    positions[:, 0] = found.r
    made = forward_kinematics(replace(motion, rotations=found.q, positions=positions))
    for shown, expected in zip(live.shown, made, strict=True):
        assert np.abs(shown - expected[-1]).max() < 1e-9
    for given, expected in zip(live.given, forward_kinematics(motion), strict=True):
        assert np.abs(given - expected[-1]).max() < 1e-9
    assert changed(before, picture(qtbot, live.viewport)).sum() > 1000
