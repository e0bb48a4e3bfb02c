"""Fonts that come with the program, so that numbers stand in columns alike on every machine.

They are matplotlib's, which the window needs anyway: no file of ours has any.
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
_PICTURED = 9.0  # points


def font_folder() -> Path | None:
    """Return the folder of matplotlib's fonts without importing it; None where it is not there."""
    spec = find_spec("matplotlib")
    places = (spec and spec.submodule_search_locations) or ()
    return next((Path(place) / _FOLDER for place in places), None)


@cache
def shipped_families() -> frozenset[str]:
    """Load the fonts into Qt the first time, and return their families; takes 5 ms.

    A package of a distribution may have put them elsewhere: then the set is empty, and the system's
    fonts are used.
    """
    folder = font_folder()
    files = [folder / name for name in _FILES] if folder else []
    loaded = [QFontDatabase.addApplicationFont(str(file)) for file in files if file.is_file()]
    families = (QFontDatabase.applicationFontFamilies(number) for number in loaded)
    return frozenset(family for found in families for family in found)


def use_shipped_fonts() -> None:
    """Set the whole program in them, for pictures that are the same on every machine."""
    assert SANS in shipped_families(), "matplotlib's fonts are missing"
    font = QFont(QApplication.font())
    font.setFamilies([SANS])
    font.setPointSizeF(_PICTURED)
    # Fontconfig's settings of a machine say how letters are drawn, unless the font does.
    font.setHintingPreference(QFont.HintingPreference.PreferVerticalHinting)
    font.setStyleStrategy(QFont.StyleStrategy.NoSubpixelAntialias)
    QApplication.setFont(font)
