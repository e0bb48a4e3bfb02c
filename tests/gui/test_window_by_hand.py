"""The window as a person meets it: its sizes, its panels, its tools, its help."""

import contextlib
import shutil

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import (
    differing,
    middle,
    needs_real_screen,
    program,
    real_screen,
    wait_until,
    watched,
)

pytestmark = pytest.mark.thorough

SEEN = (
    "{k: rect(d) for k, d in window.docks.items()"
    " if d.isVisible() and (d.isFloating() or window.rect().intersects(d.geometry()))}"
)


@pytest.fixture
def walk(tmp_path):
    return shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "walk.bvh")


def inside(part, whole):
    left, top, wide, high = part
    return (
        left >= whole[0]
        and top >= whole[1]
        and left + wide <= whole[0] + whole[2]
        and top + high <= whole[1] + whole[3]
    )


def choose(p, menu, place):
    """Click on an entry of a menu of the bar."""
    bar = f"window.menuBar().actionGeometry(window._menus['{menu}'].menuAction())"
    p.screen.click(p.ask(f"rect(window.menuBar(), {bar})"))
    p.until(f"window._menus['{menu}'].isVisible()")
    p.screen.click(p.ask(place))
    p.until(f"not window._menus['{menu}'].isVisible()")
    p.settle()


def maximised(p):
    return p.ask("window.isMaximized() and not window.isFullScreen()")


@needs_real_screen
@pytest.mark.parametrize(("size", "scale"), [((1024, 700), 1), ((1920, 1080), 2)])
def test_the_first_window_is_whole_on_a_small_screen(tmp_path, walk, look, size, scale):
    with (
        real_screen(tmp_path, size=size, look=look) as screen,
        watched(screen, tmp_path, walk, scale=scale) as p,
    ):
        left, top, wide, high = p.ask("window.frameGeometry().getRect()")
        assert left >= 0
        assert top >= 0
        assert (left + wide) * scale <= size[0]
        assert (top + high) * scale <= size[1]
        window = p.rect("window")
        shown = p.ask(SEEN)
        assert {"chains", "intervals", "curves"} <= set(shown)
        assert all(inside(part, window) for part in shown.values())
        assert p.rect("window.viewport")[2] >= window[2] / 3
        for name in ("open_dialog", "accept", "reject", "loop_interval", "focus_chain"):
            assert inside(p.ask(f"entry('{name}')"), window), name
        name = "window.fontMetrics().horizontalAdvance('Right UpL')"
        assert p.ask(f"window.chains.table.columnWidth(0) > {name}")


@needs_real_screen
def test_sizes_come_back_and_panels_that_float_stay_in_front(tmp_path, walk, look):
    with real_screen(tmp_path, size=(1600, 1000), look=look) as screen:
        with watched(screen, tmp_path, walk) as p:
            azimuth = "window.chains.table.columnViewportPosition(4) + window.chains.table"
            assert p.ask(f"{azimuth}.columnWidth(4) <= window.chains.table.viewport().width()")
            usual = p.ask(SEEN)
            left, top, *_ = p.rect("window.docks['chains']")
            screen.click((left + 90, top + 12), times=2)
            p.until("window.docks['chains'].isFloating()")
            p.settle()
            floating = chains_seen(p)
            assert differing(floating, floating[2, 2]) > 5_000
            screen.key("ctrl+q")
            p.process.wait(60)
        with watched(screen, tmp_path, walk) as p:
            assert p.ask("window.docks['chains'].isFloating()")
            assert differing(chains_seen(p), floating) < 50
            choose(p, "View", "rect(window._menus['View'], window._menus['View'].actionGeometry("
                   "window.docks['intervals'].toggleViewAction()))")  # fmt: skip
            assert not p.ask("window.docks['intervals'].isVisible()")
            choose(p, "View", "entry('reset_layout')")
            p.until("not window.docks['chains'].isFloating()")
            p.settle()
            now = p.ask(SEEN)
            assert set(now) == set(usual)
            for name, part in usual.items():
                assert all(abs(a - b) <= 2 for a, b in zip(part, now[name], strict=True)), name

            frame = p.rect("window")
            bar = p.ask("window.geometry().y() - window.frameGeometry().y()")  # high
            screen.click((frame[0] + frame[2] // 2, frame[1] - max(bar // 2, 1)), times=2)
            p.until("window.isMaximized()")
            p.settle()
            large = p.rect("window")
            for there, back in (("F5", "Escape"), ("F11", "F11"), ("F5", "F5")):
                screen.key(there)
                p.until("window.isFullScreen()")
                p.settle()
                screen.key(back)
                p.until("not window.isFullScreen()")
                p.settle()
                assert maximised(p), f"{there}, {back}"
                assert p.rect("window") == large, f"{there}, {back}"


@needs_real_screen
def test_a_size_given_by_hand_is_kept_and_others_follow_the_window(tmp_path, walk, look):
    height = "window.docks['curves'].height()"
    with real_screen(tmp_path, size=(1600, 1000), look=look) as screen:
        with watched(screen, tmp_path, walk) as p:
            usual = p.ask(height)
            to_size(p, 1300, 600)
            assert p.ask(height) < 0.4 * p.ask("window.height()"), "curves take too much of it"
            screen.key("ctrl+q")
            p.process.wait(60)
        with watched(screen, tmp_path, walk) as p:  # low, as it was left: nobody sized a panel
            to_size(p, 1400, 900)
            assert p.ask(height) == usual
            left, top, wide, _ = p.rect("window.docks['curves']")
            p.drag((left + wide // 2, top - 2), (left + wide // 2, top - 102))
            p.until(f"{height} > {usual} + 60")
            given = p.ask(height)
            to_size(p, 1400, 600)
            to_size(p, 1400, 900)
            assert p.ask(height) > usual + 15, f"{given} was given"


def to_size(p, wide, high):
    """As a window manager does it."""
    p.screen.use("windowsize", p.screen.active(), wide, high)
    p.until(f"abs(window.height() - {high}) < 3")
    p.settle()


def chains_seen(p):
    """What is to be seen where the panel of chains is, after a click on the window below it."""
    low = p.rect("window.statusBar()")
    p.screen.click((low[0] + 300, low[1] + 8))
    p.screen.park()
    p.settle()
    table = "window.chains.table"

    def framed():
        """Its border is where Qt says: a panel that was let go is placed by the window manager."""
        seen = p.screen.picture(p.rect(table))
        edges = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
        return not differing(edges, seen[0, 0]) and differing(seen, seen[0, 0])

    try:
        with contextlib.suppress(AssertionError):
            wait_until(framed, seconds=10.0)
        if not framed():  # Qt was busy when it was placed, and has not heard where: it is moved
            p.screen.use("search", "--name", "^Chains$", "windowmove", "--relative", 1, 1)
        wait_until(framed)
    except AssertionError:
        where = {name: p.rect(name) for name in ("window", "window.docks['chains']", table)}
        raise AssertionError(
            f"the panel is not to be seen where it is said to be: {where}"
        ) from None
    return p.screen.picture(p.rect(table))


@needs_real_screen
def test_one_begins_in_the_middle_and_finds_help_by_f1(tmp_path, walk, look):
    recent = {"recent": [str(walk)]}
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, settings=recent) as p,
    ):
        off = [
            "accept", "reject", "export_dialog", "undo", "next_interval", "toggle_play",
            "focus_chain", "loop_interval", "suggest_tau", "track_joints", "hold_video",
        ]  # fmt: skip
        assert p.ask(f"[n for n in {off} if window.actions_by_id[n].isEnabled()]") == []
        assert p.ask("window.actions_by_id['open_dialog'].isEnabled()")

        screen.key("F1")
        guide = screen.shown("^Guide")
        asked = "window.program._guide.browser"
        p.until(f"'guide.md' in {asked}.source().toString()")
        p.settle()
        part = p.rect(asked)
        words = screen.picture(part)
        assert len({tuple(c) for c in words[::7, ::7].reshape(-1, 3).tolist()}) > 30, "no picture"
        assert not p.ask(f"{asked}.horizontalScrollBar().maximum()")
        screen.key("ctrl+f")
        screen.type("rig profile")
        p.until(f"{asked}.textCursor().selectedText().lower() == 'rig profile'")
        assert p.ask(f"{asked}.verticalScrollBar().value()") > 0
        screen.key("Escape", "Escape")
        wait_until(lambda: guide not in screen.windows("^Guide"))

        screen.key("question")
        screen.shown("^Keyboard")
        screen.type("playhead")
        pages = "[w for w in QApplication.topLevelWidgets() if type(w).__name__ == 'KeyboardPage']"
        p.until(f"'Start at playhead' in {pages}[0].page.toPlainText()")
        assert not p.ask(f"'Undo' in {pages}[0].page.toPlainText()")
        screen.key("Escape")
        screen.shown("Twist Inspector$")

        screen.click(
            p.rect(
                "[b for b in window.start_page.findChildren(type(window.start_page"
                ".buttons['open_sample'])) if b.objectName() == 'recent'][0]"
            )
        )
        p.until("window.document.data is not None")
        assert p.ask("window.document.data.clip.name") == "walk.bvh"
        p.settle()
        assert not p.ask("window.start_page.isVisible()")
        screen.park()
        p.settle()
        off_look = screen.steady_picture(p.ask("entry('loop_interval')"))
        screen.click(p.ask("entry('loop_interval')"))
        screen.park()
        p.until("window.actions_by_id['loop_interval'].isChecked()")
        on_look = screen.steady_picture(p.ask("entry('loop_interval')"))
        assert differing(on_look, off_look) > on_look[..., 0].size // 2
        screen.use("mousemove", *middle(p.rect("window.viewport")))


@pytest.mark.parametrize("what", ["both", "file", "missing", "folder", "no picture"])
def test_words_that_cannot_work_together_end_in_one_sentence(tmp_path, what):
    taken = tmp_path / "taken.txt"
    taken.write_text("mine")
    picture, sample = tmp_path / "a.png", ASSETS / "walk.bvh"
    words = {
        "both": ["--demo", tmp_path / "out", "--screenshot", picture],
        "file": [sample, "--demo", taken],
        "missing": [tmp_path / "missing.bvh", "--screenshot", picture],
        "folder": ["--screenshot", tmp_path],
        "no picture": ["--screenshot", tmp_path / "a.txt"],
    }[what]
    with program({"PATH": "/usr/bin"}, tmp_path, *words) as process:
        said, _ = process.communicate(timeout=60)
    assert process.returncode == 2
    assert len(said.splitlines()) == 1
    assert said.startswith("twist-inspector: ")
    assert said.rstrip().endswith(".")
    assert "DISPLAY" not in said
    assert not picture.exists()
    assert taken.read_text() == "mine"
