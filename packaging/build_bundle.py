#!/usr/bin/env python3
"""Make a folder that runs without Python: `python3 packaging/build_bundle.py`.

Takes a Python ≥ 3.11 with its shared library, on Linux `binutils`, and some 3 GB of disk. The wheel
is built and installed with the window's packages into an environment of its own under
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
from importlib.metadata import distributions
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HERE = ROOT / "packaging"
BUILD, DIST = HERE / "build", HERE / "dist"
PYINSTALLER = "pyinstaller==6.22.*"  # 6.22 with its hooks is known to gather VTK and Qt whole
ICON = ROOT / "assets" / "icons" / "program.svg"
ICON_SIZE = 512
# What builds only, and is in the environment, not in the bundle.
NOT_SHIPPED = {"pip", "setuptools", "build", "pyproject-hooks", "pyproject_hooks", "pyinstaller"}
NOT_SHIPPED |= {"pyinstaller-hooks-contrib", "altgraph", "pillow", "twist-inspector"}
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
    run(python, "-m", "pip", "install", "--quiet", "build", PYINSTALLER, "pillow")
    run(python, "-m", "build", "--wheel", "--outdir", BUILD / "wheel", ROOT)
    (wheel,) = (BUILD / "wheel").glob("*.whl")
    run(python, "-m", "pip", "install", "--quiet", f"{wheel}[gui,video]")
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
    """The licence files of every package that was installed, by the package's name."""
    (site,) = (BUILD / "venv").rglob("site-packages")
    for known in distributions(path=[str(site)]):
        name = known.metadata["Name"]
        if name.lower() in NOT_SHIPPED:
            continue
        for file in known.files or ():
            if "dist-info" in str(file) and _LICENCE.search(file.name):
                (target / name).mkdir(parents=True, exist_ok=True)
                shutil.copy(file.locate(), target / name)
        if not (target / name).exists():  # some packages name it only
            (target / name).mkdir(parents=True)
            told = known.metadata.get("License-Expression") or known.metadata.get("License")
            (target / name / "LICENCE.txt").write_text(f"{told or 'see its home page'}\n", "utf-8")


def version() -> str:
    """The version as the package has it."""
    text = (ROOT / "twistcore" / "version.py").read_text("utf-8")
    found = re.search(r'__version__ = "([^"]+)"', text)
    assert found, "twistcore/version.py has no version"
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
