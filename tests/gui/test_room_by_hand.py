"""Little room: what a person reads and presses is whole at 1440×900, and on a laptop at 200 %."""

import shutil

import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import needs_real_screen, real_screen, watched

pytestmark = pytest.mark.thorough

DOCK = "window.docks['{}'].widget()"


@pytest.fixture
def clips(tmp_path):
    """A folder of two clips, one of them with errors."""
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("kick.bvh", "walk.bvh"):
        shutil.copy(ASSETS / name, folder)
    return folder


def inside(part, room):
    """Whether a rectangle lies in another one."""
    left, top, wide, high = part
    x, y, most, deep = room
    return x <= left and y <= top and left + wide <= x + most and top + high <= y + deep


@needs_real_screen
def test_the_teaching_tab_of_a_folder_shows_all_its_buttons(tmp_path, clips, look):
    """Equations give way to sliders, buttons and the sentence below them."""
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, clips) as p,
    ):
        p.until("window.document.data is not None")
        screen.key("ctrl+l")
        p.until("window.teaching.isVisible()")
        p.settle()
        room = p.rect(DOCK.format("teaching") + ".viewport()")
        for part in ("follow", "counter", "reset", "words"):
            assert inside(p.rect(f"window.teaching.what_if.{part}"), room), part
        screen.click(p.rect("window.teaching.what_if.counter"))
        p.until("window.teaching.what_if.counter.isChecked()")


@needs_real_screen
def test_a_laptop_at_200_percent(tmp_path, clips, look):
    """Begin, decide, and the preferences with their buttons, in 960×540."""
    whole = (0, 0, 1920, 1080)
    with (
        real_screen(tmp_path, look=look) as screen,
        watched(screen, tmp_path, scale=2) as p,
    ):
        start = "window.start_page"
        room = p.rect(f"{start}.viewport()")
        for name in ("tour", "open_sample", "open_dialog", "open_folder"):
            assert inside(p.rect(f"{start}.buttons['{name}']"), room), name
        screen.key("ctrl+comma")
        p.until("QApplication.activeModalWidget() is not None")
        p.settle()
        box = "QApplication.activeModalWidget()"
        for button in p.ask(f"[rect(b) for b in {box}.buttons.buttons()]"):
            assert inside(button, whole)
        assert p.ask(f"all(b.icon().isNull() for b in {box}.buttons.buttons())")
        screen.key("Escape")
        p.until("QApplication.activeModalWidget() is None")
    with (
        real_screen(tmp_path, look=look) as screen,
        watched(screen, tmp_path, clips / "kick.bvh", scale=2) as p,
    ):
        p.press("n", "a")
        p.until("window.reviewer_line.isVisible()")
        p.settle()
        assert not p.ask(DOCK.format("intervals") + ".horizontalScrollBar().isVisible()")
        hint = "window.reviewer_line.name"
        assert p.ask(
            f"{hint}.fontMetrics().horizontalAdvance({hint}.placeholderText()) < {hint}.width()"
        )
        assert "of 4" in p.ask("window.timeline.plots_button.text()")
