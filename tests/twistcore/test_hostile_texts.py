"""Texts that somebody wrote to be obeyed by a terminal, a spreadsheet, a browser, or Python.

Some of the texts are tried; all of them with TWIST_INSPECTOR_TEXTS=all.
"""

import ast
import csv
import io
import math
import os
import subprocess
import sys
import unicodedata
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.hostile_texts import as_file_name, hostile_clip, hostile_texts, shares
from tests.tiers import parametrize
from tests.twistcore.test_cli import run
from twistcore import read_clip
from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.correction.twist_removal import refine
from twistcore.batch.junit import junit_xml
from twistcore.batch.manifest import ClipRecord
from twistcore.batch.result_files import clips_csv
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.export.markers import blender_markers
from twistcore.export.scene_script import PROGRAMS, SceneOptions, scene_script
from twistcore.files.encoding import escape_csv_cell, unescape_csv_cell
from twistcore.report.clip_report import write_clip_report
from twistcore.report.document import Report
from twistcore.report.folder_report import clip_page_path
from twistcore.review import Annotate, Decide, Decision, Review, write_session
from twistcore.tuning import Tuned, read_profile, write_profile

SOURCE = ASSETS / "walk_injected.bvh"
TEXTS = hostile_texts("/hostile-trap")
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
NAMES = [text for text in TEXTS if text != "."]
SINGLE = [text for text in TEXTS if not any("\ud800" <= c <= "\udc7f" for c in text)]


@pytest.fixture(params=shares())
def judged(request, tmp_path):
    """A clip of hostile joints in a folder and file of such a name, reviewed by such a person."""
    begin = request.param
    folder = tmp_path / as_file_name(TEXTS[begin])
    folder.mkdir()
    clip = folder / f"{as_file_name(TEXTS[(begin + 25) % len(TEXTS)])}.bvh"
    hostile_clip(SOURCE, clip, begin, "/hostile-trap")
    return clip, reviewed(clip, begin)


def reviewed(path, begin):
    clip = read_clip(path)
    review = Review.of(detect(clip, tau_degrees=4.0))
    for k, j in enumerate(review.state.intervals):
        text = TEXTS[(begin + k) % len(TEXTS)]
        review.do(Annotate(j.id, text, text))
        review.do(Decide((j.id,), Decision.ACCEPTED, reviewer=text, decided_at=text))
    return clip, review.state


def steered(text):
    """What of it a terminal would obey."""
    kinds = {"Cc", "Zl", "Zp", "Cs"}
    turns = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
    return {c for c in text if (unicodedata.category(c) in kinds or c in turns) and c not in "\n\t"}


# -- terminals -------------------------------------------------------------------------------------


def verbs(clip, session, out):
    """Every command, once where it works and once where its words are wrong."""
    none, bad = out / "\x1b[31mnone\u202e.bvh", clip.parent / "\x1b]0;bad\x07.bvh"
    bad.write_bytes(b"HIERARCHY \x1b[31m\xff{}")
    named, truth = str(clip), out / "\x9btruth.json"
    found = out / "\x1b[2Jrefined.bvh"
    yield from (["info", named], ["info", named, bad, none], ["info", named, "--json"])
    yield from (["detect", named, "--explain"], ["detect", named, "--chain", "\x1b[1m"])
    yield from (["detect", named, bad, "--json"], ["signals", named, "--csv", out / "\x1bs.csv"])
    yield from (["signals", named, bad, "--json"], ["diff", named, SOURCE], ["diff", named, bad])
    yield ["refine", named, "-o", found, "--include-open", "--report", out, "-v"]
    yield from (["diff", named, found], ["diff", named, found, "--json"])
    yield ["apply", session, named, "-o", out / "\u202eapplied.bvh"]
    yield ["apply", session, SOURCE, "-o", out / "\u202eother.bvh"]
    yield ["apply", bad, named, "-o", out / "\u202eother.bvh"]
    yield ["report", session, "--clip", named, "-o", out, "--no-pictures"]
    yield ["inject", named, "-o", out / "\x1bi.bvh", "--truth", truth, "--seed", "1"]
    yield ["evaluate", "--truth", truth, "--clean", named, "--refined", out / "\x1bi.bvh"]
    yield ["evaluate", "--truth", bad, "--clean", named, "--refined", found]
    yield ["export", session, named, "--script", "blender", "-o", out / "\x1bkeys.py"]
    yield ["export", session, named, "--script", "maya", "--namespace", "\x1b", "-o", out / "m.py"]
    yield from (["convert", bad, "-o", out / "c.bvh", "--blender", "\x1b[31mno"],)
    yield ["clean", named, "-o", out / "\x1bc.bvh", "--order", "XYZ", "--rename", "smpl", "--json"]
    yield ["clean", named, "-o", out / "\x1bd.bvh", "--order", "\x1b[31m=XYZ"]
    yield ["clean", named, "-o", out / "\x1be.bvh", "--rename", bad]
    yield ["clean", named, "-o", out / "\x1bf.bvh", "--order", "XYZ", "--unroll", "--up", "Z"]
    files = ["--csv", out / "b.csv", "--junit", out / "b.xml", "--jsonl", out / "b.jsonl"]
    files += ["--annotations", "-", "--fail-if", "count<0"]
    yield ["watch", clip.parent, "-o", out / "\x1bw", "--once", "--every", "0.1", "--workers", "1"]
    yield ["batch", clip.parent, "-o", out / "\x1b[5mbatch", "--workers", "1", "--report", *files]
    yield ["batch", clip.parent, "-o", out / "b", "--fail-if", "\x1b[31m>1"]
    yield ["merge", out / "\x1b[5mbatch", "-o", out / "\x1bmerged"]
    yield ["merge", out / "\x1bnone", "-o", out / "\x1bother"]
    yield ["tune", bad, "-o", out / "t.json"]
    yield ["tune", "--sessions", clip.parent, "-o", out / "t.json"]
    yield ["benchmark", out / "\x1bnone", "--json", out / "x.json"]
    yield ["quamo", "refine", named, "-o", out / "\x1bq.bvh", "--joints", "\x1b[31m"]
    yield ["quamo", "noise", named, "-o", out / "\x1bn.bvh", "--seed", "1"]
    for name in ("evaluate", "ablation", "train"):
        yield ["quamo", name, out / "\x1bnone"]
    yield from (["completion", "\x1b"], ["\x1b[31m\u202e"], ["info", named, "--fps", "\x1b[1m"])


@pytest.mark.thorough
def test_no_command_lets_a_terminal_be_steered(capsys, monkeypatch, tmp_path, judged):
    """Nor does one write anywhere but where it was told to."""
    path, (clip, state) = judged
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    out.mkdir()
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    monkeypatch.setenv("HOME", str(elsewhere))
    session = path.with_suffix(".json")
    write_session(clip, state, session)
    said = 0
    for words in verbs(path, session, out):
        _, told, wrong = run(capsys, *words)
        said += len(told + wrong)
        assert not steered(told + wrong), words
        assert "Traceback" not in wrong, words
    assert said > 10_000
    written = {file for file in tmp_path.rglob("*") if file.is_file() and out not in file.parents}
    assert written == {path, session, path.parent / "\x1b]0;bad\x07.bvh"}
    assert not Path("/hostile-absolute").exists()


@pytest.mark.skipif(os.name != "posix", reason="no such terminals")
def test_nor_does_a_bar_on_a_terminal():
    import pty  # not on Windows
    import termios

    master, slave = pty.openpty()
    termios.tcsetwinsize(slave, (24, 200))
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root), "TERM": "dumb"}
    program = (
        "import time; from twistcore.cli.output import clip_progress_printer\n"
        "with clip_progress_printer(2) as tell: tell('\\x1b[31m\\u202e'); time.sleep(0.2); "
        "tell('\\x9b5m')\n"
    )
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=slave, stderr=slave, env=environment) as process:
        os.close(slave)
        told = b""
        try:
            while some := os.read(master, 65536):
                told += some
        except OSError:  # Linux says the end so
            pass
        os.close(master)
    text = told.decode("utf-8").replace("\r", "")
    assert "\\x9b5m" in text
    assert process.returncode == 0
    assert not steered(text)


# -- spreadsheets ----------------------------------------------------------------------------------


@given(st.text("=+-@\t\r\n;' a1,.e＝\"", max_size=8) | st.text() | st.sampled_from(TEXTS))
def test_a_cell_begins_no_formula_and_gives_its_text_again(text):
    shown = escape_csv_cell(text)
    assert unescape_csv_cell(shown) == text
    for part in shown.replace("\t", ";").replace("\r", ";").replace("\n", ";").split(";"):
        begins = part.lstrip(" ").startswith(FORMULA)
        assert not begins or (part == shown and float(part) == float(text))


@pytest.mark.parametrize("value", [-1.5, 0, None, True, "-1.5", "-2e-3", "12"])
def test_numbers_stay_numbers(value):
    assert escape_csv_cell(value) is value


def test_tables_begin_no_formula(capsys, tmp_path, judged):
    path, (clip, state) = judged
    _, page = written(tmp_path, clip, state)
    table = next(file for file in page if file.name.endswith(".csv"))
    records = [
        ClipRecord(name=text, source=text, state="failed", reason=text, sha256="") for text in TEXTS
    ]
    run(capsys, "signals", path, path, "--csv", tmp_path / "s.csv")
    texts = [table.read_text("utf-8"), clips_csv(records), (tmp_path / "s.csv").read_text("utf-8")]
    chains = set(clip.motion.skeleton.names)
    for text in texts:
        rows = list(csv.reader(io.StringIO(text, newline="")))
        assert len({len(row) for row in rows}) == 1
        for one in (value for row in rows for value in row):
            assert not one.startswith(FORMULA) or float(one) <= 0.0
    named = list(csv.DictReader(io.StringIO(texts[2], newline="")))
    expected = {n.encode("utf-8", "backslashreplace").decode() for n in chains}
    assert {unescape_csv_cell(row["chain"]) for row in named} <= expected


@pytest.mark.parametrize("text", TEXTS)
def test_a_profile_says_no_more_than_it_was_given(tmp_path, text):
    """Whatever its joints and the clips that it was tuned on are called."""
    path = tmp_path / "profile.toml"
    name = text if "\ud800" not in text else "x"
    write_profile(path, {name: Tuned(3.0, 1.5, 0, 0)}, f"{text}\n[Spine]\ntau_deg = 1", "paper")
    assert dict(read_profile(path).tau) == {name: pytest.approx(math.radians(3.0))}


# -- browsers --------------------------------------------------------------------------------------


class Tags(HTMLParser):
    """Every tag with its attributes, and what stands in scripts."""

    def __init__(self):
        super().__init__()
        self.tags = []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))


def written(folder, clip, state):
    chains = detect(clip, tau_degrees=4.0).chains_and_limbs
    target = folder / "report"
    target.mkdir()
    report = Report(clip, chains, state, clip.motion, name="report", by=TEXTS[8])
    return report, write_clip_report(target, report)


def test_a_page_has_the_tags_of_its_template_alone(tmp_path, judged):
    _, (clip, state) = judged
    _, files = written(tmp_path, clip, state)
    (page,) = [file for file in files if file.suffix == ".html"]
    tags = Tags()
    tags.feed(page.read_text("utf-8"))
    plain = read_clip(SOURCE)
    own = Tags()
    usual = Report(plain, detect(plain).chains_and_limbs, state_of(plain), plain.motion, name="own")
    own.feed(write_clip_report(tmp_path, usual)[0].read_text("utf-8"))
    assert {tag for tag, _ in tags.tags} <= {tag for tag, _ in own.tags}
    assert [t for t, _ in tags.tags].count("script") == [t for t, _ in own.tags].count("script")
    for tag, attributes in tags.tags:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            assert not (value or "").lower().lstrip().startswith(("javascript:", "file:", "http"))


def state_of(clip):
    return Review.of(detect(clip)).state


@pytest.mark.parametrize("name", ["../../out.bvh", "/etc/x.bvh", "a/../../b", *NAMES])
def test_a_page_of_a_clip_stands_below_its_report(name):
    """A manifest may say anything; its names differ."""
    page = PurePosixPath(clip_page_path(name))
    assert page.parts[0] == "clips"
    assert not {"..", "/"} & set(page.parts)
    assert all(len(part.encode("utf-8", "surrogatepass")) <= 255 for part in page.parts[-1:])
    assert clip_page_path(f"{name}x") != clip_page_path(name)


# -- programs --------------------------------------------------------------------------------------


@parametrize("program", PROGRAMS)
def test_a_script_is_data_and_its_own_code(judged, program):
    """The same statements as of harmless names; what differs are literals."""
    _, (clip, state) = judged
    plain = read_clip(SOURCE)
    made = [shape_of_script(clip, state, program), shape_of_script(plain, state, program)]
    assert made[0] == made[1]


def shape_of_script(clip, state, program):
    chains = detect(clip, tau_degrees=4.0).chains
    moved = refine(clip.motion, chains, [new_constant_offset_interval(chains[0].name, 20, 30, 0.5)])
    text = scene_script(clip.name, clip.motion, moved, state.intervals[:2], SceneOptions(program))
    assert not steered(text)
    return [(type(node).__name__, getattr(node, "name", "")) for node in ast.parse(text).body]


@parametrize("text", SINGLE, quick=6)
def test_marks_for_blender_run_as_data(monkeypatch, judged, text):
    _, (_, state) = judged
    script = blender_markers(text, state.intervals, lambda _: text)
    names = []
    scene = SimpleNamespace(
        frame_start=1,
        timeline_markers=SimpleNamespace(new=lambda name, frame: names.append((name, frame))),
    )
    monkeypatch.setitem(sys.modules, "bpy", SimpleNamespace(context=SimpleNamespace(scene=scene)))
    assert not steered(script)
    exec(compile(script, "markers.py", "exec"), {})
    assert len(names) == 2 * len(state.intervals)
    assert all(text in name for name, _ in names)


@pytest.mark.parametrize("text", TEXTS)
def test_junit_is_xml_of_the_same_elements(text):
    records = [
        ClipRecord(name=text, source=text, state="failed", reason=text, sha256=""),
        ClipRecord(name=f"x/{text}", source=text, state="waiting", reason="", sha256=""),
    ]
    root = ElementTree.fromstring(junit_xml(records, [], []))
    assert [e.tag for e in root.iter()] == [
        "testsuites", "testsuite", "testcase", "error", "testcase", "skipped",
    ]  # fmt: skip
