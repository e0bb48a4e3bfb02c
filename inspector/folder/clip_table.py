"""Write the clips of a folder to a CSV table for other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from inspector.folder.queued_clip import ClipState, QueuedClip
from twistcore.files.encoding import csv_text

# The columns. Severity is in degrees. A cell is empty if its value is not known yet.
_COLUMNS: Mapping[str, Callable[[QueuedClip], Any]] = {
    "clip": lambda c: c.label or c.path.name,
    "folder": lambda c: str(c.path.parent),
    "state": lambda c: "not checked" if c.unchecked else str(c.state),
    "severity": lambda c: round(c.severity, 6) if c.state == ClipState.READY else "",
    "intervals": lambda c: c.counts[1] if c.decided or c.state == ClipState.READY else "",
    "decided": lambda c: c.counts[0],
    "exported_as": lambda c: c.exported,
    "to_restore": lambda c: c.waits,
    "missing_frames": lambda c: c.missing if c.state == ClipState.READY else "",
    "unexamined": lambda c: c.unexamined if c.state == ClipState.READY else "",
    "reason": lambda c: c.reason,
}


def clip_table(clips: Iterable[QueuedClip]) -> str:
    """Return a table of clips as CSV, with one row per clip in the given order."""
    return csv_text(tuple(_COLUMNS), [{k: of(c) for k, of in _COLUMNS.items()} for c in clips])
