"""What is being taught now: the frame's quantities, the what-if, the symbol that is lit.

Nothing here reaches the review: a what-if is a pose that is looked at, no command.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from inspector.session.document import Document
from inspector.viewport.frame_drawing import selected_chain
from inspector.widgets.signed_numbers import signed
from twistcore.chain import Chain
from twistcore.decomposition import Decomposition, WhatIf, altered, decompose
from twistcore.detection.paper import error_of, running_offset
from twistcore.limb import Limb
from twistcore.motion import forward_kinematics
from twistcore.review import Judged
from twistcore.rotation import Array


class TaughtFrame(QObject):
    """State of the teaching tab; it lasts while the tab is shown."""

    changed = Signal()  # the quantities: another frame, chain, clip or what-if; or shown, hidden
    lit_changed = Signal()

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.document = document
        self.active = False
        self.what_if = WhatIf()
        self.lit = ""
        self.stage: float | None = None  # None: the whole pose; else see `set_stage`
        self._running: tuple[object, Array] | None = None
        self._known: tuple[object, ...] = ()
        self._quantities: Decomposition | None = None
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
        """Eq. 1-13 at the frame, as captured or as altered; None without a chain."""
        data, chain, frame = self.document.data, self.chain, self.document.frame
        if data is None or chain is None:
            return None
        key = (data.motion, chain, frame, self.what_if, self.stage, self.offset)
        if key != self._known:
            self._known = key
            what_if = self.what_if if self.what_if.changes else None
            self._quantities = decompose(
                data.motion, chain, frame, what_if, offset=self.offset, stage=self.stage
            )
        return self._quantities

    @property
    def interval(self) -> Judged | None:
        """The selected interval, if it is this chain's and the frame, as captured, is in it."""
        judged, frame = self.document.interval, self.document.frame
        altered_too = replace(self.what_if, applied=0.0).changes
        if judged is None or altered_too or judged.interval.chain != self.document.chain:
            return None
        return judged if judged.interval.start <= frame < judged.interval.stop else None

    @property
    def offset(self) -> float:
        """What a share of is taken off, radians: `interval`'s, else the paper's running sum."""
        data, chain, frame = self.document.data, self.chain, self.document.frame
        if data is None or chain is None:
            return 0.0
        if (judged := self.interval) is not None:
            return float(judged.interval.offset[frame - judged.interval.start])
        return self._running_before(frame) + self._error(frame)

    def _running_before(self, frame: int) -> float:
        """offset(t−1) as the paper sums it up, with the review's τ."""
        assert self.document.data is not None
        signals = self.document.data.signals[self.document.chain]
        key = (signals, self.tau)
        if self._running is None or self._running[0] != key:
            self._running = key, running_offset(signals, self.tau)
        return float(self._running[1][frame - 1]) if frame else 0.0

    def _error(self, frame: int) -> float:
        """err(t) of the frame as altered, before anything is taken off."""
        data, chain = self.document.data, self.chain
        assert data is not None
        assert chain is not None
        d = decompose(data.motion, chain, frame, replace(self.what_if, applied=0.0))
        return float(error_of(d.dtheta_p, d.strength, self.tau))

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
        changes = self.what_if.changes or self.stage is not None
        if data is None or chain is None or not changes:
            return None
        one = altered(
            data.motion, chain, self.document.frame, self.what_if,
            offset=self.offset, stage=self.stage,
        )  # fmt: skip
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


def degrees(angle: float) -> str:
    """An angle in radians as every label of the tab shows it."""
    return f"{signed(np.degrees(angle), 2)}°"


def numbers(values: Array) -> str:
    """A vector or quaternion as every label of the tab shows it."""
    return f"({', '.join(signed(v, 3) for v in values)})"
