"""What pages tell people to type is understood, and what is cheap is typed: commands and Python."""

from __future__ import annotations

import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.tiers import parametrize
from tests.twistcore.amass_files import amass_arrays
from twistcore.cli import main
from twistcore.detection import DETECTORS
from twistcore.report import picture_job
from twistcore.report.picture_job import Drawn

ROOT = Path(__file__).parents[1]
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
NAMES = [page.relative_to(ROOT).as_posix() for page in PAGES]
FENCED = re.compile(r"^( *)```+(\S*)\n(.*?)^\1```+$", re.DOTALL | re.MULTILINE)
SHELLS = ("", "sh", "bash", "console", "yaml")  # without a name: also what is laid out by hand
PROGRAMS = ("twistcore", "twist-inspector")
DEV = re.search(r"^COMMANDS = \{(.*?)^\}", (ROOT / "dev.py").read_text("utf-8"), re.S | re.M)
# As the page of commands is made.
MARKS = re.findall(r"<!-- commands of (\S+):(\S+) -->", (ROOT / "docs/cli.md").read_text("utf-8"))
PARSERS = {
    program: getattr(import_module(module), name)
    for program, (module, name) in zip(PROGRAMS, MARKS, strict=True)
}
# What people put their own in for: files are made for those that can be tried.
STANDS_FOR = {
    "CLIP": "walk_injected.bvh", "CLIP.bvh": "walk_injected.bvh", "A.bvh": "walk.bvh",
    "B.bvh": "walk_injected.bvh", "SESSION": "SESSION.twist.json", "take.bvh": "walk_injected.bvh",
    "mine.bvh": "walk_injected.bvh",
    "walk_injected_refined.bvh": "walk.bvh",
    "assets/walk_injected.bvh": "walk_injected.bvh", "assets/walk.bvh": "walk.bvh",
}  # fmt: skip
NUMBERS = {"HZ", "METRES", "SECONDS", "N", "DEG", "X"}
TRIED = {"info", "detect", "signals", "refine", "apply", "inject", "evaluate", "diff", "export"}
# Options of programs that are not ours.
OTHERS = {
    *("--array", "--nworkers", "--nthreads"),  # Slurm, Dask
    *("--fix", "--strict", "--no-sandbox"),  # ruff, mypy, twine, pip-audit; Chromium
    *("--disable-pip", "--enable-gpl", "--enable-version"),  # pip-audit; ffmpeg's own words
}


def blocks(page: Path, *languages: str) -> Iterator[str]:
    """The fenced blocks of a page in some languages."""
    for indent, language, text in FENCED.findall(page.read_text("utf-8")):
        if language in languages:
            yield re.sub(rf"^{indent}", "", text, flags=re.MULTILINE)


def commands(text: str) -> Iterator[list[str]]:
    """The words of every command in a block that is ours, with what a shell would put in."""
    text = re.sub(r"\\\n\s*|\n(?= +[-\[])", " ", text)
    for line in text.splitlines():
        line = re.sub(r"^\s*(\$|- run:|run:|-) ", "", line.rstrip())
        line = re.sub(r"\$\{?\w+\}?", "3", line)
        line = re.sub(r"(?<=[\w.])\|[\w.]\S*", "", line)  # A|B: either
        line = re.sub(r"\[(--[^]]*)\]", r"\1", line)  # may be left out
        if not re.search(r"\b(twistcore|twist-inspector|dev\.py)\s", line + " "):
            continue
        lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
        lexer.whitespace_split = True
        words: list[str] = []
        for word in [*lexer, ";"]:
            if not set(word) <= set(";|&<>()"):
                words.append("30" if word in NUMBERS else word)
                continue
            if words[:1] and (words[0] in PROGRAMS or words[:2] == ["python3", "dev.py"]):
                yield words
            words = []


def said(page: Path) -> list[list[str]]:
    return [words for text in blocks(page, *SHELLS) for words in commands(text)]


def options(parser: argparse.ArgumentParser) -> set[str]:
    """All options of a parser and of those below it."""
    found = set(parser._option_string_actions)
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found |= {word for below in action.choices.values() for word in options(below)}
    return found


def is_listed(words: list[str]) -> bool:
    """A table of commands says their names alone."""
    return words == ["twistcore"] or words[-1] in ("…", "...")


@pytest.mark.parametrize("name", NAMES)
def test_commands_are_understood(name, capsys):
    for words in said(ROOT / name):
        if words[0] == "python3":
            assert DEV
            assert f'"{words[2]}":' in DEV[1] + '"setup":', words
        elif not is_listed(words) and not {"--version", "--help", "-h"} & set(words):
            parser = PARSERS[words[0]]()
            try:
                parser.parse_args(words[1:])
            except SystemExit:
                pytest.fail(f"{shlex.join(words)}: {capsys.readouterr().err}")


def test_commands_are_found_at_all():
    """Else a page whose blocks are read wrongly would pass."""
    text = (
        "$ twistcore info A.bvh | head\n- run: twistcore batch a \\\n  -o b && twistcore diff a b"
    )
    assert list(commands(text)) == [
        ["twistcore", "info", "A.bvh"],
        ["twistcore", "batch", "a", "-o", "b"],
        ["twistcore", "diff", "a", "b"],
    ]
    assert list(commands("twistcore report SESSION|OUTDIR -o DIR [--clip CLIP]   # x")) == [
        ["twistcore", "report", "SESSION", "-o", "DIR", "--clip", "CLIP"]
    ]
    assert len(said(ROOT / "README.md")) > 2
    assert len(said(ROOT / "docs" / "batch.md")) > 8


@pytest.mark.parametrize("name", NAMES)
def test_options_in_the_text_exist(name):
    known = set().union(*(options(make()) for make in PARSERS.values())) | OTHERS
    programs = ("benchmarks/*.py", "checkout/*.py", "tests/fuzz/*.py")
    for script in (ROOT / "dev.py", *(file for some in programs for file in ROOT.glob(some))):
        known |= set(re.findall(r'"(--[a-z][a-z-]+)"', script.read_text("utf-8")))
    text = (ROOT / name).read_text("utf-8")
    code = re.findall(r"`[^`\n]+`", FENCED.sub("", text))
    code += [word for words in said(ROOT / name) for word in words]
    used = {option for part in code for option in re.findall(r"(?<![\w-])--[a-z][a-z-]+", part)}
    assert used <= known


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with the clips that pages speak of, and the session of a review."""
    for clip in ("walk", "walk_injected"):
        shutil.copy(ASSETS / f"{clip}.bvh", tmp_path)
    shutil.copy(ASSETS / "walk_injected.truth.json", tmp_path / "T.json")
    (tmp_path / "captures").mkdir()
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "captures" / "wrong.bvh")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write_a_session(place: Path) -> tc.Review:
    clip = tc.read_clip(place / "walk_injected.bvh")
    review = tc.Review.of(tc.detect(clip))
    review.accept()
    tc.write_session(clip, review.state, place / "SESSION.twist.json")
    return review


def tried(words: list[str]) -> list[str] | None:
    """The words with files in place of what stands for them; None if that is not cheap to try.

    What reads standard input has another command before it.
    """
    if words[0] != "twistcore" or words[1] not in TRIED or is_listed(words) or "-" in words:
        return None
    own = [STANDS_FOR.get(word, word) for word in words[1:]]
    inputs = [w for w in own[1:] if re.search(r"\.(bvh|npz|amc|fbx|twist\.json)$", w)]
    written = {own[k + 1] for k, w in enumerate(own[:-1]) if w in ("-o", "--output")}
    known = {"walk.bvh", "walk_injected.bvh", "SESSION.twist.json", "OUT.bvh"}
    return own if set(inputs) - written <= known else None


TO_TRY = sorted({tuple(own) for page in PAGES for words in said(page) if (own := tried(words))})


def test_cheap_commands_do_what_they_say(place, capsys, monkeypatch):
    write_a_session(place)
    shutil.copy(ROOT / "docs" / "example_detector" / "steps_detector.py", place)
    monkeypatch.setattr(DETECTORS, "_given", {})  # what a command registers
    # What was decided of a folder, which is a delivery once it is applied: it comes before `diff`.
    shutil.copy(place / "SESSION.twist.json", place / "captures" / "wrong.twist.json")
    assert {words[0] for words in TO_TRY} >= {"detect", "refine", "diff", "apply"}
    for words in TO_TRY:
        for old in place.glob("OUT*"):
            shutil.rmtree(old) if old.is_dir() else old.unlink()
        if "evaluate" in words:
            shutil.copy(place / "walk.bvh", place / "OUT.bvh")
        code = main(list(words))
        told = capsys.readouterr()
        assert code == 0 or (code == 1 and "--fail-over" in words), (words, told.err)
        if "--json" in words:
            assert json.loads(told.out)["schema"].startswith("twistcore.")


# -- Python -------------------------------------------------------------------------------------


def of_a_chain(place: Path) -> dict[str, object]:
    """A parent and its child in frames with an error."""
    truth = json.loads((place / "T.json").read_text("utf-8"))["errors"][0]
    motion = tc.read_clip(place / "walk_injected.bvh").motion
    chain = next(c for c in tc.find_chains(motion) if c.name == truth["chain"])
    first, last = truth["start"] - 5, truth["stop"] + 5
    at = np.zeros(last - first)
    at[5:-5] = 1.0
    q_p, q_c = (motion.rotations[first:last, j] for j in (chain.parent, chain.child))
    return {"q_p": q_p, "q_c": q_c, "axis": chain.axis, "at": at}


def with_a_review(place: Path) -> dict[str, object]:
    """What a report is made of, and a batch's folder."""
    clip = tc.read_clip(place / "walk_injected.bvh")
    review, chains = write_a_session(place), tc.analyse(clip).chains_and_limbs
    assert main(["batch", "captures", "-o", "OUTDIR", "--workers", "1"]) == 0
    refined = tc.refine(clip.motion, chains, review.accepted)
    return {"clip": clip, "chains": chains, "review": review, "refined": refined}


def with_a_batch(place: Path) -> dict[str, object]:
    assert main(["batch", "captures", "-o", "out", "--workers", "1"]) == 0
    return {}


def with_poses(place: Path) -> dict[str, object]:
    arrays = amass_arrays(tc.read_clip(place / "walk.bvh").motion, own=False)
    np.savez(place / "walk_poses.npz", **arrays)
    return {"numpy": np, "joints_at_rest": np.zeros((22, 3))}


def with_a_table(place: Path) -> dict[str, object]:
    pytest.importorskip("pandas", reason="pandas is not here; its words are looked at all the same")
    assert main(["batch", "captures", "-o", "out", "--parquet", "results.parquet"]) == 0
    return {}


MADE_BEFORE = {
    "docs/amass.md": with_poses,
    "docs/batch.md": with_a_batch,
    "docs/gates.md": with_a_table,
    "docs/method.md": of_a_chain,
    "docs/report.md": with_a_review,
}
# The README's are run, and what comes of them is looked at, in tests/twistcore/test_notebook.py.
SCRIPTED = [n for n in NAMES if n != "README.md" and list(blocks(ROOT / n, "python"))]
SCRIPTED.sort(key="docs/report.md".__eq__)  # takes longest


@parametrize("name", SCRIPTED, quick=2)
def test_python_runs(name, place, monkeypatch):
    monkeypatch.setattr(
        picture_job, "draw_figures", lambda figures, *_: [Drawn({}, "not now")] * len(figures)
    )
    names = MADE_BEFORE[name](place) if name in MADE_BEFORE else {}
    for script in blocks(ROOT / name, "python"):
        exec(compile(script, name, "exec"), names)


def test_a_loss_followed_downhill_finds_the_offset(place):
    """What the page of the method says of its script."""
    names = of_a_chain(place)
    (script,) = blocks(ROOT / "docs" / "method.md", "python")
    exec(script, names)
    error = json.loads((place / "T.json").read_text("utf-8"))["errors"][0]
    assert np.degrees(float(str(names["offset"]))) == pytest.approx(error["offset_deg"][0], abs=5.0)


@pytest.mark.thorough
def test_scripts_of_a_table_name_its_columns(place):
    """Where pandas is not there to run them."""
    main(["batch", "captures", "-o", "out", "--workers", "1", "--parquet", "results.parquet"])
    program = "import sys, pyarrow.parquet as p; print(*p.read_schema(sys.argv[1]).names)"
    found = subprocess.run([sys.executable, "-c", program, "results.parquet"], text=True,
                           capture_output=True, check=True)  # fmt: skip
    (script,) = blocks(ROOT / "docs" / "gates.md", "python")
    named = set(re.findall(r'"(\w+)"', script))
    assert named <= set(found.stdout.split())
