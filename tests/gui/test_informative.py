"""Judge a folder in the order in which verdicts say most about its automatic corrections."""

import shutil

import pytest

from inspector.folder.informative_intervals import _judged
from inspector.folder.queued_clip import QueuedClip
from inspector.session.session_files import session_path
from inspector.session.settings import Settings
from tests.gui.folders import put_errors, two_takes
from tests.gui.pictures import INJECTED
from tests.gui.windows import act
from twistcore.analysis.clip_analysis import detect
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision, Review, write_session
from twistcore.tuning.stated_precision import (
    automatic_corrections_with_confidence,
    representative_judging_order,
    verdicts_on_automatic_corrections,
)


def test_the_next_informative_interval_is_opened_in_any_clip(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    informative, document = window.informative, window.document
    qtbot.waitUntil(lambda: len(informative.ordered) > 3, timeout=60_000)
    assert not window.clips.precision.isVisible()  # nothing is judged yet
    clips = {one.path for one in informative.ordered}
    assert len(clips) == 2
    by_clip = [c for p in sorted(clips) for c in window.queue.clips[p].automatic]
    confidence = [c.confidence for c in by_clip]
    wanted = [by_clip[k] for k in representative_judging_order(confidence)]
    assert [one.correction for one in informative.ordered] == wanted

    seen = []
    for _ in range(4):
        with qtbot.waitSignal(informative.found, timeout=60_000) as found:
            act(window, "next_informative")
        (one,) = found.args
        qtbot.waitUntil(lambda one=one: _selects(document, one), timeout=60_000)
        seen.append(one)
        document.decide(Decision.REJECTED, [document.interval_id])
        window.files.save_session()
    assert [s.correction for s in seen] == wanted[:4]
    qtbot.waitUntil(lambda: informative.verdicts == 4, timeout=60_000)


@pytest.mark.thorough
def test_the_precision_of_the_rest_is_stated_after_enough_verdicts(
    qtbot, show_window, tmp_path, monkeypatch
):
    window = two_takes(qtbot, show_window, tmp_path)
    informative = window.informative
    qtbot.waitUntil(lambda: len(informative.ordered) > 3, timeout=60_000)
    for module in ("inspector.folder.informative_intervals", "twistcore.tuning.stated_precision"):
        monkeypatch.setattr(f"{module}.ENOUGH_STATED", 2)
    for _ in range(2):
        with qtbot.waitSignal(informative.found, timeout=60_000) as found:
            act(window, "next_informative")
        (one,) = found.args
        qtbot.waitUntil(lambda one=one: _selects(window.document, one), timeout=60_000)
        window.document.decide(Decision.ACCEPTED, [window.document.interval_id])
    qtbot.waitUntil(lambda: informative.stated is not None, timeout=60_000)
    assert informative.stated.verdicts == 2
    assert informative.stated.left == len(informative.ordered) - 2
    assert window.clips.precision.isVisible()
    assert f"{informative.stated.left}" in window.clips.precision.text()


def test_verdicts_do_not_move_to_other_corrections_after_a_new_analysis(tmp_path):
    clip = read_bvh(shutil.copy(INJECTED, tmp_path / "walk.bvh"))
    found = detect(clip)
    review = Review(found)
    review.do(Decide((1,), Decision.ACCEPTED, "Ada", "2026-11-01T09:00:00+00:00"))
    write_session(clip, review, session_path(clip.path))
    every = automatic_corrections_with_confidence(found)
    known = {}
    for automatic in (every, every[1:], every[::-1]):
        clips = [QueuedClip(clip.path, automatic=automatic)]
        rows, _, known = _judged(clips, {}, known, lambda _: None)
        wanted = zip(
            automatic, verdicts_on_automatic_corrections(automatic, review.state), strict=True
        )
        assert {one.correction: one.verdict for one in rows} == dict(wanted)


def test_a_folder_is_ordered_while_no_clip_is_open(qtbot, show_window, tmp_path):
    window = show_window(Settings())
    put_errors(tmp_path / "b.bvh", 3)
    window.queue.open(tmp_path)
    qtbot.waitUntil(lambda: bool(window.informative.ordered), timeout=60_000)
    assert window.document.data is None
    with qtbot.waitSignal(window.informative.found, timeout=60_000) as found:
        window.informative.look()
    assert found.args[0].path == tmp_path / "b.bvh"


def test_without_a_folder_the_reason_is_shown(qtbot, show_window):
    window = show_window(Settings())
    act(window, "next_informative")
    qtbot.waitUntil(lambda: bool(window.bar.label.text()))


def _selects(document, one):
    judged, data = document.interval, document.data
    return (
        data is not None
        and data.clip.path == one.path
        and judged is not None
        and judged.interval.chain == one.correction.chain
        and judged.interval.start < one.correction.stop
        and one.correction.start < judged.interval.stop
    )
