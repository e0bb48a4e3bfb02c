"""The selected interval in exact numbers, and its verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt, Signal
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

from inspector.language import of_core, plural, tr, tr_as
from inspector.panels.end_choice import EndChoice
from inspector.panels.interval_filter import short_word
from inspector.panels.limb_words import middle_of
from inspector.panels.protected_words import table_of, worse_line
from inspector.panels.reject_reasons import REASONS, kept_reason, told_reason
from inspector.panels.rig_names import joints_of
from inspector.session.document import Document
from inspector.session.examined import reason_unexamined
from inspector.session.why_here import reason_near, told
from inspector.widgets.building import hbox, vbox
from inspector.widgets.labels import Caption, Headline, as_tip, bold
from inspector.widgets.later import Burst
from inspector.widgets.signed_numbers import SignedBox, plain, signed
from twistcore.analysis.clip_analysis import RESTLESS_DOUBT
from twistcore.analysis.correction.protected_measures import (
    Hinges,
    ProtectedMeasure,
    protected_measures,
)
from twistcore.analysis.why_not import Why
from twistcore.detection import Interval, Kind
from twistcore.review import Annotate, Decision, Judged
from twistcore.review.model import levelled, resized
from twistcore.review.soft_onset import soft_onset
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb

_RARE, _RARER = 0.7, 3.0  # logarithms of odds: a side where a limb is half as often, hardly ever
_UNBOUND = 16_777_215  # pixels: Qt's own largest
_ARROWS = 28  # pixels: of a number box, its arrows and borders
_NEXT = tr("N goes to the next one.")
_OPEN = tr("Open a clip: N goes through its intervals.")
_SMOOTH = tr("Smooth it in Quality → Track")
_NOTHING_OUT = tr("Nothing is taken out; Accept marks it as seen.")
_OTHER_SIDE = tr("the other side of the clip may be the wrong one")


class DetailCard(QWidget):
    """Spin boxes for start, stop and δ, a note, and Accept / Reject / Reset."""

    judged = Signal(object)  # Decision
    quality_asked = Signal(object)  # Interval: a noise burst or frozen frames, whose joint to show
    end_turned = Signal()  # a flipped limb's end is to be kept if it was carried, or the reverse

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document
        self._shown: int | None = None  # whose note stands in the form
        self._burst = Burst(document.begin_drag, self)
        self.title = Headline()
        self.start, self.stop = QSpinBox(), QSpinBox()
        self.delta = SignedBox(minimum=-180.0, maximum=180.0, decimals=2, suffix="°")
        self._boxes = (self.start, self.stop, self.delta)
        for box in self._boxes:
            box.setKeyboardTracking(False)
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            most = "−180.00°" if box is self.delta else "00000"  # longer ones where there is room
            box.setMinimumWidth(box.fontMetrics().horizontalAdvance(most) + _ARROWS)
        for box, name in (
            (self.start, tr("First frame of the interval")),
            (self.stop, tr("Frame behind the interval's last")),
            (self.delta, tr("Offset δ, degrees")),
        ):
            box.setAccessibleName(name)
        self.note = QLineEdit(placeholderText=tr("Note"))
        self.note.setAccessibleName(tr("Note"))
        self.reason = QComboBox(editable=True, insertPolicy=QComboBox.InsertPolicy.NoInsert)
        self.reason.addItems(["", *map(told_reason, REASONS)])
        self.reason.setToolTip(tr("Why it is rejected"))
        self.reason.setAccessibleName(tr("Why it is rejected"))
        line = self.reason.lineEdit()
        assert line is not None
        line.setPlaceholderText(tr("Reason"))
        line.setAccessibleName(tr("Why it is rejected"))
        self.why = Caption(soft=True)
        self.end = EndChoice()
        self.end.turned.connect(self.end_turned)
        self.to_quality = QPushButton(_SMOOTH)
        self.to_quality.clicked.connect(self._ask_quality)
        self._link = QWidget()  # hidden it takes no room
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
        for decision, text, key in (
            (Decision.ACCEPTED, tr_as("the interval", "Accept"), "A"),
            (Decision.REJECTED, tr_as("the interval", "Reject"), "R"),
            (Decision.UNDECIDED, tr_as("the interval", "Reset"), tr_as("key", "Backspace")),
        ):
            button = QPushButton(text)
            button.setToolTip(f"{text} ({key})")
            button.clicked.connect(lambda _=False, d=decision: self.judged.emit(d))
            buttons.addWidget(button)
            self.buttons[decision] = button
        head = hbox((self.title, 1), self.end)
        self._told = vbox((self.why, 1), self._link)
        vbox(head, self._told, form, buttons, owner=self)
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
        """Where height is short the explanation is a line, whole in its tip; gaps are narrow."""
        layout = self.layout()
        assert layout is not None
        layout.setContentsMargins(*((8, 2, 8, 3) if low else (8, 6, 8, 8)))
        layout.setSpacing(3 if low else -1)  # -1: as the style has it
        self._form.setVerticalSpacing(3 if low else -1)
        self.why.set_short(low)
        beside = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._told.setDirection(beside[0 if low else 1])
        line = self.fontMetrics().height() + 4 if low else _UNBOUND
        self.to_quality.setMaximumHeight(line)

    def _take_clip(self) -> None:
        """Another clip: what is shown was about the last one, where it is committed already."""
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
            box.setEnabled(kind is not None and kind.repairable)
        self.end.setVisible(kind == Kind.LIMB_FLIP)
        for box in self._boxes:  # a number that is about nothing is not shown
            box.setSpecialValueText("" if judged else " ")
        if kind is not None and kind.of_capture:
            self.delta.setSpecialValueText(" ")
        if judged is None:
            with QSignalBlocker(self.start), QSignalBlocker(self.stop), QSignalBlocker(self.delta):
                self.start.setValue(self.start.minimum())
                self.stop.setValue(self.stop.minimum())
                self.delta.setValue(self.delta.minimum())
            self.why.setToolTip("")
            self.title.setToolTip("")
            self._show_reason()
            return
        interval = judged.interval
        chain = self._document.find_chain(interval.chain)
        what = "" if kind == Kind.COUNTER_TWIST else f" · {short_word(interval.kind)}"
        label = of_core(chain.label)
        varies = "" if np.ptp(interval.offset) < 1e-9 else tr(", follows")
        if interval.soft_ended:
            varies += tr(", up to {offset}°", offset=signed(np.degrees(interval.shown)))
        count = plural("{n} frame", "{n} frames", interval.frames)
        assert self._document.data is not None
        joints = joints_of(chain, self._document.data.motion.skeleton)
        self.title.setToolTip(as_tip(f"{label}{what} · {count}{varies}\n{joints}"))
        self.title.setText(f"{bold(label)}{what} · {count}{varies}")
        first = self._document.first_frame
        measures = self._measures(judged)
        figures = filter(None, (_figures(judged, chain), table_of(measures)))
        self.why.setToolTip(as_tip("\n".join(figures)))
        why = explanation(self._document.told(judged), chain, first, measures)
        self.why.set_plain(f"{worse_line(measures)} {why}".strip())
        if isinstance(chain, Limb):
            self.end.show_end(chain.end_word, interval.carried)
        with QSignalBlocker(self.start), QSignalBlocker(self.stop), QSignalBlocker(self.delta):
            self.start.setRange(first, interval.stop - 1 + first)
            self.stop.setRange(interval.start + 1 + first, self._document.frames + first)
            self.start.setValue(interval.start + first)
            self.stop.setValue(interval.stop + first)
            none = interval.kind.of_capture
            self.delta.setValue(self.delta.minimum() if none else float(np.degrees(interval.shown)))
        if not self.note.hasFocus() and not self.reason.hasFocus():
            self._show_note(judged)

    def _offer_quality(self, kind: Kind | None) -> None:
        """The button of faults of the capture."""
        fault = kind is not None and kind.of_capture
        self._link.setVisible(fault)
        self.end.keep_room(not fault)  # the heading has it
        if kind == Kind.NOISE_BURST:
            self.to_quality.setText(_SMOOTH)
            self.to_quality.setToolTip(
                tr("Open that page with the noisy joints selected; it tracks them in every frame")
            )
        elif kind == Kind.FROZEN:
            self.to_quality.setText(tr("Show the joint in Quality"))
            self.to_quality.setToolTip(tr("Open the table of joints with this one selected"))

    def _ask_quality(self) -> None:
        if judged := self._document.interval:
            self.quality_asked.emit(self._document.told(judged).interval)

    def _measures(self, judged: Judged) -> tuple[ProtectedMeasure, ...]:
        """What a correction changes in the limb, with the others that are shown as corrected."""
        document = self._document
        assert document.data is not None
        if document.data.blind:
            return ()  # an exercise does not give itself away
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
        """No interval: at a peak of the strength past τ, why there is none."""
        document = self._document
        if document.interval is not None:
            return
        reason = reason_near(document, document.frame)
        outside = reason is not None and reason.why != Why.INTERVAL
        asked, none = tr("Why is nothing found here?"), tr("No interval selected")
        self.title.setText(asked if outside else none)
        nothing = _NEXT if document.data is not None else _OPEN
        if not document.intervals:
            nothing = reason_unexamined(document.data) or nothing
        text = told(document, reason) if reason else nothing
        self.why.set_plain(text)

    def says(self, text: str) -> bool:
        """Whether a sentence is to be read here."""
        return self.why.says(text) and not self.visibleRegion().isEmpty()

    def write(self, what: str) -> bool:
        """Give the 'start', 'stop', 'delta', 'note' the keyboard; False where there is none."""
        box: QWidget = getattr(self, what)
        if not box.isEnabled():
            return False
        box.setFocus(Qt.FocusReason.ShortcutFocusReason)
        if isinstance(box, QLineEdit | QAbstractSpinBox):
            box.selectAll()
        return True

    def _show_note(self, judged: Judged | None) -> None:
        self.note.setText(judged.note if judged else "")
        self.reason.setCurrentText(told_reason(judged.reason) if judged else "")

    def _edges_edited(self) -> None:
        if judged := self._document.interval:
            first = self._document.first_frame
            start, stop = self.start.value() - first, self.stop.value() - first
            edited = resized(judged.interval, start, stop)
            self._document.edit(judged.id, edited, self._burst.drag())

    def _delta_edited(self, degrees: float) -> None:
        if judged := self._document.interval:
            edited = levelled(judged.interval, float(np.radians(degrees)))
            self._document.edit(judged.id, edited, self._burst.drag())

    def commit(self) -> None:
        """Keep a note that is still being typed, for the interval it was typed for."""
        shown = (j for j in self._document.intervals if j.id == self._shown)
        judged = next(shown, None)
        note, reason = self.note.text(), kept_reason(self.reason.currentText().strip())
        if judged and note == judged.note[: self.note.maxLength()]:
            note = judged.note  # the line holds no more of it
        if judged and reason == judged.reason.strip():
            reason = judged.reason  # nobody has written another one
        if judged and (note, reason) != (judged.note, judged.reason):
            self._document.do(Annotate(judged.id, note, reason))


def explanation(
    judged: Judged, chain: Chain, first_frame: int, measures: Sequence[ProtectedMeasure] = ()
) -> str:
    """Why the interval of a chain is there, in a line or two; measures: said by themselves."""
    if judged.by_hand:
        return tr("Made by hand.")
    interval = judged.interval
    evidence = interval.evidence or {}
    if not interval.kind.known:
        return tr("A later version of the program found it; this one only shows it.")
    if interval.kind == Kind.LONE_JUMP:
        return _lone_jump(interval, evidence, first_frame)
    if interval.kind == Kind.NOISE_BURST:
        return _noise_burst(interval, evidence)
    if interval.kind == Kind.FROZEN:
        return _frozen(chain, evidence)
    if isinstance(chain, Limb):
        return _flip(judged, chain, first_frame, measures)
    if isinstance(chain, Helper):
        return _helper_roll(judged, chain, evidence)
    sentences = []
    if interval.confidence is not None:
        sentences.append(tr("Confidence {sure:.2f}.", sure=interval.confidence))
    if doubts := _doubts(evidence, measures):
        sentences.append(tr("Against it: {why}.", why=doubts))
    if speaks := "; ".join(_for(judged, evidence, first_frame)):
        sentences.append(tr("For it: {why}.", why=speaks))
    known = RESTLESS_DOUBT in evidence.get("doubts", ()) or {"worse", "small"} & set(evidence)
    if interval.open and not known:
        alone = len(evidence.get("edges", ())) > 1
        why = tr("one joint alone turns") if alone else _OTHER_SIDE
        sentences.append(tr("Open: {why}.", why=why))
    if not judged.supported:
        sentences.append(tr("No longer found at this τ."))
    return " ".join(sentences)


def _for(judged: Judged, evidence: Mapping[str, Any], first_frame: int) -> Iterator[str]:
    """What both joints do at the edges of a counter-twist, or over it."""
    interval = judged.interval
    edges = evidence.get("edges", ())
    begins = interval.start > 0 or len(edges) > 1
    said = tr("opens with x {x}° against y {y}°"), tr("closes with x {x}° against y {y}°")
    for words, edge in zip(said if begins else said[1:], edges, strict=False):
        x, y = (signed(edge[f"residual_{signal}_deg"]) for signal in "xy")
        yield words.format(x=x, y=y)
    if soft := soft_onset(interval):
        edited = tr("found as it sets in softly, and edited")
        yield edited if judged.edited else of_core(soft)
    if "transition" in evidence:
        turn, answer = (evidence[f"transition_{signal}_deg"] for signal in "xy")
        yield tr(
            "the limb is straight; at {frame} P turns by {turn}°, C by {answer}°",
            frame=evidence["transition"] + first_frame,
            turn=signed(turn),
            answer=signed(answer),
        )
    if (share := evidence.get("child_follows", 1.0)) < 1.0:
        yield tr("the child turns back by {share:.0%} of it", share=share)
    if abs(interval.residual) > np.radians(0.005):
        yield tr("left over {angle}°", angle=signed(np.degrees(interval.residual), 2))


def _helper_roll(judged: Judged, helper: Helper, evidence: Mapping[str, Any]) -> str:
    """Return by how much a twist bone next to the chain jumps alone."""
    parts = [tr("{joint} turns about its bone alone", joint=helper.name)]
    jumps = tr("jumps by {angle}° at the start"), tr("jumps by {angle}° at the end")
    for words, key in zip(jumps, ("opens_deg", "closes_deg"), strict=True):
        if evidence.get(key) is not None:
            parts.append(words.format(angle=signed(evidence[key])))
    if doubts := _doubts(evidence):
        parts.append(tr("against it: {why}", why=doubts))
    elif judged.interval.open:
        parts.append(tr("open: {why}", why=_OTHER_SIDE))
    if not judged.supported:
        parts.append(tr("no longer found at this τ"))
    return "; ".join(parts)


def _lone_jump(interval: Interval, evidence: Mapping[str, Any], first_frame: int) -> str:
    """Which joint jumps, how fast, and that nothing is known to take it out."""
    turn = f"{signed(np.degrees(interval.residual), 0)}°"
    frame = interval.start + first_frame
    told = tr(
        "{joint} turns about its own axis by {turn} in a frame, at {frame}",
        joint=interval.joint,
        turn=turn,
        frame=frame,
    )
    if evidence:
        fps = evidence["speed_deg_s"] / abs(evidence["turn_deg"])
        told += tr(
            "; at {fps:.0f} frames a second no body turns by more than {limit:.0f}° in one",
            fps=fps,
            limit=evidence["limit_deg_s"] / fps,
        )
    rest = tr("Nothing is taken out; Insert makes an interval here, Accept marks it as seen.")
    return f"{told}. {rest}"


def _noise_burst(interval: Interval, evidence: Mapping[str, Any]) -> str:
    """Which joints jitter, by how much, and what helps."""
    said = tr(
        "{joints}: noise of about {size}° in every frame, as no body moves",
        joints=", ".join(evidence.get("joints", (interval.joint,))),
        size=plain(np.degrees(interval.residual), 0),
    )
    return f"{said}. {_NOTHING_OUT}"


def _frozen(chain: Chain, evidence: Mapping[str, Any]) -> str:
    """Which limb does not move, and for how long."""
    limb = of_core(evidence.get("part", chain.label))
    limb = limb[:1].upper() + limb[1:]
    if "seconds" not in evidence:
        said = tr("{limb}: stands still to the last digit", limb=limb)
    else:
        said = tr(
            "{limb}: stands still to the last digit for {seconds:.2f} s, while it moves in most "
            "other frames",
            limb=limb,
            seconds=evidence["seconds"],
        )
    return f"{said}. {_NOTHING_OUT}"


def _doubts(evidence: Mapping[str, Any], measures: Sequence[ProtectedMeasure] = ()) -> str:
    """What speaks against a correction, as one text; measures: said by themselves."""
    said_before = {m.doubt for m in measures if m.worse}
    return ", ".join(of_core(d) for d in evidence.get("doubts", ()) if d not in said_before)


def _flip(
    judged: Judged, limb: Limb, first_frame: int, measures: Sequence[ProtectedMeasure] = ()
) -> str:
    """The jumps about the limb's line, and where it is between them."""
    interval, evidence = judged.interval, judged.interval.evidence or {}
    sentences = []
    if edges := evidence.get("edges", ()):
        jumps = (signed(e["jump_deg"], 0) for e in edges)
        *before, last = (
            tr("by {jump}° at {frame}", jump=jump, frame=e["start"] + first_frame)
            for jump, e in zip(jumps, edges, strict=True)
        )
        told = last
        if before:
            told = tr("{first} and back {last}", first=", ".join(before), last=last)
        told += _seldom(evidence["side"], several=bool(before))
        sentences.append(tr("The {middle} jumps {told}.", middle=middle_of(limb), told=told))
    if interval.confidence is not None:
        sentences.append(tr("Confidence {sure:.2f}.", sure=interval.confidence))
    if doubts := _doubts(evidence, measures):
        sentences.append(tr("Against it: {why}.", why=doubts))
    elif interval.open and "worse" not in evidence:
        sentences.append(tr("Open: {why}.", why=_OTHER_SIDE))
    if not judged.supported:
        sentences.append(tr("No longer found at this τ."))
    return " ".join(sentences)


def _seldom(side: float, *, several: bool) -> str:
    """How rare the side is that the limb stands on; '' where it is as usual as the other."""
    if side <= _RARE:
        return ""
    if several and side > _RARER:
        return tr("; between them it stands on the side where it hardly ever is in this clip")
    if several:
        return tr("; between them it stands on the side where it less often is in this clip")
    if side > _RARER:
        return tr("; in the interval it stands on the side where it hardly ever is in this clip")
    return tr("; in the interval it stands on the side where it less often is in this clip")


def _figures(judged: Judged, chain: Chain) -> str:
    """What an interval was compared with, for who wants to know."""
    if isinstance(chain, Limb):
        return _flip_figures(judged, chain)
    if not soft_onset(judged.interval) or judged.by_hand:
        return ""
    gain = (judged.interval.evidence or {})["gain"]
    return tr(
        "Compared: P's level in spans of all lengths with the line between their ends,\n"
        "and what that does elsewhere in the clip. For an error, against motion alone,\n"
        "speak {gain} (logarithm of odds).",
        gain=plain(gain, 0),
    )


def _flip_figures(judged: Judged, limb: Limb) -> str:
    """What speaks for a flip in figures, for who wants to know."""
    interval, evidence = judged.interval, judged.interval.evidence or {}
    told = []
    if edges := evidence.get("edges", ()):
        figures = tr(
            "Otherwise the {middle} jumps by {unsteady:.1f}° or less.\n"
            "For a flip speak the {middle}'s side elsewhere ({side})\n"
            "and the price of all other explanations ({odds}),\n"
            "logarithms of odds.",
            middle=middle_of(limb),
            unsteady=max(e["sigma_deg"] for e in edges),
            side=plain(evidence["side"]),
            odds=plain(evidence["odds"]),
        )
        told.append(figures)
    if abs(interval.residual) > np.radians(0.005):
        left = signed(np.degrees(interval.residual), 2)
        told.append(tr("Left over: {angle}°.", angle=left))
    return "\n".join(told)
