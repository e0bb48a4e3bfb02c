"""Count the intervals of a batch, by kind, joint and size, and the affected frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from twistcore.analysis.clip_severity import percent_of_frames_with_error, unexamined_limb_sentences
from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind

KINDS = tuple(kind.value for kind in Kind)
BIN = 15  # width of a bin in degrees
_BINS = 180 // BIN


@dataclass(frozen=True)
class ClipRow:
    """A row of the clip table.

    If a clip was not processed, only the name, the state and the reason are set.

    Attributes
    ----------
    name, state, reason
        As in :class:`ClipRecord`.
    severity, max_deg, rms_deg
        Severity, largest and root mean square offset, in degrees.
    counts
        Number of intervals, keyed by kind.
    frames, seconds
        Length of the clip.
    affected
        Number of affected frames.
    left
        Number of intervals in the corrected clip, None if nothing was corrected.
    applied
        Number of corrected intervals, None if nothing was corrected.
    decided, of
        Number of decided intervals, or None if nobody has reviewed the clip, and number of all
        intervals.
    reviewers
        Names of the reviewers.
    unchecked
        The reason why nothing in the clip could be examined, or ''.
    missing
        Number of frames that the file's header declares but the file does not have.
    unexamined
        Limbs that no chain examines, each with the reason.
    page
        Path of the clip's page, or ''.
    """

    name: str
    state: str
    reason: str = ""
    severity: float = 0.0
    counts: Mapping[str, int] = field(default_factory=lambda: dict.fromkeys(KINDS, 0))
    frames: int = 0
    affected: int = 0
    seconds: float = 0.0
    max_deg: float = 0.0
    rms_deg: float = 0.0
    left: int | None = None
    applied: int | None = None
    decided: int | None = None
    of: int = 0
    reviewers: Sequence[str] = ()
    unchecked: str = ""
    missing: int = 0
    unexamined: Sequence[str] = ()
    page: str = ""

    @property
    def found(self) -> int:
        """Return the total number of intervals."""
        return sum(self.counts.values())

    @property
    def share(self) -> float:
        """Return the percentage of affected frames."""
        return percent_of_frames_with_error(self.affected, self.frames)


@dataclass
class FolderNumbers:
    """Counts of clips, intervals and frames in a batch.

    Attributes
    ----------
    states
        Number of clips, keyed by state.
    kinds
        Number of intervals, keyed by kind.
    joints
        Number of intervals, keyed by the name of a chain, limb or joint, and by kind.
    sizes
        Number of correctable intervals in each bin of BIN degrees, keyed by kind.
    frames, affected, seconds
        Number of frames, number of affected frames, and duration.
    with_finds
        Number of clips with intervals.
    unchecked, in_part
        Number of clips that could not be examined, and of clips with limbs that no chain examines.
    missing, cut
        Number of frames that headers declare but files do not have, and of clips with such frames.
    applied, left
        Number of corrected intervals, and of intervals in the corrected clips. None if no clip was
        corrected.
    decided
        Number of decided intervals.
    reviewers
        Number of clips, keyed by reviewer.
    how
        Number of clips, keyed by a string with the program version and the parameters.
    """

    states: Counter[str] = field(default_factory=Counter)
    kinds: Counter[str] = field(default_factory=Counter)
    joints: dict[str, Counter[str]] = field(default_factory=dict)
    sizes: dict[str, list[int]] = field(default_factory=dict)
    frames: int = 0
    affected: int = 0
    seconds: float = 0.0
    with_finds: int = 0
    unchecked: int = 0
    in_part: int = 0
    missing: int = 0
    cut: int = 0
    applied: int | None = None
    left: int | None = None
    decided: int = 0
    reviewers: Counter[str] = field(default_factory=Counter)
    how: Counter[str] = field(default_factory=Counter)

    def add(self, record: ClipRecord) -> ClipRow:
        """Add a clip to the sums, and return its table row."""
        self.states[record.state] += 1
        result = record.result
        if record.state != "done" or result is None:
            return ClipRow(record.name, record.state, record.reason)
        row = _row(record, result)
        self.kinds.update(row.counts)
        self.frames += row.frames
        self.affected += row.affected
        self.seconds += row.seconds
        self.with_finds += row.found > 0
        self.unchecked += bool(row.unchecked)
        self.missing += row.missing
        self.cut += bool(row.missing)
        self.in_part += bool(row.unexamined)
        if row.applied is not None:
            self.applied = (self.applied or 0) + row.applied
        if row.left is not None:
            self.left = (self.left or 0) + row.left
        self.decided += row.decided or 0
        self.reviewers.update(row.reviewers)
        self._add_intervals(result["intervals"])
        how = [f"twistcore {record.version}", f"detector {result['method']}"]
        how += [
            _parameter(k, v)
            for k, v in nonempty_parameters(record.parameters).items()
            if k != "method"
        ]
        self.how[", ".join(how)] += 1
        return row

    def _add_intervals(self, intervals: Iterable[Mapping[str, Any]]) -> None:
        for entry in intervals:
            name, kind = _place_name(entry), entry["kind"]
            self.joints.setdefault(name, Counter())[kind] += 1
            if Kind(kind).repairable:
                at = min(int(abs(entry["delta_deg"]) // BIN), _BINS - 1)
                self.sizes.setdefault(kind, [0] * _BINS)[at] += 1

    @property
    def clips(self) -> int:
        """Return the total number of clips, including unprocessed ones."""
        return self.states.total()

    @property
    def intervals(self) -> int:
        """Return the total number of intervals."""
        return self.kinds.total()

    @property
    def share(self) -> float:
        """Return the percentage of affected frames."""
        return percent_of_frames_with_error(self.affected, self.frames)

    def an_hour(self, kind: str) -> float:
        """Return the number of intervals of a kind per hour of motion."""
        return 3600.0 * self.kinds[kind] / self.seconds if self.seconds else 0.0


def nonempty_parameters(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters without empty values."""
    return {k: v for k, v in parameters.items() if v not in (None, [], "", False)}


def worst_first(rows: Iterable[ClipRow]) -> list[ClipRow]:
    """Sort the rows: unprocessed clips first, then the others from worst to best."""
    return sorted(rows, key=lambda r: (r.state == "done", -r.severity, -r.found, r.name))


def _row(record: ClipRecord, result: Mapping[str, Any]) -> ClipRow:
    decisions, left = record.decisions, result["left"]
    decided = decisions.get("accepted", 0) + decisions.get("rejected", 0)
    return ClipRow(
        record.name,
        record.state,
        severity=result["severity"],
        counts={kind: result["counts"].get(kind, 0) for kind in KINDS},
        frames=result["frames"],
        affected=result["affected_frames"],
        seconds=result["seconds"],
        max_deg=result["degrees"]["max"],
        rms_deg=result["degrees"]["rms"],
        left=None if left is None else len(left),
        applied=result["applied"],
        decided=decided if decisions else None,
        of=decided + decisions.get("undecided", 0),
        reviewers=tuple(decisions.get("reviewers", ())),
        unchecked=result["unchecked"],
        missing=result.get("missing_frames") or 0,
        unexamined=unexamined_limb_sentences(result),
    )


def _parameter(name: str, value: Any) -> str:
    words = name.replace("_", " ")
    if value is True:
        return words
    return f"{words} {', '.join(map(str, value)) if isinstance(value, list) else value}"


def _place_name(entry: Mapping[str, Any]) -> str:
    """Return the joint, limb or chain of an interval, given as an entry of `detect --json`."""
    return str(entry.get("joint") or entry.get("limb") or entry["chain"])
