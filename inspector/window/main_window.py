"""The main window with its docks, menus and layout."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QMenu, QWidget

from inspector.feature import Area
from inspector.language import tr
from inspector.panels.start_page import StartPage
from inspector.session.document import Document
from inspector.session.exporter import Exporter
from inspector.session.player import Player
from inspector.session.settings import Settings
from inspector.timeline.timeline import Timeline
from inspector.widgets.background import Task
from inspector.widgets.review_keys import ReviewKeys
from inspector.window.action_table import MENUS, connect_rows
from inspector.window.actions import build_actions, enable_available_actions
from inspector.window.centre import Centre
from inspector.window.features import FEATURES, panels
from inspector.window.file_actions import FileActions
from inspector.window.parts import Parts
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_signs import ReviewSigns
from inspector.window.settings_keeper import KeptLooks, SettingsKeeper
from inspector.window.toolbar import ToolBar
from inspector.window.usual_layout import UsualLayout
from twistcore.files.encoding import escape_control_characters


class MainWindow(Parts):
    """The main window of the program."""

    def __init__(self, settings: Settings, settings_file: Path | None) -> None:
        """Build the window.

        The settings are saved in `settings_file`, or not at all if `settings_file` is None.
        """
        super().__init__()
        self.settings = settings
        # True if the window closes without asking; the journal has the decisions
        self._without_asking = False
        self.document = Document(self)
        self.exporter = Exporter(self.document, self)
        self.player = Player(self.document, self)
        self.setAcceptDrops(True)
        self.setWindowTitle("Twist Inspector")
        self.setDockOptions(self.dockOptions() | QMainWindow.DockOption.AllowNestedDocks)
        self.actions_by_id, self._menus = build_actions(MENUS, self, self.menuBar())
        ticks = [tick for feature in FEATURES for tick in feature.settings]
        self.program = ProgramActions(
            self.document, settings, MENUS, self.actions_by_id, ticks, self
        )
        self.colours = self.program.colours
        self.program.colour()  # before there are widgets whose style would change
        self.program.take_settings()
        self.docks, self.built = {}, {}
        self._build_views()
        self._build_docks()
        self._build_bars()
        self._build_features()
        self._connect()
        self._restore()
        self.keys = ReviewKeys(self, self._keyboard_home)
        complain = partial(self.bar.show_message, wrong=True)
        self._kept_settings = SettingsKeeper(
            settings, settings_file, self._geometry_and_layout, complain, self
        )
        # Save at once, because after a crash the next start must know which clip was open.
        self.document.opened.connect(self._kept_settings.write)

    # -- building -----------------------------------------------------------------------------

    def _build_views(self) -> None:
        centre = Centre(self)
        self.bar, self.viewport = centre.bar, centre.viewport
        self.transport, self.reviewer_line = centre.transport, centre.reviewer_line
        self.timeline = Timeline(self.document, self.colours)
        for feature in FEATURES:
            self.built[feature.name] = feature.build(self)

    def _build_docks(self) -> None:
        # The right column is as high as the window, so the curves are only below the figure.
        self.setCorner(Qt.Corner.BottomRightCorner, Area.RightDockWidgetArea)
        self._dock("curves", tr("Curves"), self.timeline, Area.BottomDockWidgetArea)
        for feature, panel in panels():
            content = panel.content(self.part(feature))
            dock = self._dock(panel.name, panel.title, content, panel.area)
            if panel.tab:
                self.tabifyDockWidget(self.docks["intervals"], dock)
            if not panel.shown:
                dock.hide()
        self.docks["intervals"].raise_()

    def _dock(self, name: str, title: str, content: QWidget, area: Area) -> QDockWidget:
        dock = self.docks[name] = QDockWidget(title, self)
        dock.setObjectName(name)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _build_bars(self) -> None:
        self.tools = ToolBar(MENUS, self.actions_by_id, self.colours)
        self.addToolBar(self.tools)
        view = self._menus["View"]
        view.addSeparator()
        for dock in self.docks.values():
            view.addAction(dock.toggleViewAction())
        self.recent_menu = QMenu(tr("Recent"), self)
        self._menus["File"].insertMenu(self.actions_by_id["save_session"], self.recent_menu)
        self.signs = ReviewSigns(self)

    def _build_features(self) -> None:
        """Connect the features, and create the objects that carry out the window's actions."""
        self.presentation = Presentation(self, self.docks, self.viewport, self.timeline)
        for part in self.built.values():
            part.connect(self)
        self.files = FileActions(
            window=self,
            tell_saved=self.signs.show,
            recent_menu=self.recent_menu,
            begin=self.review_actions.begin,
        )
        connect_rows(self)
        complaint = "" if self.viewport.view is not None else self.viewport.overlays.notice.text()
        self.start_page = StartPage(
            self.viewport, self.actions_by_id, self.open_path, complaint, self.colours
        )
        self._enable_actions()

    def _connect(self) -> None:
        document, actions = self.document, self.actions_by_id
        document.message.connect(self.bar.show_message)
        document.question.connect(self.bar.ask)
        document.withdrawn.connect(self.bar.clear)
        document.message.connect(self.statusBar().clearMessage)
        document.opened.connect(self.signs.show)
        document.opened.connect(self._enable_actions)
        document.opener.read.connect(self.start_page.picture.show_look)
        document.opener.began.connect(self.start_page.picture.end)
        document.opener.over.connect(self.start_page.picture.end)
        document.intervals_changed.connect(self.signs.show)
        self.presentation.escaped.connect(lambda: actions["presentation"].setChecked(False))
        self.timeline.toggles["other"].toggled.connect(actions["both_detectors"].setChecked)
        QApplication.styleHints().colorSchemeChanged.connect(self._scheme_changed)
        self.signs.show()

    def _restore(self) -> None:
        tall = [panel.name for _, panel in panels() if panel.tall]
        self.usual_layout = UsualLayout(
            self, self.docks, self.transport, (self.intervals, self.detail), tall
        )
        self.usual_layout.restore(self.settings.geometry, self.settings.layout)
        for panel in (panel for _, panel in panels() if panel.empty_at_start):
            self.docks[panel.name].hide()
        for chosen in (f"theme_{self.settings.theme}", f"order_{self.settings.order}"):
            self.actions_by_id[chosen].setChecked(True)
        self.actions_by_id["zoom_each"].setChecked(self.settings.zoom_to_interval)
        self.actions_by_id["group_errors"].setChecked(self.settings.group_errors)
        self._kept_looks = KeptLooks(
            self.document, self.settings, self.actions_by_id, self._is_guided, self
        )

    def _is_guided(self) -> bool:
        """Return True if the program, not the user, decides how the figure is drawn.

        This is the case in a lesson, in an exercise and in the teaching tab.
        """
        return self.document.borrowed is not None or self.viewport.drawing.guest is not None

    def _keyboard_home(self) -> QWidget:
        table = self.intervals.table
        return self if table.visibleRegion().isEmpty() else table

    def _geometry_and_layout(self) -> tuple[str, str] | None:
        """Return the window's geometry and layout to save, or None during a presentation."""
        if self.actions_by_id["presentation"].isChecked():
            return None
        return self.usual_layout.kept(self.settings.geometry)

    # -- requests -----------------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip, a session or a folder."""
        self.files.open_path(path)

    def save_quietly(self) -> bool:
        """Save the review without a message. Return True if the session is on disk."""
        return self.files.save_quietly()

    def _scheme_changed(self) -> None:  # a method, which Qt disconnects when the window is deleted
        self.program.colour()

    def close_without_asking(self) -> None:
        """Close the window without asking. Unsaved decisions stay in the journal."""
        self._without_asking = True
        self.close()

    # -- following the document ---------------------------------------------------------------

    def _enable_actions(self) -> None:
        """Enable the actions that are possible now, and show the start page if no clip is open."""
        is_open, has_figure = self.document.data is not None, self.viewport.view is not None
        enable_available_actions(MENUS, self.actions_by_id, is_open=is_open, has_figure=has_figure)
        self.start_page.setVisible(not is_open)
        self.start_page.show_recent(*self.files.recent())

    # -- Qt events ----------------------------------------------------------------------------

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Resize the panels together with the window unless the user has set their sizes."""
        super().resizeEvent(event)
        self.usual_layout.follow()

    def showEvent(self, event: QShowEvent) -> None:
        """Show floating panels after the main window, so that it does not cover them."""
        super().showEvent(event)
        self.usual_layout.window_shown()

    def changeEvent(self, event: QEvent) -> None:
        """When the window becomes active, check whether the clip or its lock has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.ActivationChange and self.isActiveWindow():
            self.document.recovery.check_lock_and_clip()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept a drag if it contains files."""
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first dropped file. A dropped video is shown next to the open clip."""
        files = [u.toLocalFile() for u in event.mimeData().urls() if u.isLocalFile()]
        if files:
            event.acceptProposedAction()
            path = Path(files[0])
            if not any(part.take(path) for part in self.built.values()):
                self.open_path(path)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Close the window, unless the user cancels.

        Finish a running export, ask about unsaved decisions, save the layout and close the views.
        """
        self.files.closing = True
        if not self.exporter.finish() or not self.files.may_close(ask=not self._without_asking):
            self.files.closing = False
            event.ignore()
            return
        for task in self.findChildren(Task):
            task.cancel()
        self.player.pause()
        self.program.close_guide()
        self.actions_by_id["presentation"].setChecked(False)  # save the normal layout
        self.document.close_clip()
        for part in self.built.values():
            part.close()
        if trouble := self._kept_settings.end():  # no window is left to show it: print it
            print(escape_control_characters(trouble), file=sys.stderr)
        self.viewport.close()
        super().closeEvent(event)
