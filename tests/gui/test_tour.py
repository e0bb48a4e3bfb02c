"""The guided tour and the exercise: every step by hand, and the person's clip comes back."""

from PySide6.QtCore import Qt

from inspector.bundled import FLIPPED, PAGES
from inspector.lessons.guide_card import read_page
from inspector.lessons.guided_exercise import make_exercise
from inspector.session.session_files import journals, session_path
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.detection import Kind
from twistcore.review import Decide, Decision, recover
from twistcore.study.exercise import score

# -- tour -----------------------------------------------------------------------------------------


def test_the_tour_by_hand_from_end_to_end(qtbot, at_forearm):
    document = at_forearm.document
    mine = document.data.clip.path
    document.do(Decide((document.intervals[0].id,), Decision.REJECTED, "me", document.now()))
    state = document.review.state
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.guided_tour.at == 0, timeout=10_000)
    guide, tour, box = (
        at_forearm.guide,
        at_forearm.lesson_actions.guided_tour,
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
    for _ in range(5):
        qtbot.keyClick(at_forearm, Qt.Key.Key_Right, Qt.KeyboardModifier.ControlModifier)
    forward(1)
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
    qtbot.keyClick(at_forearm, Qt.Key.Key_N)
    qtbot.keyClick(at_forearm, Qt.Key.Key_A)
    walk = document.data.clip.path
    forward(7)
    # A real flip, in another clip: the whole leg and its circle are in view, the flip is selected.
    assert document.data.clip.path.name == FLIPPED.name
    assert document.data.clip.path.parent == walk.parent
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
    qtbot.keyClick(at_forearm, Qt.Key.Key_A)
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
    assert recover(journal).steps == 1
    assert (document.chain, document.frame) == ("LeftForeArm", 90)
    assert at_forearm.bar.buttons() == []  # no question about a journal that is its own
    act(at_forearm, "undo")
    assert document.intervals[0].decision == Decision.UNDECIDED
    assert not folder.exists()
    assert str(mine) in at_forearm.settings.recent[0]
    assert not any("twist-inspector-" in r for r in at_forearm.settings.recent)


def test_the_tour_shows_each_step_itself(qtbot, at_forearm):
    act(at_forearm, "tour")
    tour = at_forearm.lesson_actions.guided_tour
    qtbot.waitUntil(lambda: tour.at == 0, timeout=10_000)
    for number in range(len(tour.steps)):
        assert tour.at == number
        assert not at_forearm.guide.done
        tour.show_me.click()
        assert at_forearm.guide.done, tour.steps[number].name
        tour.forward.click()
    assert tour.at == -1


def test_a_tour_without_a_clip_and_left_half_way(qtbot, window):
    act(window, "tour")
    qtbot.waitUntil(lambda: window.lesson_actions.guided_tour.at == 0, timeout=10_000)
    window.lesson_actions.guided_tour.forward.click()
    window.lesson_actions.guided_tour.leave.click()
    assert not window.guide.isVisible()
    assert not window.lesson_actions.program.aside.open
    assert window.document.review.saved


def test_the_buttons_of_the_last_tour_do_nothing_to_the_persons_clip(qtbot, at_forearm):
    act(at_forearm, "tour")
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.guided_tour.at == 0, timeout=10_000)
    at_forearm.lesson_actions.guided_tour.leave.click()
    mine, state = at_forearm.document.data.clip.path, at_forearm.document.review.state
    act(at_forearm, "tour")
    for button in ("show_me", "forward", "back"):
        getattr(at_forearm.lesson_actions.guided_tour, button).click()
        assert at_forearm.lesson_actions.guided_tour.at == -1
    assert at_forearm.document.data.clip.path == mine
    assert at_forearm.document.review.state == state
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.guided_tour.at == 0, timeout=10_000)
    at_forearm.lesson_actions.guided_tour.leave.click()


def test_every_page_has_a_title_a_text_and_a_task():
    names = sorted(p.stem for p in PAGES.glob("*.md"))
    assert len(names) == 9
    for name in names:
        page = read_page(name)
        assert page.title
        assert len(page.body) > 150
        assert 20 < len(page.task) < 120
        assert not page.task.startswith(">")


# -- exercise -------------------------------------------------------------------------------------


def start_exercise(qtbot, window, kind, seed):
    act(window, "exercise")
    window.lesson_actions.hidden_errors.kind.setCurrentText(kind)
    window.lesson_actions.hidden_errors.seed.setValue(seed)
    qtbot.mouseClick(window.lesson_actions.hidden_errors.start, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(window.lesson_actions.hidden_errors.score_button.isEnabled, timeout=20_000)


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
    assert len(document.intervals) == 2 * len(errors)  # as many are natural
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


def test_in_find_nothing_is_listed_and_what_is_inserted_counts(qtbot, at_forearm):
    start_exercise(qtbot, at_forearm, "Find", 4)
    document = at_forearm.document
    assert document.intervals == ()
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
    assert score(errors, one.review.state.intervals).left == len(listed)


def test_opening_another_clip_ends_the_exercise(qtbot, at_forearm, tmp_path):
    start_exercise(qtbot, at_forearm, "Judge", 2)
    act(at_forearm, "next_interval")
    act(at_forearm, "accept")
    with qtbot.waitSignal(at_forearm.document.opened, timeout=10_000):
        at_forearm.open_path(ASSETS / "dance.bvh")  # no question about the exercise's verdicts
    qtbot.waitUntil(lambda: at_forearm.document.data.clip.name == "dance.bvh", timeout=10_000)
    assert not at_forearm.guide.isVisible()
