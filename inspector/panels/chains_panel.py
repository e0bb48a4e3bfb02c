"""The table of chains and limbs, with the number of intervals and the reliability of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QHeaderView, QLabel, QStackedWidget, QWidget

from inspector.language import tr, tr_as, translate_core_sentence
from inspector.panels.limb_words import limb_end_in_sentence
from inspector.panels.rig_names import chain_joint_names, joint_names_unlike_label
from inspector.session.document import Document
from inspector.session.examined import one_line_summary, reason_unexamined, unexamined_sentences
from inspector.widgets.building import action_button, hbox, hint, vbox
from inspector.widgets.labels import escape_tool_tip_text
from inspector.widgets.tables import (
    Index,
    RowDelegate,
    RowModel,
    RowTable,
    SecondaryTextDelegate,
    TableRow,
)
from inspector.widgets.theme import Colours
from twistcore.analysis.correction.twist_removal import children_off_axis
from twistcore.detection.limb_flips import BENT
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Decision
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb

_PEAK, _AZIMUTH = 2, 4  # columns
_HEADS = (
    tr("Chain"),
    tr_as("intervals", "Done"),
    tr_as("largest strength", "Peak"),
    "τ",
    tr_as("short for azimuth", "Azim."),
)
# Widest texts of the columns, without the first column
_SAMPLES = ("00/00", "180.0°", "55.0°", "100 %")
_TIPS = (
    tr(
        "Side and segment of the parent joint, then the joints' names in the file if they differ.\n"
        "The tick shows or hides the chain's intervals."
    ),
    tr("Intervals decided / intervals found"),
    tr("Largest strength in the clip; in the paper's method, the strength is the measure m"),
    tr("Threshold τ of this chain"),
    tr(
        "How reliable the azimuth is, as a median over all frames.\n"
        "The azimuth is the direction in which the bone points away from its parent's axis.\n"
        "While the limb is straight, the azimuth cannot be measured well, and the value is low.\n"
        "For a whole limb: how far the middle joint is from the line between the limb's ends,\n"
        "as a share of the limb's length."
    ),
)
_LIMB_TIPS = (
    tr("The whole limb. The tick shows or hides its flips."),
    tr("Flips decided / flips found"),
    tr(
        "Largest jump of the limb about the line from its first joint to its end, from one frame "
        "to the next"
    ),
    tr("Threshold τ of this limb: the smallest jump that is reported"),
    tr(
        "Median distance of the middle joint from the line between the limb's ends, as a share\n"
        "of the limb's length: low while the limb is straight"
    ),
)
_PAD = 8  # pixels
_TICK = 24  # pixels
_LONGEST = 200  # pixels: for a name up to this length, some columns are hidden
# The azimuth is unreliable below this ‖v⊥‖/‖v‖; v is the child's bone, v⊥ its part perpendicular to
# the parent's bone
_RELIABLE = 0.2


@dataclass(frozen=True)
class _Shown:
    """A row of the table: a chain or limb. Angles are in degrees."""

    chain: str
    label: str
    joints: str
    decided: int
    found: int
    peak: float
    tau: float
    reliability: float
    notes: tuple[str, ...]
    ticked: bool
    doubtful: bool
    tips: tuple[str, ...]


class _ChainModel(RowModel[_Shown]):
    heads, head_tips = _HEADS, _TIPS
    right = range(1, len(_HEADS))
    middle = (0,)

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__(colours)
        self._document = document

    def key(self, thing: _Shown) -> str:
        return thing.chain

    def describe(self, thing: _Shown) -> TableRow:
        done = thing.decided == thing.found
        inks = {} if thing.found else dict.fromkeys(range(len(_HEADS)), self.theme.soft)
        if thing.found:
            inks[1] = self.theme.accepted if done else self.theme.undecided
        if thing.doubtful:
            inks[_AZIMUTH] = self.theme.warning
        return TableRow(
            texts=(
                thing.label,
                f"{thing.decided}/{thing.found}" if thing.found else "–",
                f"{thing.peak:.1f}°" if np.isfinite(thing.peak) else "–",
                f"{thing.tau:.1f}°",
                f"{100 * thing.reliability:.0f} %",
            ),
            colours=inks,
            tips=tuple("\n".join((tip, *thing.notes)) for tip in thing.tips),
            tick=thing.ticked,
            secondary=thing.joints,
        )

    def flags(self, index: Index) -> Qt.ItemFlag:
        tick = Qt.ItemFlag.ItemIsUserCheckable if index.column() == 0 else Qt.ItemFlag.NoItemFlags
        return super().flags(index) | tick

    def setData(self, index: Index, value: Any, role: int = 0) -> bool:
        if role != Qt.ItemDataRole.CheckStateRole or not index.isValid():
            return False
        shown = Qt.CheckState(value) == Qt.CheckState.Checked
        self._document.set_hidden(self.things[index.row()].chain, not shown)
        return True


class ChainsPanel(QWidget):
    """The table of chains and limbs. The selected row is the document's selected chain.

    A line above the table summarises which limbs could not be examined. Next to it is a button for
    the action `joint_names`.
    """

    def __init__(self, document: Document, colours: Colours, joint_names: QAction) -> None:
        super().__init__()
        self._document = document
        self._model = _ChainModel(document, colours)
        self.table = RowTable(self._model)
        self.table.setAccessibleName(tr("Chains and limbs"))
        self.table.setItemDelegate(RowDelegate(self._model, self.table))
        self.table.setItemDelegateForColumn(0, SecondaryTextDelegate(self._model, self.table))
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        advance = self.fontMetrics().horizontalAdvance
        for column, sample in enumerate(_SAMPLES, start=1):
            width = max(advance(sample), advance(_HEADS[column])) + _PAD
            self.table.setColumnWidth(column, width)
        self.table.resized.connect(self._show_selected)
        self.table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._hint = hint(tr("Open a clip to see its chains here."))
        self._showing = False  # True while rows are being changed by the program
        self._fixed: dict[str, _Shown] = {}  # values that do not depend on τ, keyed by chain
        self._stack = QStackedWidget()
        self.unexamined = QLabel(wordWrap=True)
        self.unexamined.setObjectName("warning")
        self._notice, self._names = QWidget(), action_button(joint_names)
        hbox(
            (self.unexamined, 1),
            self._names,
            owner=self._notice,
            margins=(_PAD, _PAD, _PAD, _PAD),
        )
        self._notice.hide()
        self.people = QComboBox()
        self.people.setToolTip(tr("Person whose chains and intervals are listed"))
        self.people.setAccessibleName(tr("Person"))
        self.people.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.people.activated.connect(
            lambda _: self._document.show_person(self.people.currentData())
        )
        self.people.hide()
        parts = self.people, self._notice, (self._stack, 1)
        vbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=0)
        self._stack.addWidget(self._hint)
        self._stack.addWidget(self.table)
        self.table.selectionModel().currentRowChanged.connect(self._row_selected)
        document.opened.connect(self._reset)
        document.method_changed.connect(self._reset)
        document.chains_changed.connect(self._reset)
        document.hidden_changed.connect(self._refresh)
        document.intervals_changed.connect(self._refresh)
        document.chain_changed.connect(self._select_row)
        self._reset()

    def _refresh(self) -> None:
        data, document = self._document.data, self._document
        if data is None or not self._fixed:
            self._show(())
            return
        state = document.review.state
        own = [j for j in state.intervals if not j.interval.kind.info.whole_body]
        found = Counter(j.interval.chain for j in own)
        decided = Counter(j.interval.chain for j in own if j.decision != Decision.UNDECIDED)
        self._show(
            [
                replace(
                    self._fixed[c.name],
                    decided=decided[c.name],
                    found=found[c.name],
                    tau=float(np.degrees(state.tau[c.name])),
                    ticked=c.name not in document.hidden,
                )
                for c in document.listed_chains
            ]
        )

    def _show(self, rows: Sequence[_Shown]) -> None:
        self._showing = True
        try:
            self._model.show(rows)
        finally:
            self._showing = False

    def _reset(self) -> None:
        data = self._document.data
        chains = data.chains_and_limbs if data else ()
        self._fixed = {c.name: _of_clip(self._document, c) for c in chains}
        self._keep_room_for_names()
        self._refresh()
        self._stack.setCurrentIndex(1 if self._model.rowCount() else 0)
        if self._document.data and not self._model.rowCount():
            self._hint.setText(reason_unexamined(self._document.data))
        self._list_people()
        self._show_unexamined()
        self._select_row()

    def _keep_room_for_names(self) -> None:
        """Hide columns if the names of the chains would not fit."""
        advance = self.fontMetrics().horizontalAdvance
        longest = max((advance(shown.label) for shown in self._fixed.values()), default=0)
        self.table.keep_room(min(longest, _LONGEST) + _TICK + _PAD, (_AZIMUTH, _PEAK))

    def _list_people(self) -> None:
        """Fill the list of people, and show it if the clip has several people."""
        data = self._document.data
        people = data.analysis.people if data else ()
        self.people.clear()
        self.people.addItem(tr("Everyone"), "")
        for person in people:
            self.people.addItem(escape_control_characters(person), person)
        self.people.setCurrentIndex(max(self.people.findData(self._document.person), 0))
        self.people.setVisible(bool(people))

    def _show_unexamined(self) -> None:
        """Show the first limb that could not be examined, and the number of other such limbs."""
        sentences = unexamined_sentences(self._document.data)
        self.unexamined.setText(one_line_summary(sentences))
        self.unexamined.setToolTip(
            escape_tool_tip_text("\n".join(sentences)) if len(sentences) > 1 else ""
        )
        self._notice.setVisible(bool(sentences))
        data = self._document.data  # the button helps only if chains are missing
        self._names.setVisible(bool(data and not (data.chains and data.analysis.not_examined)))

    def _select_row(self) -> None:
        if (row := self._model.row_of(self._document.chain)) is not None:
            self.table.setCurrentIndex(self._model.index(row, 0))

    def _show_selected(self) -> None:
        """Scroll to the selected chain. Called when the height of the table changes."""
        self.table.scrollTo(self.table.currentIndex())

    def _row_selected(self, current: QModelIndex) -> None:
        if self._document.data and current.isValid() and not self._showing:
            self._document.select_chain(self._model.things[current.row()].chain)


def _peak(document: Document, chain: Chain) -> float:
    return float(np.degrees(document.detector.strength(chain.name).max()))


def _of_clip(document: Document, chain: Chain) -> _Shown:
    data = document.data
    assert data is not None
    partly = uncorrectable_joints(data.motion, chain)
    stuck = uncorrectable_joints(data.motion, chain, carried=True)
    flips, skeleton = data.limb(chain.name), data.motion.skeleton
    off_axis = {} if flips else children_off_axis(data.motion, chain)
    notes = [translate_core_sentence(warning) for warning in chain.warnings]
    if stuck:
        note = tr(
            "This chain cannot be corrected, because some of its joints have fewer than "
            "three rotation channels: {joints}.",
            joints=_listed(stuck),
        )
        notes.append(note)
    elif partly and isinstance(chain, Limb):
        note = tr(
            "Flips that did not turn the {end} cannot be corrected, because some joints have "
            "fewer than three rotation channels: {joints}.",
            end=limb_end_in_sentence(chain.end_word),
            joints=_listed(partly),
        )
        notes.append(note)
    if off_axis:
        note = tr(
            "A correction also moves {joints}, because these joints are not on the bone's axis.",
            joints=_listed(off_axis),
        )
        notes.append(note)
    if flips is None:
        tips = _TIPS
        reliability, least = data.analysis.reliability[chain.name], _RELIABLE
    else:
        tips, reliability, least = _LIMB_TIPS, float(np.median(flips.swivel.height)), BENT
    label, joints = (
        translate_core_sentence(chain.list_label),
        joint_names_unlike_label(chain, skeleton),
    )
    if isinstance(chain, Helper):
        label, joints = translate_core_sentence(chain.label), tr("twist bone")
    if stuck:
        label = tr("{chain} (locked)", chain=label)
    in_file = chain_joint_names(chain, skeleton)
    about = in_file if in_file == label else f"{label} ({in_file})"
    return _Shown(
        chain=chain.name,
        label=label,
        joints=joints,
        decided=0,
        found=0,
        peak=np.nan if data.blind else _peak(document, chain),
        tau=0.0,
        reliability=reliability,
        notes=tuple(notes),
        ticked=True,
        doubtful=reliability < least,
        tips=tuple(f"{about}: {tip}" for tip in tips),
    )


def _listed(joints: Iterable[str]) -> str:
    return ", ".join(joints)
