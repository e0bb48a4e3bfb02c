"""Whatever is done with clips works with the network cut off, and no network socket is opened.

Twice over: in a network namespace of its own there is nothing to reach, and each process, with
those that it starts, writes down what it opens: Python by an audit hook, and where strace is
installed native libraries as well.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from checkout import screens
from inspector.system_libraries import has_screen
from tests.conftest import ASSETS
from tests.tiers import parametrize

ROOT = Path(__file__).resolve().parents[1]
# AF_UNIX is the screen's, the desktop's, or a process's of ours.
TRAP = """
import os, socket, sys
FILE, MINE = os.environ["SOCKETS_SEEN"], {socket.AF_UNIX}
def seen(event, args):
    if event == "socket.__new__":
        told = args[1] not in MINE
    elif event in {"socket.connect", "socket.bind", "socket.sendto", "socket.sendmsg"}:
        told = getattr(args[0], "family", None) not in MINE
    else:
        told = event in {"socket.getaddrinfo", "socket.gethostbyname", "urllib.Request"}
    if told:
        with open(FILE, "a") as file:
            print(event, args[1:], file=file)
sys.addaudithook(seen)
"""
INET = re.compile(r"socket\((AF_INET6?|AF_PACKET)\b|connect\(.*sa_family=AF_INET6?")


def cut_off() -> list[str]:
    """The words that start a command without a network; empty where the system allows none."""
    unshare = shutil.which("unshare")
    for words in ([unshare, "-n"], [unshare, "-r", "-n"]) if unshare else ():
        code = "import socket; socket.create_connection(('127.0.0.1', 9), 1)"
        tried = [*words, sys.executable, "-c", code]
        if b"Network is unreachable" in subprocess.run(tried, capture_output=True).stderr:
            return words
    return []


WORDS = cut_off() if sys.platform.startswith("linux") else []
pytestmark = pytest.mark.skipif(not WORDS, reason="no network namespaces here (unshare -n)")


@pytest.fixture
def run(tmp_path):
    """Run a module of ours, cut off and watched; fail where it fails or opens a network socket."""
    (tmp_path / "trap").mkdir()
    (tmp_path / "trap/sitecustomize.py").write_text(TRAP)
    seen, traced = tmp_path / "seen", tmp_path / "traced"
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path)
    strace = shutil.which("strace")
    watch = [strace, "-f", "--seccomp-bpf", "-e", "trace=socket,connect", "-o", str(traced)]

    def run(*words: str, env: dict[str, str] | None = None, fails: bool = False) -> str:
        env = {**(env or os.environ), "PYTHONPATH": f"{tmp_path / 'trap'}{os.pathsep}{ROOT}"}
        command = [*WORDS, *(watch if strace else []), sys.executable, *words]
        done = subprocess.run(
            command,
            env=env | {"SOCKETS_SEEN": str(seen)},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert (done.returncode != 0) == fails, done.stdout + done.stderr
        lines = seen.read_text().splitlines() if seen.exists() else []
        told = traced.read_text().splitlines() if traced.exists() else []
        return "\n".join([*lines, *filter(INET.search, told)])

    return run


def test_the_watch_sees_a_socket_in_this_process_and_in_one_that_it_starts(run):
    code = "import socket; socket.create_connection(('192.0.2.1', 9), 1)"
    assert "socket.connect" in run("-c", code, fails=True)
    again = "import subprocess, sys; sys.exit(subprocess.call([sys.executable, '-c', sys.argv[1]]))"
    assert run("-c", again, code, fails=True).count("socket.connect") >= 2


@parametrize(
    "words",
    [
        ("detect", "walk_injected.bvh"),
        ("refine", "walk_injected.bvh", "-o", "out.bvh"),
        ("quamo", "refine", "walk_injected.bvh", "-o", "out.bvh"),
        ("batch", ".", "-o", "out", "--refine", "--report", "--workers", "2"),
    ],
    ids=lambda words: words[0],
)
def test_commands_need_no_network(run, words):
    assert run("-m", "twistcore", *words) == ""


@pytest.mark.thorough
@pytest.mark.skipif(not has_screen() and not shutil.which("Xvfb"), reason="needs a screen, or Xvfb")
def test_the_window_its_session_and_report_need_no_network(run, tmp_path):
    with screens.screen() as env:
        home = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)}
        assert run("-m", "inspector", "walk_injected.bvh", "--demo", "shown", env=env | home) == ""
    assert (tmp_path / "shown").is_dir()
    (session,) = tmp_path.rglob("*.twist.json")
    clip = ("--clip", "walk_injected.bvh")
    assert run("-m", "twistcore", "report", str(session), "-o", "pages", *clip) == ""
    assert [*(tmp_path / "pages").rglob("*.html")]
