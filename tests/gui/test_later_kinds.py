"""A kind of error that only a later version knows, in the window."""

import json
import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import Qt

from inspector.language import translate_core_sentence, use_language
from inspector.panels.interval_filter import FILTERS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, open_clip
from twistcore import Kind, Review, detect, read_clip, write_session

LATER = "melted wax"


@pytest.fixture
def session(tmp_path):
    """A review of the walk whose second interval is of such a kind, undecided as all."""
    path = Path(shutil.copy(INJECTED, tmp_path / "walk.bvh"))
    clip = read_clip(path)
    session = path.with_name("walk.twist.json")
    write_session(clip, Review(detect(clip)), session)
    document = json.loads(session.read_text("utf-8"))
    for entry in document["intervals"]:
        entry |= {"kind": entry.get("kind", "counter-twist"), "carried": False, "joint": ""}
    document["schema"] = "twistcore.session/3"
    document["intervals"][1] |= {"kind": LATER, "joint": "Hips"}
    session.write_text(json.dumps(document), "utf-8")
    return session


@pytest.mark.thorough
def test_it_is_shown_kept_and_never_corrected(qtbot, window, session):
    before = json.loads(session.read_text("utf-8"))["intervals"][1]
    messages = []
    window.document.message.connect(lambda *told: messages.append(told[0]))
    open_clip(qtbot, window, session)
    sentence = f"that only a newer version of the program supports: 1 ({LATER})"
    assert sum(sentence in text for text in messages) == 1
    document = window.document
    judged = document.intervals[1]
    assert judged.interval.kind == LATER
    document.select_interval(judged.id, jump=True)
    qtbot.wait(50)
    assert LATER in window.detail.title.text()
    assert window.detail.why.text()
    table = window.intervals.table.model()
    cells = [
        table.index(row, column).data()
        for row in range(table.rowCount())
        for column in range(table.columnCount())
    ]
    assert LATER in cells
    tips = [
        table.index(row, 0).data(Qt.ItemDataRole.ToolTipRole) for row in range(table.rowCount())
    ]
    assert len({*tips}) > 1
    act(window, "accept")
    assert judged.interval not in document.review.state.chosen()
    window.files.save_session()
    entry = json.loads(session.read_text("utf-8"))["intervals"][1]
    kept = "decision", "reviewer", "decided_at"
    assert entry["decision"] == "accepted"
    assert {k: v for k, v in entry.items() if k not in kept} == {
        k: v for k, v in before.items() if k not in kept
    }
    window.document.go_to(judged.interval.start)
    close_window(qtbot, window)


def test_kinds_have_their_words_in_the_list_and_the_filter():
    labels = [name for name in FILTERS if name in {kind.info.label for kind in Kind}]
    assert labels == [kind.info.label for kind in Kind]
    assert [translate_core_sentence(kind) for kind in (Kind.LIMB_FLIP, Kind(LATER))] == [
        "limb flip",
        LATER,
    ]
    use_language("de")
    try:
        assert translate_core_sentence(Kind.LONE_JUMP) != "lone jump"
    finally:
        use_language("en")
