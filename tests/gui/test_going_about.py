"""Going about the clip: what a loop plays, and what M finds that the review has not."""

import numpy as np
import pytest

from inspector.session.player import Player
from inspector.window.review_actions import weak_candidates
from tests.gui.pictures import INJECTED
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Decide, Decision, replay_journal, session_bytes
from twistcore.skeleton.chain import find_chains


def test_a_loop_plays_the_selected_interval_and_half_a_second_round_it(open_document):
    document = open_document(INJECTED)
    player = Player(document)
    frames, around = document.frames, round(0.5 * document.data.motion.fps)
    document.select_interval(None)
    player.set_loop(True)
    assert player.span() == (0, frames)  # nothing is selected
    spans = []
    for judged in document.review.state.intervals:
        document.select_interval(judged.id)
        i = judged.interval
        assert player.span() == (max(0, i.start - around), min(frames, i.stop + around))
        spans.append(player.span())
    assert any(first > 0 and stop < frames for first, stop in spans)
    player.set_loop(False)
    assert player.span() == (0, frames)


@pytest.mark.parametrize("order", ["time", "chain"])
def test_without_a_selection_the_next_one_is_that_from_the_playhead(open_document, order):
    document = open_document(INJECTED)
    document.order = order
    intervals, own = document.intervals, document.chain
    listed = [j for j in intervals if order == "time" or j.interval.chain == own]
    for frame in range(0, document.frames, 7):
        ahead = [j.interval.start for j in listed if j.interval.stop > frame]
        behind = [j.interval.start for j in listed if j.interval.start < frame]
        for direction, wanted in ((+1, min(ahead, default=None)), (-1, max(behind, default=None))):
            document.select_interval(None)
            document.select_chain(own)
            document.go_to(frame)
            assert document.step_interval(direction)
            if wanted is not None:
                assert document.interval.interval.start == wanted
    document.decide(Decision.ACCEPTED, [j.id for j in intervals[1:]])
    document.select_interval(None)
    document.go_to(document.frames - 1)
    assert document.step_interval(+1, undecided=True)  # round the end
    assert document.interval.id == intervals[0].id
    assert not document.step_interval(+1, undecided=True)  # there is no other


def test_a_verdict_that_stands_is_no_step_and_goes_on(open_document):
    document = open_document(INJECTED)
    first, second = document.intervals[:2]
    document.select_interval(first.id)
    document.decide(Decision.ACCEPTED)
    document.select_interval(first.id)
    steps = document.review.history
    document.decide(Decision.ACCEPTED)
    assert (document.review.history, document.interval_id) == (steps, second.id)


def test_a_name_given_later_is_that_of_this_run_s_decisions(open_document):
    document = open_document(INJECTED)
    a, b, c = document.intervals[:3]
    document.do(Decide((a.id,), Decision.ACCEPTED))  # as of an earlier run, by nobody
    document.decide(Decision.REJECTED, [b.id])
    document.decide(Decision.ACCEPTED, [c.id])
    document.decide(Decision.UNDECIDED, [c.id])
    document.sign("Ada")
    assert [document.review.state.find(j.id).reviewer for j in (a, b, c)] == ["", "Ada", ""]
    document.undo()  # a name is no step: what comes back was decided in this run, too
    assert [document.review.state.find(j.id).reviewer for j in (a, b, c)] == ["", "Ada", "Ada"]
    document.undo()
    document.undo()
    now = document.review.state
    assert [now.find(j.id).decision for j in (a, b)] == [Decision.ACCEPTED, Decision.UNDECIDED]
    document.redo()
    assert document.review.state.find(b.id).reviewer == "Ada"


def test_a_name_given_after_a_save_and_undone_steps_is_in_the_journal(open_document):
    document = open_document(INJECTED)
    keeper = document.keeper
    a, b, c = (j.id for j in document.intervals[:3])

    def in_journal():
        found = replay_journal(keeper.journal.path).review.state
        return session_bytes(document.data.clip, found)

    def now():
        return session_bytes(document.data.clip, document.review.state)

    document.decide(Decision.ACCEPTED, [a])
    assert keeper.save()[0]
    document.decide(Decision.REJECTED, [b])
    document.undo()
    assert keeper.save()[0]
    document.sign("Ada")  # with which the journal begins
    assert in_journal() == now()
    document.redo()
    assert [document.review.state.find(k).reviewer for k in (a, b)] == ["Ada", "Ada"]
    assert in_journal() == now()
    document.decide(Decision.REJECTED, [c])
    for step in (document.undo, document.undo, document.undo, document.redo):
        step()
        assert in_journal() == now()
    assert document.review.state.find(a).reviewer == "Ada"
    assert document.review.state.find(b).decision == Decision.UNDECIDED


def test_an_edge_is_played_over_once(qtbot, open_document):
    document = open_document(INJECTED)
    player = Player(document)
    assert not player.play_edge()
    interval = document.intervals[0].interval
    document.select_interval(document.intervals[0].id, jump=True)
    player.set_speed(4.0)
    for other, edge in ((False, interval.start), (True, interval.stop)):
        seen = []
        document.frame_changed.connect(seen.append)
        assert player.play_edge(other=other)
        qtbot.waitUntil(lambda: not player.playing)
        document.frame_changed.disconnect(seen.append)
        around = round(0.25 * document.data.motion.fps)
        assert seen[0] == max(0, edge - around)
        assert max(seen) <= edge + around
        assert document.frame == edge


@pytest.fixture
def faint_walk(open_document, tmp_path):
    """The walk with an error between half of τ and τ, and one above τ, in one chain."""
    clip = read_bvh(INJECTED.parent / "walk.bvh")
    offsets = {"LeftForeArm": np.zeros(clip.motion.frames)}
    offsets["LeftForeArm"][100:130] = np.radians(3.0)
    offsets["LeftForeArm"][200:230] = np.radians(30.0)
    path = tmp_path / "faint" / "faint.bvh"
    path.parent.mkdir()
    write_clip(clip, remove_twist(clip.motion, find_chains(clip.motion), offsets), path)
    document = open_document(path)
    document.set_tau(np.radians(4.0), "LeftForeArm")
    return document


def test_suspicious_moments_lie_between_half_of_tau_and_tau(faint_walk):
    document = faint_walk
    (known,) = document.review.state.intervals
    assert (known.interval.start, known.interval.stop) == (200, 230)

    def faint_ones():
        return weak_candidates(document.data.analysis, document.review.state)

    (faint,) = faint_ones()
    assert (faint.chain, faint.start, faint.stop) == ("LeftForeArm", 100, 130)
    document.set_tau(np.radians(6.5), "LeftForeArm")
    assert faint_ones() == []  # 3° is less than half of it
    document.set_tau(np.radians(2.0), "LeftForeArm")
    assert faint_ones() == []  # and found where τ is below it
