"""Lesson files: what they say is read, and what is wrong in one is told in a sentence."""

import re
from dataclasses import replace

import numpy as np
import pytest

from inspector.bundled import ASSETS, DOCS, LESSONS, SAMPLE
from inspector.lessons.lesson_conditions import CONDITIONS, Condition, read_conditions
from inspector.lessons.lesson_file import KEYS, read_lesson
from inspector.lessons.lesson_place import FIELDS, Camera, LessonPlace, lesson_place_settings
from inspector.lessons.page_in_clip import lesson_page_chain
from inspector.session.opening import analyse_clip
from inspector.teaching.symbols import SYMBOLS
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if import WhatIfBox
from inspector.widgets.theme import LIGHT, Colours
from twistcore.analysis.decomposition import WhatIf
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh

HEAD = "---\ntitle: A lesson\nclip: walk_injected.bvh\n---\n\n"
LESSON = """---
title: A lesson
clip: walk_injected.bvh
---

# First

A text with $\\mathbf{a}$ and
**words**.

```lesson
frame: 90
chain: LeftArm
camera: 30 20 1.5
show: w, alpha
lit: w
what-if: twist 75, counter, swing 120, nudge -1
tab: teaching
look: after, skin
done: counter, twist >= 60
```

> Press a button,
> and look.

# Second

```python
# this is no page
```

```lesson
camera: limb
clip: kick.bvh
done: accepted limb-flip
```
"""


def written(tmp_path, text):
    path = tmp_path / "lesson.md"
    path.write_text(text, encoding="utf-8")
    return path


def test_pages_and_their_places(tmp_path):
    path = written(tmp_path, LESSON)
    lesson = read_lesson(path)
    assert (lesson.title, lesson.path) == ("A lesson", path)
    first, second = lesson.pages
    assert first.title == "First"
    assert first.body == "A text with $\\mathbf{a}$ and\n**words**."
    assert first.task == "Press a button, and look."
    place = first.place
    assert (place.clip, place.frame, place.chain) == (SAMPLE, 90, "LeftArm")
    assert place.camera == Camera(np.radians(30.0), np.radians(20.0), 1.5)
    assert (place.show, place.lit) == (("w", "alpha"), "w")
    altered = place.what_if
    assert np.degrees([altered.twist, altered.swing, altered.nudge]) == pytest.approx([75, 120, -1])
    assert altered.counter
    assert altered.bend is None
    assert (place.tab, place.look, place.skin) == ("teaching", "after", True)
    assert first.done == (Condition("counter"), Condition("twist", 60.0))
    # Where the page before stood is kept, what it looked at is not.
    assert second.body == "```python\n# this is no page\n```"
    assert second.task == ""
    assert second.place.clip == ASSETS / "kick.bvh"
    assert (second.place.frame, second.place.chain, second.place.camera) == (90, "LeftArm", None)
    assert (second.place.show, second.place.lit, second.place.skin) == ((), "", False)
    assert not second.place.what_if.changes
    assert second.done == (Condition("accepted", words=("limb-flip",)),)


def test_a_clip_beside_the_lesson_comes_before_a_bundled_one(tmp_path):
    own = tmp_path / "kick.bvh"
    own.write_bytes((ASSETS / "walk.bvh").read_bytes())
    first, second = read_lesson(written(tmp_path, LESSON)).pages
    assert (first.place.clip, second.place.clip) == (SAMPLE, own)


BAD = {
    "title: A lesson": (
        "tittle: A lesson",
        2,
        "the key is one of title, clip, found 'tittle: A lesson'",
    ),
    "---\n\n# First": ("# First", 34, "a line '---' after the title and the clip"),
    "clip: walk_injected.bvh\n": ("", 3, "a line 'clip: …' above this one"),
    "# First": ("First", 6, "a page, which begins with a line '# Heading', found 'First'"),
    "walk_injected": ("absent", 3, "a BVH file in the lesson's folder or a bundled sample"),
    "frame: 90": ("frame: ninety", 12, "a frame, counted from 0, found 'ninety'"),
    "frame: 90\n": ("frames: 90\n", 12, "'key: value', where the key is one of clip, frame, chain"),
    "chain: LeftArm": ("frame: 3", 13, "'frame' only once"),
    "camera: 30 20 1.5": ("camera: 30 20", 14, "'limb', or an azimuth and an elevation"),
    "show: w, alpha": ("show: w, omega", 15, "one of the symbols a, q, w"),
    "twist 75": ("twist far", 17, "an angle in degrees"),
    "swing 120": ("swung 120", 17, "twist, counter, swing"),
    "tab: teaching": ("tab: history", 18, "one of teaching, intervals, found 'history'"),
    "look: after, skin": ("look: after, before", 19, "one of before, after, both"),
    "done: counter,": ("done: counted,", 20, "one of the conditions moved, seen, lit, swing"),
    "twist >= 60": ("twist > 60", 20, "'twist >= degrees'"),
    "accepted limb-flip": (
        "accepted flip",
        35,
        "one of counter-twist, carried-roll, limb-flip, helper-roll",
    ),
    "limb-flip\n```": ("limb-flip", 32, "a line '```' at the end of the settings block"),
    "camera: limb": ("```\n```lesson", 34, "only one block of settings per page"),
}


@pytest.mark.parametrize("right", BAD)
def test_what_is_wrong_is_told_with_its_line(tmp_path, right):
    wrong, line, expected = BAD[right]
    assert right in LESSON
    path = written(tmp_path, LESSON.replace(right, wrong, 1))
    with pytest.raises(FormatError) as told:
        read_lesson(path)
    sentence = str(told.value)
    assert "\n" not in sentence
    assert sentence.startswith(f"{path}, line {line}: expected ")
    assert expected in sentence


OUT_OF_RANGE = {
    "twist 75": ("twist 5000", "twist -181"),
    "swing 120": ("swing -400", "swing 181", "bend 900", "bend -1", "stage 9", "stage -1"),
    "nudge -1": ("nudge 4", "nudge -3.1"),
    "camera: 30 20 1.5": ("camera: 30 20 1e300", "camera: 30 20 0"),
    "twist >= 60": (
        "twist >= -5", "twist >= 0", "moved -3", "moved 0", "applied >= 0",
        "moved 12.4", "moved 0.4", "twist >= 181", "swing >= 180.1", "applied >= 1.01",
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("right", "wrong"), [(right, wrong) for right, all_ in OUT_OF_RANGE.items() for wrong in all_]
)
def test_what_no_slider_reaches_is_refused(tmp_path, right, wrong):
    with pytest.raises(FormatError, match=r"line (14|17|20): expected .*( from |, greater|whole)"):
        read_lesson(written(tmp_path, LESSON.replace(right, wrong, 1)))


@pytest.mark.parametrize(
    "done",
    [
        "along, counter",
        "seen before, seen after",
        "lit w, swing >= 5, lit n",
        "twist >= 500",
        "twist >= 171, counter",
    ],
)
def test_a_task_that_nobody_can_do_is_refused(tmp_path, done):
    wrong = LESSON.replace("done: counter, twist >= 60", f"done: {done}", 1)
    with pytest.raises(FormatError, match=r"line 20: expected .*, found "):
        read_lesson(written(tmp_path, wrong))
    several = read_conditions("seen before after, twist >= 180, seen after both, applied >= 1")
    assert [(c.name, c.words) for c in several if c.words] == [("seen", ("after",))]
    assert len(several) == 3


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ("frame: 344", "line 12: expected a frame of walk_injected.bvh from 0 to 343, found '344'"),
        (
            "done: moved 254, along",
            "line 20: expected at most 253 frames after 'moved'",
        ),
        (
            "chain: Tail",
            r"line 13: expected .* chains of walk_injected.bvh \(.*LeftArm.*'Tail'",
        ),
    ],
)
def test_what_has_no_place_in_the_clip_is_told_with_its_line(tmp_path, wrong, expected):
    key = wrong.split(":")[0]
    text = re.sub(f"{key}: .*", wrong, LESSON, count=1)
    lesson, data = read_lesson(written(tmp_path, text)), analyse_clip(read_bvh(SAMPLE))
    with pytest.raises(FormatError, match=expected):
        lesson_page_chain(lesson, lesson.pages[0], data)


def test_what_a_page_has_from_the_one_before_is_told_at_its_heading(tmp_path):
    kick = read_bvh(ASSETS / "kick.bvh")
    last = kick.motion.frames - 1
    assert last < 340  # else the frame lies in both clips
    lesson = read_lesson(written(tmp_path, LESSON.replace("frame: 90", "frame: 340")))
    lesson_page_chain(lesson, lesson.pages[0], analyse_clip(read_bvh(SAMPLE)))
    with pytest.raises(FormatError, match=rf"line 26: .*kick.bvh.* {last}"):
        lesson_page_chain(lesson, lesson.pages[1], analyse_clip(kick))


def test_the_ranges_are_those_of_the_sliders(tmp_path, qtbot, open_document):
    box = WhatIfBox(TaughtFrame(open_document(SAMPLE)), Colours(LIGHT))
    qtbot.addWidget(box)
    for name, slider in box.sliders.items():
        steps = 100 if name == "applied" else 10
        for at in (slider.minimum(), slider.maximum()):
            read_lesson(written(tmp_path, LESSON.replace("twist 75", f"{name} {at / steps}", 1)))
            beyond = (at + (-1 if at == slider.minimum() else 1)) / steps
            with pytest.raises(FormatError):
                read_lesson(written(tmp_path, LESSON.replace("twist 75", f"{name} {beyond}", 1)))


def test_a_lesson_of_notepads_is_one(tmp_path):
    path = tmp_path / "lesson.md"
    path.write_bytes(b"\xef\xbb\xbf" + LESSON.replace("\n", "\r\n").encode())
    assert read_lesson(path).pages == read_lesson(written(tmp_path, LESSON)).pages


@pytest.mark.parametrize("folder", ["{0}/", "../elsewhere/", "elsewhere/", "./", "..\\"])
def test_a_clip_outside_the_lessons_folder_is_none_of_its(tmp_path, folder):
    elsewhere, beside = tmp_path / "elsewhere", tmp_path / "lesson"
    for one in (elsewhere, beside, beside / "elsewhere"):
        one.mkdir()
        (one / "own.bvh").write_bytes((ASSETS / "walk.bvh").read_bytes())
    (beside / "..\\own.bvh").write_bytes((ASSETS / "walk.bvh").read_bytes())
    name = f"{folder.format(elsewhere)}own.bvh"
    path = written(beside, LESSON.replace("walk_injected.bvh", name, 1))
    with pytest.raises(FormatError, match="line 3: "):
        read_lesson(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"---\ntitle: x\nclip: walk.bvh\n---\n"])
def test_what_is_no_lesson_is_told(tmp_path, content):
    path = tmp_path / "lesson.md"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=r"lesson\.md.*: expected "):
        read_lesson(path)
    with pytest.raises(FormatError, match=r"absent\.md: "):
        read_lesson(tmp_path / "absent.md")


@pytest.mark.parametrize(
    "place",
    [
        LessonPlace(SAMPLE),
        LessonPlace(
            SAMPLE, 66, "RightUpLeg", Camera(np.radians(-30.5), np.radians(12.0), 0.75),
            ("m", "product"), "m",
            WhatIf(twist=np.radians(-60.0), counter=True, swing=np.radians(179.0), applied=0.25),
            1.5, "teaching", "after", True,
        ),
        LessonPlace(
            SAMPLE, what_if=WhatIf(bend=0.0, nudge=np.radians(1.5), toward=(0.0, 0.6, -0.8))
        ),
    ],
)  # fmt: skip
def test_a_place_that_is_written_is_read_again(tmp_path, place):
    block = lesson_place_settings(place)
    (page,) = read_lesson(written(tmp_path, f"{HEAD}# Page\n\n{block}\n")).pages
    again = page.place
    assert replace(again, what_if=WhatIf(), camera=None) == replace(
        place, what_if=WhatIf(), camera=None
    )
    for one, other in ((again.what_if, place.what_if), (again.camera, place.camera)):
        if other is not None:
            theirs, mine = vars(other), vars(one)
            for name, value in theirs.items():
                assert mine[name] == (pytest.approx(value) if value is not None else None)


# -- the documentation ----------------------------------------------------------------------------

PAGE = (DOCS / "teaching.md").read_text(encoding="utf-8")


def table(name):
    """First cells of a table that the page links to, without their marks."""
    assert f"(tables/{name}.csv)" in PAGE
    rows = (DOCS / "tables" / f"{name}.csv").read_text(encoding="utf-8").splitlines()[1:]
    return [re.search(r"`([^`]+)`", row)[1] for row in rows]


def test_every_key_and_condition_is_documented():
    assert tuple(table("lesson-keys")) == KEYS
    assert [cell.split()[0] for cell in table("lesson-conditions")] == list(CONDITIONS)
    for cell in table("lesson-conditions"):
        read_conditions(cell)  # what is shown there can be written
    symbols = PAGE.split("Symbols: ", 1)[1].split("\n\n", 1)[0]
    assert set(re.findall(r"`(\w+)`", symbols)) == SYMBOLS.keys()


def test_the_documented_lesson_is_one(tmp_path):
    (example,) = re.findall(r"````markdown\n(.*?)````", PAGE, re.S)
    lesson = read_lesson(written(tmp_path, example))
    (page,) = lesson.pages
    assert page.task
    assert page.place.show
    assert len(page.done) == 2


def test_the_table_of_bundled_lessons_is_right():
    for path in LESSONS.glob("*.md"):
        row = next(line for line in PAGE.splitlines() if f"{path.name}`" in line)
        lesson = read_lesson(path)
        assert f"| {len(lesson.pages)} |" in row
        assert lesson.title in row


def test_a_direction_of_large_numbers_is_one_like_any_other():
    toward = FIELDS["what-if"]("toward 3e200 0 4e200")["what_if"].toward
    assert toward == pytest.approx((0.6, 0.0, 0.8))
    with pytest.raises(ValueError, match="direction"):
        FIELDS["what-if"]("toward 1.7e308 1.7e308 0")
