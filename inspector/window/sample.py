"""Open a copy of the sample clip at its worst interval, and describe the error there."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import platformdirs
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence

from inspector.bundled import SAMPLE
from inspector.language import tr
from inspector.panels.limb_words import part_of_body
from inspector.widgets.signed_numbers import format_number
from inspector.window.parts import Parts
from twistcore.detection import Kind
from twistcore.files.atomic import write_atomically
from twistcore.files.ordinary import (
    is_file,
    path_exists,
    read_file,
    user_folder_or_uncreatable_path,
)
from twistcore.review import Judged

_FOLDER = "Twist Inspector"  # folder in the user's documents
_VERDICTS = ("accept", "reject")  # ids of the actions
_MOST = 100  # number of file names to try


def open_sample(parts: Parts) -> None:
    """Open the user's copy of the sample at its worst interval, showing the striped skin.

    The poses before and after the correction are shown side by side.
    """
    parts.files.open_then(user_copy_of_clip(SAMPLE), partial(_begin, parts))


def user_copy_of_clip(bundled: Path) -> Path:
    """Return the user's own copy of a bundled clip, creating it in their documents if necessary.

    If there is another file with this name, the copy gets the next free name. If the folder is
    read-only, the path of the bundled clip is returned.
    """
    folder = user_folder_or_uncreatable_path(platformdirs.user_documents_path) / _FOLDER
    try:
        content = read_file(bundled)
        for number in range(1, _MOST):
            ending = f"-{number}" if number > 1 else ""
            copy = folder / f"{bundled.stem}{ending}{bundled.suffix}"
            if is_file(copy) and read_file(copy) == content:
                return copy
            if not path_exists(copy):
                folder.mkdir(parents=True, exist_ok=True)
                write_atomically(copy, content)
                return copy
    except OSError:
        pass
    return bundled


def _begin(parts: Parts) -> None:
    worst = parts.review_actions.go_to_worst()
    # Even if the user has chosen another view for this kind of error
    for look in ("skin", "side_by_side"):
        parts.actions_by_id[look].setChecked(True)
    if worst is not None and worst.interval.kind == Kind.COUNTER_TWIST:
        sentence = _sentence(parts, worst)
        parts.bar.offer(sentence, ())
        parts.document.interval_changed.connect(
            lambda: parts.bar.withdraw(sentence), Qt.ConnectionType.SingleShotConnection
        )


def _sentence(parts: Parts, worst: Judged) -> str:
    native = QKeySequence.SequenceFormat.NativeText
    accept, reject = (parts.actions_by_id[name].shortcut().toString(native) for name in _VERDICTS)
    return tr(
        "{part} is twisted by {angle}°. Press {accept} to accept the interval or {reject} to "
        "reject it.",
        part=part_of_body(parts.document.find_chain(worst.interval.chain)),
        angle=format_number(abs(np.degrees(worst.interval.shown)), 0),
        accept=accept,
        reject=reject,
    )
