"""The command line of `twist-inspector` and `python -m inspector`, checked before Qt is loaded."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from inspector.language import language_codes
from inspector.system_libraries import has_screen, how_to_install, missing_libraries
from inspector.unread_sources import disable_pyside_source_reading
from twistcore.detection.registry import register_detector_file
from twistcore.errors import TwistError
from twistcore.files.encoding import escape_control_characters
from twistcore.files.ordinary import is_file, path_exists
from twistcore.files.version import __version__

_PICTURES = (".png", ".jpg", ".jpeg", ".bmp")  # formats of images that Qt can write
_WINDOW = (
    *("PySide6", "vtkmodules", "pyvista", "pyvistaqt", "qtpy", "pyqtgraph"),
    *("matplotlib", "markdown_it"),
)
_NOT_INSTALLED = (
    "the packages for the window are not installed. Install them with "
    'pip install "twist-inspector[gui]"; the command twistcore works without them.'
)
_NO_SCREEN = (
    "there is no screen: neither DISPLAY nor WAYLAND_DISPLAY is set. The command twistcore works "
    "without a screen; for --screenshot use xvfb-run (on Debian, in the packages xvfb and xauth)."
)


# Worker processes import this module and do not need Qt, so only `main` imports the window.
def main(argv: Sequence[str] | None = None) -> int:
    """Run `twist-inspector` and return its exit code."""
    arguments = _parser().parse_args(argv)
    if trouble := _wrong_arguments(arguments) or _missing_for_window():
        print(f"twist-inspector: {escape_control_characters(trouble, lines=True)}", file=sys.stderr)
        return 2
    disable_pyside_source_reading()
    with ExitStack() as known:
        try:
            if arguments.detector:
                known.enter_context(register_detector_file(arguments.detector))
        except TwistError as error:
            print(
                f"twist-inspector: {escape_control_characters(error, lines=True)}", file=sys.stderr
            )
            return 2
        from inspector.app import run_inspector

        return run_inspector(arguments)


def _wrong_arguments(arguments: argparse.Namespace) -> str:
    """Return an error message about wrong command-line arguments, or '' if they are valid."""
    file, picture, folder = arguments.file, arguments.screenshot, arguments.demo
    if arguments.language not in ("", "system", *language_codes()):
        return (
            f"--language {arguments.language}: expected one of {', '.join(language_codes())} or "
            "system."
        )
    if picture and folder:
        return "--demo also writes an image. Use either --demo or --screenshot."
    if (picture or folder) and file and not path_exists(file):
        return f"{file}: this file does not exist."
    if picture and picture.is_dir():
        return f"{picture} is a folder. Give --screenshot the name of an image file."
    if picture and picture.suffix.lower() not in _PICTURES:
        return f"{picture}: the name of an image must end with {', '.join(_PICTURES)}."
    target = folder or (picture.parent if picture else None)
    if target and (wrong := next((p for p in (target, *target.parents) if is_file(p)), None)):
        return f"{wrong} is a file. Choose a folder for the results."
    return ""


def _missing_for_window() -> str:
    """Return the reason why this system cannot open a window, or ''.

    Without this check, Qt would crash.
    """
    if any(find_spec(name) is None for name in _WINDOW):
        return _NOT_INSTALLED
    platform = os.environ.get("QT_QPA_PLATFORM")
    if missing := missing_libraries(platform or "xcb"):
        return how_to_install(missing)
    return "" if platform or has_screen() else _NO_SCREEN


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        super().error(escape_control_characters(message))


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
        help="save an image of the window and quit; without a clip, the window is empty (default: "
        "no image)",
    )
    parser.add_argument(
        "--demo",
        type=Path,
        metavar="DIR",
        help="run a demonstration and quit: accept every interval and write the results to DIR; "
        "without a clip, the sample is used (default: no demonstration)",
    )
    parser.add_argument(
        "--detector",
        metavar="FILE.py:CLASS",
        help="add a detector of your own to the Edit menu (docs/detectors.md; default: none)",
    )
    parser.add_argument(
        "--language",
        default="",
        metavar="CODE",
        help="language of the window: en, de or system (default: as in the preferences)",
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
