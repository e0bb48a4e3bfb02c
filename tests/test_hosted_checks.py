"""The pre-commit hook and the GitHub action, run as their hosts run them."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from tests.conftest import ASSETS

yaml = pytest.importorskip("yaml", reason="comes with the packages for clusters and for the site")
ROOT = Path(__file__).resolve().parents[1]
DIRTY, CLEAN = ASSETS / "walk_injected.bvh", ASSETS / "walk.bvh"
[HOOK] = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
INSTALL, EXAMINE = (step for step in ACTION["runs"]["steps"] if "run" in step)
pytestmark = pytest.mark.skipif(
    os.name != "posix" or not (shutil.which("bash") and shutil.which("git")),
    reason="needs bash and git",
)


@pytest.fixture
def checkout(tmp_path):
    """A repository of captures, and an environment in which `twistcore` is this checkout."""
    commands, folder = tmp_path / "bin", tmp_path / "checkout"
    commands.mkdir()
    (folder / "takes").mkdir(parents=True)
    (commands / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (commands / "twistcore").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m twistcore "$@"\n')
    for command in commands.iterdir():
        command.chmod(0o755)
    path = f"{commands}{os.pathsep}{os.environ['PATH']}"
    env = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
    return SimpleNamespace(folder=folder, env=env, temporary=tmp_path)


# -- hook ------------------------------------------------------------------------------------------


def changed(folder):
    """The staged files that pre-commit would pass to the hook."""
    words = ["git", "diff", "--cached", "--name-only", "--diff-filter=ACMRT", "-z"]
    names = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=True).stdout
    return [name for name in names.split("\0") if name and re.search(HOOK["files"], name)]


def hooked(checkout, *args):
    """The hook's exit code and output, as of pre-commit: entry, arguments, files."""
    subprocess.run(["git", "add", "-A"], cwd=checkout.folder, check=True)
    if not (names := changed(checkout.folder)):
        return 0, ""
    words = [*shlex.split(HOOK["entry"]), *(args or HOOK["args"]), *names]
    done = subprocess.run(
        words, cwd=checkout.folder, env=checkout.env, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    return done.returncode, done.stdout


@pytest.mark.thorough
def test_the_hook_stops_a_commit_with_a_bad_capture(checkout):
    assert HOOK["require_serial"]
    subprocess.run(["git", "init", "-q", checkout.folder], check=True)
    (checkout.folder / "notes.txt").write_text("no capture")
    assert hooked(checkout) == (0, "")
    shutil.copy(CLEAN, checkout.folder / "takes" / "good 1%.bvh")
    assert hooked(checkout) == (0, "")
    shutil.copy(DIRTY, checkout.folder / "takes" / "BAD.BVH")
    code, said = hooked(checkout)
    assert code == 1
    assert "BAD.BVH: " in said
    assert "'severity>5'" in said
    assert "good" not in said
    assert hooked(checkout, "--fail-if", "severity>500")[0] == 0
    assert hooked(checkout, "--fail-if", "severity")[0] == 2
    kept = {path.name for path in checkout.folder.rglob("*") if ".git" not in path.parts}
    assert kept == {"takes", "notes.txt", "good 1%.bvh", "BAD.BVH"}  # nothing is left behind


# -- action ----------------------------------------------------------------------------------------


def stepped(checkout, step, **inputs):
    """Run a step as GitHub's runner does; exit code, commands that it obeys, summary."""
    given = {name: str(about["default"]) for name, about in ACTION["inputs"].items()} | inputs
    put = {k: re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda found: given[found[1]], v)
           for k, v in step["env"].items()}  # fmt: skip
    assert "${{" not in step["run"] + "".join(put.values())
    script, summary = checkout.temporary / "step.sh", checkout.temporary / "summary.md"
    script.write_text(step["run"])
    host = {"RUNNER_TEMP": checkout.temporary, "GITHUB_STEP_SUMMARY": summary}
    host |= {"GITHUB_ACTION_PATH": ROOT, "GITHUB_WORKSPACE": checkout.folder, "CI": "true"}
    summary.unlink(missing_ok=True)
    summary.touch()
    done = subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", script], cwd=checkout.folder,
        env={**checkout.env, **{k: str(v) for k, v in host.items()}, **put}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    return done.returncode, obeyed(done.stdout.splitlines()), summary.read_text("utf-8")


def obeyed(lines):
    """The lines that a runner takes as commands, until a command stops this."""
    token, commands = "", []
    for line in lines:
        if token:
            token = "" if line.strip() == f"::{token}::" else token
        elif line.startswith("::stop-commands::"):
            token = line.removeprefix("::stop-commands::")
        elif line.lstrip().startswith("::"):
            commands.append(line)
    assert not token
    return commands


@pytest.mark.thorough
def test_the_action_shows_broken_rules_at_their_files(checkout):
    shutil.copy(CLEAN, checkout.folder / "takes" / "good.bvh")
    shutil.copy(DIRTY, checkout.folder / "takes" / "::error::a,b\n::warning::.bvh")
    (checkout.folder / "takes" / "# [x](y).bvh").write_text("no clip")
    rules = "severity>5\n\n  \nfailed>0\n"
    code, commands, summary = stepped(checkout, EXAMINE, **{"fail-if": rules})
    assert code == 1
    assert [command.split("::")[1].split(",title")[0] for command in commands] == [
        "error file=takes/# [x](y).bvh",
        "error file=takes/%3A%3Aerror%3A%3Aa%2Cb%0A%3A%3Awarning%3A%3A.bvh",
        "error title=failed>0",
    ]
    assert "title=severity>5::" in commands[1]
    head, *lines = summary.splitlines()
    assert head == "### Captures: failed"
    assert [line for line in lines if line and not line.startswith("    ")] == []
    assert "'severity>5'" in summary
    assert "clips/s" not in summary
    cases = ElementTree.parse(checkout.folder / "twistcore.xml").iter("testcase")
    assert len([*cases]) == 3 + 1
    assert {p.name for p in checkout.folder.iterdir()} == {"takes", "twistcore.xml"}


@pytest.mark.thorough
def test_the_action_passes_what_is_fine_and_refuses_what_is_wrong(checkout):
    shutil.copy(CLEAN, checkout.folder / "takes" / "good.bvh")
    code, commands, summary = stepped(checkout, EXAMINE, folder="takes", junit="results.xml")
    assert (code, commands) == (0, [])
    assert summary.startswith("### Captures: passed\n")
    assert (checkout.folder / "results.xml").exists()
    wrong = {"folder": "--none"}, {"fail-if": "severity>many"}, {"fail-if": "$(touch x)"}
    for inputs in wrong:
        code, commands, summary = stepped(checkout, EXAMINE, **inputs)
        assert (code, len(commands)) == (2, int("folder" in inputs))
        assert summary.startswith("### Captures: failed\n")
    assert not (checkout.folder / "x").exists()


@pytest.mark.thorough
def test_the_action_installs_itself(checkout):
    place = checkout.temporary / "installed"
    checkout.env |= {"PIP_TARGET": str(place), "PIP_NO_DEPS": "1", "PIP_NO_INDEX": "1"}
    checkout.env |= {"PIP_NO_BUILD_ISOLATION": "0"}  # in pip's spelling: do not isolate
    assert stepped(checkout, INSTALL)[0] == 0
    assert (place / "bin" / "twistcore").exists()
    assert (place / "twistcore" / "cli" / "watch_command.py").exists()
