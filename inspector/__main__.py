"""The words of `twist-inspector`, also `python -m inspector`: looked at before Qt is loaded."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from inspector.language import codes
from inspector.system_libraries import has_screen, how_to_install, missing_libraries
from inspector.unread_sources import leave_sources_unread
from twistcore.files.encoding import legible
from twistcore.files.ordinary import is_file, is_there
from twistcore.files.version import __version__

_PICTURES = (".png", ".jpg", ".jpeg", ".bmp")  # what Qt writes
_WINDOW = (
    *("PySide6", "vtkmodules", "pyvista", "pyvistaqt", "qtpy", "pyqtgraph"),
    *("matplotlib", "markdown_it"),
)
_NOT_INSTALLED = (
    'the window is not installed: expected pip install "twist-inspector[gui]"; '
    "twistcore works without it."
)
_NO_SCREEN = (
    "no screen to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set); twistcore works "
    "without one, and xvfb-run (Debian: xvfb and xauth) gives --screenshot a virtual one."
)


# Worker processes import this module again and need no Qt: it is imported when all is well.
def main(argv: Sequence[str] | None = None) -> int:
    """Run `twist-inspector`; returns the exit code."""
    arguments = _parser().parse_args(argv)
    if trouble := _cannot_work(arguments) or _cannot_open():
        print(f"twist-inspector: {legible(trouble, lines=True)}", file=sys.stderr)
        return 2
    leave_sources_unread()
    from inspector.app import run

    return run(arguments)


def _cannot_work(arguments: argparse.Namespace) -> str:
    """Why nothing can come of these words, before a window opens; '' if something can."""
    file, picture, folder = arguments.file, arguments.screenshot, arguments.demo
    if arguments.language not in ("", "system", *codes()):
        return f"--language takes {', '.join(codes())} or system, not {arguments.language}."
    if picture and folder:
        return "--demo leaves a picture, too; give either --demo or --screenshot."
    if (picture or folder) and file and not is_there(file):
        return f"{file}: there is no such file."
    if picture and picture.is_dir():
        return f"{picture}: is a folder; --screenshot takes the name of a picture."
    if picture and picture.suffix.lower() not in _PICTURES:
        return f"{picture}: a picture's name ends with {' or '.join(_PICTURES)}."
    target = folder or (picture.parent if picture else None)
    if target and (wrong := next((p for p in (target, *target.parents) if is_file(p)), None)):
        return f"{wrong}: is a file; results need a folder."
    return ""


def _cannot_open() -> str:
    """Why no window opens here, where Qt would end in a traceback or abort; '' if one does."""
    if any(find_spec(name) is None for name in _WINDOW):
        return _NOT_INSTALLED
    platform = os.environ.get("QT_QPA_PLATFORM")
    if missing := missing_libraries(platform or "xcb"):
        return how_to_install(missing)
    return "" if platform or has_screen() else _NO_SCREEN


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        super().error(legible(message))


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="twist-inspector",
        description="See, judge and correct twist errors in motion capture: opens the window.",
        epilog="Without a window, `twistcore` does the same: see `twistcore --help`.",
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"twist-inspector {__version__}",
        help="show the version and exit",
    )
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="CLIP|SESSION|FOLDER",
        help="the clip, session or folder to open (default: an empty window)",
    )
    parser.add_argument(
        "--screenshot",
        type=Path,
        metavar="PNG",
        help="save a picture of the window and quit (default: no picture)",
    )
    parser.add_argument(
        "--demo",
        type=Path,
        metavar="DIR",
        help="accept every interval as a demonstration, write the results into this folder and "
        "quit; without a clip, the sample is shown (default: no demonstration)",
    )
    parser.add_argument(
        "--language",
        default="",
        metavar="CODE",
        help="language of the window: en, de or system (default: as in the settings)",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
