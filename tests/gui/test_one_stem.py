"""Two clips of one stem and two formats in a folder: what is kept of each is its own."""

import shutil
from pathlib import Path

import pytest

from inspector.session.export_files import ExportChoice
from inspector.session.leftovers import clips_to_restore
from inspector.session.session_files import fallback_session_path, find_existing_sessions
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, decisions, open_clip
from tests.twistcore.amass_files import write_amass
from twistcore.export.exported_clips import find_exports_and_their_sources
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.review import Decision
from twistcore.review.folder_sessions import session_files_by_clip

pytestmark = pytest.mark.thorough


def two_of_one_stem(folder):
    """The same walk as BVH and as AMASS would have it."""
    bvh = Path(shutil.copy(INJECTED, folder / "walk.bvh"))
    return bvh, write_amass(folder / "walk.npz", read_bvh(INJECTED).motion, own=False)


def test_two_clips_of_one_stem_share_neither_session_nor_exports(qtbot, show_window, tmp_path):
    window, said = show_window(), []
    window.document.message.connect(lambda text, _: said.append(text))
    window.document.recovery.question.connect(lambda text, _: said.append(text))
    clips = two_of_one_stem(tmp_path)
    for clip, count in zip(clips, (1, 2), strict=True):
        open_clip(qtbot, window, clip)
        assert set(decisions(window)) == {Decision.UNDECIDED}
        act(window, "next_interval")
        for _ in range(count):
            act(window, "accept")
        act(window, "save_session")
        out = clip.with_stem("walk_refined")
        window.files.export(ExportChoice(out))
        assert window.exporter.finish()
    names = {path.name for path in tmp_path.iterdir() if not path.name.endswith(".lock")}
    report = ("report.html", "report.json", "intervals.csv", "markers.py", "replay.json")
    assert names == {
        *("walk.bvh", "walk.twist.json", "walk.npz", "walk.npz.twist.json"),
        *("walk_refined.bvh", *(f"walk_refined.{end}" for end in report)),
        *("walk_refined.npz", *(f"walk_refined.npz.{end}" for end in report)),
    }
    assert find_exports_and_their_sources(clip_paths_in_folder(tmp_path)) == {
        c.with_stem("walk_refined"): c.name for c in clips
    }
    found = session_files_by_clip(tmp_path).of
    assert {c.name: s.name for c, s in found.items()} == {
        "walk.bvh": "walk.twist.json",
        "walk.npz": "walk.npz.twist.json",
    }
    for clip, count in zip(clips, (1, 2), strict=True):
        open_clip(qtbot, window, clip)
        assert decisions(window).count(Decision.ACCEPTED) == count
    assert not [text for text in said if "has changed" in text or "another review" in text]


def test_a_journal_left_of_one_is_offered_for_that_one(qtbot, show_window, tmp_path):
    bvh, npz = two_of_one_stem(tmp_path)
    window = show_window()
    open_clip(qtbot, window, npz)
    act(window, "next_interval")
    act(window, "accept")
    journal = tmp_path / "walk.npz.twist.json.journal"
    kept = journal.read_bytes()
    close_window(qtbot, window)
    journal.write_bytes(kept)
    assert clips_to_restore(tmp_path, [bvh, npz]) == {npz}
    window = show_window()
    open_clip(qtbot, window, bvh)
    assert not window.bar.asks
    open_clip(qtbot, window, npz)
    assert "1 step" in window.bar.label.text()


def test_a_session_of_another_format_is_not_an_earlier_version(qtbot, window, tmp_path):
    """One that got its name from the stem alone is still found, by the clip that it is of."""
    bvh, npz = two_of_one_stem(tmp_path)
    open_clip(qtbot, window, npz)
    act(window, "next_interval")
    act(window, "accept")
    assert window.document.keeper.save(tmp_path / "walk.twist.json")[0]
    (
        fallback_session_path(npz).with_name(
            f"{fallback_session_path(npz).name[:-11]}.elsewhere.json"
        )
    ).unlink(True)
    assert find_existing_sessions(bvh) == []
    assert find_existing_sessions(npz) == [tmp_path / "walk.twist.json"]
    open_clip(qtbot, window, bvh)
    assert not window.bar.asks
    assert set(decisions(window)) == {Decision.UNDECIDED}
