"""Start faster by stopping PySide from reading the source code of each imported module.

PySide reads source code to support `from __feature__ import`, which this program does not use.
Reading takes a sixth of the processor time at startup, and PySide 6.10 has no setting to prevent
it. With other versions of PySide, this module may have no effect.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any


def disable_pyside_source_reading() -> None:
    """Stop PySide from reading source code. Call this before the first import of PySide6."""
    importlib.import_module("shiboken6")  # contains the reader, which PySide6 starts immediately
    reader: Any = sys.modules.get("shibokensupport.feature")
    if hasattr(reader, "_mod_uses_pyside"):
        reader._mod_uses_pyside = lambda _module: False
