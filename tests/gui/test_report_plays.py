"""The page of a clip in a real browser: it plays the finds before and after, without a network."""

import io
import json
import os
import re

import numpy as np
import pytest
from matplotlib.image import imread

from inspector.bundled import FLIPPED
from inspector.recording import report_figure
from tests.gui.browser import found_browser
from twistcore.analysis.clip_analysis import analyse
from twistcore.cli import main
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.report.picture_job import make_clip_figure
from twistcore.review import Review, read_session, write_session
from twistcore.skeleton.motion import forward_kinematics

LARGEST = 3_000_000
pytestmark = pytest.mark.skipif(
    found_browser() is None and not os.environ.get("CI"), reason="no Chromium here"
)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Of a clip with flips of a leg, of which the confident ones were accepted."""
    folder, clip = tmp_path_factory.mktemp("plays"), read_clip(FLIPPED)
    review = Review.of(analyse(clip).detect())
    review.accept()
    write_session(clip, review.state, folder / "kick.twist.json")
    return folder / "kick.twist.json"


@pytest.fixture(scope="module")
def page(session):
    assert main(["report", str(session), "-o", str(session.parent)]) == 0
    return session.parent / "kick.report.html"


@pytest.fixture
def browser(started, page):
    """The page as it is opened, which says nothing to the console and fetches nothing."""
    started.size(1280, 900)
    started.messages.clear()
    started.asked.clear()
    started.open(page.as_uri())
    started.tell("document.querySelector('#player').scrollIntoView()")
    yield started
    assert started.messages == []
    asked = {address.partition(",")[0] for address in started.asked}
    assert asked <= {page.as_uri(), "about:blank", "data:image/jpeg;base64"}


def words(browser, selector):
    return str(browser.tell(f"document.querySelector({selector!r}).innerText"))


def scene(browser, side):
    left, top, wide, high = (round(x) for x in browser.box(f".scene.{side}"))
    return imread(io.BytesIO(browser.picture()))[top : top + high, left : left + wide, :3]


def hues(picture):
    """The shares of orange and of blue pixels."""
    warm = picture[..., 0] - picture[..., 2]
    return float((warm > 0.2).mean()), float((warm < -0.2).mean())


@pytest.mark.thorough
def test_the_wrong_limb_is_seen_at_once_on_any_screen(browser):
    for size, dark in (((1280, 900), False), ((1280, 900), True), ((390, 844), False)):
        browser.size(*size, dark=dark)
        browser.tell("document.querySelector('#player').scrollIntoView()")
        browser.settle()
        assert browser.tell("document.documentElement.scrollWidth") <= size[0]
        before, after = hues(scene(browser, "before")), hues(scene(browser, "after"))
        assert before[0] > 0.02
        assert after[1] > 0.02
        assert before[1] < 0.01
        assert after[0] < 0.01
        assert browser.box(".scene.before")[1] < browser.box("#play")[1] < size[1]
    assert words(browser, ".before .tag") == "Before: turned by 179°"
    assert words(browser, ".after .tag") == "After"


@pytest.mark.thorough
def test_the_figures_have_the_poses_of_the_clip(browser):
    """The positions that the page computes of a frame are those of the clip."""
    frame = int(re.search(r"\d+", words(browser, "#at"))[0])
    text = browser.tell(
        "JSON.stringify((() => { const data = ClipData.read("
        "JSON.parse(document.getElementById('play-data').textContent)); const page = data.pages[0];"
        "return page.span.pose(page.frame, page.span.rotations(page.frame, null)).positions; })())"
    )
    motion = read_clip(FLIPPED).motion
    _, positions = forward_kinematics(motion.at(np.array([frame])))
    height = np.ptp(positions[0], axis=0).max()
    assert np.abs(np.array(json.loads(text)) - positions[0]).max() < 1e-3 * height


@pytest.mark.thorough
def test_a_find_is_chosen_by_click_keys_and_address(browser, page, session):
    state = read_session(session).state
    known = {f"#find-{j.id}": j.interval for j in state.intervals}
    assert browser.tell("document.querySelectorAll('#list a').length") == len(known)
    browser.click("#list li:nth-child(3) a")
    third = browser.tell("location.hash")
    interval = known[third]
    frame = int(re.search(r"\d+", words(browser, "#at"))[0])
    assert interval.start <= frame < interval.stop
    assert f"frames {interval.start}–{interval.stop}" in words(browser, ".about:not([hidden])")
    said = words(browser, "#said")  # to a screen reader
    assert said.startswith("Right leg RightUpLeg-RightFoot applied automatically: Limb flip of +")
    assert f"frames {interval.start}–{interval.stop}" in said
    browser.press("ArrowRight")
    assert words(browser, "#at").startswith(f"Frame {frame + 1} ")
    browser.press("ArrowDown")
    current = "document.querySelector('#list [aria-current=true]')"
    assert browser.tell(f"{current} === document.querySelector('#list li:nth-child(4) a')")
    assert browser.tell(f"{current} === document.activeElement")
    browser.press("End")
    assert browser.tell(f"{current} === document.querySelector('#list li:last-child a')")
    browser.open(page.as_uri() + third)
    assert browser.tell(f"{current}.hash") == third
    browser.tell("document.querySelector('td a').click()")  # the same in the table
    assert browser.tell(f"{current}.hash") == browser.tell("document.querySelector('td a').hash")


@pytest.mark.thorough
def test_it_plays_and_pauses(browser):
    at = words(browser, "#at")
    browser.click("#play")
    assert words(browser, "#play") == "Pause"
    browser.tell("new Promise((done) => setTimeout(done, 400))")
    browser.click("#play")
    assert words(browser, "#play") == "Play"
    paused = words(browser, "#at")
    assert paused != at
    browser.settle()
    assert words(browser, "#at") == paused
    before = scene(browser, "before")
    x, y = browser.middle(".scene.after")
    browser.drag((x, y), (x + 80.0, y))  # turns both
    assert (np.abs(scene(browser, "before") - before).max(axis=-1) > 0.05).mean() > 0.02


@pytest.mark.thorough
def test_it_is_small_and_prints_without_the_figure(browser, page):
    assert page.stat().st_size < LARGEST
    shown = "getComputedStyle(document.querySelector({!r})).display"
    assert browser.tell(shown.format("#still")) == "none"  # the pictures show the same finds
    browser.call("Emulation.setEmulatedMedia", media="print")
    assert browser.tell(shown.format("#player")) == "none"
    assert browser.tell(shown.format("#still")) == "block"
    browser.call("Emulation.setEmulatedMedia", media="screen")


@pytest.mark.thorough
def test_without_scripts_the_pictures_and_the_table_are_there(started, page):
    with started.without_scripts():
        started.load(page.as_uri())
        said = started.words()
    assert "The worst 3" in said
    assert "Every interval in motion" not in said


def test_without_pictures_or_three_js_there_is_no_figure(session, tmp_path, monkeypatch):
    assert main(["report", str(session), "-o", str(tmp_path), "--no-pictures"]) == 0
    assert "play-data" not in (tmp_path / "kick.report.html").read_text("utf-8")

    def missing():
        raise TwistError("no three.js")

    monkeypatch.setattr(report_figure, "three_js", missing)
    clip = read_clip(FLIPPED)
    figure = make_clip_figure(clip.motion, clip.motion, analyse(clip).chains_and_limbs, [])
    assert report_figure.FigureToDraw(figure).player() == {"problem": "no three.js"}


def test_pages_of_a_folder_play_if_that_is_asked_for(tmp_path):
    assert main(["batch", str(FLIPPED), "-o", str(tmp_path / "out")]) == 0
    for words, plays in (([], False), (["--play"], True)):
        pages = tmp_path / f"pages{len(words)}"
        assert main(["report", str(tmp_path / "out"), "-o", str(pages), *words]) == 0
        (text,) = [p.read_text("utf-8") for p in (pages / "clips").rglob("*.html")]
        assert "data:image/jpeg" in text
        assert ('id="play-data"' in text) == plays
