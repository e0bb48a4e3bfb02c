"""What windows need of the system: libraries, a screen, and the packages that bring them.

Standard library only, on any Python 3: dev.py asks before anything is installed.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# What Qt and VTK load from the system, and the Debian package that brings it. They are looked up
# by soname, not in a package database, so that the check is right on every distribution.
LIBRARIES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libfontconfig.so.1": "libfontconfig1",
    "libdbus-1.so.3": "libdbus-1-3",
}
# And what Qt takes to open windows on an X server: it ends the program where one is missing.
X_LIBRARIES = {
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-shape.so.0": "libxcb-shape0",
}


def has_screen() -> bool:
    """Whether windows can be shown as things are."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def is_loadable(soname: str) -> bool:
    """Whether the dynamic linker finds a library."""
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def missing_libraries(platform: str = "xcb") -> dict[str, str]:
    """Libraries that are not found -> the Debian package that brings each; platform: of Qt."""
    if not sys.platform.startswith("linux"):
        return {}
    wanted = LIBRARIES | (X_LIBRARIES if platform.startswith("xcb") else {})
    return {soname: package for soname, package in wanted.items() if not is_loadable(soname)}


def install_command(packages: Sequence[str]) -> list[str]:
    """What installs Debian packages, as root."""
    return ["apt-get", "install", "-y", "--no-install-recommends", *packages]


def how_to_install(missing: Mapping[str, str]) -> str:
    """What is missing and the command that brings it, or what to look for where there is no apt."""
    names, packages = ", ".join(missing), sorted(set(missing.values()))
    lacks = f"this system lacks {names}"
    if not shutil.which("apt-get"):
        return (
            f"{lacks}: expected what Debian has in {' '.join(packages)}; install their "
            "counterparts with your package manager."
        )
    sudo = "" if os.geteuid() == 0 else "sudo "
    command = " ".join(install_command(packages))
    return f"{lacks}; this installs what is missing:\n  {sudo}apt-get update && {sudo}{command}"
