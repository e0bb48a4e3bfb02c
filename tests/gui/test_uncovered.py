"""What lay over the window is gone when it closes, also where nothing remembers what it covered."""

import contextlib
import shutil
import time

import pytest

from tests.conftest import ASSETS
from tests.gui.looks import EVERY, LOOKS, Look
from tests.gui.real_screen import (
    differing,
    middle,
    needs_real_screen,
    real_screen,
    wait_until,
    watched,
)

pytestmark = pytest.mark.thorough

LARGE = 5_000  # pixels: more than a pointer or a button that is lit
SMALL = 500  # less than a tool tip, or the words of a menu over paper of its colour
DRAWN = 0.1  # seconds in which a window that is there has painted itself
KEYS = {
    "palette": "ctrl+k",
    "preferences": "ctrl+comma",
    "keyboard": "question",
    "guide": "F1",
    "open": "ctrl+o",
    "export": "ctrl+e",
    "save as": "ctrl+shift+s",
    "record": "ctrl+r",
    "add chain": "ctrl+shift+c",
    "go to frame": "ctrl+j",
    "the sure ones": "ctrl+shift+a",
}
COMBOS = ("window.transport.speed", "window.transport.show_box", "window.intervals.filter")
A_FEW = ("a menu", "Recent", "palette", "export", "filter", "tip")
PARKED = (1439, 899)


def openings(p):
    """By name: what opens something over the window, asked anew each time it is used."""
    screen = p.screen

    def menu(name):
        bar = f"window.menuBar().actionGeometry(window._menus['{name}'].menuAction())"
        screen.click(p.ask(f"rect(window.menuBar(), {bar})"))

    def recent():
        menu("File")
        place = "window._menus['File'].actionGeometry(window.recent_menu.menuAction())"
        wait_until(lambda: p.ask("window._menus['File'].isVisible()"))
        screen.click(p.ask(f"rect(window._menus['File'], {place})"))

    def about():
        menu("Help")
        wait_until(lambda: p.ask("window._menus['Help'].isVisible()"))
        screen.click(p.ask("entry('show_about')"))

    def tip():
        screen.use(
            "mousemove", *middle(p.ask("entry('next_interval')")), "mousemove_relative", 3, 2
        )

    def all_menus():
        menu("File")
        screen.key(*["Right"] * p.ask("len(window._menus) - 1"))

    found = {"menus": all_menus, "a menu": lambda: menu("View"), "Recent": recent}
    found |= {"About": about, "tip": tip}
    found |= {name: (lambda k=keys: screen.key(k)) for name, keys in KEYS.items()}
    found |= {c.rpartition(".")[2]: (lambda c=c: screen.click(p.rect(c))) for c in COMBOS}
    found["of chains"] = lambda: screen.click(p.ask("row(window.chains.table, 2)"), 3)
    found["of a plot"] = lambda: screen.click(p.rect("window.timeline.panes['strength']"), 3)
    return found


@needs_real_screen
@pytest.mark.parametrize("seen_in", LOOKS if EVERY else [Look()], ids=str)
def test_nothing_stays_of_what_lay_over_the_window(tmp_path, seen_in):
    """In a look of its own, and in the other theme, chosen in a menu."""
    clip = shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "walk.bvh")
    first = seen_in.theme
    all_of_them = (first,) if EVERY or first == "system" else ()
    with (
        real_screen(tmp_path, size=(1440, 900), look=seen_in) as screen,
        watched(screen, tmp_path, clip) as p,
    ):
        known = openings(p)
        left = {}
        for theme in (first, "light" if seen_in.dark else "dark"):
            known["a menu"]()
            p.until("window._menus['View'].isVisible()")
            screen.click(p.ask(f"entry('theme_{theme}')"))
            screen.park()
            # The status bar's first words go with the menu's.
            p.until(
                f"window.settings.theme == '{theme}' and not window.statusBar().currentMessage()"
            )
            for name in known if theme in all_of_them else A_FEW:
                if lost := stays(p, known[name]):
                    left[theme, name] = lost
                    screen.save(tmp_path / f"{theme}, {name}.png")
        assert left == {}, "pixels are left"


def stays(p, open_it):
    """How many pixels are others after something was opened and closed again by Esc."""
    screen = p.screen
    # What shows that it has the keys, or had them, does so in its own place.
    boxes = [p.rect("window.intervals.filter"), p.ask("row(window.chains.table, 2)")]

    below = p.rect("window")[1]

    def look():
        picture = screen.picture().copy()
        picture[:below] = 0  # the title is the desktop's, who may have no letters for it
        for left, top, wide, high in boxes:
            picture[top - 3 : top + high + 3, left - 3 : left + wide + 240] = 0
        return picture

    def close():
        way = ("mousemove", *middle(ground), "sleep", 0.03, "mousemove", *PARKED)
        screen.use("key", "Escape", *way)

    ground = p.rect("window.statusBar()")  # over it the pointer lights nothing
    screen.steady_picture()
    before = after = look()
    assert differing(before, before[0, 0]) > LARGE, "the window is not to be seen"
    open_it()

    def open_again():  # but not what a busy machine has still to show
        p.ask("None")
        screen.steady_picture()
        if differing(look(), before) <= SMALL:
            open_it()

    wait_until(lambda: differing(look(), before) > SMALL, meanwhile=open_again)
    time.sleep(DRAWN)
    p.ask("None")
    close()

    def is_gone():
        nonlocal after
        after = look()
        return not differing(after, before)

    with contextlib.suppress(AssertionError):
        wait_until(is_gone, seconds=20.0, meanwhile=close)
    return differing(after, before)
