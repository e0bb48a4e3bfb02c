"""A clip of a folder, with the state of its analysis and of its review."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from inspector.language import tr, translate_core_sentence
from twistcore.tuning.stated_precision import AutomaticCorrection

GONE = "no longer in the folder"
FAR_AWAY = "not on a disk of this machine; open a copy of it"
TOO_LARGE = "needs more memory than is usual for its size"
NOT_BEGUN = "the analysis stopped before it began"
TOO_SLOW = "the analysis was stopped because it took too long"
KILLED = "the system stopped the analysis, perhaps because memory ran out"
# Reasons why a clip has no results: text in tables and files, and text in the window.
_REASONS = {
    GONE: tr("no longer in the folder"),
    FAR_AWAY: tr(
        "the clip is not stored on this computer; copy it to a local disk and open the copy"
    ),
    TOO_LARGE: tr("the clip needs more memory than is usual for its size"),
    NOT_BEGUN: tr("the analysis was stopped before it began"),
    TOO_SLOW: tr("the analysis was stopped because it took too long"),
    KILLED: tr("the system stopped the analysis, perhaps because memory ran out"),
}


class ClipState(StrEnum):
    """The state of a clip's analysis."""

    WAITING = "waiting"
    ANALYSING = "analysing"
    READY = "ready"
    FAILED = "failed"


@dataclass(frozen=True)
class QueuedClip:
    """A clip of the folder.

    Attributes
    ----------
    severity
        The severity in degrees; −1 while it is unknown.
    intervals
        The number of detected intervals.
    reason
        The reason why the analysis failed or, if `unchecked` is True, why nothing could be checked.
    decided
        The number of decided and of all intervals in the open review or in the session; None if the
        clip has neither a review nor a session.
    unchecked
        True if nothing in the clip could be checked.
    exported
        The name of the latest export, or ''.
    waits
        True if the clip has unsaved decisions that can be restored.
    label
        The name of the clip in a batch, or ''.
    missing
        The number of frames that the header declares but the file does not contain.
    unexamined
        The number of arms and legs without a chain.
    automatic
        The automatic corrections; empty if the results come from a batch.
    """

    path: Path
    state: ClipState = ClipState.WAITING
    severity: float = -1.0
    intervals: int = 0
    reason: str = ""
    decided: tuple[int, int] | None = None
    unchecked: bool = False
    exported: str = ""
    waits: bool = False
    label: str = ""
    missing: int = 0
    unexamined: int = 0
    automatic: tuple[AutomaticCorrection, ...] = ()

    @property
    def title(self) -> str:
        """The name to display: the name in the batch or, if there is none, the file name.

        The suffix of a BVH file is omitted.
        """
        is_bvh = self.path.suffix.lower() == ".bvh"
        return self.label or (self.path.stem if is_bvh else self.path.name)

    @property
    def counts(self) -> tuple[int, int]:
        """The number of decided intervals and the number of all intervals."""
        return self.decided or (0, self.intervals)

    @property
    def done(self) -> bool:
        """Return True if the clip has intervals and all of them are decided."""
        return self.decided is not None and self.decided[0] == self.decided[1] > 0

    @property
    def clean(self) -> bool:
        """Return True if the clip was checked completely, without errors or unsaved decisions."""
        lacks = self.unchecked or self.missing or self.unexamined
        ready = self.state == ClipState.READY and not lacks
        return ready and not self.counts[1] and not self.waits

    @property
    def to_do(self) -> bool:
        """Return True if the clip has undecided intervals or decisions to be restored."""
        undecided = self.state == ClipState.READY and self.counts[0] < self.counts[1]
        return undecided or self.waits


def reason_text(clip: QueuedClip) -> str:
    """Return the reason why a clip failed or was not checked, in the chosen language."""
    for reason, text in _REASONS.items():
        if clip.reason.endswith(reason):
            return clip.reason.removesuffix(reason) + text
    return translate_core_sentence(clip.reason)
