"""The window's layout: messages over the figure, restored panels, and floating ones.

On a screen of its own, with real mouse and keys.
"""

import shutil

import pytest
from PySide6.QtCore import QRect

from inspector.bundled import SAMPLE
from inspector.window.usual_layout import move_clear_of_rectangle
from tests.gui.real_screen import needs_real_screen, real_screen, watched

SIZES = (
    "[window.docks['chains'].width(), window.docks['intervals'].width(), "
    "window.docks['curves'].height()]"
)


@pytest.fixture
def walk(tmp_path):
    return shutil.copy(SAMPLE, tmp_path / "walk.bvh")


def overlap(a, b):
    return QRect(*a).intersects(QRect(*b))


@pytest.mark.parametrize(
    ("taken", "wanted"),
    [
        ((0, 0, 10, 10), (40, 40)),  # not covered
        ((35, 50, 30, 30), (40, 30)),  # above is nearest
        ((35, 35, 10, 30), (45, 40)),
        ((0, 0, 200, 200), (40, 40)),  # there is no room
    ],
)
def test_a_panel_moves_the_shortest_way_or_stays(taken, wanted):
    room = QRect(0, 0, 200, 200)
    place = move_clear_of_rectangle(QRect(40, 40, 20, 20), QRect(*taken), room)
    assert place.topLeft().toTuple() == wanted
    assert place.size() == QRect(0, 0, 20, 20).size()


@pytest.mark.thorough
@needs_real_screen
def test_a_message_moves_nothing(tmp_path, walk, look):
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, walk) as p,
    ):
        p.until("not window.bar.isVisible()")
        before = p.rect("window.viewport")
        p.press("q")  # there is nothing to reject
        bar = p.rect("window.bar")
        p.settle()
        assert p.rect("window.viewport") == before
        assert QRect(*before).contains(QRect(*bar))
        label = "window.bar.label"
        assert p.ask(f"{label}.height() >= {label}.heightForWidth({label}.width()) > 0")
        screen.park()
        p.settle()
        seen = screen.picture(bar)
        close = p.rect("[b for b in window.bar.children() if hasattr(b, 'autoRaise')][0]")
        screen.click(close)
        p.until("not window.bar.isVisible()")
        screen.park()
        p.settle()
        assert (screen.picture(bar) != seen).any(axis=-1).mean() > 0.5, "the bar was not seen"


@pytest.mark.thorough
@needs_real_screen
def test_restored_panels_are_usable_and_floating_ones_leave_the_controls(tmp_path, walk, look):
    with real_screen(tmp_path, size=(1440, 900), look=look) as screen:
        with watched(screen, tmp_path, walk) as p:
            left, top, _, high = p.rect("window.docks['intervals']")
            border = left - 2, top + high // 2
            p.drag(border, (460, border[1]))
            p.until("window.docks['intervals'].width() > 800")
            left, top, _wide, high = p.rect("window.docks['curves']")
            screen.click((left + 60, top + 10), times=2)
            p.until("window.docks['curves'].isFloating()")
            p.settle()
            assert not overlap(p.rect("window.docks['curves']"), p.rect("window.transport"))
            left, top, *_ = p.rect("window.docks['curves']")
            screen.key("ctrl+q")
            p.process.wait()
        with watched(screen, tmp_path, walk) as p:
            p.until("window.docks['curves'].isVisible()")
            assert p.ask("window.docks['intervals'].width()") <= 0.5 * p.ask("window.width()") + 3
            assert p.ask("window.docks['chains'].width()") >= 120
            assert p.ask("window.docks['curves'].isFloating()")
            assert not overlap(p.rect("window.docks['curves']"), p.rect("window.transport"))
