"""The system packages that the program and its tests need."""

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
# Tests that use the program like a user run on a separate screen, where no other program
# interferes, with a window manager, with and without a compositor, and with real input events.
TEST_PROGRAMS = {
    "Xvfb": XVFB_PACKAGES,
    "openbox": ["openbox"],
    "xcompmgr": ["xcompmgr"],
    "xdotool": ["xdotool"],
}
# The browser in which tests open a lesson's web page. It is large (a download of 120 MB, 400 MB on
# disk), so only CI installs it. On other machines, an installed browser is used.
BROWSER = {"chromium": ["chromium"]}


def missing_system(*, windows: bool, tests: bool = False) -> dict[str, str]:
    """Return the missing libraries and programs, each with the Debian package that contains it.

    Without `windows`, only the requirements for creating .venv are checked. With `tests`, the
    programs that window tests need are checked, too.
    """
    if not sys.platform.startswith("linux"):
        return {}
    missing = {}
    if not (places.PYTHON.exists() or shutil.which("uv") or importlib.util.find_spec("ensurepip")):
        # Debian has this part of Python in a separate package.
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
    """Install Debian packages.

    Raise SetupError with the command to run if the user lacks the permission.
    """
    install = install_command(packages)
    if not shutil.which("apt-get"):
        raise SetupError(
            f"This system lacks the contents of these Debian packages: {' '.join(packages)}.\n"
            "Install the equivalent packages with your package manager, then try again."
        )
    if os.geteuid() != 0:
        raise SetupError(
            "Some system packages are missing. Install them with this command, then try again:\n"
            f"  sudo apt-get update && sudo {' '.join(install)}"
        )
    say(f"Installing system packages: {' '.join(packages)}")
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    # Errors are ignored, because the installation may succeed with an old index.
    quietly(["apt-get", "update"], env)
    problem = quietly(install, env)
    if problem:
        raise SetupError(
            f"The system packages could not be installed. Messages of apt-get:\n{problem}"
        )


def ensure_system(*, windows: bool, tests: bool = False) -> None:
    """Install missing system packages. Raise SetupError if any are still missing afterwards."""
    missing = missing_system(windows=windows, tests=tests)
    if missing:
        install_packages(sorted(set(missing.values())))
    importlib.invalidate_caches()  # the installation may have added modules of Python
    still = missing_system(windows=windows, tests=tests) if missing else {}
    if still:
        raise SetupError(f"Still missing after the installation: {', '.join(still)}.")
