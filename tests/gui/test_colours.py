"""Another theme reaches every view that is there, and no view is kept for it."""

from __future__ import annotations

import gc
import weakref

import pytest
import shiboken6
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from inspector.timeline.timeline import Timeline
from inspector.widgets.guide_page import GuidePage
from inspector.widgets.theme import DARK, LIGHT, Colours, Theme
from inspector.widgets.traces import TracePlot


class Swatch(QWidget):
    """Notes the themes that it is given."""

    def __init__(self, colours: Colours) -> None:
        super().__init__()
        self.seen: list[Theme] = []
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self.seen.append(theme)


def test_a_view_has_the_theme_at_once_and_every_other_one(qapp):
    colours = Colours(DARK)
    swatch = Swatch(colours)
    colours.use(LIGHT)
    assert swatch.seen == [DARK, LIGHT]
    assert colours.theme is LIGHT


def test_two_windows_have_colours_of_their_own(document, qtbot):
    one, other = Colours(DARK), Colours(DARK)
    plots = [Timeline(document, colours) for colours in (one, other)]
    for timeline in plots:
        qtbot.addWidget(timeline)
    one.use(LIGHT)
    papers = [timeline.panes["theta"].backgroundBrush().color() for timeline in plots]
    assert papers == [QColor(LIGHT.surface), QColor(DARK.surface)]


@pytest.mark.parametrize("make", [Swatch, TracePlot])
def test_no_view_is_kept_alive_by_its_colours(qapp, make):
    colours = Colours(DARK)
    view = make(colours)
    known = weakref.ref(view)
    del view
    gc.collect()
    assert known() is None
    colours.use(LIGHT)


def test_a_view_that_has_gone_is_not_coloured(qapp):
    colours = Colours(DARK)
    swatch = Swatch(colours)
    shiboken6.delete(swatch)
    colours.use(LIGHT)
    assert swatch.seen == [DARK]


class Guide(GuidePage):
    """Notes the themes that it is given."""

    def _colour(self, theme: Theme) -> None:
        self.seen = [*getattr(self, "seen", ()), theme]


def test_the_guide_that_was_closed_is_not_coloured(qtbot):
    owner, colours = QWidget(), Colours(DARK)
    qtbot.addWidget(owner)
    page = Guide(owner, colours)
    colours.use(LIGHT)
    page.show()
    page.close()
    qtbot.waitUntil(lambda: not shiboken6.isValid(page))
    colours.use(DARK)
    assert page.seen == [DARK, LIGHT]
