"""A page with the settings that determine the suggested τ, such as the cost of a false alarm."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QAbstractSpinBox, QDoubleSpinBox, QFormLayout, QSpinBox, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.tuning.tau_costs import Costs
from inspector.tuning.wishes import MOST_DRAWS, Wishes
from inspector.widgets.building import action_button, hbox, vbox
from inspector.widgets.labels import Caption
from twistcore.tuning import Span

_LEAVE_OUT = {  # texts of the buttons next to "Leave out"
    "leave_out_interval": tr("The interval"),
    "leave_out_visible": tr("Visible"),
    "take_all_in": tr("Nothing"),
}


class SuggestionPage(QWidget):
    """A page with the settings that determine the suggested τ.

    The page also shows the suggested common τ for all chains and the frames that tuning uses.
    """

    def __init__(
        self,
        document: Document,
        costs: Costs,
        wishes: Wishes,
        actions: Mapping[str, QAction],
    ) -> None:
        super().__init__()
        self._document, self._costs, self._wishes = document, costs, wishes
        self.points = QDoubleSpinBox(decimals=1, maximum=100.0, suffix=tr(" FSR points"))
        self.points.setToolTip(
            tr(
                "The cost of one false alarm per clip (per minute in longer clips), in percentage "
                "points of the FSR (the share of injected error frames that are repaired)"
            )
        )
        self.smallest = QDoubleSpinBox(decimals=1, minimum=0.1, maximum=180.0, suffix="°")
        self.smallest.setToolTip(
            tr("Injected errors smaller than this angle do not count towards the suggestion")
        )
        self.draws = QSpinBox(minimum=1, maximum=MOST_DRAWS)
        self.draws.setToolTip(
            tr(
                "How many times errors are injected into each chain. More repetitions take longer "
                "but give a narrower confidence interval."
            )
        )
        form = QFormLayout(labelAlignment=Qt.AlignmentFlag.AlignLeft)
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(3)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        boxes: tuple[tuple[str, QAbstractSpinBox], ...] = (
            (tr("Cost of a false alarm"), self.points),
            (tr("Smallest error to find"), self.smallest),
            (tr("Repetitions with random errors"), self.draws),
        )
        for words, box in boxes:
            box.setKeyboardTracking(False)
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            box.setAccessibleName(words)
            form.addRow(words, box)
        self.show_wishes()
        self.points.valueChanged.connect(lambda value: wishes.wish(points=value))
        self.smallest.valueChanged.connect(lambda value: wishes.wish(smallest_degrees=value))
        self.draws.valueChanged.connect(lambda value: wishes.wish(draws=value))
        self.shared, self.left_out = Caption(), Caption(soft=True)
        buttons = [action_button(actions[name], word) for name, word in _LEAVE_OUT.items()]
        vbox(
            form,
            self.shared,
            self.left_out,
            hbox(tr("Leave out"), *buttons, None, spacing=4),
            None,
            owner=self,
            margins=(0, 6, 0, 0),
            spacing=6,
        )

    def show_wishes(self) -> None:
        """Update the fields to show the current settings."""
        self.points.setValue(self._wishes.points)
        self.smallest.setValue(self._wishes.smallest_degrees)
        self.draws.setValue(self._wishes.draws)

    def refresh(self) -> None:
        """Update the common τ and the frames that tuning uses."""
        data = self._document.data
        if data is None:
            return
        curves = self._costs.curves
        known = len(curves) == len(self._costs.names)
        shared = self._wishes.shared(curves) if known else None
        there, total = len(curves), len(self._costs.names)
        coming = tr("Measuring chains: {known} of {total} …", known=there, total=total)
        waiting = "" if known else coming
        labels = {c.name: translate_core_sentence(c.label) for c in data.chains}
        self.shared.set_plain(translate_core_sentence(shared.words(labels)) if shared else waiting)
        self.left_out.set_text(self._left_out_words())

    def _left_out_words(self) -> str:
        frames, capture = self._document.frames, self._costs.capture
        parts = []
        if capture is not None and capture.first:
            first = self._named((0, capture.first))
            parts.append(tr("{frames} (the transition from the first pose)", frames=first))
        if capture is not None and capture.stop < frames:
            last = self._named((capture.stop, frames))
            parts.append(tr("{frames} (the transition to the rest pose)", frames=last))
        yours = [self._named(span) for span in self._document.review.state.left_out]
        if yours:
            parts.append(tr("{frames} (your choice)", frames=", ".join(yours)))
        if not parts:
            return tr("All frames are used.")
        return tr("Ignored: frames {frames}.", frames=", ".join(parts))

    def _named(self, span: Span) -> str:
        start, stop = (frame + self._document.first_frame for frame in span)
        return f"{start}" if stop == start + 1 else f"{start}–{stop}"
