"""Write a batch report's overview page, and simple pages for clips that can no longer be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from twistcore.batch.gates import Broken
from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind
from twistcore.files.version import __version__
from twistcore.report.clip_page import Home
from twistcore.report.folder_numbers import BIN, KINDS, ClipRow, FolderNumbers, nonempty_parameters
from twistcore.report.page_templates import GENERATOR, render_page_template

__all__ = ["GENERATOR", "clip_page_from_manifest", "folder_page_html"]

MOST_ROWS = 5000  # maximum number of rows that a browser sorts without delay
_MOST_JOINTS = 60


@dataclass(frozen=True)
class HistogramBar:
    """One bin of the histogram of interval sizes.

    Attributes
    ----------
    start
        Lower limit of the bin in degrees.
    counts
        Number of intervals of each kind.
    """

    start: int
    counts: tuple[int, ...]

    @property
    def total(self) -> int:
        """Return the number of intervals in the bin."""
        return sum(self.counts)


def folder_page_html(
    title: str, rows: Sequence[ClipRow], numbers: FolderNumbers, broken: Sequence[Broken]
) -> str:
    """Return the overview page of a batch report as HTML.

    Parameters
    ----------
    title
        Name of the folder.
    rows
        The clips in the order of the table, unprocessed clips first.
    numbers
        The sums over all clips.
    broken
        The rules of `--fail-if` that the batch has broken.
    """
    done = [row for row in rows if row.state == "done"]
    joints = sorted(numbers.joints.items(), key=lambda j: (-j[1].total(), j[0]))
    return render_page_template(
        "folder.html",
        title=title,
        numbers=numbers,
        kinds=_kinds(numbers),
        found_kinds=tuple(kind for kind in KINDS if numbers.kinds[kind]),
        rows=done[:MOST_ROWS],
        rows_left_out=max(0, len(done) - MOST_ROWS),
        troubled=[row for row in rows if row.state != "done"][:MOST_ROWS],
        worst=max((row.severity for row in done), default=0.0),
        joints=joints[:_MOST_JOINTS],
        joints_left_out=max(0, len(joints) - _MOST_JOINTS),
        bars=_bars(numbers),
        broken=[str(one) for one in broken],
        breakers={one.clip for one in broken},
        reviewed=any(row.decided is not None for row in done),
        program=f"twistcore {__version__}",
        written_at=datetime.now(UTC).isoformat(timespec="seconds"),
    )


def clip_page_from_manifest(record: ClipRecord, why: str, home: Home) -> str:
    """Return a clip's page with only the manifest's data.

    `why` is the reason why there is nothing else, such as a missing file.
    """
    numbers = FolderNumbers()
    return render_page_template(
        "known.html",
        record=record,
        row=numbers.add(record),
        result=record.result or {},
        why=why,
        home=home,
        parameters=nonempty_parameters(record.parameters),
    )


def _kinds(numbers: FolderNumbers) -> tuple[str, ...]:
    """Return the kinds of errors that the page counts.

    A kind of capture fault is counted only if the batch has such faults. Kinds that were not found
    have no column in the tables.
    """
    return tuple(kind for kind in KINDS if numbers.kinds[kind] or not Kind(kind).of_capture)


def _bars(numbers: FolderNumbers) -> list[HistogramBar]:
    """Return the bins of the histogram, or an empty list if there are no intervals."""
    if not numbers.sizes:
        return []
    count = len(next(iter(numbers.sizes.values())))
    by_kind = [numbers.sizes.get(kind, [0] * count) for kind in _kinds(numbers)]
    return [HistogramBar(k * BIN, tuple(sizes[k] for sizes in by_kind)) for k in range(count)]
