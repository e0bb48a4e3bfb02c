"""Descriptions of the plots for screen readers."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QObject, QTimer

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.timeline.pane import Pane

_REST_MS = 400  # time without movement of the playhead after which plots are described


class PlotDescriptions(QObject):
    """The accessible names and descriptions of the plots.

    The descriptions are updated when the playhead has stopped.
    """

    def __init__(self, document: Document, panes: Mapping[str, Pane], parent: QObject) -> None:
        """Set the accessible names of the plots. `panes` is keyed by title."""
        super().__init__(parent)
        self._document, self._panes = document, tuple(panes.values())
        for name, pane in panes.items():
            pane.setAccessibleName(name)
        self._rest = QTimer(self, singleShot=True, interval=_REST_MS)
        self._rest.timeout.connect(self.describe)
        for signal in (
            document.opened,
            document.frame_changed,
            document.chain_changed,
            document.intervals_changed,
            document.numbering_changed,
        ):
            signal.connect(lambda *_: self._rest.start())

    def describe(self) -> None:
        """Describe each plot with its chain, the frame and the values in its title."""
        document = self._document
        shown = document.data is not None and bool(document.chain)
        for pane in self._panes:
            pane.setAccessibleDescription(self._words(pane) if shown else "")

    def _words(self, pane: Pane) -> str:
        document = self._document
        title = " ".join("".join(text for text, _ in pane.front.title).split())
        return tr(
            "{chain}, frame {frame}: {values}",
            chain=translate_core_sentence(document.find_chain(document.chain).label),
            frame=document.frame + document.first_frame,
            values=title,
        )
