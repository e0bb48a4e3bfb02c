"""The first minutes of a new user: the card while the program starts, the start page, the sample.

On a screen of its own, with real mouse and keys.
"""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from inspector.bundled import SAMPLE
from tests.gui.real_screen import needs_real_screen, program, real_screen, wait_until, watched

pytestmark = [pytest.mark.thorough, needs_real_screen]
_SPLASH_WIDTH = 340
_MAIN = "Twist Inspector$"


def at_home(screen, folder):
    """The screen with a home whose documents are in the folder, as the desktop has set it."""
    config = Path(screen.env.get("XDG_CONFIG_HOME", folder / "config"))
    config.mkdir(exist_ok=True)
    documents = folder / "documents"
    (config / "user-dirs.dirs").write_text(f'XDG_DOCUMENTS_DIR="{documents}"\n')
    return replace(screen, env={**screen.env, "XDG_CONFIG_HOME": str(config)}), documents


def widths(screen, known):
    """Of the windows to be seen that were not there before."""
    found = []
    for window in set(screen.windows("")) - known:
        words = screen._asked("getwindowgeometry", "--shell", window).stdout.split()
        found += [int(word[6:]) for word in words if word.startswith("WIDTH=")]
    return found


def test_a_card_is_there_before_the_window_and_goes_when_it_comes(tmp_path, look):
    with real_screen(tmp_path, size=(1440, 900), look=look) as screen:
        known = set(screen.windows(""))
        with program(screen.env, tmp_path):
            wait_until(lambda: widths(screen, known))
            first = set(widths(screen, known))
            assert first == {_SPLASH_WIDTH}, "the card is not the first window"
            assert screen.active() not in set(screen.windows("")) - known, "the card has the keys"
            screen.shown(_MAIN)
            wait_until(lambda: _SPLASH_WIDTH not in widths(screen, known))
            assert max(widths(screen, known)) > 2 * _SPLASH_WIDTH


def test_the_sample_is_ones_own_and_opens_where_it_is_worst(tmp_path, look):
    looks = {"skin": False, "side_by_side": False}
    shipped = sorted(path.name for path in SAMPLE.parent.iterdir())
    with real_screen(tmp_path, size=(1440, 900), look=look) as plain:
        screen, documents = at_home(plain, tmp_path)
        with watched(screen, tmp_path, settings=looks) as p:
            screen.click(p.rect("window.start_page.buttons['open_sample']"))
            p.until("window.document.interval is not None")
            opened = Path(p.ask("str(window.document.data.clip.path)"))
            assert opened.parent == documents / "Twist Inspector"
            assert opened.read_bytes() == SAMPLE.read_bytes()
            severity = "[window.document.severity(j) for j in window.document.intervals]"
            worst = "window.document.severity(window.document.interval)"
            assert p.ask(f"{worst} == max({severity})")
            frame = "window.document.frame"
            assert p.ask(f"{frame} == window.document.interval.interval.seen_at")
            degrees = p.ask("abs(window.document.interval.interval.shown) * 57.29577951308232")
            said = p.until("window.bar.isVisible() and window.bar.label.text()")
            assert f"{degrees:.0f}°" in said
            assert "A " in said
            assert "R " in said
            for name in ("skin", "side_by_side"):
                assert p.ask(f"window.actions_by_id['{name}'].isChecked()"), name
                assert not p.ask(f"window.settings.{name}"), "the sample changes a setting"
            p.press("a")
            p.until("window.document.review.position == 1")
            # The sentence is about the worst interval alone.
            p.until(f"not window.bar.isVisible() or window.bar.label.text() != {said!r}")
            p.press("ctrl+s")
            wait_until(lambda: list(documents.glob("*/*.twist.json")))
        with watched(screen, tmp_path) as p:  # the next day: where one was
            screen.click(p.rect("window.start_page.buttons['open_sample']"))
            p.until("window.document.interval is not None")
            assert "accepted" in p.decisions()
            assert p.ask("window.document.interval.decision.value") == "undecided"
            assert len(list(documents.glob("*/*.bvh"))) == 1
    assert sorted(path.name for path in SAMPLE.parent.iterdir()) == shipped


def test_the_start_page_begins_the_tour_and_opens_a_folder_of_before(tmp_path, look):
    takes = tmp_path / "takes"
    takes.mkdir()
    shutil.copy(SAMPLE, takes / "one.bvh")
    known = {"clip": "one.bvh", "profile": "", "method": "", "tau": {}}
    recent = {"recent": [str(takes / "one.bvh")], "folders": {str(takes): known}}
    with real_screen(tmp_path, size=(1440, 900), look=look) as screen:
        with watched(screen, tmp_path, settings=recent) as p:
            page = "[b for b in window.start_page.findChildren(type(window.start_page.buttons"
            found = f"{page}['tour'])) if b.objectName() == '%s'][0]"
            assert p.rect(found % "recent")[1] > p.rect(found % "recent_folder")[1]
            screen.click(p.rect(found % "recent_folder"))
            p.until("window.document.data is not None")
            assert p.ask("str(window.queue.folder)") == str(takes)
        with watched(screen, tmp_path, settings={}) as p:
            screen.click(p.rect("window.start_page.buttons['tour']"))
            p.until("window.lesson_actions.on")
