"""A clip of a folder: where its analysis and its review are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from inspector.language import of_core, tr

GONE = "no longer in the folder"
FAR_AWAY = "not on a disk of this machine; open a copy of it"
TOO_LARGE = "needs more memory than a clip of its size should"
NOT_BEGUN = "the analysis stopped before it began"
TOO_SLOW = "the analysis took too long and was stopped"
KILLED = "the analysis was ended by the system, perhaps for want of memory"
# Why there is nothing of a clip, as the table of clips and as a person has it.
_REASONS = {
    GONE: tr("no longer in the folder"),
    FAR_AWAY: tr("not on a disk of this machine; open a copy of it"),
    TOO_LARGE: tr("needs more memory than a clip of its size should"),
    NOT_BEGUN: tr("the analysis stopped before it began"),
    TOO_SLOW: tr("the analysis took too long and was stopped"),
    KILLED: tr("the analysis was ended by the system, perhaps for want of memory"),
}


class ClipState(StrEnum):
    """Where a clip of the queue is."""

    WAITING = "waiting"
    ANALYSING = "analysing"
    READY = "ready"
    FAILED = "failed"


@dataclass(frozen=True)
class QueuedClip:
    """A clip of the folder.

    severity: how bad it is, degrees, −1 while unknown; reason: why it failed, or why nothing
    could be checked in it (`unchecked`); decided: of how many intervals, by its review if that is
    open, else by its session, None without either; exported: the name of its latest export, or '';
    label: its name in a batch, or ''; waits: a review that ended without saving can be restored;
    missing: frames that its header declares and it does not have; unexamined: how many of its arms
    and legs no chain examines.
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

    @property
    def title(self) -> str:
        """What a list calls it: by its place in a batch, else by its name, of a BVH the stem."""
        is_bvh = self.path.suffix.lower() == ".bvh"
        return self.label or (self.path.stem if is_bvh else self.path.name)

    @property
    def counts(self) -> tuple[int, int]:
        """Intervals decided, of all."""
        return self.decided or (0, self.intervals)

    @property
    def done(self) -> bool:
        """Every interval is decided, and there is one."""
        return self.decided is not None and self.decided[0] == self.decided[1] > 0

    @property
    def clean(self) -> bool:
        """All of it was checked to its end and nothing was found."""
        lacks = self.unchecked or self.missing or self.unexamined
        ready = self.state == ClipState.READY and not lacks
        return ready and not self.counts[1] and not self.waits

    @property
    def to_do(self) -> bool:
        """Something in it is to be decided."""
        undecided = self.state == ClipState.READY and self.counts[0] < self.counts[1]
        return undecided or self.waits


def reason_told(clip: QueuedClip) -> str:
    """Why a clip failed or was not checked, in the chosen language: files have it in English."""
    for reason, told in _REASONS.items():
        if clip.reason.endswith(reason):
            return clip.reason.removesuffix(reason) + told
    return of_core(clip.reason)
