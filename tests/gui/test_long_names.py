"""Clips whose names leave no room for those of the files beside them: kept elsewhere, and told."""

import shutil

import pytest

from inspector.session.export_files import ExportChoice
from inspector.session.session_files import fallback_session_path, journals
from inspector.session.settings import Settings
from tests.gui.pictures import INJECTED
from tests.gui.windows import export, open_clip
from tests.tiers import parametrize
from twistcore.review import Decision, read_session, replay_journal

pytestmark = pytest.mark.thorough


@parametrize("name", ["w" * 232, "ü" * 125 + "w"], ids=["232 bytes", "251 bytes"])
def test_a_review_of_it_is_kept_and_an_export_beside_it_is_told(qtbot, show_window, tmp_path, name):
    folder = tmp_path / "clips"
    folder.mkdir()
    clip = folder / f"{name}.bvh"
    shutil.copy(INJECTED, clip)
    window = show_window(Settings(turn_ms=0, recent=[str(clip)]))
    window.files.offer_unsaved()
    open_clip(qtbot, window, clip)
    assert window.bar.label.text()
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    assert replay_journal(window.document.keeper.journal.path).steps == 1
    assert window.files.save_session()
    assert "The session was saved as" in window.bar.label.text()
    assert len(read_session(fallback_session_path(clip)).state.chosen()) == 1
    assert not journals(fallback_session_path(clip))
    if len(name) == 126:
        export(window, ExportChoice(folder / f"{name}.refined.bvh"))
        assert "File name too long" in window.bar.label.text()
    export(window, ExportChoice(folder / "out.bvh"))
    assert window.bar.label.text()
    assert not [path.name for path in folder.iterdir() if path.name.endswith(".part")]
    open_clip(qtbot, window, clip)
    assert len(window.document.review.state.chosen()) == 1
