"""Set up Qt, open the window, and handle operating-system signals until the window is closed."""

from __future__ import annotations

import os
import signal
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

# Set this before importing Qt: pyvistaqt must use the same Qt binding, and does not support Wayland
# yet, so it needs X11.
os.environ.setdefault("QT_API", "pyside6")
if os.environ.get("WAYLAND_DISPLAY") and os.environ.get("DISPLAY"):
    os.environ.setdefault("QT_QPA_PLATFORM", "xcb")

from PySide6.QtCore import QLibraryInfo, QLocale, Qt, QTimer, QTranslator
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QApplication

from inspector.bundled import SAMPLE
from inspector.collector import collect_between_events, exclude_from_collection
from inspector.language import language_to_use, use_language
from inspector.session.settings import load_settings, settings_path
from inspector.widgets.background import wait_for_tasks
from inspector.widgets.fonts import shipped_families
from inspector.widgets.icons import program_icon
from inspector.widgets.splash import Splash
from inspector.widgets.theme import apply_theme, named_theme, system_theme
from twistcore.files.encoding import escape_control_characters

if TYPE_CHECKING:
    import argparse

    from inspector.window.demo import Script
    from inspector.window.main_window import MainWindow

_PATIENCE_MS = 500  # time to wait for cancelled work


def run_inspector(arguments: argparse.Namespace) -> int:
    """Run the program with its command-line arguments until the window closes.

    Returns the exit code.
    """
    path = settings_path()
    settings = load_settings(path)[0]
    language = arguments.language or settings.language
    app = make_application(language_to_use(language, QLocale.system().uiLanguages()))
    splash = Splash(named_theme(settings.theme))
    if not (arguments.demo or arguments.screenshot):
        splash.show_at_once()
    # Import the window after creating the application and the splash screen: the import takes
    # seconds from a cold disk, and builds tables of texts.
    from inspector.window.main_window import MainWindow

    settings, complaint = load_settings(path)  # again, now with the settings that features declare
    window = MainWindow(settings, path)
    window.show()
    splash.finish(window)
    if complaint:
        _show_complaint(window, complaint)
    exclude_from_collection()
    script = _script(window, arguments)
    if script is None:
        QTimer.singleShot(0, window, lambda: _begin(window, arguments.file))

    stopped = 0  # the exit code; the event loop returns 0 if the last window was closed

    def end(number: int, _frame: object) -> None:
        nonlocal stopped
        stopped = 128 + number
        window.close_without_asking()
        app.exit(stopped)  # even if a dialog is open

    closed = getattr(signal, "SIGHUP", signal.SIGTERM)  # sent when the terminal is closed
    handled = signal.getsignal(closed) != signal.SIG_IGN  # `nohup` ignores it
    for number in (signal.SIGINT, signal.SIGTERM, *([closed] if handled else ())):
        signal.signal(number, end)
    wake = QTimer()  # lets Python handle signals while Qt waits
    wake.start(200)
    wake.timeout.connect(lambda: None)
    app.exec()
    code = stopped or (script.code if script is not None else 0)
    if not wait_for_tasks(_PATIENCE_MS):
        # Qt would wait for threads that are still running, although everything important is on
        # disk.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


def _begin(window: MainWindow, path: Path | None) -> None:
    """Open `path` or, if it is None, offer to restore unsaved decisions of the last run."""
    if path is None:
        window.files.offer_unsaved()
    else:
        window.open_path(path)


def _show_complaint(window: MainWindow, complaint: str) -> None:
    """Show an error message now, and again after a clip opens, because opening clears messages."""
    print(escape_control_characters(complaint), file=sys.stderr)
    window.bar.show_message(complaint, True)
    again = partial(window.bar.add_error, complaint)
    later = partial(QTimer.singleShot, 0, window, again)
    window.document.opened.connect(later, Qt.ConnectionType.SingleShotConnection)


def _script(window: MainWindow, arguments: argparse.Namespace) -> Script | None:
    """Return the script to run for --demo or --screenshot, or None if neither option is given."""
    from inspector.window.demo import demo_script, screenshot_script

    if arguments.demo:
        return demo_script(window, arguments.demo, arguments.file or SAMPLE)
    if arguments.screenshot:
        return screenshot_script(window, arguments.screenshot, arguments.file)
    return None


def make_application(language: str = "en") -> QApplication:
    """Set the language, then create the QApplication with its theme.

    Call this function before importing the modules of the window.
    """
    use_language(language)
    QLocale.setDefault(QLocale.c())  # in every language, numbers look as in files
    app = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(app, QApplication)
    words = QTranslator(app)  # translates Qt's own texts, for example on buttons
    if words.load(
        f"qtbase_{language}", QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
    ):
        app.installTranslator(words)
    app.setApplicationName("Twist Inspector")
    app.setOrganizationName("Twist Inspector")
    app.setDesktopFileName("twist-inspector")
    app.setWindowIcon(program_icon())
    shipped_families()  # before any text is drawn, because a system may have no fonts
    font = QFont(app.font())
    font.setFeature(QFont.Tag("tnum"), 1)  # digits of equal width, for columns of numbers
    app.setFont(font)
    apply_theme(app, system_theme())
    collect_between_events(app)
    return app
