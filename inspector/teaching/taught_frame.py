"""What is being taught now: the frame's quantities, the what-if, the symbol that is lit.

Nothing here reaches the review: a what-if is a pose that is looked at, no command.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.language import tr
from inspector.session.document import Document
from inspector.viewport.frame_drawing import selected_chain
from inspector.widgets.signed_numbers import signed
from twistcore.analysis.decomposition import (
    Decomposition,
    FrameCorrection,
    WhatIf,
    altered,
    correct_frame,
    decompose,
)
from twistcore.detection.paper import running_offset
from twistcore.files.encoding import legible
from twistcore.review import Judged
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton, forward_kinematics
from twistcore.skeleton.rotation import Array

_ALONG = 1e-6  # how far off a line two vectors are one direction, in the file's unit


class FrameNumbers(NamedTuple):
    """What the tab shows of a frame: the pose that is seen, and what is taken off for it."""

    frame: Decomposition
    correction: FrameCorrection
    own: bool = False  # the selected interval's own offset is taken off, no running sum
    staged: bool = False  # the pose that is seen is on its way

    @property
    def is_event(self) -> bool:
        """Whether the pose that is seen passes the paper's test: opposed, and m ≥ τ."""
        d, tau = self.frame, self.correction.tau
        return not self.staged and d.strength_is_defined and d.strength >= tau > 0.0


class TaughtFrame(QObject):
    """State of the teaching tab; it lasts while the tab is shown."""

    changed = Signal()  # the quantities: another frame, chain, clip or what-if; or shown, hidden
    lit_changed = Signal()
    rows_changed = Signal()

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.document = document
        self.active = False
        self.what_if = WhatIf()
        self.lit = ""
        self.rows: frozenset[str] = frozenset()  # symbols that are listed; none: all
        self.stage: float | None = None  # None: the whole pose; else see `set_stage`
        self._running: tuple[object, Array] | None = None
        self._known: tuple[object, ...] = ()
        self._numbers: FrameNumbers | None = None
        document.opened.connect(self._afresh)
        document.chain_changed.connect(self._afresh)
        document.frame_changed.connect(self._tell)
        document.interval_changed.connect(self._tell)
        document.intervals_changed.connect(self._tell)

    # -- what views read ----------------------------------------------------------------------

    @property
    def chain(self) -> Chain | None:
        """The chain that is taught, the selected one; none while a limb is selected."""
        chain = selected_chain(self.document)
        return None if isinstance(chain, Limb) else chain

    @property
    def quantities(self) -> Decomposition | None:
        """Eq. 1-13 of the pose that is seen: altered, corrected, at a stage; None: no chain."""
        return None if (numbers := self.numbers) is None else numbers.frame

    @property
    def joints(self) -> dict[str, str]:
        """What P, C and G are called in the file, to be shown; empty without a chain."""
        data, chain = self.document.data, self.chain
        if data is None or chain is None:
            return {}
        return {
            letter: legible(n) for letter, n in joint_labels(data.motion.skeleton, chain).items()
        }

    @property
    def numbers(self) -> FrameNumbers | None:
        """All of section 3 at the frame; None without a chain."""
        data, chain, frame = self.document.data, self.chain, self.document.frame
        if data is None or chain is None:
            return None
        what_if, stage, tau, own = self.what_if, self.stage, self.tau, self._own_offset()
        key = (data.motion, chain, frame, what_if, stage, tau, own)
        if key != self._known:
            before = self._running_offset(frame - 1)
            found = correct_frame(
                data.motion, chain, frame, what_if, tau=tau, offset_before=before, own=own
            )
            shown = found.before
            if what_if.applied or stage is not None:
                off = found.whole
                shown = decompose(data.motion, chain, frame, what_if, offset=off, stage=stage)
            self._known = key
            self._numbers = FrameNumbers(shown, found, own is not None, stage is not None)
        return self._numbers

    @property
    def interval(self) -> Judged | None:
        """The selected interval, if it is this chain's and the frame, as captured, is in it."""
        judged, frame = self.document.interval, self.document.frame
        altered_too = replace(self.what_if, applied=0.0).changes
        if judged is None or altered_too or judged.interval.chain != self.document.chain:
            return None
        return judged if judged.interval.start <= frame < judged.interval.stop else None

    def _own_offset(self) -> float | None:
        """That of `interval`, radians; without one the paper's running sum is taken off."""
        if (judged := self.interval) is None:
            return None
        return float(judged.interval.offset[self.document.frame - judged.interval.start])

    def _running_offset(self, frame: int) -> float:
        """offset(t) of the captured clip as the paper sums it up, with the review's τ."""
        assert self.document.data is not None
        signals = self.document.data.signals[self.document.chain]
        key = (signals, self.tau)
        if self._running is None or self._running[0] != key:
            self._running = key, running_offset(signals, self.tau)
        return float(self._running[1][frame]) if frame >= 0 else 0.0

    @property
    def tau(self) -> float:
        """The review's τ of the chain, radians; 0 without one."""
        document = self.document
        return document.review.state.tau.get(document.chain, 0.0) if document.data else 0.0

    def pose(self) -> tuple[Array, Array] | None:
        """Global rotations (joints, 4) and positions (joints, 3) of the what-if, if there is one.

        Without position channels of its own the root's place is the captured one.
        """
        data, chain = self.document.data, self.chain
        numbers = self.numbers if self.what_if.changes or self.stage is not None else None
        if data is None or chain is None or numbers is None:
            return None
        frame, off = self.document.frame, numbers.correction.whole
        one = altered(data.motion, chain, frame, self.what_if, offset=off, stage=self.stage)
        rotations, positions = forward_kinematics(one)
        return rotations[0], positions[0]

    # -- what a person does -------------------------------------------------------------------

    def set_active(self, on: bool) -> None:
        """The tab is shown or hidden; hidden, the clip is seen as it is."""
        if on != self.active:
            self.active = on
            self.changed.emit()

    def set_what_if(self, what_if: WhatIf) -> None:
        """Alter the frame."""
        if what_if != self.what_if:
            self.what_if = what_if
            self._tell()

    def alter(self, **change: Any) -> None:
        """Alter the frame in this too: fields of WhatIf."""
        self.set_what_if(replace(self.what_if, **change))

    def set_stage(self, stage: float | None) -> None:
        """Show P's rotation on its way: 0…1 so much of the swing, 1…2 so much of the twist too.

        The children are carried; None: the whole pose.
        """
        if stage != self.stage:
            self.stage = stage
            self._tell()

    def reset(self) -> None:
        """As captured, whole."""
        self.set_stage(None)
        self.set_what_if(WhatIf())

    def set_rows(self, symbols: Iterable[str]) -> None:
        """List the rows of these symbols only; none: all."""
        rows = frozenset(symbols)
        if rows != self.rows:
            self.rows = rows
            self.rows_changed.emit()

    def light(self, symbol: str) -> None:
        """Light a symbol up everywhere; the lit one again: none."""
        self.lit = "" if symbol == self.lit else symbol
        self.lit_changed.emit()

    def unlight(self) -> None:
        """No symbol is lit."""
        if self.lit:
            self.light(self.lit)

    def _afresh(self) -> None:
        self.what_if, self.stage = WhatIf(), None
        self._tell()

    def _tell(self, *_: object) -> None:
        if self.active:
            self.changed.emit()


def degree_text(angle: float) -> str:
    """An angle in radians as every label of the tab shows it."""
    return f"{signed(np.degrees(angle), 2)}°"


def joint_labels(skeleton: Skeleton, chain: Chain) -> dict[str, str]:
    """What P, C and G are called in the file."""
    names = skeleton.names
    told = {"P": names[chain.parent], "C": names[chain.child]}
    if chain.grandchild >= 0:
        return told | {"G": names[chain.grandchild]}
    arm, end = np.atleast_2d(chain.arm)[0], skeleton.end_offsets.get(chain.child)
    at_end = end is not None and float(np.linalg.norm(np.cross(arm, end))) < _ALONG
    return told | {"G": tr("its End Site") if at_end else tr("none (an axis of C)")}


def reliable(share: float) -> str:
    """How far an angle near its singularity is to be trusted."""
    percent = tr("under 1") if share < 0.01 else f"{100.0 * share:.0f}"
    return tr("{percent} % reliable", percent=percent)


def numbers(values: Array) -> str:
    """A vector or quaternion as every label of the tab shows it."""
    return f"({', '.join(signed(v, 3) for v in values)})"
