"""What a page of a lesson asks for at once: Show me leaves all of it done, in whatever order."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontInfo

from inspector.bundled import LESSONS
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.page_in_clip import lesson_page_chain
from inspector.session.opening import analyse_clip
from tests.conftest import ASSETS
from tests.gui.test_tour import play
from tests.gui.windows import act
from tests.tiers import parametrize
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh

ONE_WINDOW = True
PAGE = """# A page

> Do it.

```lesson
clip: {clip}
frame: 20
chain: {chain}
{more}
done: {done}
```

"""
TASKS = (
    "swing >= 120, nudged bend",
    "nudged bend, swing >= 120",
    "nudged swing, swing >= 180",
    "nudged swing bend, swing >= 180, counter",
    "counter, applied >= 1",
    "counter, twist >= 170",
    "twist >= 100, twist >= 20",
    "moved 50, moved 12",
    "lit a w, lit v w",
    "seen before after, seen after both, accepted",
    "twist >= 60, along, accepted limb-flip, moved 100",
    "tau >= 20, tau <= 40",
)


def lesson(tmp_path, *tasks, clip="walk_injected.bvh", chain="LeftArm", more="tab: intervals"):
    path = tmp_path / "lesson.md"
    pages = [PAGE.format(clip=clip, chain=chain, more=more, done=task) for task in tasks]
    path.write_text(f"---\ntitle: T\nclip: {clip}\n---\n\n{''.join(pages)}")
    return path


@parametrize("tab", ["teaching", "intervals"])
def test_show_me_leaves_all_of_a_task_done(qtbot, at_forearm, tmp_path, tab):
    player = play(qtbot, at_forearm, lesson(tmp_path, *TASKS, more=f"tab: {tab}"))
    for page in player.pages:
        assert not at_forearm.guide.done, page.done
        player.show_me.click()
        assert at_forearm.guide.done, page.done
        player.forward.click()


@pytest.mark.thorough
def test_show_me_accepts_what_is_not_there_yet(qtbot, at_forearm, tmp_path):
    path = lesson(tmp_path, "accepted limb-flip, swing >= 90", clip="walk.bvh")
    player = play(qtbot, at_forearm, path)
    document = at_forearm.document
    assert not any(j.interval.kind == "limb flip" for j in document.intervals)
    player.show_me.click()
    assert at_forearm.guide.done
    assert document.chain == "LeftArm"  # of which the page speaks
    assert [j.decision for j in document.intervals if j.by_hand] == ["accepted"]


@pytest.mark.parametrize(
    ("done", "expected"),
    [
        (
            "accepted lone-jump",
            "a kind of interval in walk_injected.bvh after 'accepted'",
        ),
        ("accepted, counter", "no 'counter' on a page for a limb"),
    ],
)
def test_what_the_clip_cannot_give_is_refused(tmp_path, done, expected):
    path = lesson(tmp_path, done, chain="LeftUpLeg-LeftFoot")
    read, data = read_lesson(path), analyse_clip(read_bvh(ASSETS / "walk_injected.bvh"))
    with pytest.raises(FormatError, match=rf"line 15: expected {expected}"):
        lesson_page_chain(read, read.pages[0], data)


@pytest.mark.parametrize(
    ("more", "done"),
    [
        ("", "along"),
        ("look: after", "seen before after"),
        ("lit: w", "lit w, along"),
        ("what-if: twist -75, swing 120, applied 0.5", "twist >= 75, swing >= 90, applied >= 0.5"),
    ],
)
def test_what_holds_as_the_page_begins_is_no_task(tmp_path, more, done):
    with pytest.raises(
        FormatError, match=r"line 15: expected a task .* when the page opens, found"
    ):
        read_lesson(lesson(tmp_path, done, more=more))
    read_lesson(lesson(tmp_path, f"{done}, moved 1", more=more))
    read_lesson(lesson(tmp_path, "along", more="what-if: counter"))


@pytest.mark.thorough
def test_a_nudge_is_remembered_while_the_rest_waits(qtbot, at_forearm, tmp_path):
    play(qtbot, at_forearm, lesson(tmp_path, "swing >= 120, nudged bend", more="tab: teaching"))
    taught = at_forearm.lesson_actions.program.taught
    taught.alter(bend=np.radians(1.0), nudge=np.radians(1.0))
    assert not at_forearm.guide.done
    taught.alter(bend=None, nudge=0.0, swing=np.radians(130.0))
    assert at_forearm.guide.done


def test_each_page_has_a_threshold_and_a_detector_of_its_own(qtbot, at_forearm, tmp_path):
    """A person's τ ends with the page, and a page without one has the detector's own."""
    chain = "RightForeArm"
    more = "tab: intervals\ndetector: paper\ntau: {}"
    pages = [
        PAGE.format(clip="walk_noisy.bvh", chain=chain, more=own, done=done)
        for own, done in (
            (more.format(2), "tau <= 0.5"),
            (more.format(0.5), "listed 3"),
            ("tab: intervals", "tau >= 20"),
        )
    ]
    path = tmp_path / "lesson.md"
    path.write_text(f"---\ntitle: T\nclip: walk_noisy.bvh\n---\n\n{''.join(pages)}")
    player = play(qtbot, at_forearm, path)
    document = at_forearm.document
    shown = []
    for turn in (player.forward, player.forward, player.back, player.back, player.leave):
        assert not at_forearm.guide.done
        tau = round(float(np.degrees(document.review.state.tau[chain])), 3)
        shown.append((document.method, tau))
        player.show_me.click()
        assert at_forearm.guide.done
        if len(shown) == 3:
            automatic = round(float(np.degrees(document.detector.automatic_tau(chain))), 3)
        turn.click()
    pages = [("paper", 2.0), ("paper", 0.5), ("consistency", automatic)]
    assert shown == [*pages, *pages[1::-1]]


@pytest.mark.thorough
def test_a_lesson_is_given_to_a_room(qtbot, at_forearm):
    """In a presentation, the page is readable from the last row, and Page Down turns it."""
    player = play(qtbot, at_forearm, LESSONS / "3-3-refinement.md")
    guide, docks = at_forearm.guide, at_forearm.docks
    formula = at_forearm.teaching.equations.buttons["m"]
    small = QFontInfo(guide.body.font()).pixelSize(), formula.sizeHint().height()
    act(at_forearm, "presentation")
    qtbot.waitUntil(lambda: QFontInfo(guide.body.font()).pixelSize() >= 24)
    assert docks["guide"].isVisible()
    assert docks["teaching"].isVisible()
    assert not docks["intervals"].isVisible()
    assert formula.sizeHint().height() > 1.5 * small[1]
    for key, page in (
        (Qt.Key.Key_PageDown, 1),
        (Qt.Key.Key_PageUp, 0),
        *((Qt.Key.Key_PageDown, k) for k in (1, 2, 3, 4)),
    ):
        qtbot.keyClick(at_forearm, key)
        assert player.at == page
    assert not docks["teaching"].isVisible()  # the last page is about the intervals
    act(at_forearm, "presentation")
    qtbot.waitUntil(lambda: docks["intervals"].isVisible())
    assert (QFontInfo(guide.body.font()).pixelSize(), formula.sizeHint().height()) == small
    qtbot.keyClick(at_forearm, Qt.Key.Key_PageUp)  # belongs to lists again
    assert player.at == 4


@pytest.mark.thorough
def test_a_presentation_gives_back_what_the_lesson_needs_now(qtbot, at_forearm, tmp_path):
    """No page of a lesson that has ended, and the tab of the page that is open."""
    docks, clip = at_forearm.docks, "walk_injected.bvh"
    pages = [
        PAGE.format(clip=clip, chain="LeftArm", more=f"tab: {tab}", done="counter")
        for tab in ("intervals", "teaching")
    ]
    path = tmp_path / "lesson.md"
    path.write_text(f"---\ntitle: T\nclip: {clip}\n---\n\n{''.join(pages)}")
    entry = docks["guide"].toggleViewAction()
    assert not entry.isEnabled()
    player = play(qtbot, at_forearm, path)
    assert entry.isEnabled()
    act(at_forearm, "presentation")
    player.forward.click()
    act(at_forearm, "presentation")
    qtbot.waitUntil(lambda: at_forearm.taught.active)
    assert docks["guide"].isVisible()
    act(at_forearm, "presentation")
    player.forward.click()
    act(at_forearm, "presentation")
    qtbot.waitUntil(docks["intervals"].isVisible)
    assert not docks["guide"].isVisible()
    assert not entry.isEnabled()


@pytest.mark.thorough
def test_no_equation_of_a_lesson_is_cut_off(qtbot, at_forearm):
    """The tab is as wide as the rows of every page, not only those of the first."""
    player = play(qtbot, at_forearm, LESSONS / "3-1-definition.md")
    teaching = at_forearm.teaching
    qtbot.waitUntil(lambda: teaching.typesetter.done)
    act(at_forearm, "presentation")
    for _ in player.pages:
        player.show_me.click()
        qtbot.wait(50)
        room = teaching.scroll_area.viewport().width()
        assert room >= teaching.listed.minimumSizeHint().width()
        player.forward.click()
    act(at_forearm, "presentation")
