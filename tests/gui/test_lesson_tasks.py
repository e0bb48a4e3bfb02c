"""What a page of a lesson asks for at once: Show me leaves all of it done, in whatever order."""

import numpy as np
import pytest

from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.page_in_clip import chain_of
from inspector.session.opening import analyse_clip
from tests.conftest import ASSETS
from tests.gui.test_tour import play
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh

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
)


def lesson(tmp_path, *tasks, clip="walk_injected.bvh", chain="LeftArm", more="tab: intervals"):
    path = tmp_path / "lesson.md"
    pages = [PAGE.format(clip=clip, chain=chain, more=more, done=task) for task in tasks]
    path.write_text(f"---\ntitle: T\nclip: {clip}\n---\n\n{''.join(pages)}")
    return path


@pytest.mark.parametrize("tab", ["teaching", "intervals"])
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
            "an interval kind after 'accepted' that walk_injected.bvh can have",
        ),
        ("accepted, counter", "no 'counter' on the page of a limb"),
    ],
)
def test_what_the_clip_cannot_give_is_refused(tmp_path, done, expected):
    path = lesson(tmp_path, done, chain="LeftUpLeg-LeftFoot")
    read, data = read_lesson(path), analyse_clip(read_bvh(ASSETS / "walk_injected.bvh"))
    with pytest.raises(FormatError, match=rf"line 15: expected {expected}"):
        chain_of(read, read.pages[0], data)


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
