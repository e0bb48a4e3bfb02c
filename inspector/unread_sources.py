"""PySide reads the source of every module that is imported, to see whether it is named there.

It needs that for `from __feature__ import`, which nothing here has, and it takes a sixth of the
processor time of a start. PySide 6.10 has no setting; where another does it otherwise, nothing
changes.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any


def leave_sources_unread() -> None:
    """Import as without PySide from now on; before PySide6 is imported for the first time."""
    importlib.import_module("shiboken6")  # it brings what reads; PySide6 begins at once
    reader: Any = sys.modules.get("shibokensupport.feature")
    if hasattr(reader, "_mod_uses_pyside"):
        reader._mod_uses_pyside = lambda _module: False
