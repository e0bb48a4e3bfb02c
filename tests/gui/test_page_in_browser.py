"""A lesson's page in a real browser: with real mouse and keys, it says nothing to its console."""

import io
import itertools
import os
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from inspector.bundled import ASSETS, LESSONS, SAMPLE, TOUR
from inspector.lessons.lesson_conditions import CONDITIONS
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.web_page import LARGEST, export_page
from inspector.teaching.taught_frame import degree_text
from tests.gui.browser import Browser, found_browser
from tests.gui.looks import EVERY
from twistcore.analysis.decomposition import WhatIf, decompose
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains

# CI has one brought; elsewhere it is too large a thing to ask for.
pytestmark = pytest.mark.skipif(
    found_browser() is None and not os.environ.get("CI"), reason="no Chromium here"
)
FRAME = 90
LESSON = """---
title: An arm
clip: walk_injected.bvh
---

# The bone as an axis

The arrow $\\mathbf{a}$ is turned to **w**.

```lesson
frame: 90
chain: LeftArm
done: lit w
```

> Click **w**.

# A twist

```lesson
what-if: twist 75
show: theta_p, m
done: counter, applied >= 1
```

> Counter-twist.

# Before and after

```lesson
clip: kick.bvh
frame: 48
chain: RightUpLeg-RightFoot
tab: intervals
done: accepted limb-flip
```
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    (folder / "lesson.md").write_text(LESSON, encoding="utf-8")
    export_page(read_lesson(folder / "lesson.md"), folder / "lesson.html")
    return folder / "lesson.html"


@pytest.fixture
def silent(started):
    """A browser in which nothing may be said to the console."""
    started.size(1024, 640)
    started.messages.clear()
    started.asked.clear()
    yield started
    assert started.messages == []


@pytest.fixture
def browser(silent, page):
    """The page, as it is opened."""
    silent.open(page.as_uri())
    yield silent
    assert set(silent.asked) <= {page.as_uri(), "about:blank"}


def pixels(browser, selector):
    left, top, wide, high = (round(x) for x in browser.box(selector))
    whole = imread(io.BytesIO(browser.picture()))
    return whole[top : top + high, left : left + wide, :3]


def moved(before, after):
    """The share of pixels that look different."""
    return float((np.abs(before - after).max(axis=-1) > 0.05).mean())


def slide(browser, name, share):
    """Drag a slider's knob to a share of its way, 0…1."""
    left, top, wide, high = browser.box(f"#{name}")
    text = f"(e => (e.value - e.min) / (e.max - e.min))(document.querySelector('#{name}'))"
    knob = 16.0
    start, stop = (left + knob / 2 + s * (wide - knob) for s in (browser.tell(text), share))
    browser.drag((start, top + high / 2), (stop, top + high / 2))


def told(browser, selector):
    return browser.tell(f"document.querySelector({selector!r}).textContent")


def value(browser, symbol):
    return told(browser, f'[data-symbol="{symbol}"] .value')


def quantities(**what_if):
    motion = read_bvh(SAMPLE).motion
    chain = next(c for c in find_chains(motion) if c.name == "LeftArm")
    return decompose(motion, chain, FRAME, WhatIf(**what_if))


@pytest.mark.thorough
def test_a_slider_moves_the_figure_and_the_numbers(browser):
    assert value(browser, "theta_p") == degree_text(quantities().theta_p)
    before = pixels(browser, "#scene")
    slide(browser, "twist", 0.75)
    twist = float(browser.tell("document.querySelector('#twist').value"))
    assert twist == pytest.approx(90.0, abs=3.0)
    own = quantities(twist=np.radians(twist))
    assert value(browser, "theta_p") == degree_text(own.theta_p)
    assert moved(before, pixels(browser, "#scene")) > 0.01
    assert "A pure twist" in told(browser, "#words")
    browser.click("#counter")
    own = quantities(twist=np.radians(twist), counter=True)
    assert value(browser, "dtheta_c") == degree_text(own.dtheta_c)
    assert "a twist error" in told(browser, "#words")
    slide(browser, "applied", 1.0)
    assert str(value(browser, "m")).startswith("0.00° < τ")
    browser.click("#reset")
    assert value(browser, "theta_p") == degree_text(quantities().theta_p)
    assert moved(before, pixels(browser, "#scene")) < 0.001


@pytest.mark.thorough
def test_the_figure_is_turned_by_mouse_and_keys(browser):
    before = pixels(browser, "#scene")
    x, y = browser.middle("#scene")
    browser.drag((x, y), (x + 120.0, y))
    turned = pixels(browser, "#scene")
    assert moved(before, turned) > 0.02
    browser.press("ArrowLeft")
    assert moved(turned, pixels(browser, "#scene")) > 0.02
    browser.press("Home")
    assert moved(before, pixels(browser, "#scene")) < 0.001


@pytest.mark.thorough
def test_sliders_are_moved_by_keys(browser):
    seen = set()
    for _ in range(12):
        browser.press("Tab")
        seen.add(browser.tell("document.activeElement.id"))
        if browser.tell("document.activeElement.id") == "swing":
            browser.press("ArrowRight")
            break
    assert {"scene", "twist", "swing"} <= seen
    angle = float(np.degrees(quantities().alpha))
    assert told(browser, "output[for=swing]") == f"{round(angle, 1) + 0.1:.1f}°"


@pytest.mark.thorough
def test_pages_turn_and_tasks_are_ticked(browser):
    shown = "[...document.querySelectorAll('article')].findIndex((a) => !a.hidden)"
    ticks = "[...document.querySelectorAll('article')].map((a) => a.className).join()"
    browser.click('[data-symbol="w"] button')
    assert browser.tell(ticks) == "done,,"
    browser.click("#next")
    assert browser.tell(shown) == 1
    rows = "[...document.querySelectorAll('.row')].filter((r) => !r.hidden)"
    assert browser.tell(f"{rows}.map((r) => r.dataset.symbol).join()") == "theta_p,m"
    browser.click("#counter")
    assert browser.tell(ticks) == "done,,"
    browser.tell("document.querySelector('#applied').focus()")
    browser.press("End")
    assert browser.tell(ticks) == "done,done,"
    browser.click("#next")
    both = pixels(browser, "#scene")
    browser.click('#looks [value="before"]')
    assert moved(both, pixels(browser, "#scene")) > 0.005
    browser.press("b")
    assert told(browser, "#legend") == "Right leg · after"
    browser.click("#back")
    assert browser.tell(shown) == 1


@pytest.mark.thorough
def test_frames_are_scrubbed(browser):
    browser.press("ArrowRight")
    assert told(browser, "#frame-number") == f"Frame {FRAME + 1}"
    left, top, wide, high = browser.box("#curves canvas")
    browser.drag((left + wide / 2, top + high / 2), (left + 0.9 * wide, top + high / 2))
    frame = int(str(told(browser, "#frame-number")).removeprefix("Frame "))
    assert 180 < frame < 200
    motion = read_bvh(SAMPLE).motion
    chain = next(c for c in find_chains(motion) if c.name == "LeftArm")
    assert value(browser, "theta_p") == degree_text(decompose(motion, chain, frame).theta_p)


# One page serves all lessons: those with the most pages stand for the others.
@pytest.mark.thorough
@pytest.mark.parametrize(
    "path",
    sorted(LESSONS.glob("*.md")) if EVERY else [TOUR, LESSONS / "lecture.md"],
    ids=lambda path: path.stem,
)
def test_every_bundled_lesson_says_nothing_to_the_console(silent, path, tmp_path):
    browser, lesson, page = silent, read_lesson(path), tmp_path / "lesson.html"
    export_page(lesson, page)
    assert page.stat().st_size <= LARGEST
    browser.open(page.as_uri())
    for at, own in enumerate(lesson.pages):
        assert told(browser, "article:not([hidden]) h2") == own.title
        if own.place.tab == "teaching":
            rows = "[...document.querySelectorAll('.row')].filter((r) => !r.hidden)"
            listed = str(browser.tell(f"{rows}.map((r) => r.dataset.symbol).join()")).split(",")
            assert not own.place.show or set(listed) == set(own.place.show)
        if at + 1 < len(lesson.pages):
            browser.click("#next")


def test_every_condition_is_known_to_the_page():
    script = (ASSETS / "lesson_page" / "lesson.js").read_text("utf-8")
    table = script.split("const CONDITIONS = {")[1].split("};")[0]
    assert set(re.findall(r"^    (\w+): \(", table, re.MULTILINE)) == set(CONDITIONS)


@pytest.mark.thorough
def test_it_fits_every_screen(browser):
    sizes = [(1280, 800), (1024, 700), (390, 844)]
    for size, dark in itertools.product(sizes, (False, True)):
        browser.size(*size, dark=dark)
        assert browser.tell("document.documentElement.scrollWidth") <= size[0]
        for selector in ("#next", "#scene", "#twist", "#counter", "#frame"):
            left, _, wide, high = browser.box(selector)
            assert left >= 0.0, (size, selector)
            assert left + wide <= size[0], (size, selector)
            assert min(wide, high) > 8.0, (size, selector)
        assert browser.box("#scene")[3] > 0.3 * size[1]
        paper = pixels(browser, "#lesson h2")[0, -1]
        assert (paper.max() < 0.3) == dark


@pytest.mark.thorough
def test_without_webgl_bones_are_lines(page, tmp_path):
    browser = Browser(tmp_path / "profile", "--disable-3d-apis")
    browser.size(1280, 800)
    browser.open(page.as_uri())
    assert "no WebGL" in told(browser, "#no-3d")
    assert browser.box("#no-3d")[3] > 0.0
    before = pixels(browser, "#scene")
    slide(browser, "swing", 0.2)
    assert moved(before, pixels(browser, "#scene")) > 0.005
    browser.close()
    assert browser.messages == []


@pytest.mark.thorough
def test_without_scripts_the_text_is_there(silent, page):
    with silent.without_scripts():
        silent.load(page.as_uri())
        words = silent.words()
    assert "JavaScript is switched off" in words
    assert "The bone as an axis" in words
    assert "Before and after" in words
