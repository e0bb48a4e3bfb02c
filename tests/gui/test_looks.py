"""Nothing is cut, nothing overlaps, and everything can be read: sizes, scales, themes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtWidgets import QWidget

from inspector.session.settings import Settings
from inspector.teaching.symbols import SYMBOLS, colour
from inspector.widgets import theme as themes
from inspector.widgets.theme import DARK, LIGHT
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip

CHECK = Path(__file__).with_name("layout_check.py")


# A theme changes no size, so each is looked at in one of them.
@pytest.mark.parametrize(
    ("width", "height", "scale", "theme"),
    [
        (1024, 700, 1, "dark"),
        (1280, 800, 1, "light"),
        (1920, 1080, 1, "dark"),
        (1280, 800, 2, "light"),
    ],
)
def test_every_text_fits_and_no_two_widgets_overlap(tmp_path, width, height, scale, theme):
    clip = tmp_path / "walk.bvh"
    shutil.copy(ASSETS / "walk_injected.bvh", clip)
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "QT_SCALE_FACTOR": str(scale),
    }
    words = [sys.executable, str(CHECK), str(width), str(height), theme, str(clip)]
    done = subprocess.run(
        [*words, str(tmp_path / "w.png")],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""


def luminance(colour):
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a, b):
    """WCAG 2 contrast ratio."""
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_text_has_a_contrast_of_four_and_a_half(theme):
    grounds = [theme.surface, theme.window, theme.raised]
    inks = [
        *(
            "text",
            "soft",
            "accent",
            "before",
            "after",
            "tracked",
            "tau",
            "accepted",
            "rejected",
            "undecided",
            "warning",
        ),
    ]
    low = {
        (ink, ground): round(contrast(getattr(theme, ink), ground), 2)
        for ink in inks
        for ground in grounds
        if contrast(getattr(theme, ink), ground) < 4.5
    }
    assert low == {}
    assert contrast(theme.on_accent, theme.accent) >= 4.5
    assert min(contrast(theme.edge, ground) for ground in grounds) >= 2.9, "boxes are not seen"
    families = symbol_colours(theme)
    assert len(families) == 5
    assert min(contrast(ink, ground) for ink in families for ground in grounds) >= 4.5


def style_sheets(window):
    return [widget.styleSheet() for widget in window.findChildren(QWidget)]


def colours(widget):
    picture = widget.grab().toImage()
    width, height = picture.width(), picture.height()
    return {picture.pixelColor(x, y).name() for x in range(width) for y in range(height)}


def symbol_colours(theme):
    return {colour(symbol.family, theme) for symbol in SYMBOLS.values()}


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_a_new_window_has_the_colours_of_the_system(
    qtbot, show_window, tmp_path, monkeypatch, theme
):
    monkeypatch.setattr(themes, "system_theme", lambda: theme)
    window = show_window(Settings())
    assert window.viewport.theme is theme
    as_made = style_sheets(window)
    window.apply_theme(theme)
    assert style_sheets(window) == as_made, "a view was made without its colours"
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    window.document.select_chain("LeftForeArm")
    act(window, "show_teaching")
    equations = window.teaching.equations
    qtbot.waitUntil(lambda: colours(equations) >= symbol_colours(theme) | {theme.surface})
    act(window, "tour")
    qtbot.waitUntil(lambda: window.teaching_actions.guided_tour.at == 0)
    assert "Space" in window.guide.task.text()
    assert theme.accent in window.guide.task.styleSheet()


@pytest.mark.parametrize("name", ["system", "light", "dark"])
def test_a_window_takes_the_theme_that_was_chosen(show_window, monkeypatch, name):
    monkeypatch.setattr(themes, "system_theme", lambda: DARK)
    window = show_window(Settings(theme=name))
    assert window.viewport.theme is (LIGHT if name == "light" else DARK)
    assert window.actions_by_id[f"theme_{name}"].isChecked()
    act(window, "theme_light")
    assert window.viewport.theme is LIGHT
    assert window.settings.theme == "light"


def test_a_theme_that_is_there_is_not_given_again(qapp, monkeypatch):
    themes.apply_theme(qapp, DARK)
    given = []
    monkeypatch.setattr(qapp, "setStyleSheet", given.append)
    themes.apply_theme(qapp, DARK)
    assert given == []
    themes.apply_theme(qapp, LIGHT)
    assert len(given) == 1
