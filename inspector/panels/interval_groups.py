"""The groups of errors in the interval table, which the user can unfold and fold."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from inspector.panels.interval_rows import GroupRow, IntervalRow, ListRow
from inspector.session.document import Document
from twistcore.analysis.error_groups import ErrorGroup, error_groups
from twistcore.detection import Interval
from twistcore.review import Judged
from twistcore.review.model import overlapping_ids


class IntervalGroups:
    """The groups of a document's intervals.

    Attributes
    ----------
    on
        True to group errors that belong together. In an exercise, there are no groups.
    whole
        True if the selection is the whole group of the selected interval, False if it is only the
        interval.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self.on = True
        self.whole = False
        self._unfolded: set[int] = set()  # ids of the intervals in unfolded groups
        self._by_id: dict[int, GroupRow] = {}
        self._grouped_last: tuple[object, list[Interval]] | None = None
        self._found: tuple[ErrorGroup, ...] = ()

    def forget(self) -> None:
        """Discard all groups. Called when a different clip is opened."""
        self.whole = False
        self._unfolded.clear()
        self._by_id.clear()
        self._grouped_last = None

    @property
    def count(self) -> int:
        """The number of groups in the table."""
        return len({group.id for group in self._by_id.values()})

    def find(self, interval_id: int | None) -> GroupRow | None:
        """Return the group row that contains an interval, or None."""
        return self._by_id.get(interval_id) if interval_id is not None else None

    @property
    def selected(self) -> GroupRow | None:
        """The row of the group that is selected as a whole, or None."""
        return self.find(self._document.interval_id) if self.whole else None

    @property
    def entered(self) -> GroupRow | None:
        """The row of the group in which only a single interval is selected, or None."""
        return None if self.whole else self.find(self._document.interval_id)

    def unfold(self, group: GroupRow, on: bool = True) -> None:
        """Unfold a group, or fold it if `on` is False."""
        if on:
            self._unfolded.update(group.ids)
        else:
            self._unfolded.difference_update(group.ids)

    def rows(self, listed: Sequence[Judged], intervals: Sequence[Judged]) -> list[ListRow]:
        """Return the rows of all intervals and groups, including rows that are not listed.

        The rows are in the order of `intervals`. The row of a group is followed by the rows of its
        intervals, which are listed if the group is unfolded. Groups contain only intervals from
        `listed` that a detector has found.
        """
        shared, shown = overlapping_ids(intervals), {judged.id for judged in listed}
        self._by_id = {k: group for group in self._grouped(listed) for k in group.ids}
        return list(self._arranged(intervals, shared, shown))

    def _arranged(
        self, intervals: Sequence[Judged], shared: Collection[int], shown: Collection[int]
    ) -> Iterator[ListRow]:
        # The intervals of each group, in the order of the list
        inside: dict[int, list[Judged]] = {}
        for judged in intervals:
            if (group := self._by_id.get(judged.id)) is not None:
                inside.setdefault(group.id, []).append(judged)
        for judged in intervals:
            if (group := self._by_id.get(judged.id)) is None:
                yield IntervalRow(judged, judged.id in shared, judged.id in shown)
            elif group.id in inside:
                yield group
                for member in inside.pop(group.id):
                    yield IntervalRow(member, member.id in shared, group.unfolded, group)

    def _grouped(self, listed: Sequence[Judged]) -> Iterator[GroupRow]:
        data, now = self._document.data, self._document.interval_id
        if data is None or data.blind or not self.on:
            return
        listed = [judged for judged in listed if not judged.by_hand]
        new = data.analysis, [judged.interval for judged in listed]
        if new != self._grouped_last:  # decisions do not change the groups
            self._grouped_last = new
            self._found = error_groups(new[1], data.chains_and_limbs, data.motion.skeleton)
        for group in self._found:
            members = tuple(listed[k] for k in group.members)
            ids = {judged.id for judged in members}
            if now in ids and not self.whole:
                self._unfolded |= ids
            unfolded = not ids.isdisjoint(self._unfolded)
            yield GroupRow(group.name, group.short, members, unfolded)
