"""Lessons and the exercise: every step by hand, and the person's clip comes back."""

import csv
import io
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from inspector.bundled import EXERCISE_PAGE, FLIPPED, LESSONS
from inspector.lessons.classroom import score_answers, write_for_class
from inspector.lessons.exercise_texts import exercise_page
from inspector.lessons.guided_exercise import make_exercise
from inspector.lessons.lesson_checks import CHECKS
from inspector.lessons.lesson_conditions import CONDITIONS
from inspector.lessons.lesson_file import read_lesson
from inspector.session.opening import opening_notes
from inspector.session.session_files import journals, session_path
from inspector.widgets.building import bring_to_front
from tests.conftest import ASSETS
from tests.gui.windows import act, press
from tests.tiers import parametrize
from twistcore.detection import Kind
from twistcore.errors import TwistError
from twistcore.review import Decide, Decision, replay_journal
from twistcore.study.exercise import score_review_of_hidden_errors
from twistcore.synthesis.truth import read_truth

ONE_WINDOW = True

ALL = sorted(LESSONS.glob("*.md"))
TRANSLATED = sorted(p for p in LESSONS.glob("*/*.md") if p.name != EXERCISE_PAGE.name)


def play(qtbot, window, path):
    """Play a lesson and wait for its first page."""
    window.lesson_actions.play(path)
    qtbot.waitUntil(lambda: window.lesson_actions.player.at == 0, timeout=20_000)
    return window.lesson_actions.player


# -- tour -----------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_the_tour_by_hand_from_end_to_end(qtbot, at_forearm):
    document = at_forearm.document
    mine = document.data.clip.path
    document.do(Decide((document.intervals[0].id,), Decision.REJECTED, "me", document.now()))
    state = document.review.state
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.player.at == 0, timeout=10_000)
    guide, tour, box = (
        at_forearm.guide,
        at_forearm.lesson_actions.player,
        at_forearm.teaching.what_if,
    )
    assert document.data.clip.path != mine
    assert guide.isVisible()

    def forward(step):
        assert guide.done
        qtbot.mouseClick(tour.forward, Qt.MouseButton.LeftButton)
        assert tour.at == step
        assert not guide.done

    assert not guide.done
    assert (document.chain, document.frame, document.show) == ("RightUpLeg", 52, "before")
    assert at_forearm.actions_by_id["skin"].isChecked()
    for _ in range(2):
        qtbot.keyClick(at_forearm, Qt.Key.Key_Right, Qt.KeyboardModifier.ControlModifier)
    assert 59 <= document.frame < 74  # where the thigh is wrung
    forward(1)
    assert not at_forearm.actions_by_id["skin"].isChecked()
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=30_000)
    qtbot.mouseClick(at_forearm.teaching.equations.buttons["w"], Qt.MouseButton.LeftButton)
    forward(2)
    box.sliders["swing"].setValue(1250)
    forward(3)
    box.sliders["twist"].setValue(-700)
    forward(4)
    qtbot.mouseClick(box.counter, Qt.MouseButton.LeftButton)
    forward(5)
    box.sliders["swing"].setValue(1800)
    box.sliders["nudge"].setValue(10)
    assert not guide.done  # one of two
    box.sliders["swing"].setValue(400)
    box.sliders["bend"].setValue(0)
    forward(6)
    assert document.interval.interval.chain == "RightUpLeg"
    press(qtbot, at_forearm, Qt.Key.Key_A)
    walk = document.data.clip.path
    forward(7)
    # A real flip, in another clip: the whole leg and its circle are in view, the flip is selected.
    assert document.data.clip.path.name == FLIPPED.name
    assert document.data.clip.path.parents[1] == walk.parents[1]
    assert (document.chain, document.frame) == ("RightUpLeg-RightFoot", 48)
    assert document.interval.interval.kind == Kind.LIMB_FLIP
    assert at_forearm.docks["intervals"].isVisible()
    at_forearm.viewport.refresh()
    assert at_forearm.viewport.scene.circled
    qtbot.mouseClick(tour.back, Qt.MouseButton.LeftButton)
    assert document.data.clip.path == walk
    assert guide.done  # what was accepted there is still
    forward(7)
    qtbot.keyClick(at_forearm, Qt.Key.Key_B)
    assert not guide.done
    press(qtbot, at_forearm, Qt.Key.Key_A)
    assert guide.done
    assert tour.forward.text() == "Finish"
    folder = document.data.clip.path.parent
    qtbot.mouseClick(tour.forward, Qt.MouseButton.LeftButton)
    assert not guide.isVisible()
    # Back at the person's clip: the unsaved verdict is there, in memory and on disk.
    assert document.data.clip.path == mine
    assert document.review.state is state
    assert not document.review.saved
    (journal,) = journals(session_path(mine))
    assert replay_journal(journal).steps == 1
    assert (document.chain, document.frame) == ("LeftForeArm", 90)
    assert not at_forearm.bar.asks  # the journal is its own; what comes next is only offered
    act(at_forearm, "undo")
    assert document.intervals[0].decision == Decision.UNDECIDED
    assert not folder.exists()
    assert str(mine) in at_forearm.settings.recent[0]
    assert not any("twist-inspector-" in r for r in at_forearm.settings.recent)


@pytest.mark.thorough
@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_a_lesson_shows_each_page_itself(qtbot, at_forearm, path):
    at_forearm.document.set_show("after")
    looks = [at_forearm.actions_by_id[name] for name in ("skin", "side_by_side")]
    own = [look.isChecked() for look in looks]
    player = play(qtbot, at_forearm, path)
    assert at_forearm.docks["guide"].windowTitle() == read_lesson(path).title
    for number, page in enumerate(player.pages):
        assert player.at == number
        assert not at_forearm.guide.done, page.title
        if page.done:
            player.show_me.click()
            assert at_forearm.guide.done, page.title
        player.forward.click()
    assert player.at == -1
    assert at_forearm.document.data.clip.path.name == "mine.bvh"
    assert at_forearm.document.show == "after"
    assert [look.isChecked() for look in looks] == own


@pytest.mark.thorough
def test_bundled_lessons_are_in_the_menu(qtbot, at_forearm):
    menu = at_forearm.lesson_actions.lessons_menu
    menu.aboutToShow.emit()
    menu.aboutToShow.emit()
    titles = [action.text() for action in menu.actions()]
    assert titles == [read_lesson(path).title for path in ALL if path.stem != "tour"]
    menu.actions()[0].trigger()
    player = at_forearm.lesson_actions.player
    qtbot.waitUntil(lambda: player.at == 0, timeout=20_000)
    assert at_forearm.docks["guide"].windowTitle() == titles[0]


OWN = """---
title: Mine
clip: own.bvh
---

# One

With $q_P = 1$ and $\\nonsense{{$.

```lesson
frame: {frame}
chain: {chain}
camera: 40 10 2
```
"""


@pytest.mark.thorough
def test_a_lesson_of_a_persons_own_with_a_clip_beside_it(qtbot, at_forearm, tmp_path):
    folder = tmp_path / "lessons"
    folder.mkdir()
    shutil.copy(ASSETS / "dance.bvh", folder / "own.bvh")
    path = folder / "mine.md"
    path.write_text(OWN.format(frame=12, chain="LeftLeg"))
    player = play(qtbot, at_forearm, path)
    document, viewport = at_forearm.document, at_forearm.viewport
    assert (document.data.clip.name, document.chain, document.frame) == ("own.bvh", "LeftLeg", 12)
    assert document.data.clip.path.parent != folder  # a copy: nothing is written beside the lesson
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=30_000)
    assert "nonsense" in at_forearm.guide.body.toPlainText()  # what cannot be set stands as it is
    assert "q_P" not in at_forearm.guide.body.toPlainText()
    # Where the camera was put is what is copied for a page.
    act(at_forearm, "copy_place")
    block = QApplication.clipboard().text()
    assert "camera: 40 10 2" in block
    assert "clip: own.bvh\nframe: 12\nchain: LeftLeg" in block
    assert "tab: teaching" in block
    before = viewport.camera
    at_forearm.taught.alter(twist=np.radians(30.0), counter=True)
    act(at_forearm, "copy_place")
    assert "what-if: twist 30, counter" in QApplication.clipboard().text()
    assert np.allclose(viewport.camera.position, before.position)  # looking at it moves nothing
    assert player.show_me.isEnabled() is False  # nothing to do
    player.forward.click()
    assert document.data.clip.path.name == "mine.bvh"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("chain", "frame", "expected"),
    [
        ("LeftLeg", "none", "line 11: expected a frame, counted from 0, found 'none'"),
        ("LeftLeg", 435, "line 11: expected a frame of own.bvh from 0 to 434, found '435'"),
        ("Tail", 4, "line 12: expected one of the chains of own.bvh ("),
    ],
)
def test_a_lesson_that_is_wrong_is_refused_in_a_sentence(
    qtbot, at_forearm, tmp_path, chain, frame, expected
):
    folder = tmp_path / "lessons"
    folder.mkdir()
    shutil.copy(ASSETS / "dance.bvh", folder / "own.bvh")
    path = folder / "mine.md"
    path.write_text(OWN.format(frame=frame, chain=chain))
    mine = at_forearm.document.data
    said = []
    at_forearm.document.message.connect(lambda text, wrong: said.append((text, wrong)))
    at_forearm.lesson_actions.play(path)
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    ((text, wrong),) = said
    assert wrong
    assert expected in text
    assert str(path) in text
    assert at_forearm.document.data is mine
    assert not at_forearm.guide.isVisible()
    assert not at_forearm.lesson_actions.player.running
    assert not at_forearm.lesson_actions.program.aside.open


@pytest.mark.thorough
def test_a_tour_without_a_clip_and_left_half_way(qtbot, window):
    act(window, "tour")
    qtbot.waitUntil(lambda: window.lesson_actions.player.at == 0, timeout=10_000)
    window.lesson_actions.player.forward.click()
    window.lesson_actions.player.leave.click()
    assert not window.guide.isVisible()
    assert not window.lesson_actions.program.aside.open
    assert window.document.review.saved


def test_a_tour_left_on_the_teaching_tab_returns_to_the_intervals(qtbot, at_forearm):
    docks, player = at_forearm.docks, at_forearm.lesson_actions.player
    bring_to_front(docks["intervals"])
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: player.at == 0, timeout=10_000)
    player.forward.click()
    qtbot.waitUntil(lambda: not docks["teaching"].visibleRegion().isEmpty())
    player.leave.click()
    qtbot.waitUntil(lambda: not docks["intervals"].visibleRegion().isEmpty())


def test_a_tour_leaves_another_tab_that_the_user_selects_in_front(qtbot, at_forearm):
    docks, player = at_forearm.docks, at_forearm.lesson_actions.player
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: player.at == 0, timeout=10_000)
    bring_to_front(docks["history"])
    qtbot.waitUntil(lambda: not docks["history"].visibleRegion().isEmpty())
    player.leave.click()
    qtbot.wait(30)
    assert not docks["history"].visibleRegion().isEmpty()


@pytest.mark.thorough
def test_a_second_lesson_without_a_clip_takes_nothing_for_the_persons(qtbot, window):
    said = []
    window.document.message.connect(lambda text, _: said.append(text))
    for _ in range(2):
        play(qtbot, window, ALL[0]).leave.click()
    assert not any("cannot be written" in text for text in said)


@pytest.mark.thorough
def test_formulas_of_a_text_are_set(qtbot, at_forearm):
    player = play(qtbot, at_forearm, LESSONS / "3-2-extraction.md")
    player.forward.click()
    player.forward.click()
    qtbot.waitUntil(lambda: at_forearm.teaching.typesetter.done, timeout=30_000)
    body = at_forearm.guide.body
    assert "frac" not in body.toPlainText()
    pictures = [body.loadResource(2, f"tex:{k}") for k in range(2)]
    for picture in pictures:  # something is drawn
        assert picture.width() > 10
        ink = {picture.pixelColor(x, picture.height() // 2).alpha() for x in range(picture.width())}
        assert max(ink) > 100
    assert body.document().toPlainText().count("\ufffc") == 2


@pytest.mark.thorough
def test_the_buttons_of_the_last_tour_do_nothing_to_the_persons_clip(qtbot, at_forearm):
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.player.at == 0, timeout=10_000)
    at_forearm.lesson_actions.player.leave.click()
    mine, state = at_forearm.document.data.clip.path, at_forearm.document.review.state
    act(at_forearm, "tour")
    for button in ("show_me", "forward", "back"):
        getattr(at_forearm.lesson_actions.player, button).click()
        assert at_forearm.lesson_actions.player.at == -1
    assert at_forearm.document.data.clip.path == mine
    assert at_forearm.document.review.state == state
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.player.at == 0, timeout=10_000)
    at_forearm.lesson_actions.player.leave.click()


@pytest.mark.parametrize(
    "path", [*ALL, *TRANSLATED], ids=lambda path: f"{path.parent.name}-{path.stem}"
)
def test_every_page_has_a_text_and_a_task(path):
    for page in read_lesson(path).pages:
        assert 15 <= len(page.body.split()) <= 80, page.title
        assert 10 < len(page.task) < 120, page.title
        assert page.done, page.title  # whoever follows the task is told so


def test_the_exercise_has_a_page():
    title, body, task = exercise_page()
    assert title == "Exercise"
    assert len(body) > 150
    assert not task.startswith(">")
    assert EXERCISE_PAGE.is_file()


def test_every_condition_can_be_checked_and_done():
    assert CHECKS.keys() == CONDITIONS.keys()


# -- exercise -------------------------------------------------------------------------------------


def start_exercise(qtbot, window, kind, seed):
    act(window, "exercise")
    window.lesson_actions.hidden_errors.kind.setCurrentText(kind)
    window.lesson_actions.hidden_errors.seed.setValue(seed)
    qtbot.mouseClick(window.lesson_actions.hidden_errors.start, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(window.lesson_actions.hidden_errors.score_button.isEnabled, timeout=20_000)


@pytest.mark.thorough
def test_the_exercise_scores_and_leaves_the_persons_session_alone(qtbot, at_forearm):
    document = at_forearm.document
    document.do(Decide((document.intervals[0].id,), Decision.ACCEPTED, "me", document.now()))
    at_forearm.files.save_session()
    mine = document.data.clip.path
    files = {p: p.read_bytes() for p in mine.parent.iterdir() if p.is_file()}
    start_exercise(qtbot, at_forearm, "Judge", 5)
    assert document.data.clip.path.name == "exercise_5.bvh"
    errors = at_forearm.lesson_actions.hidden_errors._errors
    truth = {(e.chain, e.start) for e in errors}
    assert len(document.intervals) >= len(errors) + 4  # in each of two chains 2-5 are natural
    wrong = 0
    for judged in document.intervals:
        real = (judged.interval.chain, judged.interval.start) in truth
        document.select_interval(judged.id)
        at_forearm.actions_by_id["accept" if real else "reject"].trigger()
    at_forearm.lesson_actions.hidden_errors.score_button.click()
    result = at_forearm.lesson_actions.hidden_errors.result
    assert (len(result.hits), len(result.misses), result.false_verdicts) == (len(errors), 0, wrong)
    assert f"Hits {len(errors)}" in at_forearm.guide.body.toPlainText()
    # One verdict turned round is a miss and a false verdict.
    first = next(j for j in document.intervals if j.decision == Decision.ACCEPTED)
    document.do(Decide((first.id,), Decision.REJECTED, "", document.now()))
    at_forearm.lesson_actions.hidden_errors.score_button.click()
    assert len(at_forearm.lesson_actions.hidden_errors.result.misses) == 1
    assert at_forearm.lesson_actions.hidden_errors.result.false_verdicts == 1
    at_forearm.lesson_actions.hidden_errors.go_to(f"at:{errors[0].chain}/{errors[0].start}")
    assert (document.chain, document.frame) == (errors[0].chain, errors[0].start)
    at_forearm.lesson_actions.hidden_errors.leave.click()
    assert document.data.clip.path == mine
    assert {p: p.read_bytes() for p in mine.parent.iterdir() if p.is_file()} == files


@pytest.mark.thorough
def test_in_find_nothing_is_listed_and_what_is_inserted_counts(qtbot, at_forearm):
    start_exercise(qtbot, at_forearm, "Find", 4)
    document = at_forearm.document
    assert document.intervals == ()
    assert "Insert an interval at each error." in at_forearm.guide.task.text()
    assert "τ" not in at_forearm.intervals._hint.text()  # no threshold applies here
    error = max(at_forearm.lesson_actions.hidden_errors._errors, key=lambda e: e.stop - e.start)
    document.select_chain(error.chain)
    document.go_to((error.start + error.stop) // 2)
    act(at_forearm, "insert_interval")
    act(at_forearm, "accept")
    at_forearm.lesson_actions.hidden_errors.show_score()
    assert [e.start for e in at_forearm.lesson_actions.hidden_errors.result.hits] == [error.start]
    at_forearm.lesson_actions.leave_guide()


def test_an_exercise_is_the_same_for_its_seed(tmp_path):
    one, errors = make_exercise(ASSETS / "walk.bvh", tmp_path, 11, "Judge")
    again, same = make_exercise(ASSETS / "walk.bvh", tmp_path, 11, "Judge")
    listed = [(j.interval.chain, j.interval.start) for j in one.review.state.intervals]
    assert listed == [(j.interval.chain, j.interval.start) for j in again.review.state.intervals]
    assert [e.start for e in errors] == [e.start for e in same]
    assert all(j.interval.confidence is None for j in one.review.state.intervals)  # no hint
    assert score_review_of_hidden_errors(errors, one.review.state.intervals).left == len(listed)


@pytest.mark.thorough
def test_opening_another_clip_ends_the_exercise(qtbot, at_forearm, tmp_path):
    start_exercise(qtbot, at_forearm, "Judge", 2)
    act(at_forearm, "next_interval")
    act(at_forearm, "accept")
    with qtbot.waitSignal(at_forearm.document.opened, timeout=10_000):
        at_forearm.open_path(ASSETS / "dance.bvh")  # no question about the exercise's verdicts
    qtbot.waitUntil(lambda: at_forearm.document.data.clip.name == "dance.bvh", timeout=10_000)
    assert not at_forearm.guide.isVisible()


# -- what an exercise does not tell ----------------------------------------------------------------


@pytest.mark.thorough
def test_an_exercise_does_not_give_itself_away(qtbot, at_forearm):
    start_exercise(qtbot, at_forearm, "Judge", 5)
    document, said = at_forearm.document, []
    document.message.connect(lambda text, _: said.append(text))
    listed = [(j.interval.chain, j.interval.start) for j in document.intervals]
    # No peak by chain, no reason at a hidden error's edge, no suspicious moment.
    peaks = {row.peak for row in at_forearm.chains._model.things}
    assert all(np.isnan(peak) for peak in peaks)
    texts = at_forearm.chains._model.describe(at_forearm.chains._model.things[0]).texts
    assert texts[2] == "–"
    error = at_forearm.lesson_actions.hidden_errors._errors[0]
    document.select_interval(None)
    document.select_chain(error.chain)
    document.go_to(error.start)
    assert "above" not in at_forearm.detail.why.text()
    frame = document.frame
    for key in ("next_faint", "why_not"):
        at_forearm.bar.clear()
        act(at_forearm, key)
        assert at_forearm.bar.label.text()
    assert document.frame == frame
    # τ stays, and nothing is detected.
    tau = dict(document.review.state.tau)
    document.set_tau(np.radians(0.5))
    document.use_method("paper")
    act(at_forearm, "suggest_tau")
    qtbot.wait(100)
    assert dict(document.review.state.tau) == tau
    assert document.review.state.method == "consistency"
    assert [(j.interval.chain, j.interval.start) for j in document.intervals] == listed
    assert any("exercise" in text for text in said)
    # Beside a listed error stands the same as beside natural movement.
    for judged in document.intervals:
        document.select_interval(judged.id)
        assert at_forearm.detail.why.text() == ""
    at_forearm.lesson_actions.leave_guide()
    assert not any(np.isnan(row.peak) for row in at_forearm.chains._model.things)


def test_an_exercise_shows_changes_only_and_its_score_in_the_colour_it_deserves(qtbot, at_forearm):
    document, exercise = at_forearm.document, at_forearm.lesson_actions.hidden_errors
    panes, skin = at_forearm.timeline.grid.shown, at_forearm.actions_by_id["skin"]
    assert "strength" in panes
    act(at_forearm, "skin")
    start_exercise(qtbot, at_forearm, "Judge", 5)
    qtbot.waitUntil(lambda: at_forearm.timeline.grid.shown == ["delta"])
    assert skin.isChecked()
    notes = [text for text, _ in opening_notes(document.data, None, ())]
    assert not any("Shoulder" in text for text in notes)  # whose error fills most of the clip
    seen = replace(document.data, blind=False)
    notes = [text for text, _ in opening_notes(seen, None, ())]
    assert any("Left Shoulder is twisted by about" in text for text in notes)
    guide, theme = at_forearm.guide, at_forearm.colours.theme
    truth = {(e.chain, e.start) for e in exercise._errors}
    first = next(j for j in document.intervals if (j.interval.chain, j.interval.start) in truth)
    document.do(Decide((first.id,), Decision.ACCEPTED, "me", document.now()))
    exercise.score_button.click()
    assert guide.task.text() == f"✗ 1 of {len(truth)} errors found, 0 false verdicts"
    assert theme.rejected in guide.task.styleSheet()
    listed = guide.body.toPlainText()
    for chain in {e.chain for e in exercise._errors}:
        assert document.find_chain(chain).label in listed
        assert chain not in listed
    for j in document.intervals:
        if (j.interval.chain, j.interval.start) in truth:
            document.do(Decide((j.id,), Decision.ACCEPTED, "me", document.now()))
    exercise.score_button.click()
    assert theme.accepted in guide.task.styleSheet()
    assert exercise.start.text() == "Next exercise"
    assert exercise.seed.value() == 6
    exercise.leave.click()
    qtbot.waitUntil(lambda: at_forearm.timeline.grid.shown == panes)
    assert not skin.isChecked()


@parametrize(
    ("lesson", "first"),
    [("3-1-definition", "3.2 How the twists are measured"), ("tour", "3.1 What a twist error is")],
)
def test_after_finish_comes_what_is_next(qtbot, at_forearm, lesson, first):
    player = play(qtbot, at_forearm, LESSONS / f"{lesson}.md")
    for _ in player.pages:
        player.forward.click()
    bar = at_forearm.bar
    assert bar.label.text().endswith("is finished. What next?")
    assert [button.text() for button in bar.buttons()] == [first, "Exercise"]
    assert not bar.asks  # other messages may take its place
    bar.buttons()[1].click()
    assert at_forearm.lesson_actions.hidden_errors.running


@pytest.mark.thorough
def test_the_score_counts_frames_as_the_table_does(qtbot, at_forearm):
    at_forearm.document.set_first_frame(1)
    start_exercise(qtbot, at_forearm, "Find", 4)
    exercise = at_forearm.lesson_actions.hidden_errors
    exercise.show_score()
    error = exercise._errors[0]
    assert f"{error.start + 1} to {error.stop + 1}" in at_forearm.guide.body.toPlainText()


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_an_exercise_for_a_class_from_end_to_end(qtbot, at_forearm, tmp_path):
    exercise, document = at_forearm.lesson_actions.hidden_errors, at_forearm.document
    said = []
    document.message.connect(lambda text, wrong: said.append((text, wrong)))
    folder = tmp_path / "class"
    folder.mkdir()
    own = folder / "monday.json"
    act(at_forearm, "exercise")
    mine = document.data
    exercise.teacher.write(own)
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    assert said.pop() == (
        "Give monday.json and monday.bvh to your class. Keep the key monday.key.json to yourself.",
        False,
    )
    assert document.data is mine  # of the person's own clip, which stays as it is
    key = read_truth(folder / "monday.key.json")
    names = ["chain", "start", "stop", "delta_deg"]
    listed = json.loads(own.read_text())["intervals"]
    assert [list(entry) for entry in listed] == [names] * len(listed)
    assert {(e.chain, e.start) for e in key.errors} <= {(e["chain"], e["start"]) for e in listed}
    # A student: all accepted.
    exercise.do_one(own)
    qtbot.waitUntil(lambda: document.data is not mine, timeout=20_000)
    assert exercise.hand_in_button.isVisible()
    assert not exercise.score_button.isVisible()
    assert document.data.blind
    assert document.data.clip.path.parent != folder
    assert len(document.intervals) == len(listed)
    for judged in document.intervals:
        document.select_interval(judged.id)
        act(at_forearm, "accept")
    assert f"{len(listed)} of {len(listed)} intervals judged" in at_forearm.guide.task.text()
    exercise.hand_in(folder / "ada.json")
    exercise.leave.click()
    assert document.data.clip.path == mine.clip.path
    # A teacher.
    table = score_answers([folder / "ada.json", folder / "monday.key.json"])
    (row,) = csv.DictReader(io.StringIO(table))
    assert row["name"] == "ada"
    assert (int(row["hits"]), row["misses"]) == (len(key.errors), "0")
    assert int(row["false_accepted"]) == len(listed) - len(key.errors)
    exercise.teacher.write_table(folder / "class.csv", table)
    assert (folder / "class.csv").read_text() == table
    with pytest.raises(TwistError, match="key of the exercise"):
        score_answers([folder / "ada.json"])


@pytest.mark.thorough
def test_an_exercise_whose_clip_is_another_is_refused(qtbot, at_forearm, tmp_path):
    exercise, document = at_forearm.lesson_actions.hidden_errors, at_forearm.document
    own = tmp_path / "own.json"
    write_for_class(ASSETS / "walk.bvh", own, 3, "find")
    shutil.copy(ASSETS / "dance.bvh", tmp_path / "own.bvh")
    said, mine = [], document.data
    document.message.connect(lambda text, wrong: said.append((text, wrong)))
    act(at_forearm, "exercise")
    exercise.do_one(own)
    qtbot.waitUntil(lambda: bool(said), timeout=20_000)
    assert said == [
        (
            "own.json: own.bvh is not the clip that this exercise was made from. "
            "Ask your teacher for both files.",
            True,
        )
    ]
    assert document.data is mine
    exercise.leave.click()
    assert document.data is mine
