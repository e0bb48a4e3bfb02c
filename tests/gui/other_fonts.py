"""Fonts as other systems have them: higher, for what is between lines, or wider."""

from fontTools.ttLib import TTFont
from PySide6.QtGui import QFont, QFontDatabase, QFontMetricsF
from PySide6.QtWidgets import QApplication

from inspector.widgets.fonts import font_folder


def other_font(folder, *, higher=1.0, wider=1.0):
    """The program's font as one whose lines are higher, or whose letters are wider; loaded."""
    family = f"Other Sans {higher} {wider}"
    with TTFont(font_folder() / "DejaVuSans.ttf") as font:
        for name in font["name"].names:
            if name.nameID in (1, 4, 6, 16):
                name.string = family
        for table, above, below in (
            ("hhea", "ascent", "descent"),
            ("OS/2", "usWinAscent", "usWinDescent"),
        ):
            for edge in (above, below):
                setattr(font[table], edge, round(higher * getattr(font[table], edge)))
        widths = font["hmtx"].metrics
        for letter, (width, left) in widths.items():
            widths[letter] = round(wider * width), left
        font.save(folder / f"{family}.ttf")
    number = QFontDatabase.addApplicationFont(str(folder / f"{family}.ttf"))
    assert QFontDatabase.applicationFontFamilies(number) == [family]
    found, usual = QFont(QApplication.font()), QFontMetricsF(QApplication.font())
    found.setFamilies([family])
    new = QFontMetricsF(found)
    assert (new.height() > usual.height()) == (higher > 1.0)
    assert (new.horizontalAdvance("x") > usual.horizontalAdvance("x")) == (wider > 1.0)
    return found
