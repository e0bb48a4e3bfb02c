#!/usr/bin/env python3
"""Build a folder with the program that runs without Python: `python3 packaging/build_bundle.py`.

This needs Python ≥ 3.11 with its shared library, about 3 GB of disk and, on Linux, `binutils`. The
packages in bundle.lock, checked by their hashes, and the wheel are installed into a new environment
in packaging/build. PyInstaller collects them in packaging/dist/twist-inspector, and the folder is
also packed into an archive next to it. A bundle runs on systems with the same glibc as the build
machine or a newer one, so build it on the oldest system to support.
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
    """Build and pack the bundle, print its paths and sizes, and return the exit status."""
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
    """Create an environment with PyInstaller and the wheel. Return the path of its Python.

    The program is installed from the wheel, not from the checkout.
    """
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
    """Draw the icon as a PNG file, which PyInstaller converts for Windows and macOS."""
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    run(python, "-c", _DRAW, ICON, BUILD / "icon.png", ICON_SIZE, env=env)


def add_papers(folder: Path) -> None:
    """Add the licences and, on Linux, the files for the desktop's menu."""
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
    """Copy the licence files of Python and of every package in the bundle.

    Each package has a folder of its name in `target`.
    """
    (site,) = (BUILD / "venv").rglob("site-packages")
    there = {key(known.metadata["Name"]): known for known in distributions(path=[str(site)])}
    for name in shipped(LOCK.read_text("utf-8")):
        if name in there:  # packages for other systems are not installed
            copy_licence_files(there[name], target / name)
    shutil.copytree(HERE / "licences", target, dirs_exist_ok=True)  # Qt's wheels only name these
    shutil.copy(PAGE, target / "README.md")
    (target / "tables").mkdir()  # the page links to this folder
    shutil.copy(TABLE, target / "tables")
    for folder in (Path(sys.base_prefix), Path(stdlib_folder("stdlib"))):
        if (folder / "LICENSE.txt").exists():
            shutil.copy(folder / "LICENSE.txt", target / "Python.txt")


def copy_licence_files(known: Distribution, target: Path) -> None:
    """Copy the licence files of a package, without changing their relative paths.

    numpy, for example, has twenty files of the same name.
    """
    for file in known.files or ():
        if _LICENCE.search(file.name) and file.suffix not in {".py", ".pyc", ".pyi"}:
            place = Path(*(part for part in file.parts if part not in {"licenses", ".."}))
            to = target / (Path(*place.parts[1:]) if ".dist-info" in place.parts[0] else place)
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(str(file.locate()), to)
    if not target.exists():  # some packages have no licence file, only its name
        target.mkdir(parents=True)
        told = licence(known.metadata["Name"], known.metadata)
        (target / "LICENCE.txt").write_text(told + "\n", "utf-8")


def version() -> str:
    """Return the version of the program."""
    text = (ROOT / "twistcore" / "files" / "version.py").read_text("utf-8")
    found = re.search(r'__version__ = "([^"]+)"', text)
    assert found, "twistcore/files/version.py has no version"
    return found[1]


def size(folder: Path) -> float:
    """Return the size of a folder's files in megabytes."""
    return sum(f.stat().st_size for f in folder.rglob("*") if not f.is_symlink()) / 1e6


def run(*words: object, env: dict[str, str] | None = None) -> None:
    """Run a command. Raise CalledProcessError if it fails."""
    print("+", *words, flush=True)
    # Not in the checkout, because Python would find its packages before those of the wheel.
    subprocess.run([str(word) for word in words], check=True, env=env, cwd=BUILD)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except subprocess.CalledProcessError as error:
        sys.exit(f"The bundle was not built: {error}")
