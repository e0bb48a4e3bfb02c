"""On whatever desktop: the tests by hand meet every look, and Qt's own dialogs are seen in each."""

from pathlib import Path

import pytest
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QFileDialog, QToolButton

from inspector.session.settings import Settings
from inspector.widgets.write_dialog import WriteDialog
from tests.gui.looks import EVERY, LOOKS
from tests.gui.windows import act, open_clip

HERE = Path(__file__).parent
SEEN = 100  # of 255 that a line is lighter or darker than what is behind it


class Collected:
    """The looks of each test that is collected."""

    def __init__(self):
        self.looks = {}

    def pytest_collection_modifyitems(self, items):
        for item in items:
            if "look" in item.fixturenames:
                look = item.callspec.params["look"]
                self.looks.setdefault(item.originalname, set()).add(look)


def test_the_tests_by_hand_meet_every_look_between_them():
    modules = map(str, sorted(HERE.glob("test_*_by_hand.py")))
    by_hand = Collected()
    words = ["--collect-only", "-qq", "-p", "no:cacheprovider", *modules]
    assert pytest.main(words, [by_hand]) == 0
    assert set().union(*by_hand.looks.values()) == set(LOOKS)
    assert {len(looks) for looks in by_hand.looks.values()} == {len(LOOKS) if EVERY else 1}


@pytest.mark.parametrize("asks", ["open_dialog", "open_folder"])
def test_a_clip_is_looked_for_next_to_the_open_one(qtbot, window, clip, asks):
    open_clip(qtbot, window, clip)
    act(window, asks)
    (dialog,) = window.findChildren(QFileDialog)
    assert Path(dialog.directory().absolutePath()) == clip.parent
    dialog.reject()


@pytest.mark.thorough
@pytest.mark.parametrize("asks", ["open_dialog", "open_folder", "browse"])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_arrows_of_qts_own_file_dialog_are_seen(show_window, theme, asks):
    window = show_window(Settings(theme=theme))
    if asks == "browse":
        form = WriteDialog("Write", Path("clip.bvh"), window)
        form._browse()
    else:
        act(window, asks)
    (dialog,) = window.findChildren(QFileDialog)
    for name in ("backButton", "forwardButton", "toParentButton"):
        button = dialog.findChild(QToolButton, name)
        button.setEnabled(True)
        picture = button.grab().toImage()
        ground = dialog.palette().window().color().lightness()
        lines = [
            QColor(picture.pixel(x, y)).lightness()
            for x in range(picture.width())
            for y in range(picture.height())
        ]
        assert max(abs(line - ground) for line in lines) > SEEN, name
    dialog.reject()
