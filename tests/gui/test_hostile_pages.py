"""Pages made of texts that somebody wrote to be obeyed, in a real browser: none is."""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from inspector.bundled import SAMPLE
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.page_export import export_page
from tests.gui.browser import found_browser
from tests.hostile_texts import HTML, hostile_clip, hostile_texts
from tests.twistcore.made_records import failed, record_of
from twistcore import read_clip
from twistcore.analysis.clip_analysis import detect
from twistcore.batch.gates import Broken, parse_batch_rule
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.report.folder_report import write_folder_report
from twistcore.review import Annotate, Decide, Decision, Review

# CI has both brought; elsewhere they are too large a thing to ask for.
pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(
        found_browser() is None and not os.environ.get("CI"), reason="no Chromium here"
    ),
]


def check(browser, page, seen):
    """Nothing of the texts runs, is fetched, or is laid out as anything but words."""
    browser.asked.clear()
    browser.messages.clear()
    browser.open(page.as_uri())
    browser.tell("""document.querySelectorAll("details").forEach((d) => { d.open = true; })""")
    browser.tell("""document.querySelectorAll("button").forEach((b) => b.click())""")
    browser.tell("""document.querySelectorAll("*").forEach((e) => {
        for (const kind of ["mouseover", "error", "load", "focus", "click"])
            if (!e.closest("a")) e.dispatchEvent(new Event(kind)); })""")
    browser.settle()
    assert browser.tell("typeof window.hostile") == "undefined"
    assert browser.tell("document.querySelectorAll('s, iframe, object, embed, base').length") == 0
    links = browser.tell("""[...document.querySelectorAll("a[href]")].map((a) => a.protocol)
        .filter((p) => !["file:", "https:"].includes(p)).length""")
    assert links == 0
    folder = page.parent.as_uri()
    elsewhere = [a for a in browser.asked if not a.startswith((folder, "about:", "data:", "blob:"))]
    assert elsewhere == []
    assert browser.messages == []
    assert seen in browser.tell("document.documentElement.textContent")


def test_a_report_of_a_clip(started, tmp_path):
    path = tmp_path / "<s>clip<⁄s>.bvh"
    hostile_clip(SAMPLE, path, 0, "/hostile-trap")
    clip = read_clip(path)
    found = detect(clip, tau_degrees=4.0)
    review = Review.of(found)
    for k, j in enumerate(review.state.intervals):
        text = HTML[k % len(HTML)]
        review.do(Annotate(j.id, text, text))
        review.do(Decide((j.id,), Decision.ACCEPTED, reviewer=text, decided_at=text))
    report = Report(clip, found.chains_and_limbs, review.state, clip.motion, name="r", by=HTML[0])
    page = write_clip_report(tmp_path, report, pictures=True, play=True)[0]
    check(started, page, "<s>")
    count = len(review.state.intervals)
    assert started.tell("document.querySelectorAll('#list a').length") == count


def test_a_report_of_a_folder(started, tmp_path):
    texts = hostile_texts("/hostile-trap")
    path = tmp_path / "clip.bvh"
    hostile_clip(SAMPLE, path, 8, "/hostile-trap")
    whole = record_of(path, "<s>x.bvh", decisions={"accepted": 1, "rejected": 0, "undecided": 0,
                                                   "reviewers": list(HTML)})  # fmt: skip
    records = [
        whole,
        *(replace(whole, name=f"{k} {t}", source=f"/none/{k}") for k, t in enumerate(HTML[:8])),
        *(failed(f"{k} {t}", t) for k, t in enumerate(texts) if "\udcff" not in t),
    ]
    report = write_folder_report(
        tmp_path, tmp_path / "report", records=records, pictures=False,
        broken=[Broken(parse_batch_rule("severity>5"), HTML[0], 26.4)],
    )  # fmt: skip
    check(started, report.index, "<s>")
    pages = sorted((tmp_path / "report" / "clips").rglob("*.html"))
    assert len(pages) >= 8
    for page in pages[:9]:
        check(started, page, "<s>")


def test_the_page_of_a_lesson(started, tmp_path):
    hostile_clip(SAMPLE, tmp_path / "clip.bvh", 0, "/hostile-trap")
    lines = [text.replace("{trap}", "/hostile-trap").replace("\n", " ") for text in HTML]
    pages = "".join(f"# {line}\n\n{line} *{line}* ${line}$\n\n> {line}\n\n" for line in lines[:12])
    lesson = tmp_path / "lesson.md"
    lesson.write_text(f"---\ntitle: {lines[0]}\nclip: clip.bvh\n---\n\n{pages}", "utf-8")
    page = tmp_path / "lesson.html"
    export_page(read_lesson(lesson), page)
    check(started, page, "<s>")
    assert Path(page).stat().st_size > 10_000
