"""What the system brings: libraries, the virtual screen, programs that tests use."""

from __future__ import annotations

import importlib
import importlib.util
import os
import shutil
import sys
from typing import TYPE_CHECKING

from checkout import places
from checkout.starting import SetupError, quietly, say
from inspector.system_libraries import has_screen, install_command, missing_libraries

if TYPE_CHECKING:
    from collections.abc import Sequence

# The virtual screen, and the software OpenGL driver that draws on it.
XVFB_PACKAGES = ["xvfb", "libgl1-mesa-dri"]
# Tests that use the program as a person does have a screen of their own, where nothing else is
# seen or typed, with a window manager, with and without a compositor, and real mouse and keys.
TEST_PROGRAMS = {
    "Xvfb": XVFB_PACKAGES,
    "openbox": ["openbox"],
    "xcompmgr": ["xcompmgr"],
    "xdotool": ["xdotool"],
}
# What a lesson's web page is opened in. It is large, 120 MB to fetch and 400 MB on the disk: CI has
# it brought, elsewhere a browser that is there is used.
BROWSER = {"chromium": ["chromium"]}


def missing_system(*, windows: bool, tests: bool = False) -> dict[str, str]:
    """What the system lacks: library or program -> the Debian package that brings it.

    Unless `windows` are to be opened, only what making .venv takes is looked for; `tests` of them
    take some programs more.
    """
    if not sys.platform.startswith("linux"):
        return {}
    missing = {}
    if not (places.PYTHON.exists() or shutil.which("uv") or importlib.util.find_spec("ensurepip")):
        # Debian ships this part of Python apart.
        missing["ensurepip"] = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"
    if not windows:
        return missing
    missing |= missing_libraries()
    if not has_screen() and not shutil.which("Xvfb"):
        missing |= {package: package for package in XVFB_PACKAGES}
    wanted = TEST_PROGRAMS | (BROWSER if os.environ.get("CI") else {})
    for program, packages in wanted.items() if tests else ():
        if not shutil.which(program):
            missing |= {package: package for package in packages}
    return missing


def install_packages(packages: Sequence[str]) -> None:
    """Install Debian packages, or say which command does it where this user may not."""
    install = install_command(packages)
    if not shutil.which("apt-get"):
        raise SetupError(
            f"This system lacks what these Debian packages bring: {' '.join(packages)}.\n"
            "Install their counterparts with your package manager, then try again."
        )
    if os.geteuid() != 0:
        raise SetupError(
            "Some system packages are missing. This one command installs them; then try again:\n"
            f"  sudo apt-get update && sudo {' '.join(install)}"
        )
    say(f"Installing system packages: {' '.join(packages)}")
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    # An index that cannot be refreshed may still be good enough: the install is what counts.
    quietly(["apt-get", "update"], env)
    problem = quietly(install, env)
    if problem:
        raise SetupError(f"The system packages could not be installed. apt-get said:\n{problem}")


def ensure_system(*, windows: bool, tests: bool = False) -> None:
    """Bring the libraries and the virtual screen where they are missing."""
    missing = missing_system(windows=windows, tests=tests)
    if missing:
        install_packages(sorted(set(missing.values())))
    importlib.invalidate_caches()  # Python itself may have just become complete
    still = missing_system(windows=windows, tests=tests) if missing else {}
    if still:
        raise SetupError(f"Still not found after the installation: {', '.join(still)}.")
