"""The tables as a person uses them: nothing cut, the search, the columns, Tab, names and signs."""

import re
import time

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.gui.real_screen import needs_real_screen, real_screen, watched

pytestmark = pytest.mark.thorough

OWN = {  # the same rig with another program's names
    "Shoulder": "clavicle", "ForeArm": "radius", "Arm": "humerus", "Hand": "hand",
    "UpLeg": "femur", "Leg": "tibia", "Foot": "foot",
}  # fmt: skip
TABLE = "window.intervals.table"
# Cells, but for names that end in dots, and columns that are not to be seen in full.
CUT = f"""[(c, i.data()) for t in [{TABLE}] for m in [t.model()]
 for c in range(1, m.columnCount()) if not t.isColumnHidden(c)
 for r in range(m.rowCount()) for i in [m.index(r, c)]
 if t.columnViewportPosition(c) + t.columnWidth(c) > t.viewport().width()
 or t.sizeHintForIndex(i).width() > t.columnWidth(c)]"""


def renamed(folder):
    """The walk with eight errors, its joints called as in the ASF format."""
    text = (ASSETS / "walk_injected.bvh").read_text()
    for side in ("Left", "Right"):
        for ours, other in OWN.items():
            text = re.sub(rf"\b{side}{ours}\b", f"{side[0].lower()}{other}", text)
    path = folder / "walk.bvh"
    path.write_text(text)
    return path


def heading(p, head):
    """The rectangle of a heading of the table of intervals."""
    return p.ask(
        f"""next(rect(h.viewport(), type(h.viewport().rect())(
        h.sectionViewportPosition(c), 0, h.sectionSize(c), h.height()))
        for t in [{TABLE}] for h in [t.horizontalHeader()] for c in range(h.count())
        if t.model().headerData(c, Qt.Orientation.Horizontal).strip() == {head!r})"""
    )


def entry_of_menu(p, text):
    """The rectangle of an entry of the menu that is open, once it is."""
    return p.until(
        f"""next((rect(m, m.actionGeometry(a)) for m in app.topLevelWidgets()
        if m.isVisible() and hasattr(m, 'actionGeometry') for a in m.actions()
        if a.text() == {text!r}), None)"""
    )


def marks(picture):
    """How many things stand beside each other in a picture, two empty pixels between them."""
    paper = picture[picture.shape[0] // 2, 2]
    inked = (np.abs(picture[2:-3].astype(int) - paper).max(axis=-1) > 40).any(axis=0)
    at = np.flatnonzero(inked)
    return int((np.diff(at) > 2).sum()) + 1 if at.size else 0


@needs_real_screen
def test_a_review_in_the_tables(tmp_path, look):
    clip = renamed(tmp_path)
    with (
        real_screen(tmp_path, size=(1440, 900), look=look) as screen,
        watched(screen, tmp_path, clip) as p,
    ):
        # The file's own names, and a real minus, in the status bar.
        screen.key("n", "n")
        p.until("window.document.interval is window.document.intervals[1]")
        said = p.ask("window.signs.position.text()")
        assert "(lradius → lhand)" in said
        assert "−109.1°" in said
        assert "-" not in said

        # The mark of the order stands beside δ.
        delta = heading(p, "δ")
        screen.click(delta)
        screen.park()
        p.settle()
        assert marks(screen.picture(heading(p, "δ"))) == 2
        for order in ("-delta", ""):  # the other way round, and no longer
            time.sleep(0.5)  # else it is a double click
            screen.click(heading(p, "δ"))
            p.until(f"window.settings.interval_sort == {order!r}")

        # An accepted one that τ leaves behind: a longer decision, and nothing is cut.
        screen.key(*8 * ["ctrl+Left"], "bracketleft")
        p.settle()
        p.until("window.viewport.has_painted_interval()")
        screen.key("a")
        p.until("any(j.decision.value == 'accepted' for j in window.document.intervals)")
        screen.key("ctrl+t")
        p.until("window.tuning.box.isVisible()")
        p.settle()
        screen.click(p.rect("window.tuning.box"))
        p.until("window.tuning.box.hasFocus()")
        screen.key("ctrl+a")
        screen.type("140\n")
        p.until("window.tuning.box.value() == 140.0")
        screen.click(p.ask("row(window.chains.table, 2)"))
        screen.key("ctrl+f", "Escape")
        p.until(f"any('accepted <τ' in str({TABLE}.model().index(r, 1).data()) for r in range(8))")
        assert p.ask(CUT) == []
        left, top, _, high = p.rect("window.docks['intervals']")
        p.drag((left - 2, top + high // 2), (left + 400, top + high // 2))
        p.settle()
        assert p.ask("window.intervals.width()") < 500
        assert p.ask(CUT) == []
        now = p.rect("window.docks['intervals']")[0]
        p.drag((now - 2, top + high // 2), (left, top + high // 2))
        screen.key("ctrl+z", "ctrl+z", "ctrl+z")
        p.until("not window.document.review.undo_text")

        # What is searched for is all that is listed, and all that is judged.
        screen.key("ctrl+f")
        screen.type("femur >0.9")
        p.until("len(window.intervals.shown_ids()) == 5")
        assert p.ask("window.intervals.count.text()") == "5 of 8 listed"
        assert set(p.decisions()) == {"undecided"}  # the letters were words
        p.press("Return", "ctrl+a", "a")
        p.until("sum(j.decision.value == 'accepted' for j in window.document.intervals) == 5")
        assert p.ask("{j.interval.chain for j in window.document.intervals"
                     " if j.decision.value == 'undecided'}") == "{'lradius'}"  # fmt: skip
        screen.key("ctrl+f", "Escape")
        p.until("len(window.intervals.shown_ids()) == 8")
        assert p.ask(f"window.focusWidget() is {TABLE}")

        # Columns are chosen on the heading.
        screen.click(heading(p, "Chain"), button=3)
        screen.click(entry_of_menu(p, "Joints in the file"))
        p.until(f"'joints' in window.settings.columns and not {TABLE}.isColumnHidden(10)")
        assert "lradius → lhand" in p.ask(
            f"[{TABLE}.model().index(r, 10).data() for r in range(8)]"
        )

        # Tab leaves the chains.
        screen.click(p.ask("row(window.chains.table, 1)"))
        p.until("window.focusWidget() is window.chains.table")
        screen.key("Tab")
        p.until("window.focusWidget() is not window.chains.table")
