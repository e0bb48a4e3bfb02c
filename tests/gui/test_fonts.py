"""Fonts: numbers, and all letters where a system has none, are set in the shipped ones."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtGui import QFontInfo, QFontMetricsF

from inspector.widgets import fonts
from inspector.widgets.theme import figures_font

CHECKOUT = Path(__file__).parents[2]
ON_LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="fontconfig's settings")
CONFIG = """<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig><dir>{folder}</dir><cachedir>{folder}/cache</cachedir>
<match target="pattern"><edit name="hintstyle" mode="append"><const>{hints}</const></edit></match>
</fontconfig>"""
DRAWN = """
import hashlib, sys
from inspector.widgets import fonts
assert fonts.font_folder() is not None
print("matplotlib" in sys.modules)
from inspector.app import make_application
app = make_application()
from PySide6.QtGui import QFontInfo, QImage, QPainter
from inspector.widgets import theme
if sys.argv[1:] == ["shipped"]:
    fonts.use_shipped_fonts()
def drawn(font, text):
    image = QImage(400, 40, QImage.Format.Format_RGB32)
    image.fill(0xFFFFFFFF)
    painter = QPainter(image)
    painter.setFont(font)
    painter.drawText(5, 25, text)
    painter.end()
    return hashlib.sha256(bytes(image.constBits())).hexdigest()
for font in (app.font(), theme.figures_font()):
    one, other = drawn(font, "Twist 0.12"), drawn(font, "Swing 3.45")
    print(QFontInfo(font).family(), one != other, one, sep="|")
"""


def drawn_with(folder, *words, hints="hintslight"):
    """The lines of DRAWN in a system that has no fonts, and draws letters as its settings say."""
    config = folder / f"{hints}.conf"
    config.write_text(CONFIG.format(folder=folder, hints=hints))
    done = subprocess.run(
        [sys.executable, "-c", DRAWN, *words],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), "FONTCONFIG_FILE": str(config)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [line.split("|") for line in done.stdout.splitlines()]


def test_numbers_have_one_width_in_the_shipped_font(qapp):
    font = figures_font(9.0)
    assert QFontInfo(font).family() == fonts.FIXED
    letters = QFontMetricsF(font)
    assert len({letters.horizontalAdvance(c) for c in "0123456789+−.°iW"}) == 1


def test_matplotlib_has_every_font_that_is_loaded(qapp):
    assert [name for name in fonts._FILES if not (fonts.font_folder() / name).is_file()] == []
    assert fonts.shipped_families() == {fonts.SANS, fonts.FIXED}


def test_numbers_are_set_by_the_system_where_matplotlib_has_no_fonts(qapp, monkeypatch):
    monkeypatch.setattr(fonts, "font_folder", lambda: None)
    monkeypatch.setattr(
        "inspector.widgets.theme.shipped_families", fonts.shipped_families.__wrapped__
    )
    assert fonts.FIXED not in figures_font().families()
    assert figures_font(8.0).pointSizeF() == 8.0


@ON_LINUX
def test_a_system_without_fonts_shows_letters(tmp_path):
    """No boxes, which look all alike; and matplotlib is not imported for it."""
    imported, sans, fixed = drawn_with(tmp_path)
    assert imported == ["False"]
    assert sans[:2] == [fonts.SANS, "True"]
    assert fixed[:2] == [fonts.FIXED, "True"]


@pytest.mark.thorough
@ON_LINUX
def test_pictures_are_the_same_whatever_a_system_says_of_letters(tmp_path):
    ways = ("hintnone", "hintslight", "hintfull")
    assert drawn_with(tmp_path, hints=ways[0]) != drawn_with(tmp_path, hints=ways[2])
    lines = [drawn_with(tmp_path, "shipped", hints=way) for way in ways]
    assert lines[0] == lines[1] == lines[2]
