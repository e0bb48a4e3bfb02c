"""The documentation as a site: it builds without a warning, holds together, needs no network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

import pytest

import twistcore
from tests.gui.browser import Browser, found_browser
from twistcore.cli.parser import make_parser

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
MADE_BY_SPHINX = {"genindex.html", "py-modindex.html", "search.html"}
AXE = os.environ.get("AXE") or next(map(str, Path(sys.prefix, "axe").rglob("axe.min.js")), "")
# As `python -m sphinx`, but nothing looks for garbage, which takes a third of the time.
BUILD = "import gc, sphinx.cmd.build as b, sys; gc.disable(); sys.exit(b.main(sys.argv[1:]))"
RUN = """axe.run(document, OPTIONS).then((found) => JSON.stringify(
  found.violations.map((v) => [v.impact, v.id, v.nodes.map((n) => n.html.slice(0, 160))])))"""
# CI has one brought; elsewhere it is too large a thing to ask for.
needs_browser = pytest.mark.skipif(
    found_browser() is None and not os.environ.get("CI"), reason="no Chromium here"
)


class Page(NamedTuple):
    """What a page names, and what it asks for."""

    anchors: set[str]
    links: set[str]
    loads: set[str]


class PageReader(HTMLParser):
    """Collects the attributes that lead somewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.page = Page(set(), set(), set())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        has = {name: value or "" for name, value in attrs}
        if "id" in has:
            self.page.anchors.add(has["id"])
        if tag == "a" and "href" in has:
            self.page.links.add(has["href"])
        if tag == "link" and has.get("rel") in ("stylesheet", "icon", "preload", "shortcut icon"):
            self.page.loads.add(has["href"])
        if "src" in has:
            self.page.loads.add(has["src"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built once, from nothing: a page that is not read again says its warnings once only."""
    out = tmp_path_factory.mktemp("site")
    build = (sys.executable, "-c", BUILD, "-q", "-b", "html", "-W", "--keep-going", "-n")
    build = (*build, "-D", "nb_execution_mode=off")  # tests/test_notebooks.py runs them
    done = subprocess.run(
        [*build, "-d", str(out / "doctrees"), str(DOCS), str(out / "html")],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return out / "html"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    found = {}
    for path in site.rglob("*.html"):
        reader = PageReader()
        reader.feed(path.read_text("utf-8"))
        found[path.resolve()] = reader.page
    return found


@pytest.mark.thorough
def test_every_page_of_docs_is_there(site: Path, pages: dict[Path, Page]) -> None:
    sources = {p.relative_to(DOCS).with_suffix(".html") for p in DOCS.rglob("*.md")}
    sources |= {p.relative_to(DOCS).with_suffix(".html") for p in DOCS.rglob("*.ipynb")}
    sources |= {p.relative_to(DOCS).with_suffix(".html") for p in DOCS.glob("tables/*.csv")}
    built = {path.relative_to(site.resolve()) for path in pages}
    assert built - set(map(Path, MADE_BY_SPHINX)) == sources


@pytest.mark.thorough
def test_links_lead_somewhere(pages: dict[Path, Page]) -> None:
    wrong = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme:
                well = parts.scheme == "https" and "." in parts.netloc and " " not in link
                wrong += [] if well else [(path.name, link)]
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            there = target in pages or (target.is_file() and not parts.fragment)
            anchor = unquote(parts.fragment)
            if not there or (anchor and anchor not in pages[target].anchors):
                wrong.append((path.name, link))
    assert wrong == []


@pytest.mark.thorough
def test_tables_are_pages_with_their_file(site: Path, pages: dict[Path, Page]) -> None:
    """A link to a table leads to a page that shows it, and not to a download."""
    assert "tables/limits-cost.html" in pages[(site / "limits.html").resolve()].links
    path = (site / "tables" / "limits-cost.html").resolve()
    assert "<code>twistcore detect</code>" in path.read_text("utf-8")
    (file,) = [link for link in pages[path].links if link.endswith(".csv")]
    assert (path.parent / file).read_bytes() == (DOCS / "tables/limits-cost.csv").read_bytes()


@pytest.mark.thorough
def test_nothing_is_fetched_from_the_net(site: Path, pages: dict[Path, Page]) -> None:
    for path, page in pages.items():
        for load in page.loads:
            parts = urlsplit(load)
            assert not parts.scheme or parts.scheme == "data", (path.name, load)
            assert not parts.netloc, (path.name, load)
            if not parts.scheme:
                assert (path.parent / unquote(parts.path)).is_file(), (path.name, load)
    for style in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", style.read_text("utf-8"))


@pytest.mark.thorough
def test_every_verb_and_every_command_has_its_place(pages: dict[Path, Page]) -> None:
    anchors = {anchor for page in pages.values() for anchor in page.anchors}
    last = {anchor.rpartition(".")[2] for anchor in anchors if anchor.startswith("twistcore.")}
    assert set(twistcore.__all__) - {"__version__"} <= last
    below = make_parser()._subparsers
    assert below
    commands = {f"twistcore-{word}" for a in below._group_actions for word in a.choices or ()}
    assert commands | {"twist-inspector"} <= anchors


def test_every_picture_is_used_and_every_used_one_is_there() -> None:
    pages = [*DOCS.rglob("*.md"), *DOCS.rglob("*.ipynb"), ROOT / "README.md"]
    text = "\n".join(page.read_text("utf-8") for page in pages)
    used = set(re.findall(r"\bimages/([\w.-]+\.(?:png|svg|gif))", text))
    assert used == {path.name for path in (DOCS / "images").iterdir()}


@pytest.mark.thorough
def test_equations_are_set_without_a_script(pages: dict[Path, Page], site: Path) -> None:
    equation = r"q = s\,t_a, \quad \theta_p = 2\arctan\tfrac{a}{w}"
    program = f'import mathml; print(mathml.convert(r"{equation}"))'
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=DOCS / "_extensions", capture_output=True, text=True
    )
    assert "<mfrac>" in done.stdout, done.stderr
    assert "<math" in done.stdout
    assert not list(site.rglob("*mathjax*"))


# -- the search -----------------------------------------------------------------------------------


@pytest.mark.thorough
def test_the_index_knows_greek_letters_by_name(site: Path) -> None:
    text = (site / "searchindex.js").read_text("utf-8")
    index = json.loads(text[text.index("{") : text.rindex("}") + 1])
    for word, letter in (("tau", "τ"), ("theta", "θp"), ("delta", "δ")):
        found = {word: index["terms"].get(word, []) for word in (word, letter)}
        numbers = {w: set(n) if isinstance(n, list) else {n} for w, n in found.items()}
        assert numbers[letter], letter
        assert numbers[word] >= numbers[letter], letter


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    # No page draws in 3D, and without a graphics card to imitate, all take a quarter less time.
    started = Browser(tmp_path_factory.mktemp("browser"), "--disable-gpu")
    yield started
    started.close()


def found_pages(browser: Browser, site: Path, words: str) -> list[str]:
    """The pages that a search finds, best first, from the disk."""
    browser.open(f"{(site / 'search.html').as_uri()}?q={words}")
    links = "[...document.querySelectorAll('#search-results li a')].map((a) => a.pathname)"
    for _ in range(200):
        done = browser.tell("(document.querySelector('#search-results p') || {}).textContent || ''")
        if re.search(r"found|did not match", str(done)):
            break
        browser.settle()
    found = browser.tell(f"JSON.stringify({links})")
    return [Path(unquote(path)).stem for path in json.loads(str(found))]


@pytest.mark.thorough
@needs_browser
def test_a_search_for_a_letter_finds_its_page(browser: Browser, site: Path) -> None:
    browser.size(1280, 900)
    assert {"method", "guide", "tuning"} <= set(found_pages(browser, site, "tau"))
    assert "method" in found_pages(browser, site, "%CF%84")
    assert found_pages(browser, site, "no-such-wordx") == []
    assert browser.messages == []


@pytest.mark.thorough
@needs_browser
@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("install", "start"),
        ("threshold", "tuning"),
        ("jitter", "jitter"),
        ("knee backward", "guide"),
        ("candy wrapper", "guide"),
        ("exit code", "command-line"),
        ("fbx", "pipelines"),
        ("cluster", "batch"),
    ],
)
def test_words_that_people_search_for_lead_to_their_page(
    browser: Browser, site: Path, words: str, page: str
) -> None:
    browser.size(1280, 900)
    assert page in found_pages(browser, site, words.replace(" ", "%20"))[:3]


@pytest.mark.thorough
@needs_browser
def test_pages_fit_a_phone_and_say_nothing_in_the_console(
    browser: Browser, site: Path, pages: dict[Path, Page]
) -> None:
    browser.size(390, 844, dark=True)
    browser.asked.clear()
    for path in sorted(pages):
        browser.load(path.as_uri())
        assert browser.tell("document.documentElement.scrollWidth") == 390, path.name
        broken = "[...document.images].filter((i) => i.complete && !i.naturalWidth).length"
        assert browser.tell(broken) == 0, path.name
    assert browser.messages == []
    assert {urlsplit(address).scheme for address in browser.asked} <= {"file", "data", "about"}


@pytest.mark.thorough
@needs_browser
@pytest.mark.skipif(
    not AXE and not os.environ.get("CI"), reason="axe is not here: python3 dev.py test fetches it"
)
def test_pages_are_for_everybody(browser: Browser, site: Path) -> None:
    options: dict[str, object] = {"resultTypes": ["violations"]}
    contrast = {"runOnly": ["color-contrast"]}  # a theme changes nothing else
    for name in ("index", "cli", "api/detection"):
        browser.size(1280, 900)
        browser.open((site / f"{name}.html").as_uri())
        browser.tell(Path(AXE).read_text("utf-8") + "; 0")
        for dark, rules in ((False, options), (True, options | contrast)):
            browser.size(1280, 900, dark=dark)
            found = browser.tell(RUN.replace("OPTIONS", json.dumps(rules)))
            assert json.loads(str(found)) == [], (name, dark)
