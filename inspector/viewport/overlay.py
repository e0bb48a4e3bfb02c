"""Text over the 3D view: the legend in its corner, and what to do when nothing can be shown."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QWidget

from inspector.document import Show
from inspector.theme import Theme

EMPTY = "Open a BVH (Ctrl+O), drop one here, or try the sample"
NO_OPENGL = (
    "The 3D view needs OpenGL 3.2, which this display does not offer.\n"
    "Curves, tables and export work without it."
)


def make_notice(parent: QWidget) -> QLabel:
    """A sentence in the middle of the view."""
    label = QLabel(parent)
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    return label


def make_legend(parent: QWidget) -> QLabel:
    """The small key of colours."""
    label = QLabel(parent)
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    label.hide()
    return label


def legend_text(theme: Theme, show: Show, chain: str, degrees: float) -> str:
    """Rich text: what is before and after, by colour and form, and the chain's offset now."""
    before = _key("■" if show == Show.BEFORE else "□", theme.before, "before")
    after = _key("■", theme.after, "after")
    parts = {Show.BEFORE: before, Show.AFTER: after, Show.BOTH: f"{before}&nbsp;&nbsp; {after}"}
    text = parts[show]
    if chain:
        colour = theme.before if abs(degrees) >= 0.05 else theme.soft
        number = f"{degrees:+.1f}°".replace("-", "−") if abs(degrees) >= 0.05 else "0.0°"
        text += f"&nbsp;&nbsp;&nbsp; <b>{chain}</b>&nbsp; "
        text += f"<span style='color:{colour}'>{number} off</span>"
    return text


def legend_style(theme: Theme) -> str:
    """Style sheet of the legend."""
    return (
        f"background: {theme.raised}; color: {theme.text}; border: 1px solid {theme.line};"
        "border-radius: 4px; padding: 4px 8px;"
    )


def _key(mark: str, colour: str, text: str) -> str:
    return f"<span style='color:{colour}'>{mark}</span>&nbsp;{text}"
