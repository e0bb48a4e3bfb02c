"""Another detector in the open clip: analysed once, off the GUI thread, and kept."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from tests.gui.pictures import INJECTED
from twistcore.detection import DETECTORS
from twistcore.detection.detectors.paper import PaperDetector
from twistcore.tuning import Profile


@pytest.fixture(autouse=True)
def known_samples():
    """Share no analysis with other tests: it would know the paper's detector already."""


@pytest.fixture
def asked(monkeypatch):
    """The threads in which the paper's detector analysed."""
    threads = []
    analyse = PaperDetector.analyse

    def noted(*arguments):
        threads.append(threading.current_thread())
        return analyse(*arguments)

    monkeypatch.setattr(PaperDetector, "analyse", noted)
    return threads


def test_a_change_of_detector_analyses_once_and_off_the_gui_thread(qtbot, open_document, asked):
    document = open_document(INJECTED)
    with qtbot.waitSignal(document.method_changed):
        document.use_method("paper")
        assert document.review.state.method == "consistency"  # nothing waits for it
    assert document.review.state.method == document.method == "paper"
    document.undo()
    document.redo()
    document.use_method("consistency")
    document.use_profile(Profile({"LeftForeArm": 0.2}, "paper"))
    assert document.review.state.tau["LeftForeArm"] == 0.2
    assert len(asked) == 1
    assert asked[0] is not threading.main_thread()


def test_a_change_of_tau_is_named_with_the_chains_label(open_document):
    document = open_document(INJECTED)
    document.set_tau(0.3, "LeftForeArm")
    assert document.review.undo_text == "Set τ of Left ForeArm"


def test_while_another_detector_is_at_work_nothing_is_changed(qtbot, open_document):
    document = open_document(INJECTED)
    before = document.review.state
    with qtbot.waitSignal(document.method_changed):
        document.use_method("paper")
        with qtbot.waitSignal(document.message) as told:
            document.set_tau(0.3)
        assert told.args[0]
        assert document.review.state is before
    document.set_tau(0.3)
    expected = document.detector.intervals(document.chain, 0.3)
    found = [j.interval for j in document.intervals if j.interval.chain == document.chain]
    assert [(i.start, i.stop) for i in found] == [(i.start, i.stop) for i in expected]


def test_a_review_by_a_detector_not_yet_asked_gets_its_curve(qtbot, open_document):
    """As where a journal is taken up whose last step was another detector."""
    document = open_document(INJECTED)
    paper = replace(document.review.state, method="paper")
    with qtbot.waitSignal(document.method_changed):
        document.review.state = paper
        document._review_changed()
        document.set_tau(0.3)  # at which detector's τ? neither: it is refused
        assert document.review.state is paper
    chain = document.data.analysis.chain(document.chain)
    own = DETECTORS["paper"].analyse(document.data.motion, [chain])
    strength = document.detector.strength(chain.name)
    np.testing.assert_array_equal(strength, own.strength(chain.name))


def test_what_is_cancelled_is_asked_again_when_it_is_needed(qtbot, open_document):
    document = open_document(INJECTED)
    document.review.state = replace(document.review.state, method="paper")
    document._review_changed()
    document.opener.cancel()
    assert document.method == "consistency"
    with qtbot.waitSignal(document.method_changed):
        document.set_tau(0.3)
    assert document.method == "paper"
