"""Take the screenshots and record the film for the docs: `dev.py shot [NAME…]`."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING
from unittest.mock import patch

from PySide6.QtCore import QEventLoop, QTimer
from PySide6.QtGui import QCursor, QImage

from inspector.app import make_application
from inspector.bundled import EXERCISES, FLIPPED, LESSONS, SAMPLE, TOUR
from inspector.folder.feature import feature as of_folder
from inspector.lessons.feature import feature as of_lessons
from inspector.quality.feature import feature as of_quality
from inspector.recording.choice import Contents, RecordChoice
from inspector.recording.feature import feature as of_recording
from inspector.session.settings import Settings
from inspector.teaching.feature import feature as of_teaching
from inspector.tuning.feature import feature as of_tuning
from inspector.viewport import opengl
from inspector.widgets.fonts import use_shipped_fonts
from twistcore.analysis.decomposition import WhatIf
from twistcore.detection import Kind
from twistcore.review import Decision

if TYPE_CHECKING:
    from inspector.window.main_window import MainWindow

IMAGES = Path(__file__).parent.parent / "docs" / "images"
_SIZE = (1440, 900)
_TOUR_SIZE = (1280, 800)
_SETTLE_MS = 700
_LOOK_MS = 100
_PATIENCE_S = 60.0  # seconds to wait until the window stops changing
_SEED = 5  # seed of the exercise
_NOISY_FRAME = 200  # a frame of a clip with synthetic noise
_PICTURED = 3  # the page of a lesson that is pictured, except in the tour
_FILM = RecordChoice(
    IMAGES / "skin.gif", first=305, stop=323, speed=0.1, size=(800, 420),
    contents=Contents(curves=False), replace=True,
)  # fmt: skip
# The left forearm of the sample, which has an error in all frames of the film
_FILMED = "LeftForeArm"


def main() -> int:
    """Take the pictures named on the command line, or all pictures and the film.

    Returns the exit code.
    """
    make_application()
    use_shipped_fonts()
    from inspector.window.export_dialog import ExportDialog
    from inspector.window.main_window import MainWindow

    named = sys.argv[1:]

    def trails(window: MainWindow) -> None:
        trigger_window_actions(window, "trails", "view_iso")

    def queue(window: MainWindow) -> None:
        window.part(of_folder).queue.open(SAMPLE.parent)
        window.docks["clips"].show()
        wait_for(lambda: not window.part(of_folder).queue.running)

    def teaching(window: MainWindow) -> None:
        trigger_window_actions(window, "show_teaching")
        wait_for(lambda: window.part(of_teaching).teaching.typesetter.done)
        window.document.select_chain("RightUpLeg")
        window.document.go_to(100)
        window.part(of_teaching).taught.set_what_if(WhatIf(twist=1.1, counter=True, bend=0.9))
        trigger_window_actions(window, "focus_chain")

    def lit(window: MainWindow) -> None:
        teaching(window)
        window.part(of_teaching).taught.highlight("theta_p")

    def tuning(window: MainWindow) -> None:
        trigger_window_actions(window, "show_tuning")
        wait_for(
            lambda: (
                len(window.part(of_tuning).tuning.costs.curves)
                == len(window.part(of_tuning).tuning.costs.names)
            )
        )
        window.part(of_tuning).tuning.set_tau_degrees(5.0)

    def profiles(window: MainWindow) -> None:
        tuning(window)
        with tempfile.TemporaryDirectory() as folder:
            window.part(of_tuning).tuning_actions.save_profile_to(Path(folder) / "office.toml")
            window.document.undo()
            window.part(of_tuning).tuning_actions.compare_with([Path(folder) / "office.toml"])
        window.bar.hide()

    def quality(window: MainWindow) -> None:
        trigger_window_actions(window, "show_quality")
        wait_for(lambda: window.part(of_quality).quality.evidence.known is not None)
        window.document.select_chain("LeftForeArm")

    def tracking(window: MainWindow) -> None:
        document = window.document
        assert document.data is not None
        document.review.mark_saved()
        noisy = document.data.clip.path.parent / "dance_noisy.bvh"
        noise = (
            sys.executable,
            "-m",
            "twistcore",
            "quamo",
            "noise",
        )  # this text comes from the study, not from the window
        subprocess.run([*noise, EXERCISES[0], "-o", noisy, "--level", "A"], check=True)
        window.open_path(noisy)
        wait_for(lambda: document.data is not None and document.data.clip.path == noisy)
        quality(window)
        window.part(of_quality).quality.choose(*window.part(of_quality).quality.model.rows)
        trigger_window_actions(window, "track_joints")
        wait_for(lambda: window.part(of_quality).quality.tracked.result is not None)
        document.go_to(_NOISY_FRAME)
        trigger_window_actions(window, "view_iso")

    def flip(window: MainWindow) -> None:
        document = window.document
        assert document.data is not None
        document.review.mark_saved()
        folder = document.data.clip.path.parent
        window.open_path(Path(shutil.copy(FLIPPED, folder)))
        wait_for(lambda: document.data is not None and document.data.clip.name == FLIPPED.name)
        wait(_SETTLE_MS)
        window.intervals.filter.setCurrentText("Limb flips")
        flips = [j.id for j in document.intervals if j.interval.kind == Kind.LIMB_FLIP]
        document.decide(Decision.ACCEPTED, flips[:2])
        document.select_interval(flips[-1], jump=True)
        document.go_to(document.frame + 1)

    def export(window: MainWindow) -> None:
        every = [judged.id for judged in window.document.intervals]
        window.document.decide(Decision.ACCEPTED, every)
        dialog = ExportDialog(window.document, window)
        dialog.path.setText("walk_injected_refined.bvh")
        dialog.show()
        wait(_SETTLE_MS)
        write_docs_image(dialog.grab().toImage(), "export")
        dialog.close()

    pictures: tuple[tuple[str, str, Callable[[MainWindow], None]], ...] = (
        ("inspector", "system", trigger_window_actions),
        ("inspector-dark", "dark", trigger_window_actions),
        ("flip", "system", flip),
        ("trails", "system", trails),
        ("folder", "system", queue),
        ("export", "system", export),
        ("both-detectors", "system", lambda w: trigger_window_actions(w, "both_detectors")),
        ("presentation", "dark", lambda w: trigger_window_actions(w, "presentation")),
        ("without-opengl", "system", trigger_window_actions),
        ("teaching", "system", teaching),
        ("teaching-lit", "dark", lit),
        ("tuning", "system", tuning),
        ("tuning-profiles", "dark", profiles),
        ("quality", "system", quality),
        ("tracking", "dark", tracking),
    )
    IMAGES.mkdir(parents=True, exist_ok=True)
    if not named or _FILM.path.stem in named:
        film(MainWindow(Settings(theme="dark", turn_ms=0, reviewer_asked=True), None))
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(shutil.copy(SAMPLE, folder))
        for name, theme, prepare in pictures:
            if named and name not in named:
                continue
            none = patch.object(opengl, "renderer_name", return_value="")
            with none if name == "without-opengl" else nullcontext():
                window = MainWindow(Settings(theme=theme, reviewer_asked=True), None)
            window.resize(*_SIZE)
            window.show()
            window.open_path(clip)
            wait_for(partial(getattr, window.document, "data"))
            wait(_SETTLE_MS)
            trigger_window_actions(window, "next_interval", "accept", "accept")
            judged = window.document.interval
            assert judged is not None
            window.document.go_to((judged.interval.start + judged.interval.stop) // 2)
            prepare(window)
            if prepare not in (trails, tracking):
                trigger_window_actions(window, "focus_chain")
            if prepare != export:
                save(window, name)
            window.document.review.mark_saved()
            window.close()
            wait(50)
    if named:
        return 0
    window = MainWindow(Settings(turn_ms=0, reviewer_asked=True), None)
    trigger_window_actions(window, "why_quaternions")
    trackers = window.part(of_lessons).lesson_actions.five_trackers
    assert trackers is not None
    wait(_SETTLE_MS)
    write_docs_image(trackers.grab().toImage(), "why-quaternions")
    trackers.close()
    window.resize(*_TOUR_SIZE)
    window.show()
    lesson_pictures(window)
    window.close()
    return 0


def film(window: MainWindow) -> None:
    """Record the film in the README, which shows the sample before and after the correction."""
    document = window.document
    with tempfile.TemporaryDirectory() as folder:
        window.resize(*_SIZE)
        window.show()
        window.open_path(Path(shutil.copy(SAMPLE, folder)))
        wait_for(lambda: document.data)
        document.decide(Decision.ACCEPTED, [judged.id for judged in document.intervals])
        document.select_chain(_FILMED)
        document.go_to(_FILM.first)
        trigger_window_actions(window, "focus_chain")
        wait(_SETTLE_MS)
        window.part(of_recording).record_actions.record(_FILM)
        wait_for(lambda: not window.part(of_recording).recorder.running)
        document.review.mark_saved()
        window.close()
    print(_FILM.path.relative_to(IMAGES.parent.parent))


def lesson_pictures(window: MainWindow) -> None:
    """Take pictures of lesson pages, and of an exercise with its score."""
    QCursor.setPos(window.geometry().topLeft())  # no place under the mouse is dimmed
    player, exercise = (
        window.part(of_lessons).lesson_actions.player,
        window.part(of_lessons).lesson_actions.hidden_errors,
    )
    for path in sorted(LESSONS.glob("*.md")):
        window.part(of_lessons).lesson_actions.play(path)
        wait_for(lambda: player.at >= 0)
        for number in range(1, len(player.pages) + 1):
            wait_for(
                lambda: (
                    window.part(of_teaching).teaching.typesetter.done
                    or not window.part(of_teaching).taught.active
                )
            )
            if player.show_me.isEnabled():
                player.show_me.click()
            if path == TOUR or number == _PICTURED:
                save(window, f"{path.stem}-{number}")
            player.forward.click()
    trigger_window_actions(window, "exercise")
    exercise.seed.setValue(_SEED)
    exercise.start.click()
    wait_for(exercise.score_button.isEnabled)
    trigger_window_actions(window, "next_interval")
    assert window.document.data is not None
    exercise.score_button.click()
    assert exercise.result is not None
    hidden = {(e.chain, e.start) for e in exercise.result.misses}
    for judged in window.document.intervals[:-2]:
        window.document.select_interval(judged.id)
        real = (judged.interval.chain, judged.interval.start) in hidden
        trigger_window_actions(window, "accept" if real else "reject")
    exercise.score_button.click()
    save(window, "exercise")
    window.part(of_lessons).lesson_actions.leave_guide()


def trigger_window_actions(window: MainWindow, *names: str) -> None:
    """Trigger the actions with the given ids."""
    for name in names:
        window.actions_by_id[name].trigger()


def wait(milliseconds: int) -> None:
    """Run the event loop for some milliseconds. Unlike QTest.qWait, let other threads run."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


def wait_for(ready: Callable[[], object]) -> None:
    """Run the event loop until `ready` returns a true value."""
    while not ready():
        wait(20)


def steady_picture(window: MainWindow) -> QImage:
    """Wait until the window has stopped changing, and return a screenshot of it."""
    window.statusBar().clearMessage()  # the message would disappear at an unknown time
    seen, still_ms = window.grab().toImage(), 0
    ends = time.monotonic() + _PATIENCE_S
    while still_ms < _SETTLE_MS and time.monotonic() < ends:
        wait(_LOOK_MS)
        now = window.grab().toImage()
        still_ms = still_ms + _LOOK_MS if now == seen else 0
        seen = now
    return seen


def save(window: MainWindow, name: str) -> None:
    """Save a screenshot under a name in the docs as soon as the window has stopped changing."""
    wait(_SETTLE_MS)
    write_docs_image(steady_picture(window), name)


def write_docs_image(picture: QImage, name: str) -> None:
    """Write an image as PNG to the folder of images in the docs."""
    path = IMAGES / f"{name}.png"
    picture.save(str(path), quality=0)
    print(path.relative_to(IMAGES.parent.parent))


if __name__ == "__main__":
    sys.exit(main())
