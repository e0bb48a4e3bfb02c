"""The table of joints and their quality measures, with a row for the figure's position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import Qt

from inspector.language import tr
from inspector.quality.evidence import MEASURES, QualityEvidence, quality_measure_by_joint
from inspector.session.document import Document
from inspector.widgets.tables import RowModel, TableRow
from inspector.widgets.theme import Colours
from twistcore.analysis.quality.joint import JointQuality
from twistcore.skeleton.rotation import Array


@dataclass(frozen=True)
class _Joint:
    """A row of the table.

    Attributes
    ----------
    number
        The index of the joint; in the row of the figure's position, the number of joints.
    name
        The name of the joint.
    values
        The quality measures; None for each undefined measure.
    tracked
        True if the joint is tracked.
    after
        The jitter after tracking, or None.
    """

    number: int
    name: str
    values: tuple[float | None, ...]
    tracked: bool
    after: float | None = None


class JointsModel(RowModel[_Joint]):
    """The table of the joints, sorted by a column. Tracked joints have a different colour."""

    heads = (f"{tr('Joint')}\n", *(f"{m.name}\n{m.unit}" for m in MEASURES))
    head_tips = ("", *(m.tip for m in MEASURES))
    right = range(1, 1 + len(MEASURES))

    def __init__(self, document: Document, evidence: QualityEvidence, colours: Colours) -> None:
        super().__init__(colours)
        self._document, self._evidence = document, evidence
        self._tracked: frozenset[str] = frozenset()
        self._place_tracked = False
        self.after: JointQuality | None = None
        self._after: Array | None = None  # the jitter after tracking
        self._column, self._down = 1, True

    def key(self, thing: _Joint) -> int:
        """Return the number that identifies the row."""
        return thing.number

    def describe(self, thing: _Joint) -> TableRow:
        """Return the row with the name and the measures of a joint."""
        numbers = tuple(
            "–" if value is None else f"{value:.{measure.decimals}f}"
            for measure, value in zip(MEASURES, thing.values, strict=True)
        )
        if thing.after is not None:
            numbers = (f"{numbers[0]} → {thing.after:.{MEASURES[0].decimals}f}", *numbers[1:])
        name = thing.name
        if thing.tracked:
            name = tr("{joint}, tracked with QuaMo", joint=name)
        if thing.number == len(self.names):
            where = tr(
                "the figure's position, which can be tracked like a joint; it has no measurements"
            )
            name = f"{name}: {where}"
        return TableRow(
            texts=(f"{thing.name} ┄" if thing.tracked else thing.name, *numbers),
            colours={0: self.theme.tracked} if thing.tracked else {},
            tips=(name, *("" for _ in MEASURES)),
        )

    def reset(self) -> None:
        """Rebuild the table for a new clip, or after the quality measures have changed."""
        known = self._evidence.known
        if known is None:
            self.show(())
            return
        columns = [quality_measure_by_joint(known.joints, k) for k in range(len(MEASURES))]
        joints = [
            _Joint(
                j,
                name,
                tuple(_finite(c[j]) for c in columns),
                name in self._tracked,
                self._jitter_after(j, name),
            )
            for j, name in enumerate(self.names)
        ]
        if self.place:
            none = (None,) * len(MEASURES)
            joints.append(_Joint(len(joints), self.place, none, self._place_tracked))
        if self._column == 0:
            joints.sort(key=lambda joint: joint.name.lower(), reverse=self._down)
        else:
            joints.sort(key=self._order)
        self.show(joints)

    def mark_tracked(
        self, joints: frozenset[str], *, place: bool, after: JointQuality | None
    ) -> None:
        """Mark the tracked joints and, if `place` is True, the position of the figure.

        `after` contains the quality measures after tracking, or is None if they are unknown.
        """
        changed = (joints, place) != (self._tracked, self._place_tracked) or after is not self.after
        if changed:
            self._tracked, self._place_tracked, self.after = joints, place, after
            self._after = None if after is None else quality_measure_by_joint(after, 0)
            self.reset()

    def _jitter_after(self, joint: int, name: str) -> float | None:
        if self._after is None or name not in self._tracked or joint >= len(self._after):
            return None
        return _finite(self._after[joint])

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort the rows by a column, 0 for the name of the joint."""
        self._column, self._down = column, order == Qt.SortOrder.DescendingOrder
        self.reset()

    def _order(self, joint: _Joint) -> tuple[bool, float]:
        """Return the sort key of a joint. Joints without a value come last in both sort orders."""
        value = joint.values[self._column - 1]
        if value is None:
            return True, 0.0
        return False, -value if self._down else value

    @property
    def place(self) -> str:
        """The name of the row for the figure's position, or '' if there is no such row."""
        known = self._evidence.known
        placed = known.placed if known is not None else None
        return tr("{joint}, position", joint=self.names[placed]) if placed is not None else ""

    @property
    def rows(self) -> tuple[str, ...]:
        """The names of all trackable rows: the joints, then the figure's position."""
        return (*self.names, *((self.place,) if self.place else ()))

    @property
    def names(self) -> Sequence[str]:
        """The names of all joints."""
        return self._document.data.motion.skeleton.names if self._document.data else ()


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
