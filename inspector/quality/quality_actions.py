"""What the actions of quality do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

from inspector.quality.quality_panel import QualityPanel
from inspector.session.document import Document
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import Theme


class QualityActions(QMainWindow):
    """The quality tab and tracking."""

    document: Document
    viewport: Viewport
    theme: Theme
    actions_by_id: Mapping[str, QAction]

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        raise NotImplementedError

    def _build_quality(self, beside: QDockWidget) -> None:
        """The tab, behind another one."""
        self.quality = QualityPanel(self.document, self.theme, self.actions_by_id)
        self.quality_dock = self._dock(
            "Quality", self.quality, Qt.DockWidgetArea.RightDockWidgetArea
        )
        self.tabifyDockWidget(beside, self.quality_dock)
        self.quality_dock.visibilityChanged.connect(self.quality.set_seen)
        self.viewport.accompany(self.quality.tracked)

    def show_quality(self) -> None:
        """Bring the quality tab to the front."""
        self.quality_dock.show()
        self.quality_dock.raise_()

    def track_joints(self) -> None:
        """Track the selected joints."""
        self.quality.track()

    def cancel_tracking(self) -> None:
        """Give up what is under way."""
        self.quality.tracked.cancel()

    def stop_tracking(self) -> None:
        """Track nothing; undo takes it back."""
        self.quality.stop_tracking()
