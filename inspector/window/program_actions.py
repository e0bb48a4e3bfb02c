"""What the actions of the program itself do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMessageBox, QTextBrowser

from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.widgets import theme as themes
from inspector.window.actions import shortcuts_markdown
from inspector.window.palette import CommandPalette
from inspector.window.preferences import Preferences, apply_keys
from twistcore.version import __version__


class ProgramActions(QMainWindow):
    """Theme, preferences, palette, help."""

    document: Document
    settings: Settings
    actions_by_id: Mapping[str, QAction]
    apply_theme: Callable[[themes.Theme], None]

    def theme_system(self, on: bool) -> None:
        """Colours as the system has them."""
        self._choose_theme("system", on)

    def theme_light(self, on: bool) -> None:
        """Light colours."""
        self._choose_theme("light", on)

    def theme_dark(self, on: bool) -> None:
        """Dark colours."""
        self._choose_theme("dark", on)

    def _choose_theme(self, name: str, on: bool) -> None:
        if on and name != self.settings.theme:
            self.settings.theme = name
            self.apply_theme(self._wanted_theme())

    def _scheme_changed(self) -> None:
        self.apply_theme(self._wanted_theme())

    def _wanted_theme(self) -> themes.Theme:
        fixed = {"light": themes.LIGHT, "dark": themes.DARK}
        return fixed.get(self.settings.theme) or themes.system_theme()

    def _take_settings(self) -> None:
        self.document.reviewer = self.settings.reviewer
        self.document.set_first_frame(self.settings.first_frame)

    def preferences(self) -> None:
        """Reviewer, how frames are counted, keys."""
        dialog = Preferences(self.settings, self)
        dialog.accepted.connect(lambda: self._preferred(dialog))
        dialog.open()

    def _preferred(self, dialog: Preferences) -> None:
        dialog.take(self.settings)
        self._take_settings()
        apply_keys(self.actions_by_id, self.settings)

    def command_palette(self) -> None:
        """Any action by a part of its name."""
        palette = CommandPalette(self.actions_by_id, self)
        palette.show()
        palette.line.setFocus()

    def show_shortcuts(self) -> None:
        """Keys and mouse in a window of their own."""
        page = QTextBrowser(self)
        page.setWindowFlag(Qt.WindowType.Tool)
        page.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        page.setWindowTitle("Keyboard and mouse")
        page.setMarkdown(shortcuts_markdown())
        page.resize(520, 640)
        page.show()

    def show_about(self) -> None:
        """Version, method and data."""
        QMessageBox.about(
            self,
            "Twist Inspector",
            f"<b>Twist Inspector {__version__}</b><p>Finds intervals in which a joint and its "
            "child twist against each other, after Choi, Jang and Kim, J. Sens. Sci. Technol. "
            "35(1), 2026.</p><p>Sample data obtained from mocap.cs.cmu.edu, created with funding "
            "from NSF EIA-0196217.</p>",
        )
