"""A page with the precision and recall for each kind of error or for each chain."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QComboBox, QStackedLayout, QWidget

from inspector.language import tr, tr_as, translate_core_sentence, translate_declared_text
from inspector.session.document import Document
from inspector.tuning.cost_plot import PercentAxis
from inspector.tuning.verdict_evidence import CLIP, Scope, VerdictEvidence
from inspector.widgets.axes import Axis
from inspector.widgets.building import hbox, hint, vbox
from inspector.widgets.canvas import Canvas
from inspector.widgets.labels import Caption, coloured_rich_text, plain_text
from inspector.widgets.theme import Colours, Theme, figures_font
from twistcore.detection.error_label import WHOLE_BODY
from twistcore.tuning.verdict_counts import VerdictCount, count_verdicts_by_group

_NOTHING = tr(
    "Nothing has been decided yet. Accept (A) or reject (R) intervals of any kind; this page then "
    "shows how many of each kind are errors, and how many errors were missed."
)
# In row heights: the thickness of a bar, and the distance of the recall mark below its middle
_BAR, _APART = 0.5, 0.17
_AXIS_HEIGHT = 18  # pixels
_NAME_GAP = 14.0  # pixels between the longest name of a row and the plot
_FEWEST = 8  # minimum number of rows for which there is room, so that bars are never thick
_ROOM = 66.0  # room for numbers to the right of 100 %, in per cent of the axis


class KindBars(Canvas):
    """A plot of the precision and recall of groups of verdicts, one group in each row.

    Attributes
    ----------
    bars
        The bars, which show the precision.
    between
        The lines, which show the 90 % confidence interval of the precision.
    recall
        The diamonds, which show the recall.
    """

    def __init__(self, colours: Colours) -> None:
        self._rows = Axis("left")
        super().__init__({"left": self._rows, "bottom": PercentAxis("bottom")})
        self.set_type(figures_font(8.0))
        self.axes["bottom"].setHeight(_AXIS_HEIGHT)
        self.bars = pg.BarGraphItem(x0=[], x1=[], y=[], height=_BAR)
        self.between = pg.PlotCurveItem(connect="pairs")
        self.recall = pg.ScatterPlotItem(symbol="d", size=9)
        self._texts: list[pg.TextItem] = []
        self._theme = colours.theme
        for item in (self.bars, self.between, self.recall):
            self.addItem(item)
        self.view.setXRange(0.0, 100.0 + _ROOM, padding=0.0)
        self.setMinimumHeight(80)
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self._theme = theme
        self.colour_background(theme)
        self.bars.setOpts(brush=pg.mkBrush(theme.accepted), pen=pg.mkPen(None))
        self.between.setPen(pg.mkPen(theme.text, width=1.4))
        self.recall.setBrush(pg.mkBrush(theme.after))
        self.recall.setPen(pg.mkPen(theme.surface, width=1.0))
        for text in self._texts:
            text.setColor(theme.soft)
        self.touch()

    def show_counts(self, counts: Mapping[str, VerdictCount]) -> None:
        """Plot verdict counts, keyed by group name."""
        self._rows.setTicks([[(float(-k), name) for k, name in enumerate(counts)]])
        metrics = QFontMetricsF(figures_font(8.0))
        widest = max((metrics.horizontalAdvance(name) for name in counts), default=0.0)
        self._rows.setWidth(widest + _NAME_GAP)
        every = list(counts.values())
        rows = -np.arange(len(every), dtype=np.float64)
        share, low, high = _percent([count.score.precision for count in every])
        self.bars.setOpts(x0=np.zeros(len(every)), x1=np.nan_to_num(share), y=rows, height=_BAR)
        judged = np.isfinite(share)
        self.between.setData(
            np.stack([low, high], axis=1)[judged].ravel(), np.repeat(rows[judged], 2)
        )
        recall = 100.0 * np.array([count.recall for count in every])
        known = np.isfinite(recall)
        self.recall.setData(recall[known], rows[known] - _APART)
        for text in self._texts:
            self.view.removeItem(text)
        self._texts = [self._numbers(row, count) for row, count in zip(rows, every, strict=True)]
        self.view.setYRange(0.6 - max(len(every), _FEWEST), 0.6, padding=0.0)
        self.touch()

    def _numbers(self, row: float, count: VerdictCount) -> pg.TextItem:
        text = pg.TextItem(verdict_counts_text(count), color=self._theme.soft, anchor=(0.0, 0.5))
        text.setFont(figures_font(8.0))
        text.setPos(103.0, row)
        self.addItem(text)
        return text


class KindsPage(QWidget):
    """A page that shows how reliable the detections of each kind of error or chain are.

    Attributes
    ----------
    hint
        The text that is shown while there are no verdicts.
    scopes
        The drop-down list of clip groups, such as this clip or the folder.
    groups
        The drop-down list that determines whether each row is a kind of error or a chain.
    plot
        The plot of precision and recall.
    legend
        The legend of the plot.
    """

    def __init__(self, document: Document, evidence: VerdictEvidence, colours: Colours) -> None:
        super().__init__()
        self._document, self._evidence, self._colours = document, evidence, colours
        self._build()
        colours.changed.connect(self.refresh)
        evidence.changed.connect(self.refresh)

    def _build(self) -> None:
        self.hint = hint(_NOTHING)
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.scopes, self.groups = QComboBox(), QComboBox()
        self.scopes.setAccessibleName(tr("Scope"))
        self.groups.setAccessibleName(tr("Rows"))
        self.groups.addItem(tr("By kind"))
        self.groups.addItem(tr("By chain"))
        for box in (self.scopes, self.groups):
            box.currentIndexChanged.connect(self._show_scope)
        self.plot = KindBars(self._colours)
        self.plot.setAccessibleName(tr("Precision and recall of each row"))
        self.legend = Caption()
        head = hbox(self.scopes, self.groups, None, spacing=4)
        vbox(head, self.legend, (self.plot, 1), owner=content, margins=(0, 4, 0, 0), spacing=2)

    def refresh(self) -> None:
        """Update the page after the verdicts have changed."""
        data, scopes = self._document.data, [scope.name for scope in self._all]
        verdicts = (v for scope in self._all for clip in scope.clips for v in clip.of_kinds)
        any_verdict = any(verdict.error is not None for verdict in verdicts)
        self._pages.setCurrentIndex(int(any_verdict and data is not None))
        if not any_verdict or data is None:
            self.hint.setText(self._evidence.trouble or _NOTHING)
            return
        if [self.scopes.itemText(k) for k in range(self.scopes.count())] != scopes:
            chosen = self.scopes.currentText() or CLIP
            with QSignalBlocker(self.scopes):
                self.scopes.clear()
                self.scopes.addItems(scopes)
                self.scopes.setCurrentIndex(max(self.scopes.findText(chosen), 0))
        self._show_scope()

    @property
    def _all(self) -> tuple[Scope, ...]:
        present = self._evidence.present
        return tuple(s for s in present.scopes if not s.chain) if present else ()

    def _show_scope(self) -> None:
        counts = self.counts()
        self.plot.show_counts(counts)
        theme = self._colours.theme
        parts = (
            coloured_rich_text(tr("▬ precision, with its 90 % range"), theme.accepted),
            coloured_rich_text(tr("◆ recall, if you inserted the missed errors"), theme.after),
            coloured_rich_text(tr("✓ errors  ✗ false alarms  + missed  ? undecided"), theme.soft),
        )
        self.legend.set_text(" &nbsp; ".join(parts))
        rows = (
            f"{name}: {_shares(count)}, {verdict_counts_text(count)}"
            for name, count in counts.items()
        )
        self.plot.setAccessibleDescription("\n".join((plain_text(self.legend.text()), *rows)))

    def counts(self) -> dict[str, VerdictCount]:
        """Return the verdict counts for the chosen clips, keyed by row name."""
        name = self.scopes.currentText()
        scope = next((s for s in self._all if s.name == name), None)
        if scope is None:
            return {}
        verdicts = [v for clip in scope.clips for v in clip.of_kinds]
        if self.groups.currentIndex():
            by_chain = count_verdicts_by_group(
                verdicts, lambda v: WHOLE_BODY if v.kind.info.whole_body else v.chain
            )
            return {self._label(chain): count for chain, count in sorted(by_chain.items())}
        by_kind = count_verdicts_by_group(verdicts, lambda v: v.kind)
        ordered = sorted(by_kind.items(), key=lambda item: item[0].info.place)
        return {translate_declared_text(kind.info.label): count for kind, count in ordered}

    def _label(self, chain: str) -> str:
        if chain == WHOLE_BODY:
            return translate_core_sentence(chain)
        try:
            return translate_core_sentence(self._document.find_chain(chain).list_label)
        except KeyError:  # the chain is only in another clip
            return chain


def verdict_counts_text(count: VerdictCount) -> str:
    """Return verdict counts as text, such as "✓ 5  ✗ 2  + 1  ? 3".

    The numbers are those of found errors, false alarms, missed errors and undecided intervals.
    """
    score = count.score
    parts = [f"✓ {score.found}", f"✗ {score.alarms}"]
    if missed := score.errors - score.found:
        parts.append(f"+ {missed}")
    if count.undecided:
        parts.append(f"? {count.undecided}")
    return "  ".join(parts)


def _shares(count: VerdictCount) -> str:
    precision, recall = count.score.precision[0], count.recall
    return tr(
        "precision {precision}, recall {recall}", precision=_text(precision), recall=_text(recall)
    )


def _text(share: float) -> str:
    return tr_as("share", "unknown") if math.isnan(share) else f"{100.0 * share:.0f} %"


def _percent(shares: list[tuple[float, float, float]]) -> np.ndarray:
    """Return shares with their confidence limits in per cent, shape (3, n).

    `shares` contains (share, lower limit, upper limit), all in 0…1, for each of n groups.
    """
    return 100.0 * np.array(shares, dtype=np.float64).reshape(-1, 3).T
