"""The comparison with a second review of the clip, as a feature of the window."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    HostWindow,
    MenuRows,
)
from inspector.language import tr, translate_core_sentence
from inspector.reviewers.comparison_panel import ComparisonPanel
from inspector.reviewers.second_review import SecondReview
from inspector.session.session_files import SESSION_PATTERNS
from inspector.widgets.background import OneTask
from inspector.widgets.building import bring_to_front
from inspector.widgets.file_dialog import ask_files
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.review import Judged, Session, read_session
from twistcore.review.agreement import check_same_clip
from twistcore.review.replay import session_chains


class Reviewers(FeatureParts):
    """The comparison feature: the panel of differences, and the actions that settle them."""

    def __init__(self, window: HostWindow) -> None:
        self.comparison = ComparisonPanel(window.document, window.colours, window.actions_by_id)

    def connect(self, window: HostWindow) -> None:
        """Connect the panel to the window.

        The panel is hidden when a different clip is opened. The timeline zooms to a difference when
        it is selected.
        """
        self._window, self._dock = window, window.docks["comparison"]
        self._reading = OneTask(self.comparison)
        window.document.opened.connect(self._end)
        self.comparison.shown.connect(self._zoom)

    def choose(self) -> None:
        """Let the user choose the session file of a second review, and compare it."""
        document = self._window.document
        pattern = tr("Sessions") + f" ({SESSION_PATTERNS});;" + tr("All files") + " (*)"
        ask_files(
            self._window,
            tr("Compare with another review"),
            pattern,
            lambda paths: self.compare_with(paths[0]),
            folder=document.folder,
        )

    def compare_with(self, path: Path) -> None:
        """Compare the review in a session file with the open review."""
        if (data := self._window.document.data) is not None:
            clip = data.clip
            then = partial(self._compare, path)
            self._reading.run(lambda _: _read(path, clip), then, self._failed)

    def _compare(self, path: Path, session: Session) -> None:
        document = self._window.document
        if document.data is None:
            return
        try:
            check_same_clip(document.data.clip.sha256, session.sha256)
        except TwistError as error:
            document.message.emit(f"{path.name}: {translate_core_sentence(error)}", True)
            return
        self.comparison.compare(SecondReview(session, document.intervals))
        bring_to_front(self._dock)
        if self.comparison.rows:
            self.comparison.step()

    def _failed(self, error: Exception) -> None:
        self._window.document.message.emit(translate_core_sentence(error), True)

    def _zoom(self, judged: Judged) -> None:
        if self._window.settings.zoom_to_interval:
            self._window.timeline.visible.zoom_to_interval(judged)

    def _end(self) -> None:
        """Close the comparison. Called when a different clip is opened."""
        self._reading.cancel()
        self.comparison.compare(None)
        self._dock.hide()

    def close(self) -> None:
        """Cancel the reading of a session. Called when the window is closed."""
        self._reading.cancel()


def _read(path: Path, clip: Clip) -> Session:
    """Read a session file.

    Raises TwistError if the file is damaged, or if it belongs to this clip but its contents do not
    match the clip.
    """
    session = read_session(path)
    if session.sha256 == clip.sha256:
        session_chains(session, clip)
    return session


# fmt: off
_FILE: tuple[ActionRow[Reviewers] | None, ...] = (
    ActionSpec("compare_reviews", tr("Compare with another review…"), (),
               tr(
                   "List the differences between your review and another reviewer's session "
                   "for this clip"),
               needs="clip", do=lambda p: p.choose()),
)
_EDIT: tuple[ActionRow[Reviewers] | None, ...] = (
    None,
    ActionSpec("keep_mine", tr("Difference: keep my decision"), ("Shift+M",),
               tr("Confirm your decision on the selected difference"), verdict=True,
               do=lambda p: p.comparison.keep_mine()),
    ActionSpec("take_theirs", tr("Difference: take their decision"), ("Shift+T",),
               tr("Use the other reviewer's decision and correction"), verdict=True,
               do=lambda p: p.comparison.take_theirs()),
    ActionSpec("take_undecided", tr("Take their decisions on my undecided intervals"), (),
               tr(
                   "Adopt the other reviewer's decisions on all intervals that you have not "
                   "decided on, under that reviewer's name"),
               do=lambda p: p.comparison.take_undecided()),
)
_GO: tuple[ActionRow[Reviewers] | None, ...] = (
    ActionSpec("next_difference", tr("Next difference between reviews"), ("X",),
               tr("Go to the next difference that is not settled"),
               do=lambda p: p.comparison.step()),
)
# fmt: on

feature = Feature(
    "reviewers",
    Reviewers,
    rows=(
        MenuRows("File", _FILE, after="save_session_as"),
        MenuRows("Edit", _EDIT, after="accept_confident"),
        MenuRows("Go", _GO, after="previous_of_all"),
    ),
    panels=(
        DockPanel(
            "comparison",
            tr("Compare"),
            Area.RightDockWidgetArea,
            lambda p: p.comparison,
            shown=False,
            empty_at_start=True,
            tab=True,
        ),
    ),
)
