"""Plots and 3D view under a person's mouse and eyes, on a screen with a window manager."""

import numpy as np
import pytest

from tests.gui.pictures import INJECTED
from tests.gui.real_screen import differing, needs_real_screen, wait_until, watched

pytestmark = [pytest.mark.thorough, needs_real_screen]
UNDECIDED = "undecided"


@pytest.fixture(scope="module")
def one_program(screen, tmp_path_factory):
    """One for all: starting it takes longer than most that is done with it."""
    screen.park()
    folder = tmp_path_factory.mktemp("program")
    with watched(screen, folder, INJECTED, settings={"reviewer": "Kim"}) as started:
        yield started


@pytest.fixture
def program(screen, one_program):
    """With nothing decided, nothing selected, everything in view, the playhead at the start."""
    while one_program.ask("bool(window.document.review.undo_text)"):
        screen.key("ctrl+z")
        one_program.settle()
    for chain in ("RightUpLeg", "LeftForeArm"):  # an interval of another chain is let go
        at = one_program.ask(f"[c.name for c in window.document.data.chains].index('{chain}')")
        screen.click(one_program.ask(f"row(window.chains.table, {at})"))
        one_program.until(f"window.document.chain == '{chain}'")
    screen.key("shift+z", "shift+f", "Home")
    screen.park()
    one_program.until("window.document.frame == 0 and window.document.interval_id is None")
    return one_program


def spot(program, key, frame, share=0.5):
    """Pixel on the screen of a place in a plot: a frame, and a share of its height from above."""
    pane = f"window.timeline.panes['{key}']"
    left, top, width, height = program.ask(
        f"rect({pane}.viewport(), {pane}.view.sceneBoundingRect().toAlignedRect())"
    )
    (first, last), _ = program.ask(f"[list(r) for r in {pane}.view.viewRange()]")
    return round(left + (frame - first) / (last - first) * width), round(top + share * height)


def on_strip(program, frame, share):
    """Pixel on the screen of a frame in the overview, a share of its height from above."""
    left, top, _, height = program.rect("window.timeline.overview")
    return round(left + program.ask(f"window.timeline.overview._x({frame})")), round(
        top + share * height
    )


def frames(program):
    return program.ask("window.document.interval and [window.document.interval.interval.start, "
                       "window.document.interval.interval.stop]")  # fmt: skip


def ends(program):
    return program.ask("list(window.timeline.visible.ends)")


def begin_drag(screen, start, *others):
    """Press at a place and go to others; the button stays down."""
    screen.use("mousemove", *start, "sleep", 0.05, "mousedown", 1)
    for place in others:
        screen.use("mousemove", *place, "sleep", 0.05)


def let_go(screen, program):
    screen.use("mouseup", 1)
    program.settle()


def differs(picture, other):
    return differing(picture, other) > 0


def test_a_click_on_the_overview_selects_what_it_hits(screen, program):
    """And A decides nothing that is not on the screen."""
    assert program.ask("window.document.chain") == "LeftForeArm"
    screen.key("n")
    program.until("window.document.interval_id is not None")
    empty = on_strip(program, 30, 0.25)
    screen.click(empty)
    program.until("window.document.interval_id is None")
    assert abs(program.ask("window.document.frame") - 30) <= 1
    screen.click(on_strip(program, 155, 0.8))  # a leg's, which is not selected
    program.until("window.document.chain == 'RightUpLeg'")
    assert frames(program) == [149, 161]
    assert 149 <= program.ask("window.document.frame") < 161
    assert program.rect("window.timeline.overview")[3] < 40
    # Looked at closely, another interval is clicked: the plots go there.
    screen.key("z")
    program.until("window.timeline.visible.ends[1] < 300")
    screen.click(on_strip(program, 66, 0.7))
    program.until("window.document.interval.interval.start == 59")
    first, last = ends(program)
    assert first < 59 < 74 < last
    screen.key("a")
    program.until(f"[j.decision.value for j in window.document.intervals].count('{UNDECIDED}') < 8")
    decided = program.ask("[j.interval.start for j in window.document.intervals "
                          f"if j.decision.value != '{UNDECIDED}']")  # fmt: skip
    assert decided == [59]


def test_the_overviews_window_drags(screen, program):
    screen.key("n", "z")
    program.until("window.timeline.visible.ends[1] < 300")
    first, last = ends(program)
    middle = on_strip(program, 0.8 * last + 0.2 * first, 0.5)  # beside the playhead
    screen.drag(middle, (middle[0] + 180, middle[1]))
    program.settle()
    moved = ends(program)
    assert moved[0] > first + 20
    assert moved[1] - moved[0] == pytest.approx(last - first, abs=0.5)
    assert program.ask("window.document.interval_id") is None  # it is out of view
    edge = on_strip(program, moved[1], 0.5)
    screen.drag(edge, (edge[0] + 60, edge[1]))
    program.settle()
    wider = ends(program)
    assert wider[0] == pytest.approx(moved[0], abs=0.5)
    assert wider[1] > moved[1] + 10


def test_a_drag_draws_an_interval_and_shows_where_it_is(screen, program):
    where = program.rect("window.viewport")
    here, there = spot(program, "theta", 60, 0.8), spot(program, "theta", 90, 0.8)
    count = program.ask("len(window.document.intervals)")
    before = screen.steady_picture(where)
    begin_drag(screen, here, ((here[0] + there[0]) // 2, here[1]), there)
    program.until("window.document.frame in (89, 90, 91)")
    program.settle()
    assert differs(screen.picture(where), before)  # the 3D view goes along
    assert "frames" in program.ask("window.timeline.scenery.drag_label.words")
    let_go(screen, program)
    start, stop = frames(program)
    assert abs(start - 60) <= 1
    assert abs(stop - 91) <= 1
    assert program.ask("window.document.interval.by_hand")
    assert start <= program.ask("window.document.frame") < stop
    screen.key("ctrl+z")
    program.until(f"len(window.document.intervals) == {count}")
    screen.click(spot(program, "theta", 270, 0.8))  # a click still moves the playhead
    program.until("window.document.frame in (269, 270, 271)")
    assert program.ask("len(window.document.intervals)") == count
    # An edge: the frame at the cursor while it is dragged, and back again.
    screen.key("n", "z")
    program.until("window.timeline.visible.ends[0] > 100")
    start, stop = frames(program)
    home = program.ask("window.document.frame")
    edge = spot(program, "theta", stop - 0.5, 0.8)
    begin_drag(
        screen, edge, spot(program, "theta", stop + 3, 0.8), spot(program, "theta", stop + 8)
    )
    program.until(f"abs(window.document.frame - {stop + 8}) <= 1")
    assert program.ask("window.timeline.scenery.drag_label.words") == (
        f"frame {program.ask('window.document.frame')}"
    )
    let_go(screen, program)
    assert frames(program)[1] > stop + 5
    assert program.ask("window.document.frame") == home


def test_values_zoom_and_fit(screen, program):
    def values():
        return program.ask("list(window.timeline.panes['strength'].view.viewRange()[1])")

    whole = values()
    time = ends(program)
    place = spot(program, "strength", 170, 0.9)
    screen.use("mousemove", *place, "keydown", "ctrl")
    screen.use("click", "--repeat", 3, "--delay", 40, 4, "keyup", "ctrl")
    program.until(f"window.timeline.panes['strength'].view.viewRange()[1][1] < {whole[1]} * 0.8")
    close = values()
    assert ends(program) == time
    axis = (spot(program, "strength", time[0])[0] - 20, place[1])
    screen.wheel(axis, 2)
    program.until(f"window.timeline.panes['strength'].view.viewRange()[1][1] < {close[1]} * 0.9")
    span = np.ptp(values())
    screen.drag(axis, (axis[0], axis[1] - 30))
    program.settle()
    assert np.ptp(values()) == pytest.approx(span)
    screen.click(axis, times=2)
    program.until(
        f"abs(window.timeline.panes['strength'].view.viewRange()[1][1] - {whole[1]}) < 1e-6"
    )
    assert values() == pytest.approx(whole)
    # One plot alone by its title, and all again.
    left, top, *_ = program.rect("window.timeline.panes['theta']")
    screen.click((left + 200, top + 8), times=2)
    program.until("window.timeline.grid.shown == ['theta']")
    left, top, *_ = program.rect("window.timeline.panes['theta']")
    screen.click((left + 200, top + 8), times=2)
    program.until("len(window.timeline.grid.shown) == 4")


def test_words_stand_beside_the_curves(screen, program):
    """Above a plot and at its axes, not in it."""
    screen.park()
    for key in ("theta", "strength", "offset"):
        pane = f"window.timeline.panes['{key}']"
        left, top, width, _ = program.ask(
            f"rect({pane}.viewport(), {pane}.view.sceneBoundingRect().toAlignedRect())"
        )
        high = program.rect(pane)[1]
        assert top - high >= 15  # a line for the title
        title = screen.steady_picture((left - 50, high, width, top - high - 1))
        assert differs(title, title[0, 0])
        # Nothing but lines: right at the top, where a title would lie, between two intervals.
        begin, end = spot(program, key, 230)[0], spot(program, key, 290)[0]
        ground = screen.steady_picture((begin, top + 2, end - begin, 14))
        assert not differs(ground, ground[0, 0]), key
    tau = program.ask("list(window.timeline.panes['strength'].front.tau)")[1]
    assert tau.startswith("τ ")


def test_low_plots_are_fewer_not_illegible(screen, program):
    left, top, *_ = program.rect("window.docks['curves']")
    splitter = (left + 300, top - 2)
    program.drag(splitter, (splitter[0], splitter[1] + 130), steps=20)
    program.until("window.docks['curves'].height() < 260")
    shown = "[window.timeline.panes[k].view.height() for k in window.timeline.grid.shown]"
    heights = program.ask(shown)
    assert 1 <= len(heights) < 4
    assert min(heights) >= 50
    assert "of 4" in program.ask("window.timeline.plots_button.text()")


def test_labels_follow_the_views_size(screen, program):
    """Gizmo labels after F5 and after a splitter's drag are where a fresh drawing has them."""
    screen.key("ctrl+l")
    program.until("window.teaching.typesetter.done")
    screen.key("f")
    program.settle()

    def look():
        seen = []
        screen.park()
        for keys in ((), ("period", "comma")):  # as it is, and drawn anew by a step forth and back
            if keys:
                screen.key(*keys)
            program.settle()
            seen.append(screen.steady_picture(program.rect("window.viewport")))
        assert differing(*seen) == 0
        return seen[0]

    usual = look()
    screen.key("F5")
    wait_until(lambda: program.ask("window.isFullScreen()"))
    assert look().shape != usual.shape
    screen.key("Escape")
    wait_until(lambda: not program.ask("window.isFullScreen()"))
    look()
    screen.key("v")  # side by side: the divider begins below the legend
    program.until("window.viewport.overlays.divider.isVisible()")
    program.settle()
    legend, divider = (program.rect(f"window.viewport.overlays.{n}") for n in ("legend", "divider"))
    assert legend[1] + legend[3] <= divider[1]
    left, top, width, height = program.rect("window.viewport")
    bar = (left + width + 2, top + height // 2)
    program.drag(bar, (bar[0] - 120, bar[1]))  # the splitter between the view and the right docks
    program.settle()
    assert program.rect("window.viewport")[2] != width
    look()
