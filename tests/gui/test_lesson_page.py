"""A lesson as a web page: nothing is fetched, nothing in its texts is HTML, and it fits."""

import json
import re
from html.parser import HTMLParser
from zipfile import ZipFile

import pytest

from inspector.bundled import SAMPLE
from inspector.lessons.lesson_file import read_lesson
from inspector.lessons.web_page import LARGEST, export_page, page_text
from inspector.viewport import web_figure
from inspector.viewport.web_figure import three_js
from twistcore.errors import TwistError

LESSON = """---
title: An arm
clip: walk_injected.bvh
---

# The bone as an axis

The arrow $\\mathbf{a}$ is turned to **w**.

```lesson
frame: 90
chain: LeftArm
```

> Click **w**.

# A thigh

See [the paper](https://example.org/paper).

```lesson
frame: 66
chain: RightUpLeg
tab: intervals
```

# A knee

```lesson
clip: kick.bvh
frame: 48
chain: RightUpLeg-RightFoot
tab: intervals
done: accepted limb-flip
```
"""


class Read(HTMLParser):
    """Every tag with its attributes, and the texts of scripts."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.words = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] == "script" and self.cdata_elem == "script":
            self.scripts[-1] += data
        else:
            self.words.append(data)

    def values(self, *names):
        return [a[name] for _, a in self.tags for name in names if name in a]

    def data(self):
        at = [a.get("type") for tag, a in self.tags if tag == "script"].index("application/json")
        return json.loads(self.scripts[at])


def written(folder, text=LESSON):
    path = folder / "lesson.md"
    path.write_text(text, encoding="utf-8")
    return read_lesson(path)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    export_page(written(folder), folder / "lesson.html")
    return (folder / "lesson.html").read_text("utf-8")


def test_nothing_is_fetched(page):
    read = Read(page)
    assert read.values("src", "srcset", "poster", "action", "background") == []
    assert set(read.values("href")) == {"data:,", "https://example.org/paper"}
    links = [a for tag, a in read.tags if "href" in a and tag != "a"]
    assert links == [{"rel": "icon", "href": "data:,"}]
    assert not re.search(r"@import|url\(", page)
    policy = next(a["content"] for t, a in read.tags if "http-equiv" in a)
    assert policy.startswith("default-src 'none';")
    own = "".join(s for s in read.scripts if "Three.js Authors" not in s)
    assert not re.search(r"https?://|fetch\(|XMLHttpRequest|WebSocket|import\(", own)


def test_no_two_elements_have_one_name(page):
    names = Read(page).values("id")
    assert len(names) == len(set(names))


def test_it_holds_the_library_once_with_its_licence_and_fits(page):
    assert len(page.encode()) <= LARGEST
    assert page.count("Three.js Authors") == 1
    assert page.count("SPDX-License-Identifier: MIT") == 1
    assert page.count(").THREE={})") == 1
    assert "GLTFLoader" not in page  # of the viewer that it lies in


def test_pages_share_what_they_show(page):
    data = Read(page).data()
    assert len(data["figures"]) == 2  # clips
    assert len(data["spans"]) == 2  # frames 90 and 66 are within one
    assert [p["label"] for p in data["pages"]] == ["Left Arm", "Right UpLeg", "Right leg"]
    assert [p["taught"] for p in data["pages"]] == [True, False, False]
    assert [p["after"] is None for p in data["pages"]] == [True, False, False]
    assert [p["chain"] for p in data["pages"]] == [0, 1, None]


def test_a_task_far_away_is_within_reach(tmp_path):
    text = LESSON.replace("frame: 90", "frame: 170\ndone: moved 160", 1)
    first = Read(page_text(written(tmp_path, text))).data()["pages"][0]
    assert first["frame"] - first["first"] >= 160


HOSTILE = "</script></style></title><img src=x onerror=alert(1)><script>alert(2)</script>"


def test_no_text_becomes_html(tmp_path, page):
    clip = SAMPLE.read_text("utf-8").replace("JOINT ", "JOINT </script><img/src=x>")
    (tmp_path / "clip.bvh").write_text(clip, encoding="utf-8")
    hostile = f"""---
title: {HOSTILE}
clip: clip.bvh
---

# {HOSTILE}

{HOSTILE} [x](javascript:alert(1)) [y](secret.html) ![z](https://example.org/z.png)
<script>alert(3)</script> ${HOSTILE}$ and $\\frac{{$

```lesson
chain: </script><img/src=x>LeftArm
```

> {HOSTILE}
"""
    lesson = written(tmp_path, hostile)
    read = Read(page_text(lesson))
    assert len(read.scripts) == len(Read(page).scripts)
    tags = {tag for tag, _ in read.tags}
    assert "img" not in tags
    assert [t for t, _ in read.tags if t in ("title", "style")] == ["title", "style"]
    assert not [name for _, a in read.tags for name in a if name.startswith("on")]
    links = {a["href"]: tag for tag, a in read.tags if "href" in a}
    assert links == {"data:,": "link", "https://example.org/z.png": "a"}  # a link to the picture
    assert read.data()["pages"][0]["joints"]["P"] == "</script><img/src=x>LeftArm"
    assert HOSTILE in "".join(read.words)


def test_a_name_that_is_no_utf_8_is_escaped(tmp_path):
    (tmp_path / "clip.bvh").write_bytes(SAMPLE.read_bytes().replace(b"LeftForeArm", b"Fore\xe9Arm"))
    text = LESSON.replace("walk_injected", "clip", 1)
    export_page(written(tmp_path, text), tmp_path / "lesson.html")
    read = Read((tmp_path / "lesson.html").read_text("utf-8"))
    assert read.data()["pages"][0]["joints"]["C"] == "Fore\udce9Arm"


def test_fewer_frames_where_it_would_be_too_large(tmp_path, monkeypatch):
    lesson = written(tmp_path)
    whole = len(page_text(lesson).encode())
    smaller = page_text(lesson, largest=whole - 1)
    assert len(smaller.encode()) < whole
    first = Read(smaller).data()["pages"][0]
    assert (first["first"], first["last"]) == (30, 150)  # half a second on either side
    with pytest.raises(TwistError, match=r"limit of 0\.1 MB\. Shorten the lesson"):
        page_text(lesson, largest=100_000)


def test_places_that_are_not_there_are_told(tmp_path):
    with pytest.raises(TwistError, match=r"line \d+: .*'9999'"):
        page_text(written(tmp_path, LESSON.replace("frame: 66", "frame: 9999")))
    with pytest.raises(TwistError, match=r"line \d+: .*LeftArm.*'Tail'"):
        page_text(written(tmp_path, LESSON.replace("chain: RightUpLeg\n", "chain: Tail\n")))


def test_without_the_library_a_sentence_says_what_to_install(tmp_path, monkeypatch):
    assert three_js().startswith("/**\n * @license")
    monkeypatch.setattr(web_figure, "find_spec", lambda _name: None)
    with pytest.raises(TwistError, match="trimesh"):
        three_js()
    folder = tmp_path / "resources/templates"
    folder.mkdir(parents=True)
    other = type("Spec", (), {"origin": str(tmp_path / "__init__.py")})
    monkeypatch.setattr(web_figure, "find_spec", lambda _name: other)
    with pytest.raises(TwistError, match=r"three\.js|trimesh"):
        three_js()
    with ZipFile(folder / "viewer.zip", "w") as viewer:
        viewer.writestr("viewer.html.template", "<script>another viewer</script>")
    with pytest.raises(TwistError, match=r"three\.js|trimesh"):
        three_js()
