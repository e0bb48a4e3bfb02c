"""The state of the teaching tab: the frame's quantities, what-if values, highlighted symbol.

What-if values are edits that the user makes to the displayed frame with sliders or the gizmo. They
change only the displayed pose, never the review.
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
from inspector.widgets.signed_numbers import format_signed_number
from twistcore.analysis.decomposition import (
    Decomposition,
    FrameCorrection,
    WhatIf,
    decompose,
    detect_and_correct_frame,
    frame_motion_with_user_changes,
)
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Judged
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton, forward_kinematics
from twistcore.skeleton.rotation import Array

_BLANK = "\u00a0"  # where no line is broken
_ALONG = 1e-6  # tolerance for parallel vectors, in the unit of the file


class FrameNumbers(NamedTuple):
    """The numbers in the teaching tab for a frame: the displayed pose and its correction."""

    frame: Decomposition
    correction: FrameCorrection
    own: bool = False  # the selected interval's offset is used instead of the running sum
    staged: bool = False  # the displayed pose is a stage of the animation

    @property
    def is_event(self) -> bool:
        """True if the displayed pose passes the paper's test for an event.

        The changes must have opposite signs, and the strength m must be at least τ.
        """
        d, tau = self.frame, self.correction.tau
        return not self.staged and d.strength_is_defined and d.strength >= tau > 0.0


class TaughtFrame(QObject):
    """The frame that the teaching tab explains, and how the tab displays it."""

    changed = Signal()  # the quantities have changed, or the tab was shown or hidden
    lit_changed = Signal()
    rows_changed = Signal()

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.document = document
        self.active = False
        self.what_if = WhatIf()
        self.lit = ""
        self.rows: frozenset[str] = frozenset()  # symbols whose rows are listed; empty for all
        self.stage: float | None = None  # None for the whole pose; see `set_stage`
        self._running: tuple[object, Array] | None = None
        self._known: tuple[object, ...] = ()
        self._numbers: FrameNumbers | None = None
        document.opened.connect(self._reset_all)
        document.chain_changed.connect(self._reset_all)
        document.frame_changed.connect(self._emit_changed)
        document.interval_changed.connect(self._emit_changed)
        document.intervals_changed.connect(self._emit_changed)

    # -- what views read ----------------------------------------------------------------------

    @property
    def chain(self) -> Chain | None:
        """The selected chain, or None if a limb is selected."""
        chain = selected_chain(self.document)
        return None if isinstance(chain, Limb) else chain

    @property
    def quantities(self) -> Decomposition | None:
        """The quantities of Eq. 1-13 for the displayed pose, or None if no chain is selected."""
        return None if (numbers := self.numbers) is None else numbers.frame

    @property
    def joints(self) -> dict[str, str]:
        """The names of parent, child and grandchild for display, keyed by 'P', 'C' and 'G'.

        If no chain is selected, the result is empty.
        """
        data, chain = self.document.data, self.chain
        if data is None or chain is None:
            return {}
        return {
            letter: escape_control_characters(n)
            for letter, n in joint_labels(data.motion.skeleton, chain).items()
        }

    @property
    def numbers(self) -> FrameNumbers | None:
        """All quantities of [Choi26 §3] for the frame, or None if no chain is selected."""
        data, chain, frame = self.document.data, self.chain, self.document.frame
        if data is None or chain is None:
            return None
        what_if, stage, tau, own = self.what_if, self.stage, self.tau, self._own_offset()
        key = (data.motion, chain, frame, what_if, stage, tau, own)
        if key != self._known:
            before = self._running_offset(frame - 1)
            found = detect_and_correct_frame(
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
        """The selected interval if it contains the current frame, or None.

        The result is also None if the user has edited the frame, or if the interval's offset is
        not a twist of the parent, as in a stretch.
        """
        judged, frame = self.document.interval, self.document.frame
        altered_too = replace(self.what_if, applied=0.0).changes
        if judged is None or altered_too or judged.interval.chain != self.document.chain:
            return None
        if not judged.interval.repairable:
            return None
        return judged if judged.interval.start <= frame < judged.interval.stop else None

    def _own_offset(self) -> float | None:
        """Return the offset of the selected interval at the current frame, in radians.

        Returns None if no interval that contains this frame is selected. The correction then uses
        the paper's running sum.
        """
        if (judged := self.interval) is None:
            return None
        return float(judged.interval.offset[self.document.frame - judged.interval.start])

    def _running_offset(self, frame: int) -> float:
        """Return the paper's offset(t) in radians: the running sum in the captured clip up to t."""
        assert self.document.data is not None
        signals = self.document.data.signals[self.document.chain]
        key = (signals, self.tau)
        if self._running is None or self._running[0] != key:
            self._running = key, paper_detector_running_offset(signals, self.tau)
        return float(self._running[1][frame]) if frame >= 0 else 0.0

    @property
    def tau(self) -> float:
        """The τ of the selected chain in the review, in radians, or 0 if no clip is open."""
        document = self.document
        return document.review.state.tau.get(document.chain, 0.0) if document.data else 0.0

    def pose(self) -> tuple[Array, Array] | None:
        """Return the edited pose: global rotations (joints, 4) and positions (joints, 3).

        Returns None if the pose is as captured.
        """
        data, chain = self.document.data, self.chain
        numbers = self.numbers if self.what_if.changes or self.stage is not None else None
        if data is None or chain is None or numbers is None:
            return None
        frame, off = self.document.frame, numbers.correction.whole
        one = frame_motion_with_user_changes(
            data.motion, chain, frame, self.what_if, offset=off, stage=self.stage
        )
        rotations, positions = forward_kinematics(one)
        return rotations[0], positions[0]

    # -- what a person does -------------------------------------------------------------------

    def set_active(self, on: bool) -> None:
        """Set whether the teaching tab is visible. If it is hidden, edits are not shown."""
        if on != self.active:
            self.active = on
            self.changed.emit()

    def set_what_if(self, what_if: WhatIf) -> None:
        """Set the what-if values of the displayed frame."""
        if what_if != self.what_if:
            self.what_if = what_if
            self._emit_changed()

    def alter(self, **change: Any) -> None:
        """Change the given what-if values. The other values stay the same."""
        self.set_what_if(replace(self.what_if, **change))

    def set_stage(self, stage: float | None) -> None:
        """Show a stage of the parent's rotation; None shows the whole pose.

        A stage from 0 to 1 is a share of the swing. A stage from 1 to 2 is the whole swing and a
        share of the twist. The joints below the parent follow.
        """
        if stage != self.stage:
            self.stage = stage
            self._emit_changed()

    def reset(self) -> None:
        """Discard all edits and show the frame as captured."""
        self.set_stage(None)
        self.set_what_if(WhatIf())

    def set_rows(self, symbols: Iterable[str]) -> None:
        """List only the equations of these symbols. If `symbols` is empty, list all equations."""
        rows = frozenset(symbols)
        if rows != self.rows:
            self.rows = rows
            self.rows_changed.emit()

    def highlight(self, symbol: str) -> None:
        """Highlight a symbol in all views, or stop highlighting it if it is highlighted already."""
        self.lit = "" if symbol == self.lit else symbol
        self.lit_changed.emit()

    def remove_highlight(self) -> None:
        """Stop highlighting a symbol."""
        if self.lit:
            self.highlight(self.lit)

    def _reset_all(self) -> None:
        self.what_if, self.stage = WhatIf(), None
        self._emit_changed()

    def _emit_changed(self, *_: object) -> None:
        if self.active:
            self.changed.emit()


def degree_text(angle: float) -> str:
    """Return an angle, given in radians, as text in degrees."""
    return f"{format_signed_number(np.degrees(angle), 2)}°"


def joint_labels(skeleton: Skeleton, chain: Chain) -> dict[str, str]:
    """Return the joint names of parent, child and grandchild, keyed by 'P', 'C' and 'G'."""
    names = skeleton.names
    names_shown = {"P": names[chain.parent], "C": names[chain.child]}
    if chain.grandchild >= 0:
        return names_shown | {"G": names[chain.grandchild]}
    arm, end = np.atleast_2d(chain.arm)[0], skeleton.end_offsets.get(chain.child)
    at_end = end is not None and float(np.linalg.norm(np.cross(arm, end))) < _ALONG
    return names_shown | {"G": tr("C's End Site") if at_end else tr("none (an axis of C)")}


def reliability_text(share: float) -> str:
    """Return the reliability of an angle, `share` (0…1), as a percentage for display."""
    percent = tr("under 1") if share < 0.01 else f"{100.0 * share:.0f}"
    return tr("{percent} % reliable", percent=percent)


def padded_vector_text(values: Array) -> str:
    """Return a vector or quaternion as text of constant length.

    A zero has no sign and is padded instead; without padding, the width of the tab would change
    from frame to frame.
    """
    return f"({', '.join(format_signed_number(v, 3).rjust(6, _BLANK) for v in values)})"
