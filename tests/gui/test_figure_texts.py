"""Texts of a figure as wide as a column: none overlaps another, none is cut off, in any font."""

from itertools import combinations

import pytest
from PySide6.QtCore import QPoint, QRect, QRectF
from PySide6.QtGui import QFont

from inspector.recording.choice import Contents, Paper, RecordChoice, Shot
from inspector.recording.sheet import SheetShape, Words
from inspector.recording.stage import Shown, Stage
from inspector.teaching.gizmo_drawing import GizmoGuest
from inspector.timeline.title_lines import title_lines
from inspector.widgets import theme
from tests.conftest import ASSETS
from tests.gui.other_fonts import other_font
from tests.gui.windows import act, open_clip
from tests.tiers import parametrize
from twistcore.analysis.decomposition import WhatIf
from twistcore.detection import Kind

ONE_WINDOW = True

DPI = 300.0
TOUCH = 0.3  # units by which two outlines may come closer than their letters
FONTS = {
    "usual": {},
    "higher": {"higher": 1.5},
    "wider": {"wider": 1.3},
    "Nimbus Sans": "Nimbus Mono PS",
    "DejaVu Serif": "DejaVu Serif",
}


@pytest.fixture
def set_font(qapp, tmp_path, monkeypatch):
    """Sets the font of all texts, including numbers."""
    before = QFont(qapp.font())

    def use(name):
        how = FONTS[name]
        if not how:
            return
        qapp.setFont(before)
        new = QFont(name, 9) if isinstance(how, str) else other_font(tmp_path, **how)
        family = how if isinstance(how, str) else new.families()[0]
        monkeypatch.setattr(theme, "FIXED", family)
        monkeypatch.setattr(theme, "shipped_families", lambda: {family})
        qapp.setFont(new)

    yield use
    qapp.setFont(before)


@pytest.fixture
def figure(at_forearm, tmp_path):
    """Makes the figure of what the window shows; the stage and its sheet."""
    window, staged = at_forearm, []

    def make(millimetres=90.0, contents=None):
        shown = Shown(window.taught, window.viewport, window.timeline, window.teaching.typesetter)
        size = round(millimetres / 25.4 * DPI), 0
        contents = contents or Contents(equations=window.taught.active)
        paper = Paper(DPI, 8.0, white=True)
        choice = RecordChoice(tmp_path / "x.pdf", size=size, contents=contents, paper=paper)
        staged.append(stage := Stage(shown, choice))
        stage.show_shot(Shot(window.document.frame))
        return stage, stage.sheet()

    yield make
    for stage in staged:
        stage.close_views()


def explained(qtbot, window):
    """The equations and the gizmo, with altered angles and two more lines above the plots."""
    act(window, "show_teaching")
    qtbot.waitUntil(lambda: window.teaching.typesetter.done, timeout=30_000)
    act(window, "next_interval")
    window.taught.set_what_if(WhatIf(twist=1.1, counter=True, bend=0.9))


def every_plot(qtbot, window):
    """An interval of the review with all plots."""
    for toggle in window.timeline.toggles.values():
        toggle.setChecked(True)
    act(window, "next_interval")


def flipped(qtbot, window):
    """A limb flip, whose plots are others."""
    open_clip(qtbot, window, ASSETS / "kick.bvh")
    flips = [j.id for j in window.document.intervals if j.interval.kind == Kind.LIMB_FLIP]
    window.document.select_interval(flips[0], jump=True)


def outlines(sheet):
    """The texts in the order in which they are painted, each with its place and its box."""
    for at, item in enumerate(sheet.items):
        if isinstance(item, Words) and item.text.strip():
            yield at, item, item.outline().boundingRect()


def overlapping(one, other, touch=TOUCH):
    shared = one.intersected(other)
    return shared.width() > touch and shared.height() > touch


def faults(sheet):
    """What a reader would find fault with."""
    texts = list(outlines(sheet))
    for (_, one, its), (_, other, theirs) in combinations(texts, 2):
        twice = one.text == other.text and (its.center() - theirs.center()).manhattanLength() < 1.5
        if overlapping(its, theirs) and not twice:
            yield f"{one.text!r} is over {other.text!r}"
    for at, words, box in texts:
        if not sheet.box.contains(box):
            yield f"{words.text!r} is not on the paper"
        clip = words.clip
        if "…" in words.text or (clip is not None and not clip.boundingRect().contains(box)):
            yield f"{words.text!r} is cut off"
        for shape in sheet.items[at + 1 :]:
            if isinstance(shape, SheetShape) and shape.ink is not None and shape.ink.alpha() > 128:
                area = shape.path.boundingRect()
                area = area if shape.clip is None else area.intersected(shape.clip.boundingRect())
                if min(area.width(), area.height()) > 3.0 and overlapping(area, box):
                    yield f"{words.text!r} is covered"


@parametrize("fonts", [["usual"], list(FONTS)[1:]], ids=["usual", "others"])
@parametrize("wide", [90.0, 60.0])
@parametrize("show", [flipped, explained, every_plot])
def test_texts_neither_overlap_nor_are_cut_off(
    qtbot, at_forearm, figure, set_font, show, wide, fonts
):
    show(qtbot, at_forearm)
    qtbot.wait(50)
    for font in fonts:
        set_font(font)
        stage, sheet = figure(wide, None if wide == 90.0 else Contents(view=False))
        assert list(faults(sheet)) == [], font
        said = "".join(words.text for _, words, _ in outlines(sheet)).replace(" ", "")
        for key in stage.timeline.grid.shown:
            for text, _ in stage.timeline.panes[key].front.title:
                assert text.replace(" ", "") in said, (font, key)


@parametrize("fonts", [["usual"], list(FONTS)[1:]], ids=["usual", "others"])
def test_symbols_in_3d_and_rows_of_equations_keep_apart(qtbot, at_forearm, figure, set_font, fonts):
    explained(qtbot, at_forearm)
    for font in fonts:
        set_font(font)
        stage, _ = figure()
        guest = stage.viewport.drawing.guest
        assert isinstance(guest, GizmoGuest)
        boxes = [box for _, box, _, _ in guest.labels._placed]
        assert len(boxes) > 6
        assert not [pair for pair in combinations(boxes, 2) if pair[0].intersects(pair[1])], font
        assert all(QRectF(stage.viewport.rect()).contains(box) for box in boxes), font
        equations = stage.equations
        parts = [*equations.buttons.values(), *equations._rights, *equations.values.values()]
        parts += [*equations.heads, equations.conventions]
        places = [QRect(part.mapTo(equations, QPoint()), part.size()) for part in parts]
        assert not [pair for pair in combinations(places, 2) if pair[0].intersects(pair[1])], font
        assert all(equations.rect().contains(place) for place in places), font


def test_a_symbol_at_the_edge_of_the_image_is_whole_or_not_there(qtbot, at_forearm, figure):
    explained(qtbot, at_forearm)
    viewport = at_forearm.viewport
    for zoom in (1.3, 1.8, 2.5):
        viewport.focus_chain()
        viewport.steer(lambda camera, zoom=zoom: camera.zoomed(zoom))
        stage, _ = figure(contents=Contents(curves=False))
        boxes = [box for _, box, _, _ in stage.viewport.drawing.guest.labels._placed]
        assert boxes
        legend = QRectF(stage.viewport.overlays.legend.geometry())
        assert all(QRectF(stage.viewport.rect()).contains(box) for box in boxes)
        assert not any(box.intersects(legend) for box in boxes)


def test_the_programs_own_font_needs_no_more_room_than_is_kept(at_forearm):
    assert at_forearm.timeline.scenery.higher == 0.0
    assert at_forearm.timeline.panes["theta"].axes["left"].width() == 58.0


def test_words_that_are_wider_than_a_line_are_divided():
    title = [("Strength ", "soft"), ("0.0°", "before"),
             ("   soft |δ| ╌ 2.3°; its maximum 5.2° is compared with τ", "text"),
             ("   paper's m ╌", "soft"), ("   1.0°", "soft")]  # fmt: skip
    lines = ["".join(text for text, _ in line) for line in title_lines(title, 30.0, len)]
    assert lines == ["Strength 0.0° soft |δ| ╌ 2.3°;", "its maximum 5.2° is compared",
                     "with τ paper's m ╌ 1.0°"]  # fmt: skip
