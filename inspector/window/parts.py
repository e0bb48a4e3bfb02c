"""The attributes of the window that its own actions use."""

from __future__ import annotations

from inspector.feature import HostWindow
from inspector.window.file_actions import FileActions
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_actions import ReviewActions
from inspector.window.usual_layout import UsualLayout


class Parts(HostWindow):
    """The window as used by the action rows that belong to no feature."""

    presentation: Presentation
    usual_layout: UsualLayout
    program: ProgramActions
    files: FileActions
    review_actions: ReviewActions
