"""The details of the selected interval: its error, its exact numbers, and the decision."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QBoxLayout,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QWidget,
)

from inspector.language import plural, tr, tr_as, translate_core_sentence
from inspector.panels.end_choice import EndChoice
from inspector.panels.limb_words import middle_joint_word, next_part, part_of_body
from inspector.panels.protected_words import protected_measures_table, worsened_measures_sentence
from inspector.panels.reject_reasons import (
    REASONS,
    reject_reason_in_english,
    translate_reject_reason,
)
from inspector.panels.rig_names import joints_of_error, label_of
from inspector.session.document import Document
from inspector.session.examined import reason_unexamined
from inspector.session.why_here import reason_near, reason_sentence
from inspector.widgets.building import hbox, vbox
from inspector.widgets.labels import Caption, Headline, bold, capitalised, escape_tool_tip_text
from inspector.widgets.later import Burst
from inspector.widgets.signed_numbers import SignedBox, format_number, format_signed_number
from twistcore.analysis.clip_analysis import BODY_STEP_DOUBT, RESTLESS_DOUBT
from twistcore.analysis.correction.protected_measures import (
    Hinges,
    ProtectedMeasure,
    protected_measures,
)
from twistcore.analysis.why_not import Why
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import resized_interval, with_offset_of_size
from twistcore.detection.soft_onset import describe_soft_onset
from twistcore.review import Annotate, Decision, Judged
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb

# Log odds; above these, the limb is at most half as often on this side, or hardly ever
_RARE, _RARER = 0.7, 3.0
_UNBOUND = 16_777_215  # Qt's maximum size in pixels
_ARROWS = 28  # pixels of a number field for its arrows and borders
_FINE = 10.0  # degrees: smaller angles are shown with a decimal
_LEAST = 0.05  # degrees: smaller offsets are not shown
_NEXT = tr("Press N to go to the next interval.")
_OPEN = tr("Open a clip, then press N to go through its intervals.")
_SMOOTH = tr("Track this burst")
_DOUBTED = {BODY_STEP_DOUBT, RESTLESS_DOUBT}  # reasons why an interval of any kind may be open
_NOT_CORRECTED = tr("There is no correction for this detection. Accept it to mark it as seen.")
_MAY_INSERT = tr(
    "There is no correction for this detection. Accept it to mark it as seen, or press Insert if "
    "the joint is rotated wrongly from here on, or up to here."
)
_EDITED = tr_as("an interval", "edited")
_OTHER_SIDE = tr("the error may lie in the frames around the interval instead")


class DetailCard(QWidget):
    """A panel with the details of the selected interval.

    It contains an explanation, fields for the frames, the offset and a note, and buttons for the
    decision.
    """

    judged = Signal(object)  # with the Decision
    quality_asked = Signal(object)  # with an Interval, a capture fault, to show in the quality tab
    end_turned = Signal()  # the user switched between 'kept' and 'carried along'

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document
        self._shown: int | None = None  # id of the interval whose note is shown
        self._burst = Burst(document.begin_drag, self)
        self.title = Headline()
        self.start, self.stop = QSpinBox(), QSpinBox()
        self.delta = SignedBox(minimum=-180.0, maximum=180.0, decimals=2, suffix="°")
        self._boxes = (self.start, self.stop, self.delta)
        for box in self._boxes:
            box.setKeyboardTracking(False)
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            most = "−180.00°" if box is self.delta else "00000"
            box.setMinimumWidth(box.fontMetrics().horizontalAdvance(most) + _ARROWS)
        for box, name in (
            (self.start, tr("First frame of the interval")),
            (self.stop, tr("First frame after the interval")),
            (self.delta, tr("Offset δ, degrees")),
        ):
            box.setAccessibleName(name)
        self.note = QLineEdit(placeholderText=tr("Note"))
        self.note.setAccessibleName(tr("Note"))
        self.reason = QComboBox(editable=True, insertPolicy=QComboBox.InsertPolicy.NoInsert)
        self.reason.addItems(["", *map(translate_reject_reason, REASONS)])
        self.reason.setToolTip(tr("Reason for the rejection"))
        self.reason.setAccessibleName(tr("Reason for the rejection"))
        line = self.reason.lineEdit()
        assert line is not None
        line.setPlaceholderText(tr("Reason"))
        line.setAccessibleName(tr("Reason for the rejection"))
        self.why = Caption(soft=True)
        self.end = EndChoice()
        self.end.turned.connect(self.end_turned)
        self.to_quality = QPushButton(_SMOOTH)
        self.to_quality.clicked.connect(self._ask_quality)
        self._link = QWidget()  # takes no space while it is hidden
        hbox(self.to_quality, None, owner=self._link, margins=(0, 0, 0, 0))
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        self._form = form
        to = tr_as("between two numbers", "to")
        edges = hbox((self.start, 1), to, (self.stop, 1), "δ", (self.delta, 1))
        form.addRow(tr("Frames"), edges)
        form.addRow(tr("Notes"), hbox((self.reason, 2), (self.note, 3)))
        buttons = QHBoxLayout()
        self.buttons: dict[Decision, QPushButton] = {}
        self._words: dict[Decision, str] = {}
        for decision, text, key in (
            (Decision.ACCEPTED, tr_as("the interval", "Accept"), "A"),
            (Decision.REJECTED, tr_as("the interval", "Reject"), "R"),
            (Decision.UNDECIDED, tr_as("the interval", "Reset"), tr_as("key", "Backspace")),
        ):
            button = QPushButton(text)
            button.setToolTip(f"{text} ({key})")
            self._words[decision] = text
            button.clicked.connect(lambda _=False, d=decision: self.judged.emit(d))
            buttons.addWidget(button)
            self.buttons[decision] = button
        self.several = Caption()
        self.several.hide()
        self._head = head = hbox((self.title, 1), self.end)
        head.addStrut(self.end.sizeHint().height())  # so that the rows below do not move
        self._text = vbox((self.why, 1), self._link)
        vbox(self.several, head, self._text, form, buttons, owner=self)
        self.set_low(False)
        self.start.valueChanged.connect(self._edges_edited)
        self.stop.valueChanged.connect(self._edges_edited)
        self.delta.valueChanged.connect(self._delta_edited)
        self.note.editingFinished.connect(self.commit)
        line.editingFinished.connect(self.commit)
        self.reason.activated.connect(self.commit)
        document.numbering_changed.connect(self._refresh)
        document.confidence_changed.connect(self._refresh)
        document.leaving.connect(self.commit)
        document.opened.connect(self._take_clip)
        document.opener.began.connect(lambda _: self.setEnabled(False))
        document.opener.over.connect(lambda: self.setEnabled(True))
        document.intervals_changed.connect(self._refresh)
        document.interval_changed.connect(self._refresh)
        for changed in (document.frame_changed, document.chain_changed, document.method_changed):
            changed.connect(self._show_reason)
        self._refresh()

    def set_low(self, low: bool) -> None:
        """Set whether to use the layout for windows of low height.

        In this layout, gaps are smaller. The explanation is a single line and has the full text in
        its tool tip.
        """
        layout = self.layout()
        assert layout is not None
        self._low = low
        layout.setContentsMargins(*((8, 2, 8, 3) if low else (8, 6, 8, 8)))
        layout.setSpacing(3 if low else -1)  # -1 stands for the style's default
        self._form.setVerticalSpacing(3 if low else -1)
        self.why.set_short(low)
        directions = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._text.setDirection(directions[0 if low else 1])
        line = self.fontMetrics().height() + 4 if low else _UNBOUND
        self.to_quality.setMaximumHeight(line)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the title and the buttons for the limb's end for the new width."""
        super().resizeEvent(event)
        self._arrange_head()

    def _arrange_head(self) -> None:
        """Show the buttons for the limb's end below the title if the title would not fit.

        In a low window, they are always next to the title.
        """
        margins = self.contentsMargins() + self._head.contentsMargins()
        layout = self.layout()
        assert layout is not None
        margins += layout.contentsMargins()
        room = self.width() - margins.left() - margins.right() - self._head.spacing()
        fits = self.title.least_width + self.end.sizeHint().width() <= room
        in_one_row = self._low or self.end.isHidden() or fits
        directions = QBoxLayout.Direction.TopToBottom, QBoxLayout.Direction.LeftToRight
        self._head.setDirection(directions[in_one_row])

    def show_selected(self, ids: Sequence[int]) -> None:
        """Show how many intervals a decision applies to, if there are several.

        If some of the corrections would have harmful side effects, show how many.
        """
        number = len(ids)
        for decision, button in self.buttons.items():
            many = f" ({number})" if number > 1 else ""
            button.setText(f"{self._words[decision]}{many}")
        self.several.setVisible(number > 1)
        if number < 2:
            return
        sentences = [tr("{n} intervals are selected. A decision applies to all of them.", n=number)]
        selected = set(ids)
        intervals = (j.interval for j in self._document.intervals if j.id in selected)
        doubtful = (i.evidence or {} for i in intervals if i.open)
        if worse := sum(bool(evidence.get("worse")) for evidence in doubtful):
            sentences.append(
                plural(
                    "{n} of these corrections has a side effect that makes the motion worse. "
                    "Look at that interval separately.",
                    "{n} of these corrections have side effects that make the motion worse. "
                    "Look at those intervals separately.",
                    worse,
                )
            )
        self.several.set_plain(" ".join(sentences))

    def _take_clip(self) -> None:
        """Show a new clip. A note that was typed for the previous clip has already been stored."""
        self._shown = None
        self._show_note(None)
        self._refresh()

    def _refresh(self) -> None:
        judged = self._document.interval
        if self._shown != (judged.id if judged else None):
            self.commit()
            self._shown = judged.id if judged else None
            self._show_note(judged)
        kind = judged.interval.kind if judged else None
        self._offer_quality(kind)
        for widget in (self.note, self.reason, *self.buttons.values()):
            widget.setEnabled(kind is not None)
        for box in self._boxes:
            box.setEnabled(kind is not None and kind.correctable)
        angle = kind is not None and kind.by_angle
        below = kind is not None and kind.info.below
        self.delta.setEnabled(angle)
        self.end.setVisible(below)
        for box in self._boxes:  # without an interval, the fields are empty
            box.setSpecialValueText("" if judged else " ")
        if kind is not None and kind.of_capture and not angle:
            self.delta.setSpecialValueText(" ")
        if judged is None:
            with QSignalBlocker(self.start), QSignalBlocker(self.stop), QSignalBlocker(self.delta):
                self.start.setValue(self.start.minimum())
                self.stop.setValue(self.stop.minimum())
                self.delta.setValue(self.delta.minimum())
            self.why.setToolTip("")
            self.title.setToolTip("")
            self._show_reason()
            self._arrange_head()
            return
        interval = judged.interval
        chain = self._document.find_chain(interval.chain)
        what = "" if kind == Kind.COUNTER_TWIST else f" · {translate_core_sentence(interval.kind)}"
        what += f" · {_EDITED}" if judged.edited else ""
        label = label_of(interval, chain)
        varies = "" if np.ptp(interval.offset) < 1e-9 else tr(", varying δ")
        if interval.soft_ended:
            varies += tr(
                ", up to {offset}°", offset=format_signed_number(np.degrees(interval.shown))
            )
        count = plural("{n} frame", "{n} frames", interval.frames)
        assert self._document.data is not None
        joints = joints_of_error(interval, chain, self._document.data.motion.skeleton)
        self.title.setToolTip(
            escape_tool_tip_text(f"{label}{what} · {count}{varies}\n{joints}".rstrip())
        )
        forms = (f" · {count}{varies}", f" · {count}", "")
        self.title.set_forms(*(f"{bold(label)}{what}{rest}" for rest in forms))
        first = self._document.first_frame
        measures = self._measures(judged)
        figures = filter(None, (_figures(judged, chain), protected_measures_table(measures)))
        self.why.setToolTip(escape_tool_tip_text("\n".join(figures)))
        shown, begun = self._document.displayed(judged), self._ended_at(interval)
        sentences = explanation(shown, chain, first, measures, begun)
        blind = self._document.data.blind  # an exercise must not reveal its errors
        self.why.set_plain("" if blind else sentences)
        if below:
            word = chain.end_word if isinstance(chain, Limb) else "next joint"
            self.end.show_end(word, interval.carried)
        self._arrange_head()
        with QSignalBlocker(self.start), QSignalBlocker(self.stop), QSignalBlocker(self.delta):
            self.start.setRange(first, interval.stop - 1 + first)
            self.stop.setRange(interval.start + 1 + first, self._document.frames + first)
            self.start.setValue(interval.start + first)
            self.stop.setValue(interval.stop + first)
            none = interval.kind.of_capture and not angle
            self.delta.setValue(self.delta.minimum() if none else float(np.degrees(interval.shown)))
        if not self.note.hasFocus() and not self.reason.hasFocus():
            self._show_note(judged)

    def _offer_quality(self, kind: Kind | None) -> None:
        """Show the button that leads to the quality tab if `kind` is a capture fault."""
        fault = kind is not None and kind.of_capture
        self._link.setVisible(fault)
        if kind == Kind.NOISE_BURST:
            self.to_quality.setText(_SMOOTH)
            self.to_quality.setToolTip(
                tr("Smooth the noisy joints in these frames only (can be undone)")
            )
        elif fault:
            self.to_quality.setText(tr("Show the joint in Quality"))
            self.to_quality.setToolTip(tr("Open the table of joints with this joint selected"))

    def _ask_quality(self) -> None:
        if judged := self._document.interval:
            self.quality_asked.emit(self._document.displayed(judged).interval)

    def _ended_at(self, jump: Interval) -> Interval | None:
        """Return the stretch of the same joint that begins or ends at a lone jump, or None.

        A stretch is an interval in which the joint stays rotated about its own bone.
        """
        stretches = (j.interval for j in self._document.intervals if j.interval.kind.info.turns)
        return next(
            (
                i
                for i in stretches
                if i.joint == jump.joint and jump.start in (i.start, i.stop) and i is not jump
            ),
            None,
        )

    def _measures(self, judged: Judged) -> tuple[ProtectedMeasure, ...]:
        """Return the side effects of a correction, with all other corrections also applied."""
        document = self._document
        assert document.data is not None
        if document.data.blind:
            return ()  # an exercise must not reveal its errors
        motion, state = document.data.motion, document.review.state
        hinges = Hinges(motion, [j.interval for j in state.intervals if j.interval.repairable])
        return protected_measures(
            motion,
            document.data.chains_and_limbs,
            judged.interval,
            hinges,
            state.chosen(undecided=True),
        )

    def _show_reason(self) -> None:
        """If no interval is selected, explain why a peak near the playhead is not an interval."""
        document = self._document
        if document.interval is not None:
            return
        reason = reason_near(document, document.frame)
        outside = reason is not None and reason.why != Why.INTERVAL
        question, none = tr("Why is nothing found here?"), tr("No interval selected")
        self.title.set_forms(question if outside else none)
        nothing = _NEXT if document.data is not None else _OPEN
        if not document.intervals:
            nothing = reason_unexamined(document.data) or nothing
        text = reason_sentence(document, reason) if reason else nothing
        self.why.set_plain(text)

    def says(self, text: str) -> bool:
        """Return True if the panel is visible and its explanation is this text."""
        return self.why.says(text) and not self.visibleRegion().isEmpty()

    def focus_field(self, what: str) -> bool:
        """Move the focus to the field 'start', 'stop', 'delta' or 'note'.

        Returns False if the field is disabled.
        """
        box: QWidget = getattr(self, what)
        if not box.isEnabled():
            return False
        box.setFocus(Qt.FocusReason.ShortcutFocusReason)
        if isinstance(box, QLineEdit | QAbstractSpinBox):
            box.selectAll()
        return True

    def _show_note(self, judged: Judged | None) -> None:
        self.note.setText(judged.note if judged else "")
        self.reason.setCurrentText(translate_reject_reason(judged.reason) if judged else "")

    def _edges_edited(self) -> None:
        if judged := self._document.interval:
            first = self._document.first_frame
            start, stop = self.start.value() - first, self.stop.value() - first
            edited = resized_interval(judged.interval, start, stop)
            self._document.edit(judged.id, edited, self._burst.drag())
            if not start <= self._document.frame < stop:  # go to a frame of the interval
                self._document.go_to(start)

    def _delta_edited(self, degrees: float) -> None:
        if judged := self._document.interval:
            edited = with_offset_of_size(judged.interval, float(np.radians(degrees)))
            self._document.edit(judged.id, edited, self._burst.drag())

    def commit(self) -> None:
        """Store the note and the reason that the user has typed for the displayed interval."""
        shown = (j for j in self._document.intervals if j.id == self._shown)
        judged = next(shown, None)
        note, reason = self.note.text(), reject_reason_in_english(self.reason.currentText().strip())
        if judged and note == judged.note[: self.note.maxLength()]:
            note = judged.note  # the field shows only the beginning of the note
        if judged and reason == judged.reason.strip():
            reason = judged.reason  # the reason is unchanged
        if judged and (note, reason) != (judged.note, judged.reason):
            self._document.do(Annotate(judged.id, note, reason))


def explanation(
    judged: Judged,
    chain: Chain,
    first_frame: int,
    measures: Sequence[ProtectedMeasure] = (),
    stretch: Interval | None = None,
) -> str:
    """Return the text that explains why an interval is listed.

    The text describes the error, the side effects of the correction, and the numbers. `measures`
    contains the protected measures before and after the correction. `stretch` is the interval that
    begins or ends at a lone jump, or None.
    """
    interval = judged.interval
    evidence = interval.evidence or {}
    if not interval.kind.known:
        return tr(
            "This interval was detected by a newer version of the program. Your version can "
            "show the interval but not correct it."
        )
    if (judged.by_hand or judged.edited) and not interval.kind.info.repairer:
        made = tr("Made by hand.") if judged.by_hand else tr("Edited by hand.")
        found = "" if judged.supported else tr("No longer found at this τ.")
        parts = _lead(judged, chain, evidence), worsened_measures_sentence(measures), made, found
        return " ".join(filter(None, parts))
    if interval.kind == Kind.LONE_JUMP:
        return _lone_jump(interval, evidence, first_frame, stretch)
    if interval.kind == Kind.NOISE_BURST:
        return _noise_burst(interval, evidence)
    if interval.kind == Kind.FROZEN:
        return _frozen(chain, evidence)
    if why := interval.kind.info.why:
        size = f"{format_number(np.degrees(interval.size))}°"
        offer = interval.kind.info.offer if interval.correctable else ""
        fields = {"joint": interval.joint, "size": size}
        said = " ".join(
            f"{translate_core_sentence(part.format(**fields))}." for part in (why, offer) if part
        )
        left = _MAY_INSERT if interval.kind == Kind.JOINT_JUMP else _NOT_CORRECTED
        rest = worsened_measures_sentence(measures) if offer else left
        made = tr("Made by hand.") if judged.by_hand else ""
        return " ".join(filter(None, (said, rest, made)))
    sentences = [_lead(judged, chain, evidence), worsened_measures_sentence(measures)]
    if interval.confidence is not None:
        sentences.append(tr("Confidence {sure:.2f}.", sure=interval.confidence))
    if isinstance(chain, Limb):
        sentences += _flip(chain, evidence, first_frame)
    elif isinstance(chain, Helper):
        sentences += _helper_roll(evidence)
    else:
        sentences += _counter_twist(judged, evidence, first_frame)
    doubts = _doubts(evidence, measures)
    if doubts:
        sentences.append(tr("Reasons for doubt: {why}.", why=doubts))
    why_open = {*_DOUBTED, interval.kind.info.doubt}
    known = not why_open.isdisjoint(evidence.get("doubts", ()))
    known = known or bool({"worse", "small"} & set(evidence))
    if isinstance(chain, Limb | Helper):
        known = known or bool(doubts)
    if interval.open and not known:
        why = _OTHER_SIDE
        if _one_turns(judged, chain, evidence):
            why = tr("only one of the two joints turns")
        sentences.append(tr("Not corrected automatically: {why}.", why=why))
    if not judged.supported:
        sentences.append(tr("No longer found at this τ."))
    return " ".join(filter(None, sentences))


def _lead(judged: Judged, chain: Chain, evidence: Mapping[str, Any]) -> str:
    """Return the first sentence of an explanation, with the body part, angle and duration."""
    interval = judged.interval
    degrees = abs(float(np.degrees(interval.shown)))
    if degrees < _LEAST:
        return ""
    angle = format_number(degrees, 0 if degrees >= _FINE else 1)
    if interval.soft_ended:
        angle = tr("up to {angle}", angle=angle)
    frames = plural("{n} frame", "{n} frames", interval.frames)
    if isinstance(chain, Limb):
        return tr(
            "{limb} is flipped for {frames}: the {middle} points {angle}° away from where it "
            "should point.",
            limb=part_of_body(chain),
            frames=frames,
            middle=middle_joint_word(chain),
            angle=angle,
        )
    if isinstance(chain, Helper):
        return tr(
            "{joint} is turned {angle}° too far about its bone for {frames}, but the limb "
            "itself does not turn.",
            joint=chain.name,
            angle=angle,
            frames=frames,
        )
    share = evidence.get("child_follows", 1.0)
    values = {
        "part": part_of_body(chain),
        "angle": angle,
        "frames": frames,
        "next": next_part(chain),
    }
    if interval.kind == Kind.CARRIED_ROLL:
        return tr(
            "{part} rolls {angle}° too far for {frames}, and the {next} rolls with it. "
            "The limb keeps its shape.",
            **values,
        )
    if judged.by_hand or judged.edited or _one_turns(judged, chain, evidence):
        return tr("{part} is turned {angle}° too far for {frames}.", **values)
    if share < 1.0:
        return tr(
            "{part} is turned {angle}° too far for {frames}; the {next} counter-rotates by "
            "{share:.0%} of that angle.",
            share=share,
            **values,
        )
    return tr(
        "{part} is turned {angle}° too far for {frames}; the {next} counter-rotates by the same "
        "angle.",
        **values,
    )


def _one_turns(judged: Judged, chain: Chain, evidence: Mapping[str, Any]) -> bool:
    """Return True for an open interval in which the parent rotates but the child does not.

    In a counter-twist, the child would rotate back by the same angle.
    """
    edges = evidence.get("edges", ())
    return judged.interval.open and len(edges) > 1 and not isinstance(chain, Limb | Helper)


def _counter_twist(judged: Judged, evidence: Mapping[str, Any], first_frame: int) -> Iterator[str]:
    """Yield sentences about the edges of a counter-twist: how θp and θc change there."""
    interval = judged.interval
    edges = evidence.get("edges", ())
    begins = interval.start > 0 or len(edges) > 1
    jumps = (
        tr("At the start, θp jumps by {p}° and θc by {c}°."),
        tr("At the end, θp jumps by {p}° and θc by {c}°."),
    )
    for words, edge in zip(jumps if begins else jumps[1:], edges, strict=False):
        p, c = (format_signed_number(edge[f"residual_{signal}_deg"]) for signal in "xy")
        yield words.format(p=p, c=c)
    if soft := describe_soft_onset(interval):
        yield tr("The error {how}.", how=translate_core_sentence(soft))
    if "transition" in evidence:
        p, c = (evidence[f"transition_{signal}_deg"] for signal in "xy")
        yield tr(
            "At frame {frame}, where the limb is straight, θp changes by {p}° and θc by {c}°.",
            frame=evidence["transition"] + first_frame,
            p=format_signed_number(p),
            c=format_signed_number(c),
        )
    if abs(interval.residual) > np.radians(0.005):
        yield tr(
            "An error of {angle}° remains after the interval.",
            angle=format_signed_number(np.degrees(interval.residual), 2),
        )


def _helper_roll(evidence: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences about the jumps of a twist bone at the edges of the interval."""
    jumps = (
        tr("The roll jumps by {angle}° at the start."),
        tr("The roll jumps by {angle}° at the end."),
    )
    for words, key in zip(jumps, ("opens_deg", "closes_deg"), strict=True):
        if evidence.get(key) is not None:
            yield words.format(angle=format_signed_number(evidence[key]))


def _lone_jump(
    interval: Interval, evidence: Mapping[str, Any], first_frame: int, stretch: Interval | None
) -> str:
    """Return sentences about a lone jump: the joint, its speed, and what the user can do."""
    sentences = [
        tr(
            "At frame {frame}, {joint} turns {turn}° about its own axis in a single frame.",
            joint=interval.joint,
            turn=format_signed_number(np.degrees(interval.residual), 0),
            frame=interval.start + first_frame,
        )
    ]
    if evidence:
        fps = evidence["speed_deg_s"] / abs(evidence["turn_deg"])
        limit = tr(
            "At {fps:.0f} frames per second, no body turns more than {limit:.0f}° in one frame.",
            fps=fps,
            limit=evidence["limit_deg_s"] / fps,
        )
        sentences.append(limit)
    if stretch is not None:
        sentences.append(
            tr(
                "Another interval (frames {first}–{last}) begins or ends here. Accept that "
                "interval to correct this jump as well.",
                first=stretch.start + first_frame,
                last=stretch.stop + first_frame,
            )
        )
        return " ".join(sentences)
    sentences.append(_MAY_INSERT)
    return " ".join(sentences)


def _noise_burst(interval: Interval, evidence: Mapping[str, Any]) -> str:
    """Return sentences about a noise burst: the joints, the size, and what the user can do."""
    noise = tr(
        "Every frame of the interval has about {size}° of noise at {joints}. No body moves like "
        "that.",
        joints=", ".join(evidence.get("joints", (interval.joint,))),
        size=format_number(np.degrees(interval.residual), 0),
    )
    offer = tr(
        "Press “{button}” to smooth these joints in these frames, or accept the detection to mark "
        "it as seen.",
        button=_SMOOTH,
    )
    return f"{noise} {offer}"


def _frozen(chain: Chain, evidence: Mapping[str, Any]) -> str:
    """Return sentences about a limb that does not move: the limb and the duration."""
    limb = capitalised(translate_core_sentence(evidence.get("part", chain.label)))
    if "seconds" not in evidence:
        still = tr("{limb} does not move at all.", limb=limb)
    else:
        still = tr(
            "{limb} does not move at all for {seconds:.2f} s, although it moves in most other "
            "frames.",
            limb=limb,
            seconds=evidence["seconds"],
        )
    return f"{still} {_NOT_CORRECTED}"


def _doubts(evidence: Mapping[str, Any], measures: Sequence[ProtectedMeasure] = ()) -> str:
    """Return the reasons for doubt about a correction, except doubts that `measures` describe."""
    listed = {m.doubt for m in measures if m.worse}
    return ", ".join(
        translate_core_sentence(d) for d in evidence.get("doubts", ()) if d not in listed
    )


def _flip(limb: Limb, evidence: Mapping[str, Any], first_frame: int) -> Iterator[str]:
    """Yield sentences about a flip: its jumps, and how common the side between them is."""
    edges = evidence.get("edges", ())
    if not edges:
        return
    *before, last = (_jump(edge, first_frame) for edge in edges)
    jumps = last
    if before:
        jumps = tr("{first} and back {last}", first=", ".join(before), last=last)
    yield tr("The {middle} jumps {jumps}.", middle=middle_joint_word(limb), jumps=jumps)
    yield _rare_side(evidence["side"])


def _jump(edge: Mapping[str, Any], first_frame: int) -> str:
    """Return a phrase with the angle of a flip's edge and the frame or frames of the edge."""
    jump, frame = format_signed_number(edge["jump_deg"], 0), edge["start"] + first_frame
    if (n := edge["stop"] - edge["start"]) == 1:
        return tr("by {jump}° at frame {frame}", jump=jump, frame=frame)
    return tr("by {jump}° within {n} frames from frame {frame}", jump=jump, n=n, frame=frame)


def _rare_side(side: float) -> str:
    """Return a sentence if the joint is rarely on this side in the clip, or ''.

    `side` is the log odds that the joint belongs on the opposite side.
    """
    if side > _RARER:
        return tr(
            "In these frames, the joint is on a side where it is rarely found in the rest of "
            "this clip."
        )
    if side > _RARE:
        return tr(
            "In these frames, the joint is on the side where it spends less time in this clip."
        )
    return ""


def _figures(judged: Judged, chain: Chain) -> str:
    """Return the numbers on which a detection is based, for the tool tip of the explanation."""
    if judged.edited:
        return ""
    if isinstance(chain, Limb):
        return _flip_figures(judged, chain)
    if not describe_soft_onset(judged.interval) or judged.by_hand:
        return ""
    gain = (judged.interval.evidence or {})["gain"]
    return tr(
        "The parent's twist was compared with a straight line between the ends of each "
        "span of frames,\nand with the parent's twist in the rest of the clip.\nLog odds "
        "of an error versus natural motion: {gain}.",
        gain=format_number(gain, 0),
    )


def _flip_figures(judged: Judged, limb: Limb) -> str:
    """Return the numbers on which the detection of a flip is based, for the tool tip."""
    interval, evidence = judged.interval, judged.interval.evidence or {}
    lines = []
    if edges := evidence.get("edges", ()):
        figures = tr(
            "In other frames, the {middle} jumps by {unsteady:.1f}° or less.\nLog odds of a "
            "flip, judging by the {middle}'s side in the rest of the clip: {side}.\nLog odds "
            "of a flip versus all other explanations: {odds}.",
            middle=middle_joint_word(limb),
            unsteady=max(e["sigma_deg"] for e in edges),
            side=format_number(evidence["side"]),
            odds=format_number(evidence["odds"]),
        )
        lines.append(figures)
    if abs(interval.residual) > np.radians(0.005):
        left = format_signed_number(np.degrees(interval.residual), 2)
        lines.append(tr("An error of {angle}° remains after the interval.", angle=left))
    return "\n".join(lines)
