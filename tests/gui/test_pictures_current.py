"""Pictures of the docs show the program as it is: some are taken again and compared."""

import sys

import numpy as np
import pytest
from PySide6.QtGui import QImage

from inspector import shots
from inspector.bundled import DOCS

# Those that show most: all docks with a review under way, and the tab that has most in it. Taken on
# the same machine pictures are the same byte for byte; other drivers differ a little.
TAKEN = ("inspector", "teaching")
TILE = 12  # pixels
DIFFERS = 5.0  # of 255, a tile's mean; letters drawn a little softer stay below
SHARE = 0.001  # of all tiles; another word in the tool bar is 0.0022


def tiles(path):
    """Mean brightness of each tile, (rows, columns)."""
    image = QImage(str(path)).convertToFormat(QImage.Format.Format_Grayscale8)
    assert not image.isNull(), path
    lines = np.frombuffer(image.constBits(), dtype=np.uint8)
    lines = lines.reshape(image.height(), image.bytesPerLine())[:, : image.width()]
    high, wide = image.height() // TILE, image.width() // TILE
    cut = lines[: high * TILE, : wide * TILE].astype(float)
    return cut.reshape(high, TILE, wide, TILE).mean(axis=(1, 3))


def changed(one, other):
    """Which share of a picture shows something else."""
    before, now = tiles(one), tiles(other)
    assert before.shape == now.shape
    return float((np.abs(before - now) > DIFFERS).mean())


@pytest.fixture(autouse=True)
def chain_by_chain():
    """The worst interval first: pictures show what a new user sees."""


@pytest.fixture
def taken(qapp, tmp_path, monkeypatch):
    """Pictures taken now, elsewhere than those of the docs."""
    folder = tmp_path / "docs" / "images"
    monkeypatch.setattr(shots, "IMAGES", folder)
    monkeypatch.setattr(sys, "argv", ["shots", *TAKEN])
    assert shots.main() == 0
    return folder


@pytest.mark.thorough
def test_the_window_is_as_pictured(taken):
    for name in TAKEN:
        share = changed(DOCS / "images" / f"{name}.png", taken / f"{name}.png")
        assert share < SHARE, f"{name}: {share:.2%} is other; take them again: python3 dev.py shot"


def test_one_picture_is_not_another():
    images = DOCS / "images"
    assert changed(images / "inspector.png", images / "both-detectors.png") > 10 * SHARE
