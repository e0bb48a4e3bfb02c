"""An AMC in the window: reviewed, exported, taught, as a BVH is."""

import re

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QLabel

from inspector.session.export_files import ExportChoice, uncorrected_warning
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, open_clip
from tests.twistcore.amass_files import write_amass
from tests.twistcore.amc_files import numbers, written
from tests.twistcore.test_amc import LIMB, dirty
from twistcore.cli import main
from twistcore.formats.bvh import read_bvh

pytestmark = pytest.mark.thorough

ONE_WINDOW = True


@pytest.fixture
def window(window_for_clips):
    """The program's window: each test opens a clip of its own."""
    return window_for_clips(Settings(turn_ms=0))


def test_an_amc_is_reviewed_and_exported(qtbot, window, tmp_path, capsys):
    path, out, again = dirty(tmp_path / "in", False), tmp_path / "out.amc", tmp_path / "again.amc"
    open_clip(qtbot, window, path)
    document = window.document
    assert document.data.clip.format == "amc"
    document.accept_undecided()
    assert [i.chain for i in document.review.state.chosen()] == [LIMB]
    assert uncorrected_warning(document) == ""
    window.files.export(ExportChoice(out))
    assert window.exporter.finish()
    assert "in 8 frames" in window.bar.label.text()
    assert main(["refine", str(path), "-o", str(again)]) == 0
    assert out.read_bytes() == again.read_bytes()
    document.review.mark_saved()


def test_its_angles_are_told_about_the_axes_of_the_bone(qtbot, window, tmp_path):
    open_clip(qtbot, window, written(tmp_path / "in", True))
    window.document.select_chain("lhumerus")
    window.document.go_to(90)
    act(window, "show_teaching")
    forms = window.teaching.other_forms
    qtbot.mouseClick(forms.head, Qt.MouseButton.LeftButton, pos=QPoint(20, 6))
    x, y, z = numbers(True)["lhumerus"][90]
    told = re.findall(r"([XYZ]) ([+−-][0-9.]+)", forms.values["parent"].text())
    assert [letter for letter, _ in told] == ["Z", "Y", "X"]
    shown = [float(number.replace("−", "-")) for _, number in told]
    assert shown == pytest.approx([z, y, x], abs=0.006)


def test_the_export_says_before_what_the_figure_cannot_turn(qtbot, window, tmp_path):
    open_clip(qtbot, window, dirty(tmp_path / "in", False))
    act(window, "next_interval")
    act(window, "turn_end")  # a kept foot would have to turn about an axis that it has not
    act(window, "accept")
    dialog = ExportDialog(window.document, window)
    qtbot.addWidget(dialog)
    assert "rfoot" in " ".join(label.text() for label in dialog.findChildren(QLabel))
    window.document.review.mark_saved()


def test_clips_of_other_skeletons_open_one_after_the_other(qtbot, window, tmp_path):
    """While rows of the old chains go, the table's current row is no choice of a person."""
    clips = (
        INJECTED,
        written(tmp_path, True),
        write_amass(tmp_path / "a.npz", read_bvh(INJECTED).motion),
    )
    chosen = []
    window.document.chain_changed.connect(lambda: chosen.append(window.document.chain))
    for clip in (*clips, INJECTED):
        open_clip(qtbot, window, clip)
        document, table = window.document, window.chains.table
        assert (
            table.currentIndex().data().startswith(document.find_chain(document.chain).list_label)
        )
    assert chosen == []


def test_knobs_greyed_from_the_start_say_nothing_and_keep_their_room(qtbot, show_window):
    window = show_window()
    open_clip(qtbot, window, INJECTED)
    data = window.document.data
    window.document.select_chain(data.analysis.limbs[0].name)
    act(window, "show_teaching")
    knobs = window.teaching.what_if.numbers
    assert {label.text() for label in knobs.values()} == {""}
    before = {name: label.width() for name, label in knobs.items()}
    window.document.select_chain(data.chains[0].name)
    qtbot.waitUntil(lambda: knobs["swing"].text() != "")
    assert {name: label.width() for name, label in knobs.items()} == before
    knobs["swing"].setText("180.0°")
    assert knobs["swing"].width() == before["swing"]
