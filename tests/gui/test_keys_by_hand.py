"""Keys, focus and the way through a review as a person has them: real keys, mouse and wheel."""

import shutil

import pytest

from tests.gui.pictures import INJECTED
from tests.gui.real_screen import needs_real_screen, watched

pytestmark = [pytest.mark.thorough, needs_real_screen]
NAMED = {"reviewer": "Ada"}  # nobody is asked who reviews
AT_HOME = "app.focusWidget() is window.intervals.table"
POPUP = "app.activePopupWidget() is not None"


@pytest.fixture
def clip(tmp_path):
    folder = tmp_path / "clips"
    folder.mkdir()
    return shutil.copy(INJECTED, folder / "walk.bvh")


def retyped(p, box, text, end):
    """Click into a box, write something else there, and press a key."""
    p.screen.click(p.rect(box), times=2)
    p.until(f"app.focusWidget() is {box}")
    p.screen.key("ctrl+a", *text, end)


def at(p, start):
    """Wait until the interval with this start is the selected one."""
    p.until(f"window.document.interval.interval.start == {start}")


def decided(p, number, verdict):
    p.until(f"window.document.intervals[{number}].decision.value == {verdict!r}")


def test_the_keyboard_is_the_review_s_unless_a_text_is_written(screen, tmp_path, clip):
    with watched(screen, tmp_path, clip, settings=NAMED) as p:
        screen.key("n")
        p.until("window.document.interval is not None")
        delta, undone = "window.detail.delta.value()", "window.document.review.undo_text == ''"
        before = p.ask(delta)

        # The wheel over boxes that do not have the keyboard edits nothing.
        for box in ("delta", "start", "stop"):
            screen.wheel(p.rect(f"window.detail.{box}"), 2)
        screen.park()
        p.settle()
        assert (p.ask(delta), p.ask(undone)) == (before, True)

        # Ctrl+Z in a number box undoes what the review did; Esc leaves what stood there.
        retyped(p, "window.detail.delta", "12", "Return")
        p.until(f"{delta} == 12.0 and {AT_HOME}")
        screen.click(p.rect("window.detail.delta"))
        screen.key("ctrl+z")
        p.until(f"{delta} == {before} and {undone}")
        retyped(p, "window.detail.delta", "7", "Escape")
        p.until(f"{AT_HOME} and {delta} == {before} and {undone}")

        # Enter and Esc leave the note, and Esc what stood there.
        retyped(p, "window.detail.note", "no", "Return")
        p.until(AT_HOME)
        screen.key("a")
        decided(p, 0, "accepted")
        p.until("window.document.intervals[0].note == 'no'")
        retyped(p, "window.detail.note", "an", "Escape")
        p.until(AT_HOME)
        screen.key("a")
        decided(p, 1, "accepted")
        assert p.ask("window.document.intervals[1].note") == ""

        # A τ that is typed is a step that Ctrl+Z takes back at once, also from another tab.
        screen.key("ctrl+t")
        p.until("not window.tuning.box.visibleRegion().isEmpty()")
        tau, value = p.ask("window.tuning.box.value()"), "window.tuning.box.value()"
        retyped(p, "window.tuning.box", "20", "ctrl+z")
        p.until("window.document.review.redo_text != ''")
        p.until(f"{value} == {tau}")
        retyped(p, "window.tuning.box", "20", "Return")
        p.until(f"{value} == 20.0")
        screen.click(p.rect("window.tuning.box"))
        screen.key("ctrl+d")  # the tab of quality
        p.until("window.tuning.box.visibleRegion().isEmpty()")
        p.until("app.focusWidget() is not window.tuning.box")
        screen.key("ctrl+z")
        p.until("window.document.review.state.tau[window.document.chain] < 0.1")
        screen.key("ctrl+e")
        p.until("app.activeModalWidget() is not None")
        p.until("app.activeWindow() is app.activeModalWidget()")  # it gets the keys
        screen.key("Escape")
        p.until("app.activeModalWidget() is None")

        # Tab goes through the chains at once.
        screen.click(p.ask("row(window.chains.table, 1)"))
        p.until("app.focusWidget() is window.chains.table")
        screen.key("Tab")
        p.until("app.focusWidget() is not window.chains.table")


def test_accept_and_next_go_on_to_what_is_to_decide(screen, tmp_path, clip):
    with watched(screen, tmp_path, clip, settings=NAMED) as p:
        _, two, three, four, five, six = p.ask(
            "[j.interval.start for j in window.document.intervals[:6]]"
        )
        # From the playhead, not from row 1; the plots show it and what is around, in the middle.
        retyped(p, "window.transport.frame", "150", "Return")
        p.until(AT_HOME)
        screen.key("n")
        at(p, two)
        stop = p.ask("window.document.interval.interval.stop")
        left, right = p.ask("list(window.timeline.visible.ends)")
        assert left < two < stop < right < left + 200
        assert abs((left + right) - (two + stop)) < 4

        screen.key("a")
        decided(p, 1, "accepted")
        at(p, three)
        screen.key("ctrl+Up")  # back to what was decided
        at(p, two)
        screen.key("a")  # accepted as it is: on to the next undecided
        at(p, three)
        screen.key("n")
        at(p, four)

        # What has gone out of view is shown before it is judged.
        screen.key("End", "a")
        p.until(f"window.document.frame == {four}")
        assert p.decisions()[3] == "undecided"
        screen.key("a")
        decided(p, 3, "accepted")
        at(p, five)

        # Reasons, note and numbers by keys.
        screen.key("q")
        p.until(POPUP)
        screen.key("2")
        decided(p, 4, "rejected")
        p.until("window.document.intervals[4].reason == 'fast but real'")
        at(p, six)
        screen.key("i", *"on", "Return", "shift+d", "minus", *"170", "Return")
        screen.key("ctrl+bracketright", *"160", "Return")
        judged = "window.document.intervals[5]"
        p.until(f"{judged}.note == 'on' and {judged}.interval.stop == 160")
        assert p.ask("window.detail.delta.value()") == -170.0

        # Over an edge, and back on it.
        screen.key("shift+p")
        p.until("not window.player.playing and window.document.frame == 160")
        screen.key("q")
        p.until(POPUP)
        screen.key(*"jump", "Return")
        decided(p, 5, "rejected")
        p.until("window.document.intervals[5].reason == 'jump'")

        # How many they are is seen before it is done; then what comes next is said.
        screen.key("ctrl+shift+a")
        screen.shown("Accept confident intervals")
        assert p.ask("app.activeModalWidget() is None")
        screen.key("Return")
        p.until("'undecided' not in [j.decision.value for j in window.document.intervals]")
        p.until("'Ctrl+E' in window.bar.label.text()")


@pytest.mark.parametrize("key", ["a", "r", "BackSpace"])
def test_a_held_key_decides_once(screen, tmp_path, clip, key):
    with watched(screen, tmp_path, clip, settings=NAMED) as p:
        screen.key("n")
        p.until("window.document.interval is not None")
        p.settle()
        if key == "BackSpace":
            screen.key("a")
            p.until("window.document.intervals[0].decision.value == 'accepted'")
            screen.key("shift+n")
            p.settle()
        screen.use("keydown", "Right", "sleep", 1, "keyup", "Right")
        moved = p.until("window.document.frame - window.document.interval.interval.start")
        assert moved > 3  # keys repeat here
        before = p.ask("window.document.review.position")
        screen.use("keydown", key, "sleep", 2, "keyup", key)
        p.until(f"window.document.review.position > {before}")
        p.settle()
        assert p.ask("window.document.review.position") == before + 1


def test_a_name_is_asked_for_once_and_the_order_is_remembered(screen, tmp_path, clip):
    with watched(screen, tmp_path, clip) as p:
        starts = p.ask("sorted(j.interval.start for j in window.document.intervals)")
        go = "window.menuBar().actionGeometry(window.menuBar().actions()[2])"
        screen.click(p.ask(f"rect(window.menuBar(), {go})"))
        p.until("entry('order_time') is not None")
        screen.click(p.ask("entry('order_time')"))
        screen.key("n")
        at(p, starts[0])
        assert not p.ask("window.reviewer_line.isVisible()")
        p.settle()
        screen.key("a")
        p.until("window.reviewer_line.isVisible()")
        p.settle()
        screen.key("a")  # the question does not take the keys of the review
        p.until("[j.decision.value for j in window.document.intervals].count('accepted') == 2")
        at(p, starts[2])
        screen.click(p.rect("window.reviewer_line.name"))
        p.until("app.focusWidget() is window.reviewer_line.name")
        screen.type("Ada")  # letters of a name decide nothing
        at(p, starts[2])
        screen.key("Return")
        p.until(f"not window.reviewer_line.isVisible() and {AT_HOME}")
        assert p.decisions().count("accepted") == 2
        p.settle()
        screen.key("a")
        p.until("[j.reviewer for j in window.document.intervals].count('Ada') == 3")
        screen.key("ctrl+s")
        p.until("window.document.review.saved")
        screen.key("ctrl+q")
        p.process.wait(60)
    with watched(screen, tmp_path, clip) as p:
        for start in starts[3:6]:
            screen.key("n")
            at(p, start)
        assert p.ask("window.document.reviewer") == "Ada"
