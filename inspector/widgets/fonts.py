"""The fonts that the program uses, so that columns of numbers look the same on all systems.

The fonts are part of matplotlib, which the program also uses for other purposes.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from PySide6.QtGui import QFont, QFontDatabase
from PySide6.QtWidgets import QApplication

SANS, FIXED = "DejaVu Sans", "DejaVu Sans Mono"
_FOLDER = Path("mpl-data", "fonts", "ttf")
_FILES = tuple(
    f"DejaVuSans{style}.ttf"
    for style in ("", "-Bold", "-Oblique", "-BoldOblique", "Mono", "Mono-Bold")
)
_PICTURED = 9.0  # points; the font size in screenshots


def font_folder() -> Path | None:
    """Find the folder of matplotlib's fonts without importing matplotlib.

    Returns None if matplotlib is not installed.
    """
    spec = find_spec("matplotlib")
    places = (spec and spec.submodule_search_locations) or ()
    return next((Path(place) / _FOLDER for place in places), None)


@cache
def shipped_families() -> frozenset[str]:
    """Return the family names of matplotlib's fonts. The first call loads them into Qt (5 ms).

    Some Linux distributions store these fonts in a different folder. In this case, the set is
    empty, and the program uses the system's fonts.
    """
    folder = font_folder()
    files = [folder / name for name in _FILES] if folder else []
    loaded = [QFontDatabase.addApplicationFont(str(file)) for file in files if file.is_file()]
    families = (QFontDatabase.applicationFontFamilies(number) for number in loaded)
    return frozenset(family for found in families for family in found)


def use_shipped_fonts() -> None:
    """Use matplotlib's fonts for all text, so that screenshots look the same on all systems."""
    assert SANS in shipped_families(), "matplotlib's fonts are missing"
    font = QFont(QApplication.font())
    font.setFamilies([SANS])
    font.setPointSizeF(_PICTURED)
    # These settings override those of the system's fontconfig.
    font.setHintingPreference(QFont.HintingPreference.PreferVerticalHinting)
    font.setStyleStrategy(QFont.StyleStrategy.NoSubpixelAntialias)
    QApplication.setFont(font)
