#!/usr/bin/env python3
"""Make a folder that runs without Python: `python3 packaging/build_bundle.py`.

Takes a Python ≥ 3.11 with its shared library, on Linux `binutils`, and some 3 GB of disk. What
bundle.lock names, by its hashes, and the wheel are installed into an environment of its own under
packaging/build; PyInstaller gathers them into packaging/dist/twist-inspector, which is packed
beside it. A bundle runs on systems with the glibc of its builder or a newer one, so build on the
oldest meant.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import venv
from importlib.metadata import Distribution, distributions
from pathlib import Path
from sysconfig import get_path as stdlib_folder

from list_licences import PAGE, TABLE, key, licence, shipped

ROOT = Path(__file__).resolve().parents[1]
HERE = ROOT / "packaging"
BUILD, DIST = HERE / "build", HERE / "dist"
LOCK = HERE / "bundle.lock"
ICON = ROOT / "assets" / "icons" / "program.svg"
ICON_SIZE = 512
_LICENCE = re.compile(r"licen[cs]e|copying|notice", re.IGNORECASE)
_DRAW = """
import sys
from PySide6.QtGui import QGuiApplication, QIcon
app = QGuiApplication([])
assert QIcon(sys.argv[1]).pixmap(int(sys.argv[3])).save(sys.argv[2])
"""


def main() -> int:
    """Build, pack and say where it is; returns the exit code."""
    shutil.rmtree(BUILD, ignore_errors=True)
    shutil.rmtree(DIST, ignore_errors=True)
    python = environment()
    draw_icon(python)
    gather = [python, "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN"]
    run(*gather, "--distpath", DIST, "--workpath", BUILD / "work", HERE / "twist-inspector.spec")
    folder = DIST / "twist-inspector"
    add_papers(folder)
    name = f"twist-inspector-{version()}-{sys.platform}-{platform.machine().lower()}"
    kind = "zip" if os.name == "nt" else "gztar"
    packed = Path(shutil.make_archive(str(DIST / name), kind, DIST, folder.name))
    print(f"{folder}: {size(folder):,.0f} MB")
    print(f"{packed}: {packed.stat().st_size / 1e6:,.0f} MB")
    return 0


def environment() -> Path:
    """An environment with the wheel, not the checkout, and PyInstaller; returns its Python."""
    BUILD.mkdir()
    venv.create(BUILD / "venv", with_pip=True)
    python = BUILD / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    pip = (python, "-m", "pip", "install", "--quiet")
    run(*pip, "--require-hashes", "--requirement", LOCK)
    build = (python, "-m", "build", "--wheel", "--no-isolation")
    run(*build, "--outdir", BUILD / "wheel", ROOT)
    (wheel,) = (BUILD / "wheel").glob("*.whl")
    run(*pip, "--no-deps", wheel)
    return python


def draw_icon(python: Path) -> None:
    """The icon as a picture: PyInstaller makes Windows' and macOS' own kinds of it."""
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    run(python, "-c", _DRAW, ICON, BUILD / "icon.png", ICON_SIZE, env=env)


def add_papers(folder: Path) -> None:
    """Licence and what belongs into a desktop's menu."""
    shutil.copy(ROOT / "LICENSE", folder)
    copy_licences(folder / "licences")
    if sys.platform == "linux":
        shutil.copy(HERE / "linux" / "install.sh", folder)
        share = folder / "share"
        share.mkdir()
        for name in ("twist-inspector.desktop", "twist-inspector-mime.xml"):
            shutil.copy(HERE / "linux" / name, share)
        shutil.copy(ICON, share / "twist-inspector.svg")


def copy_licences(target: Path) -> None:
    """The licence files of every package that is in it, by the package's name, and Python's."""
    (site,) = (BUILD / "venv").rglob("site-packages")
    there = {key(known.metadata["Name"]): known for known in distributions(path=[str(site)])}
    for name in shipped(LOCK.read_text("utf-8")):
        if name in there:  # else another system's
            copy_licence_files(there[name], target / name)
    shutil.copytree(HERE / "licences", target, dirs_exist_ok=True)  # that Qt's wheels only name
    shutil.copy(PAGE, target / "README.md")
    (target / "tables").mkdir()  # where the page links to it
    shutil.copy(TABLE, target / "tables")
    for folder in (Path(sys.base_prefix), Path(stdlib_folder("stdlib"))):
        if (folder / "LICENSE.txt").exists():
            shutil.copy(folder / "LICENSE.txt", target / "Python.txt")


def copy_licence_files(known: Distribution, target: Path) -> None:
    """Into the folder, each under the path that it has: numpy brings twenty of one name."""
    for file in known.files or ():
        if _LICENCE.search(file.name) and file.suffix not in {".py", ".pyc", ".pyi"}:
            place = Path(*(part for part in file.parts if part not in {"licenses", ".."}))
            to = target / (Path(*place.parts[1:]) if ".dist-info" in place.parts[0] else place)
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(str(file.locate()), to)
    if not target.exists():  # some packages name it only
        target.mkdir(parents=True)
        told = licence(known.metadata["Name"], known.metadata)
        (target / "LICENCE.txt").write_text(told + "\n", "utf-8")


def version() -> str:
    """The version as the package has it."""
    text = (ROOT / "twistcore" / "files" / "version.py").read_text("utf-8")
    found = re.search(r'__version__ = "([^"]+)"', text)
    assert found, "twistcore/files/version.py has no version"
    return found[1]


def size(folder: Path) -> float:
    """Megabytes of a folder's files."""
    return sum(f.stat().st_size for f in folder.rglob("*") if not f.is_symlink()) / 1e6


def run(*words: object, env: dict[str, str] | None = None) -> None:
    """Carry out a command; one that fails ends the build."""
    print("+", *words, flush=True)
    # Not in the checkout, whose packages Python would find before the installed wheel's.
    subprocess.run([str(word) for word in words], check=True, env=env, cwd=BUILD)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except subprocess.CalledProcessError as error:
        sys.exit(f"The bundle was not built: {error}")
