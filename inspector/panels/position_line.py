"""The labels in the status bar: one for the frame and the interval, and one for the chain."""

from __future__ import annotations

import numpy as np

from inspector.language import tr, translate_core_sentence
from inspector.panels.rig_names import chain_joint_names, joint_names_unlike_label
from inspector.session.document import Document
from inspector.widgets.labels import ElidedLine, SteadyLabel, escape_tool_tip_text
from inspector.widgets.signed_numbers import format_signed_number

_LONGEST_JOINTS = 26  # maximum number of letters; the tool tip shows the rest


class FrameLine(ElidedLine):
    """A label with the frame, the time and the selected interval.

    The status bar shows temporary messages in its place.
    """

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document
        for signal in (
            document.opened,
            document.intervals_changed,
            document.interval_changed,
            document.frame_changed,
            document.numbering_changed,
        ):
            signal.connect(self._show_frame)

    def _show_frame(self, *_: object) -> None:
        document = self._document
        data, first = document.data, document.first_frame
        if data is None:
            self.set_text("")
            return
        last = document.frames - 1 + first
        seconds = document.frame * data.motion.frame_time
        text = tr("frame {frame} of {last}", frame=document.frame + first, last=last)
        text += f"   {seconds:.3f} s"
        if judged := document.interval:
            selected = tr(
                "interval {start} to {stop}, {decision}",
                start=judged.interval.start + first,
                stop=judged.interval.stop + first,
                decision=translate_core_sentence(judged.decision.value),
            )
            text += f"   {selected}"
        self.set_text(text)


class PositionLine(SteadyLabel):
    """A label with the selected chain and its angle, strength and offset at the playhead."""

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document
        for signal in (
            document.opened,
            document.intervals_changed,
            document.frame_changed,
            document.chain_changed,
        ):
            signal.connect(self._show_position)

    def _show_position(self, *_: object) -> None:
        document = self._document
        data = document.data
        if data is None or not document.chain:
            self.setText("")
            return
        frame, limb, chain = document.frame, document.limb, document.chain
        size = data.signals[chain].strength if limb is None else np.abs(limb.departures)
        names = ("θp", "m") if limb is None else ("φ", "Δφ")
        angles = data.angle(chain)[frame], document.offset(chain)[frame]
        angle, off = (f"{format_signed_number(np.degrees(a)):>7}°" for a in angles)
        found, skeleton = document.find_chain(chain), data.motion.skeleton
        own = joint_names_unlike_label(found, skeleton)
        if len(own) > _LONGEST_JOINTS:
            own = f"{own[: _LONGEST_JOINTS - 1]}…"
        label = translate_core_sentence(found.label)
        label = f"{label} ({own})" if own else label
        self.setToolTip(escape_tool_tip_text(chain_joint_names(found, skeleton)))
        strength = f"{np.degrees(size[frame]):6.2f}°"
        taken = tr("offset {angle}", angle=off)
        self.setText(f"{label}   {names[0]} {angle}   {names[1]} {strength}   {taken}")
