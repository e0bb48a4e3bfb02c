"""While a clip is analysed, the start page shows its figure in the middle frame."""

import shutil

import numpy as np
import pytest
from PySide6.QtCore import QRectF

from inspector.panels.first_look_picture import fit_bones_to_rectangle
from inspector.session.first_look import first_look
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.formats.bvh import read_bvh

ONE_WINDOW = True


@pytest.fixture
def looks(window):
    seen = []
    window.document.opener.read.connect(seen.append)
    yield seen
    window.document.opener.read.disconnect(seen.append)


def close(window):
    window.document.review.mark_saved()
    act(window, "close")


def test_the_figure_is_there_until_the_clip_is_open(qtbot, window, looks, tmp_path):
    picture, clip = window.start_page.picture, shutil.copy(ASSETS / "walk.bvh", tmp_path)
    shown = []
    window.document.opener.read.connect(lambda _: shown.append(picture.isVisible()))
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path / "walk.bvh")
    assert [look.name for look in looks] == ["walk.bvh"]
    assert shown == [True]
    assert picture.look is None
    assert picture.isHidden()
    assert read_bvh(clip).motion.frames == looks[0].frames
    close(window)


def test_neither_cancelling_nor_failing_leaves_the_figure(qtbot, window, looks, tmp_path):
    picture, opener = window.start_page.picture, window.document.opener
    shutil.copy(ASSETS / "walk.bvh", tmp_path)
    shown = []

    def cancel(_look):
        shown.append(picture.look)
        act(window, "cancel_opening")

    opener.read.connect(cancel)
    with qtbot.waitSignal(opener.over, timeout=60_000):
        window.open_path(tmp_path / "walk.bvh")
    opener.read.disconnect(cancel)
    assert shown == looks
    assert picture.look is None
    assert picture.isHidden()
    (tmp_path / "bad.bvh").write_text("HIERARCHY\nROOT")
    with qtbot.waitSignal(opener.over, timeout=60_000):
        window.open_path(tmp_path / "bad.bvh")
    assert picture.look is None


def test_another_clip_takes_the_figure_away(qtbot, window, looks, tmp_path):
    picture, opener = window.start_page.picture, window.document.opener
    first, second = (
        shutil.copy(ASSETS / "walk.bvh", tmp_path / name) for name in ("a.bvh", "b.bvh")
    )
    shown = []

    def open_second(_look):
        opener.read.disconnect(open_second)
        window.open_path(second)
        shown.append(picture.look)

    opener.read.connect(open_second)
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(first)
    assert shown == [None]
    assert [look.name for look in looks] == ["a.bvh", "b.bvh"]
    close(window)


def test_the_figure_stands_upright_and_has_every_bone():
    clip = read_bvh(ASSETS / "walk.bvh")
    look = first_look(clip)
    skeleton = clip.motion.skeleton
    assert look.bones.shape == (len(skeleton) - 1, 2, 2)
    ends = dict(zip(skeleton.names[1:], look.bones[:, 1], strict=True))
    assert ends["Head"][1] > ends["LeftFoot"][1]
    assert abs(ends["LeftArm"][0] - ends["RightArm"][0]) > 1.0  # seen from the front


@pytest.mark.parametrize("size", [(400, 300), (120, 500)])
def test_the_figure_fits_its_room(size):
    bones = np.random.default_rng(1).normal(size=(20, 2, 2))
    placed = fit_bones_to_rectangle(bones, QRectF(10.0, 20.0, *size)).reshape(-1, 2)
    assert (placed >= [10.0, 20.0]).all()
    assert (placed <= [10.0 + size[0], 20.0 + size[1]]).all()
    top = bones.reshape(-1, 2)[:, 1].argmax()
    assert placed[:, 1].argmin() == top
