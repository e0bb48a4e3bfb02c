"""Walk all visible widgets of the window: `layout_check.py WIDTH HEIGHT THEME CLIP PNG [CODE]`.

Prints one line a defect: text that does not fit its widget, its tab or its cell, siblings that
overlap. CODE: of the language.
"""

import shutil
import sys
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

from PySide6.QtCore import QRect
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QLabel,
    QMenuBar,
    QScrollArea,
    QTabBar,
    QWidget,
)

from inspector.app import make_application
from inspector.bundled import LESSONS, TOUR
from inspector.language import translated_page_path
from inspector.session.settings import Settings
from inspector.teaching.section_head import SectionHead
from inspector.widgets.labels import Headline
from inspector.widgets.tables import RowTable
from tests.conftest import ASSETS
from tests.gui.cut_texts import cut_cells, cut_tabs
from tests.gui.waiting import wait
from twistcore.analysis.decomposition import WhatIf

NARROWEST = 1024
_LOOKS = 60  # in vain, before what does not fit is a defect


def name(widget: QWidget) -> str:
    text = getattr(widget, "text", lambda: "")() if not isinstance(widget, QComboBox) else ""
    return f"{type(widget).__name__} {widget.objectName()!r} {text[:40]!r}"


def cut_texts(widgets: Iterable[QWidget]):
    for widget in widgets:
        if widget.visibleRegion().isEmpty():  # it is behind a tab
            continue
        if isinstance(widget, Headline | SectionHead):
            wraps = isinstance(widget, Headline) and widget.wordWrap()
            if not wraps and widget.least_width > widget.width():
                yield f"{name(widget)} is {widget.width()} wide and needs {widget.least_width}"
        elif isinstance(widget, RowTable):
            for text in cut_cells(widget):
                yield f"{text!r} is cut in {widget.accessibleName()!r}"
        elif isinstance(widget, QTabBar):
            for text in cut_tabs(widget):
                yield f"the tab {text!r} is cut"


def defects(window: QWidget):
    visible = [w for w in window.findChildren(QWidget) if w.isVisible() and w.width() > 0]
    for widget in visible:
        if isinstance(widget, QLabel | QAbstractButton | QComboBox):
            text = widget.text() if not isinstance(widget, QComboBox) else widget.currentText()
            hint = widget.minimumSizeHint()
            wraps = isinstance(widget, QLabel) and widget.wordWrap()
            if text and not wraps and widget.width() < hint.width():
                yield f"{name(widget)} is {widget.width()} wide and needs {hint.width()}"
            if text and widget.height() < hint.height() - 1:
                yield f"{name(widget)} is {widget.height()} high and needs {hint.height()}"
    yield from cut_texts(visible)
    for parent in [window, *visible]:
        if parent.layout() is None:
            continue
        laid = [parent.layout().itemAt(k).widget() for k in range(parent.layout().count())]
        # Docks behind a tab are visible in Qt's sense, and laid where nobody sees them.
        seen = [w for w in laid if w and w.isVisible() and parent.rect().intersects(w.geometry())]
        for a, b in combinations(seen, 2):
            common = QRect(a.geometry()).intersected(b.geometry())
            if common.width() > 1 and common.height() > 1:
                yield f"{name(a)} and {name(b)} overlap by {common.width()}×{common.height()}"
    for area in window.findChildren(QScrollArea):
        inner = area.widget()
        shown = not area.visibleRegion().isEmpty()
        if shown and inner and inner.width() > area.viewport().width():
            needed = f"{inner.width()} wide and {area.viewport().width()} of it are seen"
            yield f"what scrolls in {name(area.parentWidget())} is {needed}"
    bar = window.findChild(QMenuBar)
    if bar is not None and bar.sizeHint().width() > window.width():
        yield "the menu bar does not fit"


def act(window, name: str) -> None:
    window.actions_by_id[name].trigger()


def look(window: QWidget, where: str, settled: int = 400) -> None:
    wait(settled)
    looks = _LOOKS
    while (found := list(defects(window))) and looks:  # a busy machine lays out later
        wait(250)
        looks -= 1
    for defect in found:
        print(f"{where}: {defect}")


def look_at_groups(window, folder: Path) -> None:
    window.open_path(Path(shutil.copy(ASSETS / "kick.bvh", folder)))
    while window.document.data is None or not window.intervals._groups.count:
        wait(10)
    for _ in range(3):
        act(window, "next_interval")
        look(window, "a row of a clip with groups")
    kinds = {judged.interval.kind: judged.id for judged in window.document.intervals}
    for kind, number in kinds.items():
        window.document.select_interval(number, jump=True)
        look(window, f"an interval of the kind {kind}")


def teach(window, lessons: Iterable[Path]) -> None:
    act(window, "show_teaching")
    while not window.teaching.typesetter.done:
        wait(10)
    window.document.select_chain("LeftForeArm")
    window.taught.set_what_if(WhatIf(twist=1.2, counter=True))
    look(window, "teaching")
    player = window.lesson_actions.player
    for lesson in lessons:
        window.lesson_actions.play(lesson)
        while player.at < 0:
            wait(10)
        for number in range(1, len(player.pages) + 1):
            player.show_me.click()
            look(window, f"{lesson.stem}, page {number}", 150)
            player.forward.click()
    act(window, "exercise")
    look(window, "exercise")
    window.lesson_actions.leave_guide()


def track(window, what) -> None:
    before, until = window.quality.tracked.result, 6000
    act(window, "track_joints")
    look(window, f"quality, to be {what}")
    while window.quality.tracked.result is before and until:
        wait(20)
        until -= 1
    look(window, f"quality, {what}")


def assess(window) -> None:
    act(window, "show_quality")
    while window.quality.evidence.known is None:
        wait(10)
    look(window, "quality")
    window.quality.choose("LeftForeArm", "LeftHand", "LeftArm")
    wait(50)
    track(window, "smoothed")
    window.quality.page.both_ways.setChecked(True)
    window.quality.page.learned.setChecked(True)
    track(window, "tracked")
    act(window, "why_quaternions")
    look(window.lesson_actions.five_trackers, "why quaternions")
    window.lesson_actions.five_trackers.close()


def main() -> None:
    language = sys.argv[6] if len(sys.argv) > 6 else "en"
    make_application(language)
    from inspector.window.main_window import MainWindow  # after the application: VTK asks for it

    width, height, theme, clip, png = sys.argv[1:6]
    window = MainWindow(Settings(theme=theme), None)
    window.resize(int(width), int(height))
    window.show()
    look_at_groups(window, Path(clip).parent)
    with_groups = window.document.data
    window.open_path(Path(clip))
    while window.document.data in (None, with_groups):
        wait(10)
    act(window, "next_interval")
    act(window, "accept")
    look(window, "review")
    if (window.width(), window.height()) != (int(width), int(height)):
        print(f"the window needs {window.width()}×{window.height()}")
    window.grab().save(png)
    act(window, "show_tuning")
    while len(window.tuning.costs.curves) < len(window.tuning.costs.names):
        wait(10)
    look(window, "tuning, curves")
    profile = Path(clip).with_name("a_profile_with_a_long_name.toml")
    window.tuning_actions.save_profile_to(profile)
    window.tuning_actions.compare_with([profile, profile])
    look(window, "tuning, profiles")
    act(window, "both_costs")
    look(window, "tuning, both detectors")
    act(window, "both_costs")
    window.tuning.tabs.setCurrentWidget(window.tuning.suggestion)
    look(window, "tuning, suggestion")
    assess(window)
    # A page that fits the narrowest window fits the others: there the tour stands for all.
    narrow = int(width) == NARROWEST
    lessons = sorted(LESSONS.glob("*.md")) if narrow else [TOUR]
    teach(window, [translated_page_path(lesson) for lesson in lessons])
    if (window.width(), window.height()) != (int(width), int(height)):
        print(
            f"with tuning, quality and teaching the window needs {window.width()}×{window.height()}"
        )
    window.document.review.mark_saved()
    window.close()


if __name__ == "__main__":  # worker processes import this module again
    main()
