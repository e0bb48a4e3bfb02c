"""The rows of the action table for choosing a detector."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtGui import QAction, QActionGroup

from inspector.feature import ActionSpec
from inspector.language import translate_core_sentence
from inspector.window.parts import Parts
from twistcore.detection import DEFAULT_METHOD, DETECTORS, DetectorInfo


def detector_rows() -> tuple[ActionSpec[Parts], ...]:
    """Return a row for each available detector."""
    return tuple(map(_row, DETECTORS.infos()))


def _row(info: DetectorInfo) -> ActionSpec[Parts]:
    return ActionSpec(
        f"use_{info.name}",
        translate_core_sentence(info.menu_text),
        (),
        translate_core_sentence(info.measures),
        group="method",
        checked=info.name == DEFAULT_METHOD,
        do=lambda p: p.document.use_method(info.name),
    )


def tick_detector_entry(actions: Mapping[str, QAction], method: str) -> None:
    """Tick the menu entry of the detector `method`, or untick all if it has no entry."""
    if (action := actions.get(f"use_{method}")) is not None:
        action.setChecked(True)
        return
    group = actions[f"use_{DEFAULT_METHOD}"].actionGroup()
    if group is not None and (checked := group.checkedAction()) is not None:
        group.setExclusionPolicy(QActionGroup.ExclusionPolicy.None_)
        checked.setChecked(False)
        group.setExclusionPolicy(QActionGroup.ExclusionPolicy.Exclusive)
