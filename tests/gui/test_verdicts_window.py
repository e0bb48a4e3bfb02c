"""What verdicts say, in the Tuning tab: τ, the learned confidence, profiles that are remembered."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtWidgets import QLabel

from inspector.language import use_language
from inspector.lessons.classroom import open_for_review
from inspector.panels.accept_confident_dialog import AcceptConfidentDialog
from inspector.session.document import BLIND
from inspector.session.open_clip import Borrowed
from inspector.session.settings import Settings
from inspector.tuning.verdict_evidence import CLIP, FOLDER, Scope
from inspector.tuning.verdict_page import needed_verdicts_sentence
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, open_clip
from tests.twistcore.test_verdicts import folder as folder_of
from tests.twistcore.test_verdicts import together
from twistcore.analysis.clip_analysis import detect
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision, LeaveOut, Review, write_session
from twistcore.tuning.verdict_curve import tau_curve_from_verdicts
from twistcore.tuning.verdicts_of import is_judged_counter_twist

ONE_WINDOW = True

TIME = "2026-01-01T00:00:00+00:00"


@pytest.fixture
def folder(tmp_path):
    """Clips 05_00 to 05_03, all but the first judged: of each the first interval is rejected."""
    for k in range(4):
        path = shutil.copy(INJECTED, tmp_path / f"05_0{k}.bvh")
        if k:
            clip = read_bvh(path)
            state = Review.of(detect(clip)).state
            said = [Decision.REJECTED] + [Decision.ACCEPTED] * (len(state.intervals) - 1)
            judged = [
                replace(j, decision=d, decided_at=TIME)
                for j, d in zip(state.intervals, said, strict=True)
            ]
            write_session(clip, state.with_intervals(judged), tmp_path / f"05_0{k}.twist.json")
    return tmp_path


@pytest.fixture
def window(qtbot, window_for_clips, folder):
    window = window_for_clips(Settings(turn_ms=0), (1440, 900))
    open_clip(qtbot, window, folder / "05_00.bvh")
    return window


def look(qtbot, window, page):
    """Bring a page to the front and wait until it is counted."""
    act(window, "show_tuning")
    tuning = window.tuning
    tuning.tabs.setCurrentWidget(page)
    evidence = tuning.evidence
    qtbot.waitUntil(lambda: evidence.present is not None and not evidence.running, timeout=30_000)
    qtbot.wait(50)


def rows(page):
    return {line.name: line.texts for line in page.model.things}


def test_nobody_has_decided_anything(qtbot, show_window, tmp_path):
    window = show_window(size=(1440, 900))
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    page = window.tuning.verdicts
    look(qtbot, window, page)
    assert page.hint.isVisible()
    assert "(A)" in page.hint.text()
    assert "10 accepted counter-twists" in page.hint.text()  # verdicts on other kinds do not count
    look(qtbot, window, window.tuning.confidence)
    assert "20" in window.tuning.confidence.hint.text()
    assert not window.tuning.confidence.use.isEnabled()
    assert not window.tuning.confidence.remember.isEnabled()


@pytest.mark.thorough
def test_verdicts_of_clip_performer_rig_and_folder_are_counted(qtbot, window):
    page = window.tuning.verdicts
    look(qtbot, window, page)
    assert rows(page)["Performer 05"][1:3] == ("21", "3")
    assert "This clip" not in rows(page)  # nothing is decided there
    document = window.document
    document.do(Decide((document.intervals[0].id,), Decision.REJECTED, "", TIME))
    qtbot.waitUntil(lambda: "This clip" in rows(page), timeout=10_000)
    assert rows(page)["This clip"][1:3] == ("0", "1")
    assert rows(page)["Folder"][1:3] == ("21", "4")
    precision = 100 * 21 / 25
    assert rows(page)["Folder"][3].startswith(f"{precision:.0f} % ±")


def test_use_takes_the_suggested_tau_in_one_step(qtbot, window):
    page, document = window.tuning.verdicts, window.document
    look(qtbot, window, page)
    before = dict(document.review.state.tau)
    page.show_scope("This rig")
    wanted = page.suggested()
    assert wanted.keys() == {c.name for c in document.data.chains}
    assert any(abs(before[n] - t) > 1e-6 for n, t in wanted.items())
    page.use.click()
    after = document.review.state.tau
    assert all(after[n] == t for n, t in wanted.items())
    qtbot.waitUntil(lambda: not page.use.isEnabled(), timeout=5_000)
    document.undo()
    assert dict(document.review.state.tau) == before


@pytest.mark.thorough
def test_a_person_says_how_small_errors_are_looked_for(qtbot, window):
    page, evidence = window.tuning.verdicts, window.tuning.evidence
    look(qtbot, window, page)
    before = evidence.present
    window.tuning.wishes.wish(smallest_degrees=5.0)
    qtbot.waitUntil(lambda: evidence.present is not before, timeout=10_000)
    page.show_scope("This rig")
    tau = np.degrees(page.suggested()["LeftArm"])
    assert 2.5 < tau <= 5.0


@pytest.mark.thorough
def test_learned_confidence_is_shown_once_a_person_says_so(qtbot, window, folder):
    document, page = window.document, window.tuning.confidence
    look(qtbot, window, page)
    own = [j.interval.confidence for j in document.intervals]
    said = [document.displayed(j).interval.confidence for j in document.intervals]
    assert said == own  # learned, but not asked for
    assert page.figure.isVisible()
    before, after = page.plot.before.getData(), page.plot.after.getData()
    assert len(before[0]) >= 1
    assert len(after[0]) >= 1
    dialog = AcceptConfidentDialog(document, lambda _: None, window)
    dialog.confidence.setValue(0.95)
    assert dialog.ok.isEnabled()
    drawn = window.intervals._model.describe(window.intervals._model.things[0]).texts
    page.use.click()
    learned = [document.displayed(j).interval.confidence for j in document.intervals]
    assert max(learned) < 0.95  # one of eight was rejected, however sure the detector
    assert learned == pytest.approx([document.learned(c) for c in own])
    assert not dialog.ok.isEnabled()
    assert window.intervals._model.describe(window.intervals._model.things[0]).texts != drawn
    document.accept_undecided(0.95)
    assert all(j.decision == Decision.UNDECIDED for j in document.intervals)
    assert [j.interval.confidence for j in document.intervals] == own  # a session keeps these
    page.use.click()
    assert dialog.ok.isEnabled()
    dialog.reject()


@pytest.mark.thorough
def test_a_profile_is_remembered_by_skeleton_and_offered(qtbot, window, folder, tmp_path):
    page, bar, document = window.tuning.confidence, window.bar, window.document
    look(qtbot, window, page)
    document.borrowed = Borrowed(tmp_path, "Nothing is kept.")  # as by a lesson
    page.refresh()
    assert (page.remember.isEnabled(), page.remember.toolTip()) == (False, "Nothing is kept.")
    document.borrowed = None
    page.refresh()
    page.remember.click()
    assert bar.label.text()
    another = tmp_path / "alone"
    another.mkdir()
    open_clip(qtbot, window, shutil.copy(INJECTED, another / "05_09.bvh"))
    qtbot.waitUntil(lambda: len(bar.buttons()) == 2, timeout=5_000)
    assert " 05 " in bar.label.text()
    automatic = dict(document.review.state.tau)
    assert document.learned is None  # offered, not taken
    use, _ = bar.buttons()
    use.click()
    assert dict(document.review.state.tau) != automatic
    assert document.learned is not None
    assert document.learned.accepted == 21
    document.review.mark_saved()
    # One who declines is not asked again in this run, and another performer's clip is not meant.
    for k, asked in ((8, True), (7, False)):
        open_clip(qtbot, window, shutil.copy(INJECTED, another / f"05_0{k}.bvh"))
        assert document.learned is None
        if asked:
            qtbot.waitUntil(lambda: len(bar.buttons()) == 2)
            bar.buttons()[1].click()
        else:
            qtbot.wait(100)
            assert len(bar.buttons()) != 2


@pytest.mark.thorough
def test_another_performers_clip_has_no_offer(qtbot, window, folder, tmp_path):
    page, bar = window.tuning.confidence, window.bar
    look(qtbot, window, page)
    page.remember.click()
    another = tmp_path / "alone"
    another.mkdir()
    open_clip(qtbot, window, shutil.copy(INJECTED, another / "06_01.bvh"))
    qtbot.wait(100)
    assert bar.buttons() == []


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_a_person_names_the_performer(qtbot, window):
    page, evidence = window.tuning.confidence, window.tuning.evidence
    look(qtbot, window, page)
    assert page.performer.text() == "05"
    page.performer.setText("Ann")
    page.performer.editingFinished.emit()
    qtbot.waitUntil(
        lambda: any(s.name == "Performer Ann" for s in evidence.present.scopes), timeout=10_000
    )
    path = window.document.data.clip.path
    assert type(evidence.performers)().of(path) == "Ann"


@pytest.mark.thorough
def test_frames_left_out_and_another_tau_are_counted_again(qtbot, window):
    page, document = window.tuning.verdicts, window.document
    first = document.intervals[0]
    document.do(Decide((first.id,), Decision.REJECTED, "", TIME))
    look(qtbot, window, page)
    evidence = window.tuning.evidence
    assert rows(page)["Folder"][1:3] == ("21", "4")
    document.do(LeaveOut(((first.interval.start, first.interval.stop),)))
    qtbot.waitUntil(lambda: rows(page)["Folder"][1:3] == ("21", "3"), timeout=10_000)
    before = evidence.present
    document.set_tau(0.3)
    qtbot.waitUntil(lambda: evidence.present is not before, timeout=10_000)


@pytest.mark.thorough
def test_the_sure_ones_are_no_verdicts_until_each_is_looked_at(qtbot, window):
    document = window.document
    assert document.accept_undecided(0.5)
    sure = [j for j in document.intervals if j.decision == Decision.ACCEPTED]
    assert sure
    assert not any(map(is_judged_counter_twist, sure))
    document.decide(Decision.ACCEPTED, [sure[0].id])  # A, on one that is accepted already
    assert is_judged_counter_twist(document.review.state.find(sure[0].id))


def test_what_a_chain_still_needs_is_said():
    clips = together(folder_of([30.0] * 12, [], 4, "L"), folder_of([], [3.0] * 3, 4, "X"))
    few = Scope("X", tuple(clips), tau_curve_from_verdicts(clips, "X"), chain="X")
    words = "2 more verdicts on this chain are needed to suggest a τ for this group."
    assert needed_verdicts_sentence(few) == words
    clips = folder_of([30.0] * 9, [3.0] * 9, 4)
    every = Scope("This rig", tuple(clips), tau_curve_from_verdicts(clips))
    words = "1 more accepted interval is needed to suggest a τ for this group."
    assert needed_verdicts_sentence(every) == words


@pytest.mark.thorough
def test_in_an_exercise_the_tab_tells_nothing(qtbot, window, folder, tmp_path):
    tuning, document = window.tuning, window.document
    look(qtbot, window, tuning.confidence)
    tuning.confidence.remember.click()
    tuning.tabs.setCurrentWidget(tuning.curves)
    act(window, "next_bar")
    shutil.copy(INJECTED, tmp_path / "05_09.bvh")
    document.show_clip(open_for_review(tmp_path / "05_09.bvh", []))
    qtbot.waitUntil(lambda: tuning.hint.text() == BLIND)
    assert tuning.hint.isVisible()
    assert not tuning.tabs.isVisible()
    assert not tuning.costs.running
    frame = document.frame
    for step in ("next_bar", "next_in_bar"):
        act(window, step)
        assert document.frame == frame
    qtbot.wait(50)
    assert not any("remembered" in b.text() for b in window.bar.findChildren(QLabel))
    open_clip(qtbot, window, folder / "05_00.bvh")
    qtbot.waitUntil(tuning.tabs.isVisible)


# -- kinds -----------------------------------------------------------------------------------------


def kinds_of(window):
    """Return the numbers (errors, found, false alarms, undecided) of each row of the page."""
    counts = window.tuning.kinds.counts().items()
    return {
        name: (c.score.errors, c.score.found, c.score.alarms, c.undecided) for name, c in counts
    }


def test_each_kind_has_a_bar_with_its_precision(qtbot, window):
    page = window.tuning.kinds
    look(qtbot, window, page)
    page.scopes.setCurrentText(FOLDER)
    found = kinds_of(window)
    errors, listed, alarms, undecided = found["Counter-twists"]
    assert (errors, alarms) == (listed, 3)
    assert undecided
    ticks = page.plot.axes["left"]._tickLevels[0]
    assert [label for _, label in ticks] == list(found)
    ends = page.plot.bars.opts["x1"]
    row = list(found).index("Counter-twists")
    assert ends[row] == pytest.approx(100.0 * listed / (listed + alarms))
    assert "Counter-twists" in page.plot.accessibleDescription()
    use_language("de")
    try:
        assert "Gegentwists" in page.counts()
    finally:
        use_language("en")


def test_a_verdict_in_this_clip_changes_its_row(qtbot, window):
    page = window.tuning.kinds
    look(qtbot, window, page)
    page.scopes.setCurrentText(CLIP)
    page.groups.setCurrentIndex(1)
    before = kinds_of(window)
    act(window, "next_interval")
    label = window.document.find_chain(window.document.interval.interval.chain).label
    qtbot.waitUntil(window.viewport.has_painted_interval)
    act(window, "reject")
    qtbot.waitUntil(lambda: kinds_of(window) != before, timeout=30_000)
    assert kinds_of(window)[label][2] == before.get(label, (0, 0, 0, 0))[2] + 1
