"""Check whether the system libraries and the screen that a window needs are available.

This module uses only the standard library of any Python 3, because dev.py runs it before anything
is installed.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# Libraries that Qt and VTK load, and the Debian packages with these libraries. The check uses the
# names of the libraries, not a database of packages, so that it works in every distribution.
LIBRARIES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libfontconfig.so.1": "libfontconfig1",
    "libdbus-1.so.3": "libdbus-1-3",
}
# Libraries that Qt needs on an X server. If one of them is missing, Qt ends the program.
X_LIBRARIES = {
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-shape.so.0": "libxcb-shape0",
}


def has_screen() -> bool:
    """Return True if this system has a screen on which windows can be shown."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def is_loadable(soname: str) -> bool:
    """Return True if the dynamic linker can load a library."""
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def missing_libraries(platform: str = "xcb") -> dict[str, str]:
    """Return the missing system libraries, as a dict of library name → Debian package.

    `platform` is the name of Qt's platform plugin.
    """
    if not sys.platform.startswith("linux"):
        return {}
    needed = LIBRARIES | (X_LIBRARIES if platform.startswith("xcb") else {})
    return {soname: package for soname, package in needed.items() if not is_loadable(soname)}


def install_command(packages: Sequence[str]) -> list[str]:
    """Return the command that installs Debian packages, which must be run as root."""
    return ["apt-get", "install", "-y", "--no-install-recommends", *packages]


def how_to_install(missing: Mapping[str, str]) -> str:
    """Return a message with the missing libraries and the command that installs them."""
    names, packages = ", ".join(missing), sorted(set(missing.values()))
    lacks = f"this system lacks {names}"
    if not shutil.which("apt-get"):
        return (
            f"{lacks}. Debian has them in the packages {' '.join(packages)}; install the packages "
            "of your distribution that correspond to these."
        )
    sudo = "" if os.geteuid() == 0 else "sudo "
    command = " ".join(install_command(packages))
    return f"{lacks}. Install them with:\n  {sudo}apt-get update && {sudo}{command}"
