#!/usr/bin/env python3
"""Write docs/tables/licences.csv: `python packaging/list_licences.py`, with all packages installed.

The licence of each package comes from its metadata. The tables in this file list what the metadata
lacks, such as licences of libraries in a wheel. They describe the versions in
packaging/bundle.lock.
"""

from __future__ import annotations

import csv
import io
import re
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK, PAGE = ROOT / "packaging" / "bundle.lock", ROOT / "docs" / "licences.md"
TABLE = ROOT / "docs" / "tables" / "licences.csv"

# Packages that build a bundle and are not part of it. The bundle contains PyInstaller's start-up
# code, which may be distributed with any program.
BUILDS = {
    *("altgraph", "build", "hatch-fancy-pypi-readme", "hatchling", "macholib", "pathspec"),
    *("pefile", "pluggy", "pyinstaller", "pyinstaller-hooks-contrib", "pyproject-hooks"),
    *("pywin32-ctypes", "setuptools", "tomlkit", "trove-classifiers"),
}
# The names of licences for which the metadata has the whole text, or nothing.
NAMES = {
    "colorama": "BSD-3-Clause",
    "contourpy": "BSD-3-Clause",
    "cycler": "BSD-3-Clause",
    "jinja2": "BSD-3-Clause",
    "kiwisolver": "BSD-3-Clause",
    "markdown-it-py": "MIT",
    "matplotlib": "matplotlib's own, like PSF-2.0",
    "mdurl": "MIT",
    "pyobjc-core": "MIT",  # macOS only: known from its index page
    "pyobjc-framework-cocoa": "MIT",
    "scipy": "BSD-3-Clause",
    "trimesh": "MIT",
    "vtk": "BSD-3-Clause",
}
# Other contents of wheels, with their licences.
BRINGS = {
    "av": "FFmpeg's libraries (LGPL-3.0-or-later as configured), x264 and x265 "
    "(GPL-2.0-or-later), SVT-AV1, dav1d, libvpx, Opus, libwebp, oneVPL (BSD-like), LAME "
    "(LGPL-2.0-or-later), OpenCORE AMR (Apache-2.0), GnuTLS, Nettle, GMP, libunistring "
    "(LGPL), ALSA (LGPL-2.1-or-later), libdrm and X11's client libraries (MIT)",
    "imageio-ffmpeg": "ffmpeg, a program of its own, built with --enable-gpl "
    "--enable-version3: GPL-3.0-or-later (x264, x265, xvid, rubberband, vid.stab and others "
    "are inside)",
    "matplotlib": "fonts: DejaVu (Bitstream Vera's licence), STIX (OFL-1.1), Computer Modern "
    "(BaKoMa), Last Resort (OFL-1.1); AGG, FreeType, Qhull",
    "numpy": "OpenBLAS (BSD-3-Clause) with LAPACK; libgfortran and libquadmath (GPL-3.0 with the "
    "runtime exception, LGPL-2.1-or-later)",
    "pillow": "libjpeg-turbo, libpng, libtiff, libwebp, libavif, OpenJPEG, FreeType, HarfBuzz, "
    "Little CMS, zlib, Zstandard, Brotli, XZ, X11's client libraries",
    "pyqtgraph": "colour maps of Peter Kovesi (CC-BY-4.0)",
    "pyside6-essentials": "Qt 6 with its plugins (LGPL-3.0-only) and ICU (Unicode-3.0); in the "
    "wheel, not in a bundle, also parts under the GPL alone: Qt Wayland Compositor, Designer",
    "pyvista": "small example meshes",
    "scipy": "OpenBLAS (BSD-3-Clause) with LAPACK; libgfortran and libquadmath as numpy; "
    "Qhull, SuperLU, ARPACK, HiGHS, Boost",
    "trimesh": "three.js (MIT), in the viewer that a lesson's page is made from",
    "tzdata": "IANA's time zones (public domain)",
    "vtk": "GL2PS (LGPL-2.0-or-later); permissive: Viskores, HDF5, NetCDF, Expat, FreeType, "
    "libharu, libpng, libjpeg-turbo, libtiff, PROJ, SQLite, Theora, zlib and others",
}
ONLY_ON = {"darwin": "macOS", "win32": "Windows"}


def key(name: str) -> str:
    """Return the normalised name of a distribution, as package indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def shipped(lock: str) -> dict[str, str]:
    """Return the packages of the bundle, each with the only system that needs it, or ''.

    `lock` is the text of the bundle's lock file.
    """
    found = {}
    for name, marker in re.findall(r"^([\w.-]+)==[^\s;]+(.*)$", lock, re.MULTILINE):
        system = re.search(r"sys_platform == '(\w+)'", marker)
        found[name] = ONLY_ON.get(system[1], system[1]) if system else ""
    return {name: system for name, system in found.items() if name not in BUILDS}


def licence(name: str, told: metadata.PackageMetadata) -> str:
    """Return the licence in a package's metadata. Raise LookupError if there is none."""
    short = told.get("License-Expression") or told.get("License") or ""
    if not short or "\n" in short or len(short) > 60:
        raise LookupError(f"{name} does not name its licence: look, and say it in NAMES")
    return short


def table() -> str:
    """Return the CSV table, with one row per package."""
    rows = [("package", "its licence", "what else its wheel contains")]
    for name, system in sorted(shipped(LOCK.read_text("utf-8")).items()):
        only = f" ({system} only)" if system else ""
        named = NAMES.get(name) or licence(name, metadata.metadata(name))
        rows.append((f"{name}{only}", named, BRINGS.get(name, "")))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def main() -> int:
    """Write the table and return the exit status."""
    TABLE.write_text(table(), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
