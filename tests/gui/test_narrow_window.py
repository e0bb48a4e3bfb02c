"""A window of 1024×700: names, titles and tabs are whole, and panels get their sizes back."""

import shutil
from dataclasses import replace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QTabBar

from inspector.panels.interval_columns import COLUMNS, PLACE, columns_that_fit
from inspector.panels.interval_rows import GroupRow
from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.settings import Settings
from inspector.teaching.section_head import SectionHead
from inspector.widgets.labels import Headline, bold, plain_to_rich_text
from inspector.widgets.text_forms import form_that_fits
from inspector.widgets.theme import LIGHT, Colours
from tests.conftest import ASSETS
from tests.gui.cut_texts import cut_cells, cut_tabs
from tests.gui.windows import act, open_clip, resize
from twistcore.detection import Kind

SIZE = (1024, 700)
TABS = ("history", "tuning", "teaching", "quality", "intervals")


@pytest.fixture
def narrow(qtbot, show_window):
    """A window of 1024×700, nothing open."""
    window = show_window(Settings(turn_ms=0))
    resize(qtbot, window, SIZE)
    return window


@pytest.fixture
def kick(qtbot, narrow, tmp_path):
    """It with a clip that has groups of errors."""
    open_clip(qtbot, narrow, shutil.copy(ASSETS / "kick.bvh", tmp_path))
    return narrow


def group_rows(window):
    panel = window.intervals
    rows = range(panel.table.model().rowCount())
    return [row for row in rows if isinstance(panel._thing(row), GroupRow)]


def height(window, name="chains"):
    return window.docks[name].height()


# -- the list of intervals --------------------------------------------------------------------


def test_groups_have_their_names_in_a_second_line(qtbot, kick):
    table = kick.intervals.table
    usual = table.verticalHeader().defaultSectionSize()
    groups = group_rows(kick)
    assert len(groups) == 2
    for row in groups:
        assert table.columnSpan(row, 0) == len(COLUMNS)
        assert table.rowHeight(row) >= usual + table.fontMetrics().height()
    assert table.rowHeight(0) == usual
    assert list(cut_cells(table)) == []
    act(kick, "group_errors")
    assert not group_rows(kick)
    assert {table.rowHeight(row) for row in range(table.model().rowCount())} == {usual}


def test_both_lines_of_a_group_are_painted(qtbot, kick):
    table = kick.intervals.table
    row = group_rows(kick)[0]
    table.clearSelection()
    place = table.visualRect(table.model().index(row, 0))
    picture = table.viewport().grab(place.intersected(table.viewport().rect())).toImage()
    usual = table.verticalHeader().defaultSectionSize()

    def inks(lines):
        scale = picture.devicePixelRatio()
        rows = range(round(scale * lines.start), round(scale * lines.stop))
        return {picture.pixel(x, y) for y in rows for x in range(picture.width())}

    below = range(usual, usual + table.fontMetrics().height() - 4)
    assert len(inks(range(4, usual - 6))) > 4
    assert len(inks(below)) > 4


@pytest.fixture
def panel(qtbot, open_document):
    """A list of intervals with groups, without a window."""
    panel = IntervalsPanel(open_document(ASSETS / "kick.bvh"), Colours(LIGHT), Settings())
    qtbot.addWidget(panel)
    panel.resize(400, 300)
    panel.show()
    qtbot.waitExposed(panel)
    return panel


@pytest.mark.parametrize("width", [900, 500, 340, 240])
def test_the_name_of_a_group_is_as_long_as_there_is_room(panel, width):
    panel.resize(width, 400)
    table = panel.table
    things = map(panel._thing, range(table.model().rowCount()))
    row, group = next((k, t) for k, t in enumerate(things) if isinstance(t, GroupRow))
    forms = panel._model.row_for(group).below
    assert [form.endswith(f"({len(group.members)})") for form in forms] == [True, True]
    table.clearSpans()
    table.set_line_below(row, forms)
    room, letters = table.viewport().width() - table.indent_below, table.fontMetrics()
    shown = form_that_fits(forms, letters.horizontalAdvance, room)
    assert shown == forms[0 if letters.horizontalAdvance(forms[0]) <= room else 1]
    assert (shown == forms[0]) == (width >= 500)
    assert forms[1].startswith("5 times: right knee flips")
    usual = table.verticalHeader().defaultSectionSize()
    assert table.rowHeight(row) == usual + letters.height()
    table.set_line_below(row, [20 * forms[0]])
    assert table.rowHeight(row) > usual + 2 * letters.height()
    table.set_line_below(row, ())
    assert table.rowHeight(row) == usual


def test_a_low_window_lists_groups_in_one_line(qtbot, kick):
    table = kick.intervals.table
    resize(qtbot, kick, (948, 500))
    usual = table.verticalHeader().defaultSectionSize()
    for row in group_rows(kick):
        assert table.rowHeight(row) == usual
        assert table.columnSpan(row, 0) == 1
        assert table.columnSpan(row, PLACE["stop"]) > 1
    resize(qtbot, kick, SIZE)
    assert all(table.rowHeight(row) > usual for row in group_rows(kick))


def test_a_click_on_the_arrow_unfolds_a_group_of_two_lines(qtbot, kick):
    table = kick.intervals.table
    place = table.visualRect(table.model().index(group_rows(kick)[0], 0)).topLeft() + QPoint(6, 6)
    before = table.model().rowCount()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert table.model().rowCount() == before + 13
    assert list(cut_cells(table)) == []


def test_the_stop_gives_way_to_whole_names():
    widths = {column.id: 60 for column in COLUMNS} | {"chain": 150}
    filled = {"chain", "decision", "start", "stop", "delta"}
    assert "stop" in columns_that_fit(widths, filled, 4 * 60 + 150)
    assert "stop" not in columns_that_fit(widths, filled, 4 * 60 + 149)


def test_columns_and_numbers_give_way_to_whole_names(panel):
    table, columns, seen = panel.table, panel.columns, set()
    needed = columns._width(COLUMNS[0])
    for width in range(230, 700, 5):
        panel.resize(width, 300)
        shown, numbers = columns.shown(), table.verticalHeader().isVisible()
        whole = table.columnWidth(0) >= needed
        assert whole or not ({"stop", "confidence", "note"} & set(shown) or numbers)
        assert whole or "start" in shown  # without a gain, it stays
        seen.add((whole, "stop" in shown, "start" in shown, numbers))
    assert {(True, True, True, True), (True, False, True, True), (True, False, False, False)} < seen
    assert any(not whole for whole, *_ in seen)


def test_the_count_is_shown_only_next_to_a_whole_filter(qtbot, kick):
    panel = kick.intervals
    for width in (1024, 1280, 1440, 1920):
        resize(qtbot, kick, (width, 800))
        filters = panel.filters
        assert filters.width() >= min(filters.sizeHint().width(), filters.parent().width() - 8)


# -- titles -----------------------------------------------------------------------------------


def test_a_headline_takes_the_longest_form_that_fits(qtbot):
    title = Headline()
    qtbot.addWidget(title)
    forms = [f"{bold('Right leg')} · limb flip{rest}" for rest in (" · 6 frames, varying δ", "")]
    title.set_forms(*forms)
    title.show()
    title.resize(title.sizeHint().width() + 4, 20)
    assert title.shown == forms[0]
    title.resize(title.least_width, 20)
    assert title.shown == forms[1]
    assert title.text() == forms[0]
    short = title.grab().toImage()
    title.set_forms(forms[0])
    assert title.grab().toImage() != short  # it ends with '…'
    assert title.least_width > title.width()


def test_the_ends_of_a_limb_go_below_a_title_that_needs_the_room(qtbot, kick):
    card, document = kick.detail, kick.document
    flip = next(j for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP)
    document.select_interval(flip.id, jump=True)
    qtbot.waitUntil(lambda: card.end.isVisible())
    qtbot.waitUntil(lambda: card.end.y() <= card.title.y() < card.end.geometry().bottom())
    assert card.title.width() >= card.title.least_width
    assert "limb flip" in card.title.shown
    card.end.name.setText("The joint after the next one, in a rig with long names:")
    card._arrange_head()
    qtbot.waitUntil(lambda: card.end.y() > card.title.geometry().bottom())
    assert card.title.width() >= card.title.least_width
    card.set_low(True)
    card._arrange_head()
    qtbot.waitUntil(lambda: card.end.y() <= card.title.geometry().bottom())


def test_a_section_of_equations_leaves_out_the_joints_if_they_do_not_fit(qtbot):
    pictures = []
    for text, short in (("Child C = RightFoot: azimuth", "Child C: azimuth"), ("", "")):
        head = SectionHead("")
        qtbot.addWidget(head)
        head.set_text(text or "Child C: azimuth", short)
        head.resize(head.fontMetrics().horizontalAdvance("Child C: azimuth") + 30, 20)
        pictures.append(head.grab().toImage())
        assert head.accessibleName() == (text or "Child C: azimuth")
    assert pictures[0] == pictures[1]


def test_the_title_of_the_teaching_tab_is_whole(qtbot, narrow, tmp_path):
    open_clip(qtbot, narrow, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    narrow.document.select_chain("RightUpLeg")
    act(narrow, "show_teaching")
    panel = narrow.teaching
    qtbot.waitUntil(lambda: panel.title.width() >= panel.title.least_width)
    assert all(button.isVisible() for button in panel._buttons)
    whole = panel.title.text()
    panel.title.set_forms(
        plain_to_rich_text("a chain with a name that is longer " + 8 * "and longer ")
    )
    panel._make_room_for_title()
    assert not any(button.isVisible() for button in panel._buttons)
    panel.title.set_forms(whole)
    panel._make_room_for_title()
    assert all(button.isVisible() for button in panel._buttons)


# -- chains and docks -------------------------------------------------------------------------


def test_a_long_chain_name_hides_columns_of_the_chains(qtbot, narrow, tmp_path):
    open_clip(qtbot, narrow, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    panel = narrow.chains
    assert not any(panel.table.isColumnHidden(k) for k in range(5))

    def hidden():
        numbers = []
        for width in range(200, 500, 10):
            panel.table.resize(width, 100)
            numbers.append(sum(panel.table.isColumnHidden(k) for k in range(5)))
        return numbers

    short, name = hidden(), next(iter(panel._fixed))
    panel._fixed[name] = replace(panel._fixed[name], label="Unterschenkel rechts (gesperrt)")
    panel._keep_room_for_names()
    long = hidden()
    assert all(a <= b for a, b in zip(short, long, strict=True))
    assert sum(short) < sum(long)
    assert long[-1] == 0


def test_the_tabs_of_the_docks_are_whole(qtbot, kick):
    bars = [bar for bar in kick.findChildren(QTabBar) if bar.parent() is kick and bar.isVisible()]
    assert bars
    for bar in bars:
        assert list(cut_tabs(bar)) == []


def test_the_chains_get_back_the_height_that_they_give_to_the_equations(qtbot, kick):
    usual = height(kick)
    assert usual > 150
    bar = next(
        bar for bar in kick.findChildren(QTabBar) if bar.parent() is kick and bar.count() > 3
    )
    for name in ("teaching", *TABS, "teaching", "intervals"):
        texts = [bar.tabText(k) for k in range(bar.count())]
        tab = bar.tabRect(texts.index(kick.docks[name].windowTitle())).center()
        QTest.mouseClick(bar, Qt.MouseButton.LeftButton, pos=tab)
        qtbot.waitUntil(lambda name=name: not kick.docks[name].visibleRegion().isEmpty())
        qtbot.wait(50)
        if name == "teaching":
            qtbot.waitUntil(lambda: 60 < height(kick) < 0.6 * usual)
        else:
            qtbot.waitUntil(lambda: height(kick) == usual)


def test_a_layout_that_is_restored_behind_a_tab_still_follows_the_window(qtbot, kick, show_window):
    act(kick, "show_teaching")
    qtbot.wait(100)
    geometry, layout = kick.usual_layout.kept("")
    again = show_window(Settings(turn_ms=0, geometry=geometry, layout=layout))
    for size in (SIZE, (1500, 1000)):
        for window in (kick, again):
            resize(qtbot, window, size)
            window.docks["intervals"].raise_()
        least = 0.25 * size[1]
        qtbot.waitUntil(lambda least=least: height(again) == height(kick) > least)


def test_the_column_has_its_width_again_after_a_lesson(qtbot, narrow, tmp_path):
    open_clip(qtbot, narrow, shutil.copy(ASSETS / "walk_injected.bvh", tmp_path))
    wide, high = (narrow.docks["chains"].width(), height(narrow))
    act(narrow, "tour")
    qtbot.waitUntil(lambda: narrow.lesson_actions.player.at == 0)
    qtbot.waitUntil(lambda: narrow.docks["chains"].width() < wide)
    qtbot.waitUntil(lambda: height(narrow) == high)
    narrow.lesson_actions.leave_guide()
    qtbot.waitUntil(lambda: narrow.docks["chains"].width() == wide)
    assert height(narrow) == high


def test_tool_tips_have_the_whole_names(kick):
    table, panel = kick.intervals.table, kick.intervals
    for row in group_rows(kick):
        tip = table.model().index(row, 0).data(Qt.ItemDataRole.ToolTipRole)
        described = panel._model.row_for(panel._thing(row))
        assert described.texts[0][2:] in tip
        assert described.texts[PLACE["stop"]] in tip
    chains = kick.chains.table.model()
    for row in range(chains.rowCount()):
        index = chains.index(row, 0)
        assert index.data() in index.data(Qt.ItemDataRole.ToolTipRole)


def test_a_narrow_column_takes_the_room_that_a_wide_one_leaves():
    widths = {column.id: 60 for column in COLUMNS} | {"chain": 150, "kind": 160}
    filled = {"chain", "decision", "start", "stop", "delta", "kind"}
    room = 4 * 60 + 150
    assert columns_that_fit(widths, filled, room) == ["chain", "decision", "start", "stop", "delta"]
    # No empty column for notes while another column is hidden.
    wide = columns_that_fit(widths, filled, room + 159)
    assert wide == ["chain", "decision", "start", "delta", "kind"]
    assert columns_that_fit(widths, filled, room + 160)[-1] == "kind"
    assert columns_that_fit(widths, filled, room + 160 + 60)[-2:] == ["kind", "note"]
