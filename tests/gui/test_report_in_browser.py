"""A report's pages in a real browser: nothing in its console, nothing fetched, keys, axe."""

import json
import os
import sys
from collections import Counter
from pathlib import Path

import pytest

from inspector.bundled import SAMPLE
from tests.gui.browser import found_browser
from tests.twistcore.made_records import failed, record_of, waiting
from twistcore.batch.gates import Broken, parse_batch_rule
from twistcore.detection import Kind
from twistcore.report.folder_report import write_folder_report

# CI has both brought; elsewhere they are too large a thing to ask for.
pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(
        found_browser() is None and not os.environ.get("CI"), reason="no Chromium here"
    ),
]
KICK = SAMPLE.with_name("kick.bvh")
AXE = os.environ.get("AXE") or next(map(str, Path(sys.prefix, "axe").rglob("axe.min.js")), "")
# What axe calls serious or critical keeps somebody from using a page; the rest is to be clean, too.
RUN = """axe.run(document, { resultTypes: ["violations"] }).then((found) => JSON.stringify(
  found.violations.map((v) => [v.impact, v.id, v.nodes.map((n) => n.html.slice(0, 120))])))"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Clips with finds, one without, one that failed, one that is gone, and one that waits."""
    folder = tmp_path_factory.mktemp("batch")
    clean = SAMPLE.with_name("walk.bvh")
    records = [
        record_of(SAMPLE, "a/walk & <injected>.bvh", refine=folder),
        record_of(KICK, "kick.bvh", decisions={"accepted": 1, "rejected": 2, "undecided": 9,
                                               "reviewers": ["Kim"]}),
        record_of(clean, "walk.bvh"),
        record_of(KICK, "gone.bvh", source="/nowhere/gone.bvh"),
        failed("broken.bvh", "line 2, column 12: expected '{'"),
        waiting("later.bvh"),
    ]  # fmt: skip
    written = write_folder_report(
        folder, folder / "report", records=records, pictures=False,
        broken=[Broken(parse_batch_rule("failed>0"), "", 1), Broken(parse_batch_rule("severity>5"),
                                                              "kick.bvh", 26.4)],
    )  # fmt: skip
    assert len(written.problems) == 1
    return folder / "report"


@pytest.fixture
def browser(started, report):
    started.size(1280, 900)
    started.open((report / "index.html").as_uri())
    yield started
    assert started.messages == []
    assert all(asked.startswith(("file:", "about:", "data:")) for asked in started.asked)


def names(browser):
    """Of the clips that the table shows, from the top."""
    script = """JSON.stringify([...document.querySelectorAll("#table tbody tr:not([hidden]) th")]
      .map((cell) => cell.querySelector("a").textContent))"""
    return json.loads(browser.tell(script))


def press_on(browser, selector, number=0):
    """Enter on one of some buttons, as a person with a keyboard has it."""
    browser.tell(f"document.querySelectorAll('{selector}')[{number}].focus()")
    for kind, text in (("keyDown", "\r"), ("keyUp", "")):
        browser.call("Input.dispatchKeyEvent", type=kind, key="Enter", code="Enter", text=text,
                     windowsVirtualKeyCode=13)  # fmt: skip
    browser.settle()


def test_the_table_is_sorted_by_keys_and_says_so(browser):
    worst_first = names(browser)
    assert worst_first[-1] == "walk.bvh"
    press_on(browser, "#table th button")
    by_name = ["a/walk & <injected>.bvh", "gone.bvh", "kick.bvh", "walk.bvh"]
    assert names(browser) == by_name
    order = "document.querySelector('#table th').getAttribute('aria-sort')"
    assert browser.tell(order) == "ascending"
    press_on(browser, "#table th button")
    assert (names(browser), browser.tell(order)) == (by_name[::-1], "descending")
    assert browser.tell("document.querySelectorAll('[aria-sort]').length") == 1
    press_on(browser, "#table th button", 1)
    assert names(browser) == worst_first


def test_clips_are_found_by_name_kind_and_state(browser):
    def chosen(control, value):
        browser.tell(f"document.getElementById('{control}').value = '{value}'")
        browser.tell(f"document.getElementById('{control}').dispatchEvent("
                     "new Event('input', { bubbles: true }))")  # fmt: skip
        return sorted(names(browser))

    assert chosen("find", "WALK") == ["a/walk & <injected>.bvh", "walk.bvh"]
    assert browser.tell("document.getElementById('shown').textContent") == "2 of 4 clips"
    assert chosen("find", "breaks a rule") == []  # what stands beside a name is none of it
    assert chosen("find", "") == ["a/walk & <injected>.bvh", "gone.bvh", "kick.bvh", "walk.bvh"]
    assert chosen("kind", "none") == ["walk.bvh"]
    flip, twist = (f"k{[*Kind].index(k)}" for k in (Kind.LIMB_FLIP, Kind.COUNTER_TWIST))
    assert chosen("kind", flip) == ["gone.bvh", "kick.bvh"]
    assert chosen("kind", twist) == ["a/walk & <injected>.bvh"]
    chosen("kind", "")
    assert chosen("state", "decided") == []
    assert "kick.bvh" in chosen("state", "open")


def test_without_scripts_it_is_a_table_with_nothing_to_press(started, report):
    started.messages.clear()
    with started.without_scripts():
        started.load((report / "index.html").as_uri())
        words = started.words()
    assert "a/walk & <injected>.bvh" in words
    assert "part of a name" not in words
    assert started.messages == []


@pytest.mark.parametrize("page", ["index.html", "clips/a/walk & <injected>.bvh.html",
                                  "clips/gone.bvh.html"])  # fmt: skip
def test_nobody_is_kept_from_reading_it(browser, report, page):
    if not AXE and not os.environ.get("CI"):
        pytest.skip("axe is not here: python3 dev.py test fetches it")
    for width, dark in ((1280, False), (400, True)):
        browser.size(width, 900, dark=dark)
        browser.open((report / page).as_uri())
        assert browser.tell("document.documentElement.scrollWidth") <= width
        browser.tell(Path(AXE).read_text("utf-8") + "; 0")
        assert json.loads(browser.tell(RUN)) == []


def test_a_long_table_has_its_head_on_every_printed_page(browser):
    """A head of buttons is not repeated: printed, they are none."""
    browser.call("Emulation.setEmulatedMedia", media="print")
    shown = "getComputedStyle(document.querySelector('#table th button')).display"
    assert browser.tell(shown) == "contents"
    browser.call("Emulation.setEmulatedMedia", media="")
    assert browser.tell(shown) != "contents"


def test_no_tile_stands_alone_and_no_reason_is_cut(browser, report):
    tops = "JSON.stringify([...document.querySelectorAll('.figures > div')].map(t => t.offsetTop))"
    for count in range(10, 21):
        browser.tell(f"""(() => {{
          const tiles = document.querySelector('.figures');
          while (tiles.children.length > {count}) tiles.lastElementChild.remove();
          while (tiles.children.length < {count}) tiles.append(tiles.children[0].cloneNode(true));
        }})()""")
        rows = Counter(json.loads(browser.tell(tops)))
        assert rows.total() == count
        assert min(rows.values()) > 1
    browser.size(400, 900)
    long = "/".join(["a_folder_with_a_name"] * 8)
    browser.tell(f"document.querySelector('td.text').textContent = '{long}'")
    wide = "document.querySelector('td.text').scrollWidth"
    assert browser.tell(wide) <= 400
