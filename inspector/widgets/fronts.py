"""Bringing a part of the window, or a window of its own, before a person's eyes."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget


def bring_to_front(widget: QWidget) -> None:
    """Show it, and before what lies over it: a dock comes before the other tabs of its place."""
    widget.show()
    widget.raise_()
