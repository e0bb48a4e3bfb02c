"""The list of review steps. A click on a step undoes or redoes all steps up to that step."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.panels.rig_names import label_of, label_without_chain
from inspector.session.document import Document
from inspector.widgets.building import vbox
from twistcore.detection import Interval
from twistcore.review import Review


class HistoryPanel(QWidget):
    """The list of review steps. Undone steps are greyed out."""

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document
        self.list = QListWidget()
        self.list.setAccessibleName(tr("Steps of the review"))
        self.list.setUniformItemSizes(True)
        self.list.itemClicked.connect(self._go)
        vbox(self.list, owner=self, margins=(0, 0, 0, 0))
        document.opened.connect(self._refresh)
        document.intervals_changed.connect(self._refresh)
        document.numbering_changed.connect(self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        review = self._document.review if self._document.data else None
        texts = (tr("As opened"), *(self._steps(review) if review else ()))
        if [self.list.item(k).text() for k in range(self.list.count())] != list(texts):
            self.list.clear()
            self.list.addItems(texts)
        done = review.position if review else 0
        for k in range(self.list.count()):
            item = self.list.item(k)
            colour = self.palette().placeholderText() if k > done else self.palette().text()
            item.setForeground(colour)
            spoken = tr("undone") if k > done else ""  # screen readers do not report faint text
            item.setData(Qt.ItemDataRole.AccessibleDescriptionRole, spoken)
        self.list.setCurrentRow(done)
        self.list.scrollToItem(self.list.item(done))

    def _steps(self, review: Review) -> Iterator[str]:
        """Yield the name of each step and, if it changed an interval, its chain and frames."""
        first = self._document.first_frame
        for name, judged in zip(review.history, review.changed_intervals, strict=True):
            place = ""
            if judged is not None:
                interval = judged.interval
                frames = f"{interval.start + first}–{interval.stop + first}"
                place = f" · {self._label(interval)} {frames}"
            yield f"{translate_core_sentence(name)}{place}"

    def _label(self, interval: Interval) -> str:
        try:
            return label_of(interval, self._document.find_chain(interval.chain))
        except KeyError:  # a later step has removed the chain
            return label_without_chain(interval)

    def _go(self, item: QListWidgetItem) -> None:
        target = self.list.row(item)
        if self._document.data is None:
            return
        while self._document.review.position > target:
            self._document.undo()
        while self._document.review.position < target and self._document.review.redo_text:
            self._document.redo()

    def showEvent(self, event: QShowEvent) -> None:
        """Update the list, because the colours may have changed with the theme."""
        self._refresh()
        super().showEvent(event)
