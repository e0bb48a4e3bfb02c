"""The actions for the whole program: theme, preferences, command palette and help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QMessageBox, QWidget

from inspector.feature import Tick
from inspector.language import tr
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.widgets import theme as themes
from inspector.widgets.building import bring_to_front
from inspector.widgets.guide_page import GuidePage
from inspector.widgets.icons import program_icon
from inspector.window.actions import Menus, apply_keys
from inspector.window.palette import CommandPalette
from inspector.window.preferences import Preferences
from twistcore.files.version import __version__

_ICON = 64  # pixels


@dataclass(eq=False)
class ProgramActions:
    """The actions for the theme, the preferences, the command palette and the help.

    `ticks` are the check boxes for feature settings in the preferences.
    """

    document: Document
    settings: Settings
    menus: Menus
    actions: Mapping[str, QAction]
    ticks: Sequence[Tick]
    window: QWidget
    _guide: GuidePage | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.colours = themes.Colours(self.wanted_theme(), self.window)

    def choose_theme(self, name: str) -> None:
        """Use the theme 'system', 'light' or 'dark', and save this choice."""
        if name != self.settings.theme:
            self.settings.theme = name
            self.colour()

    def colour(self) -> None:
        """Apply the theme chosen in the preferences: light, dark or the system's theme."""
        self.apply_theme(self.wanted_theme())

    def apply_theme(self, theme: themes.Theme) -> None:
        """Apply a theme to the application and to all views."""
        app = QApplication.instance()
        assert isinstance(app, QApplication)
        themes.apply_theme(app, theme)
        self.colours.use(theme)

    def wanted_theme(self) -> themes.Theme:
        """Return the theme to use: the user's choice or, for 'system', the system's theme."""
        return themes.named_theme(self.settings.theme)

    def take_settings(self) -> None:
        """Apply the settings for the reviewer, the frame numbering and the keyboard shortcuts."""
        self.document.sign(self.settings.reviewer)
        self.document.set_first_frame(self.settings.first_frame)
        apply_keys(self.menus, self.actions, self.settings)

    def preferences(self) -> None:
        """Open the preferences."""
        dialog = Preferences(self.settings, self.menus, self.ticks, self.window)
        dialog.accepted.connect(self.take_settings)
        dialog.open()

    def command_palette(self) -> None:
        """Open the command palette."""
        palette = CommandPalette(self.actions, self.window)
        palette.show()
        palette.line.setFocus()

    def show_guide(self) -> None:
        """Open the guide, or bring its window to the front."""
        if self._guide is None:
            self._guide = GuidePage(self.window, self.colours)
            self._guide.destroyed.connect(self._guide_gone)
        bring_to_front(self._guide)
        self._guide.activateWindow()

    def close_guide(self) -> None:
        """Close the guide's window."""
        if self._guide is not None:
            self._guide.close()

    def _guide_gone(self) -> None:
        self._guide = None

    def show_about(self) -> None:
        """Show a dialog with the version, the method, the sources of the data and the licence."""
        box = QMessageBox(self.window)
        box.setWindowTitle("Twist Inspector")
        box.setIconPixmap(program_icon().pixmap(_ICON))
        box.setTextFormat(Qt.TextFormat.RichText)
        box.setText(
            tr(
                "<b>Twist Inspector {version}</b><p>Finds intervals in which a joint and its "
                "child twist against each other, based on the method of Choi, Jang and Kim, J. "
                "Sens. Sci. Technol. 35(1), 2026.</p><p>Sample data obtained from "
                "mocap.cs.cmu.edu, created with funding from NSF EIA-0196217.</p><p>MIT licence. "
                "The program uses Qt under the LGPL; the licences of all parts are listed in the "
                "guide, Start → Packages and bundles → Licences.</p>",
                version=__version__,
            )
        )
        box.exec()
        box.deleteLater()
