"""The lessons of section 3 taken by hand: each task is done as its page asks.

With TWIST_INSPECTOR_PICTURES=FOLDER the other lessons are taken as well, and every page leaves a
picture there before and after its task.
"""

import os
import shutil
from pathlib import Path

import pytest

from inspector.bundled import LESSONS, TOUR
from inspector.lessons.lesson_file import read_lesson
from tests.conftest import ASSETS
from tests.gui.real_screen import middle, needs_real_screen, real_screen, watched

pytestmark = pytest.mark.thorough

_HANDLE = 16  # pixels of a slider's length that its handle takes
_BEYOND = 1.15  # of what a task asks for
_PICTURES = os.environ.get("TWIST_INSPECTOR_PICTURES", "")
_TAKEN = sorted(LESSONS.glob("*.md" if _PICTURES else "3-*.md"))
_PLAYER = "window.lesson_actions.player"
_WHAT_IF = "window.teaching.what_if"


def drag(p, name, value):
    """Drag a slider's handle to a value of its own scale, a hand's breadth off at most."""
    slider = f"{_WHAT_IF}.sliders[{name!r}]"
    low, high, now = p.ask(f"[{slider}.minimum(), {slider}.maximum(), {slider}.value()]")
    left, top, wide, tall = p.rect(slider)

    def at(number):
        share = (min(max(number, low), high) - low) / (high - low)
        return round(left + 0.5 * _HANDLE + share * (wide - _HANDLE)), top + tall // 2

    p.screen.drag(at(now), at(value))
    p.settle()


def do(p, condition):
    """What a student does for a condition, with the mouse or the key that the page names."""
    amount = condition.amount
    match condition.name:
        case "moved":
            for _ in range(round(amount)):
                p.screen.key("Right")
                p.settle()
        case "lit":
            p.screen.click(p.rect(f"window.teaching.equations.buttons[{condition.words[0]!r}]"))
        case "counter":
            p.screen.click(p.rect(f"{_WHAT_IF}.counter"))
        case "along":
            assert p.ask(f"{_WHAT_IF}.follow.isChecked()")
        case "swing" | "twist":
            drag(p, condition.name, 10.0 * amount * _BEYOND)
        case "applied":
            drag(p, "applied", 1e9)
        case "nudged":
            for singular in condition.words:
                drag(p, singular, 1e9 if singular == "swing" else 0.0)
                drag(p, "nudge", 20.0)
        case "seen":
            for _ in range(3):
                if not p.ask("window.guide.done"):
                    p.screen.key("b")
                    p.settle()
        case "accepted":
            p.screen.key("a")
        case other:
            raise AssertionError(f"nobody says how {other!r} is done by hand")


@needs_real_screen
@pytest.mark.parametrize("path", _TAKEN, ids=lambda path: path.stem)
def test_every_task_of_a_lesson_is_done_with_mouse_and_keys(tmp_path, look, path):
    lesson = read_lesson(path)
    clip = shutil.copy(ASSETS / "dance.bvh", tmp_path / "own.bvh")
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, clip) as p,
    ):

        def keep(name):
            if _PICTURES:
                screen.park()
                screen.save(Path(_PICTURES) / f"{path.stem}-{name}.png")

        screen.click(p.ask("menu('Teach')"))
        if path == TOUR:
            screen.click(p.ask("entry('tour')"))
        else:
            menu = "window.lesson_actions.lessons_menu"
            p.until("entry('tour') is not None")
            owner = f"{menu}.menuAction().associatedObjects()[0]"
            screen.click(p.ask(f"rect({owner}, {owner}.actionGeometry({menu}.menuAction()))"))
            p.until(f"{menu}.isVisible()")
            titles = p.ask(f"[a.text() for a in {menu}.actions()]")
            number = titles.index(lesson.title)
            screen.click(p.ask(f"rect({menu}, {menu}.actionGeometry({menu}.actions()[{number}]))"))
        for number, page in enumerate(lesson.pages):
            p.until(f"{_PLAYER}.at == {number}")
            p.settle()
            assert not p.ask("window.guide.done"), page.title
            keep(f"{number + 1:02}a")
            for condition in page.done:
                do(p, condition)
            p.until("window.guide.done")
            p.settle()
            keep(f"{number + 1:02}b")
            screen.click(middle(p.rect(f"{_PLAYER}.forward")))
        p.until("not window.lesson_actions.program.aside.open")
        p.until("window.document.data and window.document.data.clip.name == 'own.bvh'")
