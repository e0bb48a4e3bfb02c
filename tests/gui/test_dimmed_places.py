"""On a page of a lesson at most two places are watched, and the others are dimmed."""

from collections import Counter

import pytest
from PySide6.QtCore import QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QEnterEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from inspector.bundled import LESSONS
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.watched_places import MOST_WATCHED, PLACES
from inspector.widgets.theme import DARK, LIGHT
from inspector.widgets.veil import Veil
from tests.gui.test_lesson_tasks import lesson
from tests.gui.test_tour import play
from tests.gui.windows import act
from tests.tiers import parametrize
from twistcore.errors import FormatError

ONE_WINDOW = True


def is_on_screen(widget):
    """Whether it is shown: of a dock behind another tab, Qt says so as well."""
    window = widget.window()
    middle = widget.mapTo(window, widget.rect().center())
    return widget.isVisible() and window.rect().contains(middle)


def veil_of(widget):
    return widget.findChild(Veil, options=Qt.FindChildOption.FindDirectChildrenOnly)


def is_dimmed(widget):
    """Whether it or what it is inside of is below a veil."""
    while widget is not None:
        veil = veil_of(widget)
        if veil is not None and veil.isVisible():
            assert veil.size() == widget.size()
            assert not above(veil)
            return True
        widget = widget.parentWidget()
    return False


def above(veil):
    """The visible siblings that are painted after it, without scroll bars."""
    every = veil.parentWidget().children()
    later = [c for c in every[every.index(veil) + 1 :] if isinstance(c, QWidget) and c.isVisible()]
    return [c for c in later if not c.objectName().startswith("qt_scrollarea")]


def dimmed(window):
    """The names of the places that are on the screen below a veil."""
    names = set()
    for name, find in PLACES.items():
        below = [is_dimmed(widget) for widget in find(window) if is_on_screen(widget)]
        assert len(set(below)) <= 1, name
        names |= {name} if any(below) else set()
    return names


def clear(window):
    """The names of the places that are on the screen without a veil."""
    every = {name for name, find in PLACES.items() if any(map(is_on_screen, find(window)))}
    return every - dimmed(window)


class PaintCount(QObject):
    """Counts how often widgets are painted."""

    def __init__(self):
        super().__init__()
        self.painted = Counter()

    def eventFilter(self, watched, event):  # noqa: N802 - Qt's name
        if event.type() == QEvent.Type.Paint:
            self.painted[watched] += 1
        return False


def veils(window):
    return [veil for veil in window.findChildren(Veil) if veil.isVisible()]


def leave_every_place(window):
    """Tell the places that the mouse is over none of them, wherever the mouse of the screen is."""
    for find in PLACES.values():
        for widget in find(window):
            QApplication.sendEvent(widget, QEvent(QEvent.Type.Leave))


@parametrize("path", sorted(LESSONS.glob("[!e]*.md")), ids=lambda path: path.stem)
@parametrize("presented", [False, True])
def test_each_page_has_at_most_two_clear_places(qtbot, at_forearm, path, presented):
    window = at_forearm
    player = play(qtbot, window, path)
    if presented:
        act(window, "presentation")
    for page in player.pages:
        leave_every_place(window)
        watched = page.place.watched
        assert 1 <= len(watched) <= MOST_WATCHED, page.title
        assert clear(window) <= set(watched), page.title
        assert clear(window), page.title  # in a presentation, some places are hidden
        if not presented:
            assert clear(window) == set(watched), page.title
        player.forward.click()
        qtbot.wait(1)
    assert not veils(window)
    if presented:
        act(window, "presentation")


@pytest.mark.parametrize("path", sorted(LESSONS.glob("[!e]*.md")), ids=lambda path: path.stem)
def test_the_pages_of_every_language_watch_the_same(path):
    every = [path, *(path.parent / folder / path.name for folder in ("de",))]
    first, *others = [[p.place.watched for p in read_lesson(one).pages] for one in every]
    assert all(other == first for other in others)


def test_a_page_that_names_no_place_dims_nothing(qtbot, at_forearm, tmp_path):
    player = play(qtbot, at_forearm, lesson(tmp_path, "moved 5", "moved 6", more="watch: clock"))
    leave_every_place(at_forearm)
    assert "figure" not in dimmed(at_forearm)  # the clock is inside
    assert "chains" in dimmed(at_forearm)
    player.end()
    assert not veils(at_forearm)
    play(qtbot, at_forearm, lesson(tmp_path, "moved 5"))
    assert not veils(at_forearm)


def test_dimming_ends_with_the_lesson_and_while_its_card_is_closed(qtbot, at_forearm, tmp_path):
    window = at_forearm
    player = play(qtbot, window, lesson(tmp_path, "moved 5", more="watch: figure"))
    assert veils(window)
    window.docks["guide"].close()
    assert not veils(window)
    window.docks["guide"].show()
    assert veils(window)
    player.end()
    assert not veils(window)


def test_a_dimmed_place_is_clear_and_usable_under_the_mouse(qtbot, at_forearm, tmp_path):
    window = at_forearm
    play(qtbot, window, lesson(tmp_path, "moved 5", more="watch: figure"))
    leave_every_place(window)
    transport = window.transport
    assert "transport" in dimmed(window)
    at = QPoint(4, 4)
    QApplication.sendEvent(transport, QEnterEvent(at, at, at))
    assert "transport" not in dimmed(window)
    leave_every_place(window)
    assert "transport" in dimmed(window)
    frame, forward = window.document.frame, transport._buttons[2]
    at = forward.mapTo(window, forward.rect().center())
    assert window.childAt(at) is forward  # the veil lets the mouse through
    QTest.mouseClick(forward, Qt.MouseButton.LeftButton)
    assert window.document.frame == frame + 1


def test_turning_a_page_below_a_closed_card_dims_nothing(qtbot, at_forearm, tmp_path):
    window = at_forearm
    pages = lesson(tmp_path, "moved 5", "moved 6", more="watch: figure")
    player = play(qtbot, window, pages)
    assert veils(window)
    window.docks["guide"].close()
    player.forward.click()  # as Page Down does in a presentation
    assert player.at == 1
    assert not veils(window)
    window.docks["guide"].show()
    assert veils(window)


@parametrize("theme", [LIGHT, DARK])
def test_a_dimmed_place_has_less_contrast_and_is_readable(qtbot, at_forearm, tmp_path, theme):
    window = at_forearm
    window.colours.use(theme)
    play(qtbot, window, lesson(tmp_path, "moved 5", more="watch: figure"))
    leave_every_place(window)
    frame = window.transport.frame

    def spread():
        image = window.grab(frame.rect().translated(frame.mapTo(window, QPoint()))).toImage()
        grey = [
            image.pixelColor(x, y).lightness() for x in range(image.width()) for y in (8, 12, 16)
        ]
        return max(grey) - min(grey)

    dim = spread()
    window.lesson_actions.player.dim(on=False)
    assert 0.4 * spread() < dim < 0.75 * spread()


@pytest.mark.parametrize("wrong", ["figure, clock, theta", "figure, nothing", "everything"])
def test_three_places_or_an_unknown_one_are_refused(tmp_path, wrong):
    path = lesson(tmp_path, "moved 5", more=f"watch: {wrong}")
    with pytest.raises(FormatError, match="at most 2 of these places: figure, clock"):
        read_lesson(path)


def test_what_is_below_a_veil_is_not_painted_more_often(qtbot, at_forearm, tmp_path):
    window = at_forearm
    play(qtbot, window, lesson(tmp_path, "moved 5", more="watch: theta"))
    leave_every_place(window)
    count = PaintCount()
    for veil in veils(window):
        veil.installEventFilter(count)

    def nothing_is_painted():
        count.painted.clear()
        qtbot.wait(300)
        return not count.painted

    assert any(nothing_is_painted() for _ in range(20))
    window.document.go_to(window.document.frame + 1)
    qtbot.wait(300)
    assert max(count.painted.values(), default=0) <= 3


def test_a_presentation_keeps_the_figures_of_the_page(qtbot, at_forearm, tmp_path):
    window = at_forearm
    play(qtbot, window, lesson(tmp_path, "moved 5", more="tab: intervals\nlook: before, skin"))
    looks = [window.actions_by_id[look] for look in ("skin", "side_by_side")]
    assert [look.isChecked() for look in looks] == [True, False]
    act(window, "presentation")
    qtbot.wait(50)
    assert [look.isChecked() for look in looks] == [True, False]
    act(window, "presentation")
    qtbot.wait(50)
    assert [look.isChecked() for look in looks] == [True, False]
