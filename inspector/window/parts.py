"""The window attributes that the action table uses."""

from __future__ import annotations

from inspector.feature import HostWindow
from inspector.window.file_actions import FileActions
from inspector.window.presentation import Presentation
from inspector.window.program_actions import ProgramActions
from inspector.window.review_actions import ReviewActions
from inspector.window.usual_layout import UsualLayout


class Parts(HostWindow):
    """The window's attributes that rows of the action table use.

    A row that belongs to a feature uses the attributes of that feature instead.
    """

    presentation: Presentation
    usual_layout: UsualLayout
    program: ProgramActions
    files: FileActions
    review_actions: ReviewActions
