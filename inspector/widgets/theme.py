"""The colours and fonts of the light and the dark theme.

In both themes, orange is used for the clip before correction and blue for the clip after it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

from inspector.widgets.fonts import FIXED, shipped_families


@dataclass(frozen=True)
class Theme:
    """The colours of a theme, as '#rrggbb'. Each colour is named after its use.

    The text colours have a contrast of at least 4.5:1 on `surface`.
    """

    dark: bool
    window: str  # background behind panels
    surface: str  # background of tables, plots and the 3D view
    raised: str  # background of buttons and headers
    line: str  # borders of panels, and grid lines
    edge: str  # borders of buttons and inputs, with a contrast of at least 3:1
    text: str
    soft: str  # secondary text
    accent: str  # selection, focus, playhead
    on_accent: str
    before: str  # the clip as captured: orange
    after: str  # the clip as corrected: blue
    tracked: str  # the clip after tracking with QuaMo: magenta
    tau: str  # the line at the threshold τ
    accepted: str
    rejected: str
    undecided: str
    bone: str  # bones that belong to no chain
    warning: str

    @property
    def faint(self) -> str:
        """The colour of disabled text and icons."""
        return blend_colour_over_paper(self.soft, self.window, 150).name()


_COLOURS = {  # light, dark
    "window": ("#eef1f4", "#15191f"),
    "surface": ("#ffffff", "#1c2129"),
    "raised": ("#f7f9fa", "#262d37"),
    "line": ("#d3dae1", "#3a4350"),
    "edge": ("#7d8792", "#748090"),
    "text": ("#18202a", "#e7ecf2"),
    "soft": ("#556170", "#a6b1bf"),
    "accent": ("#5b3fc4", "#a693ff"),
    "on_accent": ("#ffffff", "#14101f"),
    "before": ("#a65300", "#ff9d3d"),
    "after": ("#1668b3", "#62b1f5"),
    "tracked": ("#a8197f", "#ff86d0"),
    "tau": ("#b3261e", "#ff7b72"),
    "accepted": ("#1b7040", "#6fce95"),
    "rejected": ("#a3342b", "#ff938a"),
    "undecided": ("#6b5b00", "#d9c65a"),
    "bone": ("#a9b4c0", "#6d7988"),
    "warning": ("#8a4b00", "#ffb45e"),
}
LIGHT = Theme(dark=False, **{role: light for role, (light, _) in _COLOURS.items()})
DARK = Theme(dark=True, **{role: dark for role, (_, dark) in _COLOURS.items()})

# The factor, in percent, by which Qt's Fusion style draws outlines darker than the window
_OUTLINE = 140
_BOXES = (
    "QCheckBox", "QRadioButton", "QComboBox", "QAbstractSpinBox", "QLineEdit", "QPushButton",
    "QSlider", "QTableView", "QListView",
)  # fmt: skip


class Colours(QObject):
    """The current theme. The signal `changed` is emitted whenever a theme is set."""

    changed = Signal(object)  # with the Theme

    def __init__(self, theme: Theme, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.theme = theme

    def follow(self, colour: Callable[[Theme], None]) -> None:
        """Call `colour` with the current theme now, and with each new theme later.

        `colour` must be a method of a QObject, so that Qt disconnects it when the object is
        deleted.
        """
        self.changed.connect(colour)
        colour(self.theme)

    def use(self, theme: Theme) -> None:
        """Set the theme and emit `changed`, even if the theme is the same as before."""
        self.theme = theme
        self.changed.emit(theme)


def system_theme() -> Theme:
    """Return the light or the dark theme, according to the setting of the operating system."""
    scheme = QGuiApplication.styleHints().colorScheme()
    return DARK if scheme == Qt.ColorScheme.Dark else LIGHT


def named_theme(name: str) -> Theme:
    """Return the theme 'light' or 'dark', or the system's theme for any other name."""
    return {"light": LIGHT, "dark": DARK}.get(name) or system_theme()


def apply_theme(app: QApplication, theme: Theme) -> None:
    """Apply Qt's Fusion style with the palette and style sheet of the theme.

    If the theme is already applied, do nothing, because applying it to a window takes 0.15 s.
    """
    lit = blend_colour_over_paper(theme.accent, theme.window, 60).name()
    sheet = _STYLE.format(**vars(theme), lit=lit)
    if app.styleSheet() == sheet:
        return
    app.setStyle("Fusion")
    palette = QPalette()
    role = QPalette.ColorRole
    for target, colour in (
        (role.Window, theme.window),
        (role.WindowText, theme.text),
        (role.Base, theme.surface),
        (role.AlternateBase, theme.raised),
        (role.Text, theme.text),
        (role.Button, theme.raised),
        (role.ButtonText, theme.text),
        (role.BrightText, theme.text),
        (role.ToolTipBase, theme.raised),
        (role.ToolTipText, theme.text),
        (role.PlaceholderText, theme.soft),
        (role.Highlight, theme.accent),
        (role.HighlightedText, theme.on_accent),
        (role.Link, theme.accent),
        (role.Light, theme.raised),
        (role.Midlight, theme.raised),
        (role.Mid, theme.line),
        (role.Dark, theme.line),
        (role.Shadow, theme.line),
        (role.Accent, theme.accent),
    ):
        palette.setColor(target, QColor(colour))
    for target in (role.Text, role.WindowText, role.ButtonText, role.PlaceholderText):
        palette.setColor(QPalette.ColorGroup.Disabled, target, QColor(theme.faint))
    app.setPalette(palette)
    # Fusion draws borders in a shade of the window's colour, which is invisible on a dark window.
    # These widgets use that colour only for borders, so they get a lighter one.
    palette.setColor(role.Window, QColor(theme.edge).lighter(_OUTLINE))
    for kind in _BOXES:
        app.setPalette(palette, kind)  # type: ignore[arg-type]  # the stubs wrongly require bytes
    app.setStyleSheet(sheet)


def figures_font(size: float = 0.0) -> QFont:
    """Return the fixed-width font for columns of numbers.

    `size` is in points. 0 means the size of the program's font.
    """
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    if FIXED in shipped_families():
        font.setFamilies([FIXED])
    of_program = QGuiApplication.font()
    font.setHintingPreference(of_program.hintingPreference())
    font.setStyleStrategy(of_program.styleStrategy())
    font.setPointSizeF(size or of_program.pointSizeF())
    return font


# Labels show plain text unless they are set to RichText. Qt itself would guess the format.
_STYLE = """
QLabel[textFormat="AutoText"] {{ qproperty-textFormat: PlainText; }}
* {{ dialogbuttonbox-buttons-have-icons: 0; }}
QDockWidget {{ font-weight: 600; }}
QDockWidget::title {{ background: {window}; padding: 3px 8px; }}
QDockWidget > QWidget {{ font-weight: 400; }}
QMainWindow::separator {{ background: {line}; width: 3px; height: 3px; }}
QMainWindow::separator:hover {{ background: {accent}; }}
QHeaderView::section {{ background: {raised}; color: {soft}; border: 0;
  border-bottom: 1px solid {line}; padding: 4px 4px; }}
QTableView {{ gridline-color: transparent; border: 1px solid {line};
  selection-background-color: {accent}; selection-color: {on_accent}; }}
QToolBar {{ background: {window}; border: 0; border-bottom: 1px solid {line};
  spacing: 2px; padding: 0; }}
QToolBar QToolButton {{ padding: 3px 5px; border: 1px solid transparent; border-radius: 4px; }}
QToolBar QToolButton:hover:enabled {{ background: {raised}; border-color: {edge}; }}
QToolBar QToolButton:pressed {{ background: {line}; }}
QToolBar QToolButton:checked {{ background: {lit}; border-color: {accent}; }}
QTabBar::tab {{ background: {window}; color: {soft}; padding: 5px 11px;
  border: 1px solid {line}; }}
QTabBar::tab:hover {{ color: {text}; }}
QTabBar::tab:selected {{ background: {surface}; color: {text}; border-color: {edge}; }}
QTabBar::tab:bottom {{ border-top: 2px solid {line}; border-bottom-left-radius: 4px;
  border-bottom-right-radius: 4px; }}
QTabBar::tab:bottom:selected {{ border-top: 2px solid {accent}; }}
QTabBar::tab:top {{ border-bottom: 2px solid {line}; border-top-left-radius: 4px;
  border-top-right-radius: 4px; padding: 5px 7px; }}
QTabBar::tab:top:selected {{ border-bottom: 2px solid {accent}; }}
#start, #start_page {{ background: {surface}; }}
#start_title {{ font-size: 15pt; font-weight: 600; }}
#start QPushButton {{ padding: 6px 12px; }}
#recent, #recent_folder {{ color: {accent}; text-align: left; }}
QStatusBar {{ background: {window}; border-top: 1px solid {line}; color: {soft}; }}
QStatusBar::item {{ border: 0; }}
QStatusBar QLabel {{ color: {soft}; padding: 0 8px; }}
QToolTip {{ background: {raised}; color: {text}; border: 1px solid {line}; padding: 4px; }}
#bar {{ background: {raised}; border: 1px solid {line}; border-radius: 4px; }}
#bar[wrong="true"] {{ border: 1px solid {rejected}; }}
#bar QLabel {{ color: {text}; }}
#scope:checked {{ background: {accent}; color: {on_accent}; border: 1px solid {accent};
  border-radius: 3px; }}
#palette::item {{ padding: 3px 4px; }}
#soft {{ color: {soft}; }}
#warning {{ color: {warning}; }}
#hold:checked {{ background: {accent}; color: {on_accent}; border: 1px solid {line};
  border-radius: 2px; padding: 3px 6px; }}
"""


@cache
def blend_colour_over_paper(colour: str, paper: str, alpha: int) -> QColor:
    """Return the opaque colour that results from `colour` with opacity alpha/255 over `paper`.

    Painting with opaque colours is 30 times faster than blending.
    """
    above, below, share = QColor(colour), QColor(paper), alpha / 255.0
    parts = (QColor.red, QColor.green, QColor.blue)
    return QColor(*(round(share * p(above) + (1.0 - share) * p(below)) for p in parts))
