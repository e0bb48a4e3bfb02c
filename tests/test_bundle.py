"""The bundle's own parts: what its programs start with, and its place in a desktop's menu."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
START = ROOT / "packaging" / "bundle_start.py"
LINUX = ROOT / "packaging" / "linux"
linux_only = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="a desktop of Linux")


def start(*words: str) -> subprocess.CompletedProcess[str]:
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, str(START), *words], env=env, capture_output=True, text=True, check=False
    )


def test_a_bundle_is_the_python_of_its_own_processes() -> None:
    assert start("-c", "import sys; print(sys.argv)", "x").stdout == "['-c', 'x']\n"
    module = start("-m", "twistcore", "info", str(ROOT / "assets" / "walk.bvh"))
    assert module.returncode == 0
    assert "walk.bvh: 344 frames" in module.stdout


def test_a_bundle_runs_no_other_modules() -> None:
    other = start("-m", "http.server")  # the words go to the program, which does not know them
    assert other.returncode == 2
    assert "Serving" not in other.stdout


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    folder = tmp_path / "a bundle"
    (folder / "share").mkdir(parents=True)
    shutil.copy(LINUX / "install.sh", folder)
    for name in ("twist-inspector.desktop", "twist-inspector-mime.xml"):
        shutil.copy(LINUX / name, folder / "share")
    shutil.copy(ROOT / "assets" / "icons" / "program.svg", folder / "share" / "twist-inspector.svg")
    for name in ("twist-inspector", "twistcore"):
        (folder / name).write_text("#!/bin/sh\necho ours\n")
        (folder / name).chmod(0o755)
    return folder


def install(bundle: Path, *words: str) -> subprocess.CompletedProcess[str]:
    env = {"PATH": os.environ["PATH"], "HOME": str(bundle.parent / "home")}
    command = ["sh", str(bundle / "install.sh"), *words]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False)


@linux_only
def test_into_the_menu_and_out_of_it(bundle: Path) -> None:
    home = bundle.parent / "home"
    for _ in range(2):
        assert install(bundle).returncode == 0
    entry = home / ".local/share/applications/twist-inspector.desktop"
    assert f'Exec="{bundle}/twist-inspector" %f' in entry.read_text("utf-8")
    assert "*.bvh" in (home / ".local/share/mime/packages/twist-inspector.xml").read_text("utf-8")
    assert subprocess.check_output([home / ".local/bin/twist-inspector"], text=True) == "ours\n"
    assert install(bundle, "--remove").returncode == 0
    ours = [f for f in home.rglob("*") if "twist" in f.name]
    assert ours == []


@linux_only
def test_what_is_not_ours_stays(bundle: Path) -> None:
    other = bundle.parent / "home" / ".local/bin/twistcore"
    other.parent.mkdir(parents=True)
    other.write_text("theirs")
    done = install(bundle)
    assert done.returncode == 1
    assert str(other) in done.stderr
    assert not (bundle.parent / "home/.local/share/applications").exists()
    assert install(bundle, "--remove").returncode == 1
    assert other.read_text() == "theirs"


@linux_only
def test_a_bundle_that_was_moved_takes_its_links_along(bundle: Path) -> None:
    install(bundle)
    moved = bundle.rename(bundle.with_name("moved"))
    assert install(moved).returncode == 0
    link = bundle.parent / "home/.local/bin/twistcore"
    assert link.resolve() == moved / "twistcore"
