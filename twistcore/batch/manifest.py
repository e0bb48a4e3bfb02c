"""What is known of every clip of a batch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class ClipRecord:
    """A clip of a batch; result: a document 'twistcore.batch_clip/1', or None."""

    source: str
    name: str
    state: str
    reason: str
    sha256: str
    bytes: int
    seconds: float
    peak_bytes: int
    finished_at: str
    parameters: Mapping[str, Any]
    version: str
    result: Mapping[str, Any] | None
    corrected: str
    decisions: Mapping[str, Any]
