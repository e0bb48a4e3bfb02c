"""Nothing is cut, nothing overlaps, and everything can be read: sizes, scales, themes."""

import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtGui import QGuiApplication, QTextTable
from PySide6.QtWidgets import QWidget

import twistcore as tc
from inspector.app import make_application
from inspector.panels.position_line import FrameLine
from inspector.session.settings import Settings
from inspector.teaching.symbols import SYMBOLS, symbol_family_colour
from inspector.widgets import theme as themes
from inspector.widgets.keyed_list import KeyedList
from inspector.widgets.late_panel import LatePanel
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.signed_numbers import format_signed_number
from inspector.widgets.theme import DARK, LIGHT
from inspector.window.keyboard_page import KeyboardPage
from tests.conftest import ASSETS
from tests.gui import forked
from tests.gui.looks import EVERY
from tests.gui.windows import act, open_clip, resize
from tests.tiers import parametrize
from tests.twistcore.test_capture_faults import faulty_clip
from tests.twistcore.test_joint_repairs import SKELETON, WALK, spiked, turned
from tests.twistcore.test_strangers import flipping_helper
from twistcore.detection import Kind
from twistcore.formats.bvh.compose import bvh_text

ONE_WINDOW = True
CHECK = Path(__file__).with_name("layout_check.py")
_FAULTS = Kind.NOISE_BURST, Kind.FROZEN
_OF_JOINTS = Kind.STRETCH, Kind.SPIKE
_OF_LIMBS = Kind.COUNTER_TWIST, Kind.LIMB_FLIP, Kind.LONE_JUMP


# What fits a narrow window in German, whose words are longer, and English at a large scale fits the
# others: those are looked at with all looks.
_OTHERS = [
    (1024, 700, 1, "dark", "en"),
    (1280, 800, 1, "light", "de"),
    (1920, 1080, 1, "dark", "en"),
]


# A theme changes no size, so each is looked at in one of them.
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("width", "height", "scale", "theme", "language"),
    [
        (1024, 700, 1, "dark", "de"),
        (1280, 800, 2, "light", "en"),
        *(_OTHERS if EVERY else []),
    ],
)
def test_every_text_fits_and_no_two_widgets_overlap(
    tmp_path, width, height, scale, theme, language
):
    clip = tmp_path / "walk.bvh"
    shutil.copy(ASSETS / "walk_injected.bvh", clip)
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "QT_SCALE_FACTOR": str(scale),
    }
    words = [CHECK, str(width), str(height), theme, clip, tmp_path / "w.png", language]
    assert forked.run(words, environment) == (0, "")


LAPTOP = (948, 500)  # of a window on 1920×1080 at 200 %


def whole(widget, area):
    """Whether all of a widget is in what is seen of the area that scrolls it."""
    place = QRect(widget.mapTo(area.viewport(), QPoint(0, 0)), widget.size())
    return area.viewport().rect().contains(place)


def rows_seen(table):
    return table.viewport().height() // table.rowHeight(0)


@pytest.mark.thorough
def test_a_dock_alone_in_a_low_window_has_its_title(qtbot, show_window):
    window = show_window(Settings())
    window.resize(1024, 600)
    intervals, others = window.docks["intervals"], ("history", "tuning", "teaching", "quality")
    qtbot.waitUntil(lambda: intervals.titleBarWidget() is not None)
    for name in others:
        window.docks[name].hide()
    qtbot.waitUntil(lambda: intervals.titleBarWidget() is None)
    window.docks["tuning"].show()
    qtbot.waitUntil(lambda: intervals.titleBarWidget() is not None)
    window.docks["tuning"].setFloating(True)
    qtbot.waitUntil(lambda: intervals.titleBarWidget() is None)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [*_FAULTS, *_OF_JOINTS, *_OF_LIMBS, Kind.HELPER_ROLL], ids=str)
def test_a_low_window_lists_four_intervals_above_a_whole_card(
    qtbot, window_for_clips, tmp_path, kind
):
    window = window_for_clips(Settings())
    resize(qtbot, window, LAPTOP)
    if kind == Kind.HELPER_ROLL:
        clip = tmp_path / "flipping.bvh"
        clip.write_bytes(bvh_text(flipping_helper()).encode())
    elif kind in _OF_JOINTS:
        clip = tmp_path / "joints.bvh"
        both = turned("LeftFoot", 200, 260).rotations.copy()
        arm = SKELETON.index("LeftForeArm")
        both[:, arm] = spiked("LeftForeArm", 150, 152).rotations[:, arm]
        tc.write_clip(WALK, WALK.motion.with_rotations(both), clip)
    elif kind in _FAULTS:
        clip = tmp_path / "faulty.bvh"
        clip.write_bytes(faulty_clip().data)
    else:
        name = "walk_injected.bvh" if kind == Kind.COUNTER_TWIST else "kick.bvh"
        clip = shutil.copy(ASSETS / name, tmp_path)
    open_clip(qtbot, window, clip)
    judged = next(j for j in window.document.intervals if j.interval.kind == kind)
    window.document.select_interval(judged.id, jump=True)
    area, table, card = window.docks["intervals"].widget(), window.intervals.table, window.detail
    qtbot.waitUntil(lambda: rows_seen(table) >= 4)
    link = [card.to_quality] if kind in _FAULTS else []
    for part in (card.title, card.why, *link, card.start, card.reason, *card.buttons.values()):
        assert whole(part, area), part
    assert not any(
        bar.isVisible()
        for bar in (area.verticalScrollBar(), area.horizontalScrollBar(),
                    table.horizontalScrollBar())
    )  # fmt: skip
    assert table.visualRect(table.currentIndex()).bottom() < table.viewport().height()
    # What a line has no room for is in its tip.
    assert card.why.height() < 1.5 * card.fontMetrics().height()
    assert "…" in card.why.label.text() or kind == Kind.HELPER_ROLL  # whose reason is short
    assert card.why.text() in card.why.label.toolTip()
    resize(qtbot, window, (1440, 900))
    qtbot.waitUntil(lambda: "…" not in card.why.label.text())
    assert card.why.label.text() == card.why.text()
    assert not card.why.label.toolTip()


@parametrize(("size", "share"), [((1440, 900), 0.35), ((1024, 700), 0.28)], ids=str)
def test_the_figure_has_a_large_share_of_the_window(qtbot, window_for_clips, tmp_path, size, share):
    window = window_for_clips(Settings())
    resize(qtbot, window, size)
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    act(window, "next_interval")
    figure, area = window.viewport.view, window.docks["intervals"].widget()
    wanted = share * window.width() * window.height()
    qtbot.waitUntil(lambda: figure.width() * figure.height() >= wanted)
    # What is needed for a decision is seen as well.
    qtbot.waitUntil(lambda: rows_seen(window.intervals.table) >= 4)
    card, transport = window.detail, window.transport
    for part in (card.title, card.why, card.start, card.note, *card.buttons.values()):
        assert whole(part, area), part
    assert not area.verticalScrollBar().isVisible()
    assert {"theta", "strength"} <= set(window.timeline.grid.shown)
    for part in (transport, transport.slider, window.tools, window.chains.table):
        assert part.isVisible()
        assert not part.visibleRegion().isEmpty()
    assert (window.width(), window.height()) == size, "the window has grown"


@pytest.mark.skipif(sys.platform != "linux", reason="only X11 has a surface of its own")
def test_the_surface_of_the_figure_moves_along(qtbot, show_window):
    window = show_window(Settings())
    surface = window.viewport.windowHandle()
    if surface is None:
        pytest.skip("not on X11")
    centre = window.centralWidget()
    centre.move(centre.x() + 37, centre.y())
    place = window.viewport.mapTo(window, QPoint(0, 0))
    assert surface.position() == place
    assert place.x() >= 37


def titles(window):
    return {name for name, dock in window.docks.items() if dock.titleBarWidget() is None}


@pytest.mark.thorough
def test_titles_are_away_where_tabs_say_the_same_and_in_a_presentation(qtbot, show_window):
    window = show_window(Settings())
    everywhere, tabs = set(window.docks), {"intervals", "history", "tuning", "teaching", "quality"}
    assert titles(window) == everywhere
    resize(qtbot, window, LAPTOP)
    qtbot.waitUntil(lambda: titles(window) == everywhere - tabs)
    act(window, "presentation")
    assert "curves" not in titles(window)
    act(window, "presentation")
    qtbot.waitUntil(lambda: (window.width(), window.height()) == LAPTOP)
    qtbot.waitUntil(lambda: titles(window) == everywhere - tabs)
    window.docks["tuning"].setFloating(True)
    qtbot.waitUntil(lambda: "tuning" in titles(window))  # it is moved and closed by it
    window.docks["tuning"].setFloating(False)
    resize(qtbot, window, (1440, 900))
    qtbot.waitUntil(lambda: titles(window) == everywhere)


@pytest.mark.thorough
def test_the_program_has_a_sign_of_its_own(qtbot, show_window):
    window = show_window(Settings())
    make_application()
    sign = window.windowIcon().pixmap(16, 16).toImage()
    inks = [sign.pixelColor(x, y) for x in range(16) for y in range(16)]
    assert sum(c.alpha() > 200 for c in inks) > 128
    assert any(c.red() > 200 and c.blue() < 120 and c.alpha() > 200 for c in inks), "no arrow"
    assert any(min(c.red(), c.green(), c.blue()) > 200 for c in inks), "no bone"
    assert QGuiApplication.desktopFileName() == "twist-inspector"


@pytest.mark.thorough
def test_frame_and_interval_are_said_on_every_tab(qtbot, show_window, tmp_path):
    window = show_window(Settings(first_frame=1))
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    act(window, "next_interval")
    window.statusBar().clearMessage()
    line, judged = window.statusBar().findChild(FrameLine), window.document.interval
    start, stop = judged.interval.start + 1, judged.interval.stop + 1
    for tab in ("show_tuning", "show_teaching", "show_quality"):
        act(window, tab)
        assert line.isVisible()
        assert f"frame {window.document.frame + 1} of 344 " in line.text()
        assert line.text().endswith(f"interval {start} to {stop}, undecided")
    act(window, "accept")
    window.document.select_interval(judged.id)
    assert line.text().endswith("accepted")
    window.document.go_to(7)
    assert "frame 8 of 344   0.058 s" in line.text()


@pytest.mark.thorough
def test_a_lone_jump_says_how_far_it_goes(qtbot, window_for_clips, tmp_path):
    window = window_for_clips(Settings())
    open_clip(qtbot, window, shutil.copy(ASSETS / "kick.bvh", tmp_path))
    jump = next(j for j in window.document.intervals if j.interval.kind == Kind.LONE_JUMP)
    window.document.select_interval(jump.id, jump=True)
    legend = window.viewport.overlays.legend
    size = format_signed_number(float(np.degrees(jump.interval.residual)))
    qtbot.waitUntil(lambda: f"jumps by {size}°" in legend.text().replace("&nbsp;", " "))
    window.document.go_to(jump.interval.stop)
    qtbot.waitUntil(lambda: "jumps" not in legend.text())


@pytest.mark.thorough
@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_the_page_of_keys_has_one_title_and_soft_lines(show_window, theme):
    window = show_window(Settings(theme="dark" if theme.dark else "light"))
    act(window, "show_shortcuts")
    page = window.findChild(KeyboardPage).page
    assert "Keyboard and mouse\nFile" not in page.toPlainText()
    assert page.toPlainText().startswith("File")
    tables = [f for f in page.document().rootFrame().childFrames() if isinstance(f, QTextTable)]
    assert tables
    for table in tables:
        assert table.format().border() == 0
        under = table.cellAt(1, 0).format().toTableCellFormat().bottomBorderBrush().color().name()
        assert under == theme.line


@pytest.mark.parametrize(
    ("keys_first", "rows"),
    [
        (True, [("natural", "1"), ("natural", "W")]),
        (False, [("Go", "Ctrl+K"), ("Leave", "Ctrl+K")]),
    ],
)
def test_keys_of_a_list_stand_in_a_column(qtbot, keys_first, rows):
    shown = KeyedList(keys_first=keys_first)
    qtbot.addWidget(shown)
    for words, key in rows:
        shown.add(words, key)
    shown.resize(300, 120)
    shown.show()
    qtbot.waitExposed(shown)
    boxes = [shown.visualItemRect(shown.item(k)) for k in range(2)]
    key_wide = 24 if keys_first else shown.fontMetrics().horizontalAdvance("Ctrl+K") + 10
    for box in boxes:
        if keys_first:
            box.setLeft(box.left() + key_wide)
        else:
            box.setLeft(box.right() - key_wide)
    first, second = (shown.viewport().grab(box).toImage() for box in boxes)
    assert first == second
    assert len({first.pixel(x, y) for x in range(first.width()) for y in range(first.height())}) > 4


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
    return {symbol_family_colour(symbol.family, theme) for symbol in SYMBOLS.values()}


@pytest.mark.thorough
@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_a_new_window_has_the_colours_of_the_system(
    qtbot, show_window, tmp_path, monkeypatch, theme
):
    monkeypatch.setattr(themes, "system_theme", lambda: theme)
    window = show_window(Settings())
    assert window.viewport.theme is theme
    for area in window.findChildren(LatePanel):
        area.build()
    as_made = style_sheets(window)
    window.program.apply_theme(theme)
    assert style_sheets(window) == as_made, "a view was made without its colours"
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    window.document.select_chain("LeftForeArm")
    act(window, "show_teaching")
    equations = window.teaching.equations
    window.taught.highlight("err")  # filled: its strokes are thinner than a pixel
    qtbot.waitUntil(lambda: colours(equations) >= symbol_colours(theme) | {theme.surface})
    act(window, "tour")
    qtbot.waitUntil(lambda: window.lesson_actions.player.at == 0)
    assert "playhead" in window.guide.task.text()
    assert theme.accent in window.guide.task.styleSheet()


@pytest.mark.thorough
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


def test_a_button_with_a_long_name_is_shortened_in_a_narrow_view(qtbot):
    view = QWidget()
    qtbot.addWidget(view)
    view.resize(393, 300)
    bar = MessageBar(view)
    name, pressed = "Open kick_with_a_long_name.bvh", []
    bar.offer("kick_with_a_long_name.bvh is worse.", [(name, lambda: pressed.append(name))])
    bar.setGeometry(6, 6, 381, 60)
    view.show()
    qtbot.waitExposed(view)
    (button,) = bar.buttons()
    assert button.width() >= button.minimumSizeHint().width()
    assert button.text().startswith("Open")
    assert "…" in button.text()
    assert button.accessibleName() == name
    assert name in button.toolTip()
    assert button.shortcut().toString() == "Alt+1"
    button.click()
    assert pressed == [name]


def small_window(qtbot, window_for_clips, folder):
    """A window of 1024×700 with the sample."""
    window = window_for_clips(Settings(turn_ms=0))
    resize(qtbot, window, (1024, 700))
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk_injected.bvh", folder))
    return window


@pytest.mark.thorough
def test_the_pages_of_tuning_and_what_they_say_fit(qtbot, window_for_clips, tmp_path):
    window = small_window(qtbot, window_for_clips, tmp_path)
    act(window, "next_interval")
    act(window, "accept")
    act(window, "show_tuning")
    tabs, page = window.tuning.tabs, window.tuning.verdicts
    qtbot.waitUntil(lambda: tabs.tabBar().sizeHint().width() <= tabs.width())
    tabs.setCurrentWidget(page)
    qtbot.waitUntil(lambda: "are needed" in page.words.text())
    qtbot.waitUntil(lambda: "…" not in page.words.label.text())
    assert page.words.height() >= page.words.label.heightForWidth(page.words.width())


@pytest.mark.thorough
def test_teaching_says_in_full_that_a_limb_has_no_equations(qtbot, window_for_clips, tmp_path):
    window = small_window(qtbot, window_for_clips, tmp_path)
    act(window, "show_teaching")
    window.document.select_chain("RightUpLeg-RightFoot")
    title = window.teaching.title
    qtbot.waitUntil(lambda: "is a limb" in title.text())
    line = title.fontMetrics().height()
    qtbot.waitUntil(lambda: title.height() >= title.heightForWidth(title.width()) > 1.5 * line)
    window.document.select_chain("RightUpLeg")
    qtbot.waitUntil(lambda: title.text().startswith("Right UpLeg"))
    assert not title.wordWrap()
