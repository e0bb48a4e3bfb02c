"""Where one is in a review: numbers and the menu of rows, several rows, edits, and what undo shows.

On a screen of its own, with real mouse and keys.
"""

import shutil

import pytest

from inspector.bundled import SAMPLE
from tests.gui.real_screen import needs_real_screen, real_screen, watched

pytestmark = [pytest.mark.thorough, needs_real_screen]
TABLE = "window.intervals.table"


@pytest.fixture
def walk(tmp_path):
    return shutil.copy(SAMPLE, tmp_path / "walk.bvh")


def in_menu(p, text):
    """Where an entry of the open menu is on the screen."""
    menu = p.until("QApplication.activePopupWidget() is not None") and (
        "QApplication.activePopupWidget()"
    )
    return p.ask(
        f"[rect({menu}, {menu}.actionGeometry(a)) for a in {menu}.actions()"
        f" if a.text().replace('&', '').startswith('{text}')][0]"
    )


def test_rows_have_numbers_a_menu_and_say_how_many_are_selected(tmp_path, walk, look):
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, walk) as p,
    ):
        numbers = f"[{TABLE}.model().headerData(k, Qt.Orientation.Vertical) for k in range(8)]"
        assert p.ask(numbers) == [str(k) for k in range(1, 9)]
        assert p.ask(f"{TABLE}.verticalHeader().isVisible()")
        screen.click(p.ask(f"row({TABLE}, 2)"), button=3)
        screen.click(in_menu(p, "Reject"))
        p.until("'rejected' in [j.decision.value for j in window.document.intervals]")
        assert p.decisions().index("rejected") == 2
        p.settle()
        several = "window.detail.several"
        assert not p.ask(f"{several}.isVisible()")
        screen.click(p.ask(f"row({TABLE}, 4)"))
        screen.use("keydown", "shift")
        screen.click(p.ask(f"row({TABLE}, 6)"))
        screen.use("keyup", "shift")
        p.until(f"{several}.isVisible() and {several}.text().startswith('3 ')")
        p.press("a")
        p.until("window.document.review.position == 2")
        assert p.decisions()[4:7] == ["accepted"] * 3
        p.until(f"not {several}.isVisible()")


def test_an_edited_interval_says_so_and_what_is_undone_is_shown(tmp_path, walk, look):
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, walk) as p,
    ):
        p.press("n")
        p.until("window.document.interval is not None")
        p.settle()
        interval, why = "window.document.interval", "window.detail.why.text()"
        assert "0.99" in p.ask(why)
        screen.key("bracketright")  # the end at the playhead
        p.until(f"{interval}.edited")
        p.settle()
        assert "edited" in p.ask("window.detail.title.text()")
        assert "0.99" not in p.ask(why)
        assert "jumps" not in p.ask(why)
        cells = (
            f"[{TABLE}.model().index(0, k).data() for k in range({TABLE}.model().columnCount())]"
        )
        assert "–" in p.ask(cells)
        assert any("✎" in str(cell) for cell in p.ask(cells))
        screen.key("shift+z", "End")  # far away
        p.until("window.document.frame == window.document.frames - 1")
        left, top, wide, high = p.rect("window.timeline.panes['theta']")
        screen.wheel((left + wide * 95 // 100, top + high // 2), 6)
        visible = "window.timeline.visible.ends"
        p.until(f"{visible}[0] > {interval}.interval.stop")
        p.press("ctrl+z")
        p.until(f"not {interval}.edited")
        p.until(f"{visible}[0] <= {interval}.interval.start <= {visible}[1]")
        assert p.ask(f"window.document.frame == {interval}.interval.seen_at")
        assert "0.99" in p.ask(why)
