"""What screen readers say where a person who sees reads a sign, a bar or a place."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QWidget

from inspector.folder.clips_panel import ClipsPanel
from inspector.folder.informative_intervals import InformativeIntervals
from inspector.folder.queued_clip import ClipState, QueuedClip
from inspector.panels.end_choice import EndChoice
from inspector.panels.history_panel import HistoryPanel
from inspector.panels.interval_columns import PLACE
from inspector.session.document import Document
from inspector.widgets.building import tool_button
from inspector.widgets.keyed_list import KeyedList
from inspector.widgets.labels import ElidedLine
from inspector.widgets.theme import DARK, Colours
from twistcore.review import Decision

ONE_WINDOW = True
SPOKEN = Qt.ItemDataRole.AccessibleTextRole


def name(widget):
    return QAccessible.queryAccessibleInterface(widget).text(QAccessible.Text.Name)


def test_bars_and_ticks_of_the_table_of_clips_are_said(qtbot, queue):
    document = Document()
    panel = ClipsPanel(queue, document, Colours(DARK), InformativeIntervals(queue, document))
    qtbot.addWidget(panel)
    path = Path("walk.bvh")
    clip = QueuedClip(
        path, ClipState.READY, 1.25, 3, decided=(1, 3), exported="walk_fixed.bvh", waits=True
    )
    queue.clips = {path: clip}
    queue.changed.emit()
    model = panel.table.model()
    assert [model.index(0, k).data(SPOKEN) for k in range(4)] == [
        "walk: unsaved decisions can be restored",
        "severity 1.2°",
        "1 / 3",
        "exported as walk_fixed.bvh",
    ]
    queue.clips = {}


def test_joints_beside_a_chain_are_said_with_it(opened):
    model = opened.chains.table.model()
    row = next(k for k, thing in enumerate(model.things) if not thing.joints)
    assert model.index(row, 0).data(SPOKEN) == model.things[row].label
    assert model.index(row, 3).data(SPOKEN) == model.index(row, 3).data()


@pytest.mark.thorough
def test_a_decision_is_said_without_its_sign(opened):
    model = opened.intervals.table.model()
    at = model.index(0, PLACE["decision"])
    assert (at.data(), at.data(SPOKEN)) == ("· undecided", "undecided")


@pytest.mark.thorough
def test_a_step_that_was_undone_is_said_to_be(opened):
    opened.document.decide(Decision.ACCEPTED, [opened.document.intervals[0].id])
    (panel,) = opened.findChildren(HistoryPanel)
    steps, told = panel.list, Qt.ItemDataRole.AccessibleDescriptionRole
    assert [steps.item(k).data(told) for k in (0, 1)] == ["", ""]
    opened.document.undo()
    assert [steps.item(k).data(told) for k in (0, 1)] == ["", "undone"]


def test_a_button_with_a_sign_says_its_tip(qtbot):
    sign, word = tool_button("✕", "Close"), tool_button("Keep", "Kept (Enter)")
    for button in (sign, word):
        qtbot.addWidget(button)
    assert [name(sign), name(word)] == ["Close", "Keep"]


def test_the_end_of_a_limb_is_said_with_what_became_of_it(qtbot):
    end = EndChoice()
    qtbot.addWidget(end)
    end.show_end("foot", carried=True)
    assert [name(button) for button in end.choices.values()] == [
        "Foot: kept",
        "Foot: carried along",
    ]


def test_a_row_with_a_key_says_both(qtbot):
    keyed = KeyedList(keys_first=False)
    qtbot.addWidget(keyed)
    keyed.add("Accept", "A")
    keyed.add("Nothing", "")
    assert [keyed.item(k).data(SPOKEN) for k in (0, 1)] == ["Accept, A", None]


def test_a_line_that_stands_still_is_said(qtbot):
    line = ElidedLine()
    qtbot.addWidget(line)
    for frame in range(5):
        line.set_text(f"frame {frame}")
    assert line.accessibleName() == ""
    qtbot.waitUntil(lambda: line.accessibleName() == "frame 4")


@pytest.mark.thorough
def test_what_can_have_the_keyboard_in_panels_has_a_name(opened):
    panels = opened.chains, opened.clips, opened.intervals, opened.detail, opened.transport
    asked = [w for panel in (*panels, opened.video) for w in panel.findChildren(QWidget)]
    asked = [w for w in asked if w.window() is opened]  # no lists that a box opens
    own = (w for w in asked if not isinstance(w.parent(), QAbstractSpinBox | QComboBox))
    focused = [w for w in own if w.focusPolicy() & Qt.FocusPolicy.TabFocus]
    assert len(focused) > 15
    nameless = [(type(w).__name__, w.objectName(), w.parent()) for w in focused if not name(w)]
    assert nameless == []
