"""The rows of the interval table: single intervals, and groups that can be unfolded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6.QtCore import QSortFilterProxyModel, Qt

from inspector.language import tr, tr_as, translate_core_sentence
from inspector.panels.interval_columns import COLUMNS, PLACE
from inspector.panels.reject_reasons import translate_reject_reason
from inspector.panels.rig_names import joints_of_error, label_of
from inspector.session.document import Document
from inspector.widgets.labels import capitalised
from inspector.widgets.signed_numbers import (
    format_number,
    format_signed_number,
    interval_angle_text,
)
from inspector.widgets.tables import SORT_ROLE, Index, RowModel, TableRow
from inspector.widgets.theme import Colours
from twistcore.review import Decision, Judged
from twistcore.review.model import APPLIED, SEEN
from twistcore.skeleton.helper import Helper

INDENT = 4 * "\N{NO-BREAK SPACE}"  # precedes the name of an interval in an unfolded group
NAME = PLACE["stop"]  # the first column that the name of a group spans
_FOLDED, _UNFOLDED = "▸ ", "▾ "
_NOTED = 500  # maximum length of a note in its cell
_LISTED = 12  # maximum number of intervals in the tool tip of a group
MARKS = {
    Decision.UNDECIDED: tr("· undecided"),
    Decision.ACCEPTED: tr("✓ accepted"),
    Decision.REJECTED: tr("✗ rejected"),
}
ENDS = tr_as("the limb's end is", "kept"), tr_as("the limb's end is", "turned")
SHARED, UNSUPPORTED, EDITED = " +", " <τ", " ✎"


@dataclass(frozen=True)
class GroupRow:
    """The row of a group.

    Attributes
    ----------
    short
        The short form of the name, for a narrow table.
    members
        The intervals of the group. The first one determines the chain and the values for sorting.
    unfolded
        True if the rows of the group's intervals are visible.
    listed
        True if the row of the group is visible.
    """

    name: str
    short: str
    members: tuple[Judged, ...]
    unfolded: bool
    listed: bool = True

    @property
    def id(self) -> int:
        """The id of the row. It differs from the ids of all intervals."""
        return -self.members[0].id

    @property
    def ids(self) -> tuple[int, ...]:
        """The ids of all intervals in the group."""
        return tuple(judged.id for judged in self.members)

    @property
    def undecided(self) -> Judged:
        """The first undecided interval in the group or, if all are decided, the first interval."""
        left = (j for j in self.members if j.decision == Decision.UNDECIDED)
        return next(left, self.members[0])


@dataclass(frozen=True)
class IntervalRow:
    """The row of an interval.

    Attributes
    ----------
    shared
        True if a different interval of the same chain overlaps this interval.
    listed
        True if the row is visible.
    group
        The row of the interval's group, or None if the interval is in no group.
    """

    judged: Judged
    shared: bool
    listed: bool = True
    group: GroupRow | None = None

    @property
    def id(self) -> int:
        """The id of the interval."""
        return self.judged.id

    @property
    def ids(self) -> tuple[int, ...]:
        """The interval's id as a tuple, like the ids of a group."""
        return (self.judged.id,)


ListRow = IntervalRow | GroupRow


class IntervalModel(RowModel[ListRow]):
    """The rows of the interval table. The intervals of a group follow the row of the group."""

    heads = tuple(column.head for column in COLUMNS)
    head_tips = tuple(column.tip or column.name for column in COLUMNS)
    right = tuple(k for k, column in enumerate(COLUMNS) if column.figures)
    middle = (PLACE["chain"],)

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__(colours)
        self._document = document

    def key(self, thing: ListRow) -> int:
        """Return the key that identifies a row."""
        return thing.id

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        """Return the heading of a column, or the number of the interval in a row.

        The number is the interval's id and does not depend on the sort order.
        """
        if orientation == Qt.Orientation.Vertical and role == Qt.ItemDataRole.DisplayRole:
            thing = self.things[section]
            return "" if isinstance(thing, GroupRow) else str(thing.id)
        return super().headerData(section, orientation, role)

    def describe(self, thing: ListRow) -> TableRow:
        """Return the texts, colours and other data of all cells in a row."""
        if isinstance(thing, GroupRow):
            return self._describe_group(thing)
        judged, shared = thing.judged, thing.shared
        document = self._document
        interval, own = document.displayed(judged).interval, judged.interval.confidence
        assert document.data is not None
        delta, first = float(np.degrees(interval.shown)), document.first_frame
        seconds = interval.start * document.data.motion.frame_time
        decision = verdict_text(judged)
        decision += (SHARED if shared else "") + ("" if judged.supported else UNSUPPORTED)
        decision += EDITED if judged.edited else ""
        sure = -1.0 if interval.confidence is None else interval.confidence
        chain = document.find_chain(interval.chain)
        joints = joints_of_error(interval, chain, document.data.motion.skeleton)
        end = limb_end_state_text(judged)
        label = label_of(interval, chain, listed=not isinstance(chain, Helper))
        note = " · ".join(filter(None, (translate_reject_reason(judged.reason), judged.note)))[
            :_NOTED
        ]
        # Text and sort value of each cell, keyed by column
        cells: dict[str, tuple[str, object]] = {
            "chain": (label, "" if interval.kind.info.whole_body else interval.chain),
            "decision": (decision, judged.decision.value),
            "start": (str(interval.start + first), interval.start),
            "stop": (str(interval.stop + first), interval.stop),
            "frames": (str(interval.frames), interval.frames),
            "time": (f"{seconds:.2f} s", interval.start),
            "delta": (interval_angle_text(interval.kind, interval.shown), abs(delta)),
            "confidence": ("–" if interval.confidence is None else f"{sure:.2f}", sure),
            "end": (end, end),
            "kind": (translate_core_sentence(interval.kind), interval.kind.value),
            "joints": (joints, joints),
            "note": (note, note),
        }
        inside = INDENT * (thing.group is not None)
        return TableRow(
            texts=(inside + label, *(cells[column.id][0] for column in COLUMNS[1:])),
            sort=tuple(cells[column.id][1] for column in COLUMNS),
            colours={
                PLACE["decision"]: getattr(self.theme, str(judged.decision)),
                PLACE["joints"]: self.theme.soft,
                PLACE["kind"]: getattr(self.theme, interval.kind.info.colour, self.theme.text),
            },
            tips=(
                _tip(
                    document.displayed(judged),
                    shared,
                    f"{label} ({joints})" if joints else label,
                    own,
                ),
            ),
            spoken={PLACE["decision"]: decision.partition(" ")[2], 0: label},
        )

    def _describe_group(self, group: GroupRow) -> TableRow:
        lead, every = group.members[0], [j.decision for j in group.members]
        document, count = self._document, len(every)
        chain, first = document.find_chain(lead.interval.chain), document.first_frame
        decided = count - every.count(Decision.UNDECIDED)
        one = every[0] if len(set(every)) == 1 else None
        decision = MARKS[one] if one else tr("{done} of {count}", done=decided, count=count)
        if all(j.verdict == SEEN for j in group.members):
            decision = tr("✓ seen")
        start = min(j.interval.start for j in group.members)
        name, short = (
            capitalised(translate_core_sentence(text)) for text in (group.name, group.short)
        )
        place = label_of(lead.interval, chain)
        label = (_UNFOLDED if group.unfolded else _FOLDED) + place
        about = f"{place} ({count}): {name}"
        texts, sort = [""] * len(COLUMNS), list(self.describe(IntervalRow(lead, False)).sort)
        texts[PLACE["chain"]] = f"{label} ({count})"
        texts[PLACE["decision"]] = decision
        texts[PLACE["start"]] = str(start + first)
        texts[NAME] = name
        sort[PLACE["start"]] = sort[PLACE["time"]] = start
        state = tr("expanded") if group.unfolded else tr("collapsed")
        lines = [
            f"{j.interval.start + first}–{j.interval.stop + first}  "
            f"{label_of(j.interval, document.find_chain(j.interval.chain), listed=True)}  "
            f"{translate_core_sentence(j.interval.kind)}"
            for j in group.members[:_LISTED]
        ]
        return TableRow(
            texts=tuple(texts),
            sort=tuple(sort),
            colours={PLACE["decision"]: getattr(self.theme, str(one or Decision.UNDECIDED))},
            tips=("\n".join((about, *lines, *["…"] * (count > _LISTED))),),
            spoken={
                0: tr("group of {count}, {state}: {name}", count=count, state=state, name=name),
                PLACE["decision"]: decision.removeprefix(MARKS[one][:2]) if one else decision,
            },
            left=(NAME,),
            lead=label,
            below=(f"{name} ({count})", f"{short} ({count})"),
        )


class SortedRows(QSortFilterProxyModel):
    """The visible rows, sorted by a column or in the order of the model.

    The intervals of a group always follow the row of the group. Rows with equal values are in the
    order of the model.
    """

    def __init__(self, model: IntervalModel) -> None:
        super().__init__()
        self._model = model
        self.setSortRole(SORT_ROLE)
        self.setSourceModel(model)

    def filterAcceptsRow(self, row: int, parent: Index) -> bool:
        """Return True if a row is visible."""
        del parent
        return self._model.things[row].listed

    def lessThan(self, left: Index, right: Index) -> bool:
        """Return True if `left` comes before `right` in ascending order."""
        one, other = (self._model.things[index.row()] for index in (left, right))
        tops = [getattr(thing, "group", None) or thing for thing in (one, other)]
        if tops[0].id == tops[1].id and GroupRow not in (type(one), type(other)):
            tops = [one, other]
        values = [self._model.row_for(thing).sort[left.column()] for thing in tops]
        if values[0] != values[1]:
            return bool(values[0] < values[1])
        return (left.row() < right.row()) == (self.sortOrder() == Qt.SortOrder.AscendingOrder)


def verdict_text(judged: Judged) -> str:
    """Return the verdict on an interval as text, with a symbol such as ✓."""
    if judged.verdict == APPLIED:
        return tr("✓ automatic")
    return tr("✓ seen") if judged.verdict == SEEN else MARKS[judged.decision]


def limb_end_state_text(judged: Judged) -> str:
    """Return 'turned' if the error also rotated the next part of the body, or 'kept' if not.

    This part is the foot, hand or next joint. The result is '' if the kind of error has no such
    part.
    """
    if not judged.interval.kind.info.below:
        return ""
    return ENDS[judged.interval.carried]


def _tip(judged: Judged, shared: bool, chain: str, own: float | None) -> str:
    interval = judged.interval
    kind, joint = translate_core_sentence(interval.kind), interval.joint
    parts = [tr("{chain}, {kind}, {n} frames", chain=chain, kind=kind, n=interval.frames)]
    if tip := interval.kind.info.tip:
        size = f"{format_number(np.degrees(interval.size))}°"
        parts.append(translate_core_sentence(tip.format(joint=joint, size=size)))
    elif not interval.kind.known:
        parts.append(tr("found by a newer version of the program; not corrected"))
    elif abs(interval.residual) > 1e-9:
        left = format_signed_number(np.degrees(interval.residual), 2)
        parts.append(tr("an error of {angle}° remains after the interval", angle=left))
    if own != interval.confidence and own is not None and not judged.edited:
        line = tr(
            "confidence learned from your decisions (the detector's own value is {own:.2f})",
            own=own,
        )
        parts.append(line)
    if shared:
        parts.append(tr("overlaps another interval of its chain; their offsets add up"))
    if judged.reason:
        parts.append(tr("reason: {reason}", reason=translate_reject_reason(judged.reason)))
    if judged.edited:
        parts.append(tr("edited by hand"))
    if judged.by_hand:
        parts.append(tr("made by hand"))
    if not judged.supported:
        parts.append(tr("no longer found at this τ"))
    if judged.verdict == APPLIED:
        parts.append(tr("corrected automatically, not yet reviewed"))
    if judged.reviewer or judged.decided_at:
        by, at = judged.reviewer, judged.decided_at
        parts.append(tr("decision: {at} {reviewer}", at=at, reviewer=by).strip())
    return "\n".join(parts)
