"""Mouse gestures in a plot: drags, clicks, the context menu, zooming and panning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.why_here import peak_near, reason_here, reason_sentence
from inspector.timeline.context_menu import context_menu
from inspector.timeline.drag_escape import DragEscape
from inspector.timeline.layers import DragLabel, Scenery
from inspector.timeline.tau_line import set_tau_at, tau_from_position
from inspector.timeline.time_view import TimeView
from inspector.timeline.visible_range import VisibleRange
from inspector.widgets.labels import escape_tool_tip_text
from inspector.widgets.later import Latest
from inspector.widgets.signed_numbers import interval_angle_text
from twistcore.detection import Interval
from twistcore.detection.interval_offsets import resized_interval
from twistcore.review import Judged

_REACH = 6.0  # distance in pixels at which the mouse grabs an edge or the playhead
_ZOOM = 1.25  # zoom factor per notch of the wheel
_PAN = 0.12  # share of the visible range by which a notch of the wheel pans


class Part(Enum):
    """The part of a plot under the mouse pointer."""

    START = "start"
    STOP = "stop"
    BODY = "body"
    PLAYHEAD = "playhead"
    EMPTY = "empty"


_CURSORS = {Part.EMPTY: Qt.CursorShape.CrossCursor, Part.BODY: Qt.CursorShape.OpenHandCursor}


@dataclass(frozen=True)
class Hit:
    """The part of a plot under the mouse pointer, and the interval to which the part belongs."""

    part: Part
    judged: Judged | None = None


class Gestures:
    """The mouse gestures in all plots, which select, edit and draw intervals and move the playhead.

    While the user drags an edge or draws an interval, the playhead follows the mouse, so the 3D
    view shows that frame. Afterwards, the playhead returns to its previous frame or, if an interval
    was drawn, moves to this interval. Esc cancels a drag.

    Attributes
    ----------
    plots
        A function that takes the key of a plot and returns additional entries for its context menu.
    tau_plot
        The key of the plot that shows τ.
    """

    draws = True  # True if a drag on empty space draws an interval

    def __init__(
        self,
        document: Document,
        scenery: Scenery,
        visible: VisibleRange,
        refresh: Callable[[], None],
        repaint: Callable[[], None],
        parent: QWidget,
    ) -> None:
        """Connect the gestures to a document and its plots.

        Parameters
        ----------
        refresh
            A function that applies pending document changes to the plots, so that the mouse can
            grab only intervals that still exist.
        repaint
            A function that repaints the plots.
        """
        self._document, self._scenery, self._visible = document, scenery, visible
        self._refresh, self._repaint, self._parent = refresh, repaint, parent
        self.plots: Callable[[str], Sequence[tuple[str, Callable[[], None]]]] = lambda _: ()
        self.tau_plot = ""
        self._latest = Latest(parent)
        self._escape = DragEscape(document, self.cancel, parent)
        self._hit = Hit(Part.EMPTY)
        self._origin = 0.0
        self._grabbed: Interval | None = None
        self._frames_set: tuple[int, int] | None = None
        self._drag = 0
        self._band: tuple[int, int] | None = None
        self._home = 0
        self.dragging = False
        document.opened.connect(self._give_up)

    # -- hit test -----------------------------------------------------------------------------

    def hit(self, frame: float, pixel: float) -> Hit:
        """Return the part of the plot at `frame`. `pixel` is the number of frames per pixel.

        The edge of an interval takes precedence over the playhead, because the playhead moves to
        this edge when the interval is selected.
        """
        reach = _REACH * pixel
        near = self._scenery.between(frame - reach, frame + reach)
        best: tuple[float, Hit] | None = None
        for judged in reversed(near):  # the selected interval first
            start, stop = self._scenery.drawn_ends(judged, pixel)
            inside = min(reach, (stop - start) / 3.0)
            for part, edge, inward in ((Part.START, start, 1.0), (Part.STOP, stop, -1.0)):
                depth = (frame - edge) * inward  # positive inside the interval
                if -reach <= depth <= inside and (best is None or abs(depth) < best[0]):
                    best = abs(depth), Hit(part, judged)
            if best is not None and judged.id == self._scenery.selected:
                break
        if best is not None:
            return best[1]
        if abs(frame - self._document.frame) <= reach * 0.7:
            return Hit(Part.PLAYHEAD)
        body = self.interval_at(frame) or next(
            (
                j
                for j in near
                if self._scenery.drawn_ends(j, pixel)[0]
                <= frame
                < self._scenery.drawn_ends(j, pixel)[1]
            ),
            None,
        )
        return Hit(Part.BODY, body) if body else Hit(Part.EMPTY)

    def interval_at(self, frame: float) -> Judged | None:
        """Return the interval at `frame`, or None.

        If there are several, return the selected one or, if none is selected, the shortest one.
        """
        near = self._scenery.between(frame, frame)
        if not near:
            return None
        if near[-1].id == self._scenery.selected:
            return near[-1]
        return min(near, key=lambda j: j.interval.frames)

    # -- dragging -----------------------------------------------------------------------------

    def drag(self, view: TimeView, event: Any, *, pan: bool) -> None:
        """Handle a mouse event of a drag. If `pan` is True, the drag pans in time."""
        if not self._document.frames:
            return
        frame, button = view.frame_at(event.pos()), event.button()
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        if pan or button == Qt.MouseButton.MiddleButton or shift:
            self._visible.pan(view.frame_at(event.lastPos()) - frame)
            return
        if button != Qt.MouseButton.LeftButton:
            return
        if event.isStart():
            self._begin(view.frame_at(event.buttonDownPos()), view.viewPixelSize()[0])
        elif not self.dragging:
            return  # the clip was closed during the drag
        height = event.pos().y()
        self._latest.ask(lambda: self._continue(view.key, frame, height))
        if event.isFinish():
            self._latest.flush()
            moved = abs(frame - self._origin) > _REACH * view.viewPixelSize()[0]
            self._end(self._band if moved else None)

    def cancel(self) -> None:
        """Cancel the current drag, and undo its changes."""
        self._latest.forget()
        self._escape.undo()
        self._document.go_to(self._home)
        self._end(None)

    def _give_up(self) -> None:
        """Stop a drag without undoing its changes. Called when a different clip is opened."""
        self._escape.end()
        self._latest.forget()
        self._hit = Hit(Part.EMPTY)
        self._grabbed = self._band = self._scenery.drag_label = None
        self.dragging = False

    def _begin(self, frame: float, pixel: float) -> None:
        self._refresh()
        self._hit = self.hit(frame, pixel)
        self._origin = frame
        self._frames_set = self._band = None
        self._home = self._document.frame
        self.dragging = True
        self._escape.begin()
        if self._hit.judged is not None:
            self._grabbed = self._hit.judged.interval
            self._frames_set = (self._grabbed.start, self._grabbed.stop)
            self._drag = self._document.begin_drag()
            self._document.select_interval(self._hit.judged.id)

    def _continue(self, key: str, frame: float, height: float) -> None:
        judged, grabbed, part = self._hit.judged, self._grabbed, self._hit.part
        at = min(max(round(frame), 0), self._document.frames - 1)
        if judged is not None and grabbed is not None:
            start, stop = self._frames_of(grabbed, frame)
            self._resize(judged, grabbed, (start, stop))
            at = start if part is Part.START else stop - 1
        elif part is Part.EMPTY and self.draws:
            first = min(max(round(self._origin), 0), self._document.frames - 1)
            start, stop = self._band = min(first, at), max(first, at) + 1
        else:
            start, stop = at, at + 1
        if part is not Part.BODY:
            self._document.go_to(at)
        place = frame if part in (Part.BODY, Part.EMPTY) else at
        words = self._words(start, stop) if part in (Part.BODY, Part.EMPTY) else self._words(at)
        self._scenery.drag_label = DragLabel(key, place, height, words, self._band)
        self._repaint()

    def _words(self, start: int, stop: int = 0) -> str:
        first = self._document.first_frame
        if stop - start < 2:
            return tr("frame {frame}", frame=start + first)
        stop, n = stop + first, stop - start
        return tr("frames {first}–{last} ({n})", first=start + first, last=stop, n=n)

    def _end(self, drawn: tuple[int, int] | None) -> None:
        """End a drag. `drawn` is the frame range [start, stop) of a new interval, or None."""
        self._escape.end()
        if self._hit.part is not Part.PLAYHEAD and (self._grabbed or self.draws):
            # This is called before the drag ends, so the plots do not scroll.
            self._document.go_to(self._home)
        self._grabbed = self._band = self._scenery.drag_label = None
        self.dragging = False
        self._repaint()
        data, chain = self._document.data, self._document.chain
        if drawn is not None and data is not None:
            self._document.insert_interval(drawn[0], data.proposed_over(chain, *drawn))
            if (judged := self._document.interval) is not None:
                self._document.go_to(judged.interval.seen_at)

    def _resize(self, judged: Judged, grabbed: Interval, frames: tuple[int, int]) -> None:
        if frames == self._frames_set:
            return
        self._frames_set = frames
        if self._hit.part is Part.BODY:
            new = grabbed.with_offset(frames[0], grabbed.offset)
        else:  # resize the original, so that dragging back restores it
            new = resized_interval(grabbed, *frames)
        self._document.edit(judged.id, new, self._drag)

    def _frames_of(self, grabbed: Interval, frame: float) -> tuple[int, int]:
        by = round(frame - self._origin)
        last = self._document.frames
        if self._hit.part is Part.START:
            return int(np.clip(grabbed.start + by, 0, grabbed.stop - 1)), grabbed.stop
        if self._hit.part is Part.STOP:
            return grabbed.start, int(np.clip(grabbed.stop + by, grabbed.start + 1, last))
        by = int(np.clip(by, -grabbed.start, last - grabbed.stop))
        return grabbed.start + by, grabbed.stop + by

    # -- clicks, wheel and hover --------------------------------------------------------------

    def click(self, view: TimeView, event: Any) -> None:
        """Select an interval or move the playhead.

        In the strength plot, a click can also explain a peak or set τ.
        """
        if not self._document.frames:
            return
        self._refresh()
        place = view.mapToView(event.pos())
        frame = float(place.x())
        if event.button() == Qt.MouseButton.RightButton:
            self.open_menu(view.key, frame, place.y(), event.screenPos().toPoint())
        elif event.double() and view.key == self.tau_plot:
            set_tau_at(self._document, place.y())
        elif judged := self.hit(frame, view.viewPixelSize()[0]).judged:
            self._document.select_interval(judged.id)
        elif view.key == self.tau_plot and self._ask_peak(frame, view.viewPixelSize()[0]):
            return
        else:
            self._document.go_to(round(frame))
            self._visible.deselect_hidden()

    def _ask_peak(self, frame: float, pixel: float) -> bool:
        """Move to a nearby peak above τ that is in no interval, and explain why it is in none.

        Return False if there is no such peak.
        """
        near = peak_near(self._document, round(frame), max(_REACH * pixel, 0.5))
        if near is None or (reason := reason_here(self._document, near)) is None:
            return False
        self._document.go_to(near)
        self._document.answered.emit(reason_sentence(self._document, reason))
        return True

    def open_menu(self, key: str, frame: float, place: float, position: QPoint) -> QMenu:
        """Open and return the context menu for a point in a plot, without waiting for a choice."""
        judged = self.interval_at(frame)
        if judged is not None:
            self._document.select_interval(judged.id)
        degrees = tau_from_position(place) if key == self.tau_plot else 0.0
        menu = context_menu(
            self._parent, self._document, self._visible, frame, degrees, judged, self.plots(key)
        )
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._document.opened.connect(menu.close)  # its position belongs to the clip that was open
        menu.popup(position)
        return menu

    def wheel(self, frame: float, notches: float, *, pan: bool) -> None:
        """Zoom in time around `frame`, or pan. `notches` is the rotation of the mouse wheel."""
        first, last = self._visible.ends
        if pan:
            self._visible.pan(-notches * _PAN * (last - first))
        else:
            scale = _ZOOM**-notches
            self._visible.show(frame - (frame - first) * scale, frame + (last - frame) * scale)

    def hover(self, view: TimeView, event: Any) -> None:
        """Set the cursor and the tool tip for the part under the mouse pointer."""
        if not self._document.frames:
            return
        hit = self.hit(view.frame_at(event.pos()), view.viewPixelSize()[0])
        if hit.part is Part.EMPTY and not self.draws:
            view.unsetCursor()
        else:
            view.setCursor(_CURSORS.get(hit.part, Qt.CursorShape.SizeHorCursor))
        view.setToolTip(escape_tool_tip_text(self._hint(hit.judged, view.frame_at(event.pos()))))

    def _hint(self, judged: Judged | None, frame: float) -> str:
        """Return the tool tip for an interval or, if it is None, for a frame between intervals."""
        if judged is not None:
            i = judged.interval
            kind, decision = (
                translate_core_sentence(i.kind),
                translate_core_sentence(judged.decision),
            )
            lines = [
                f"{i.chain}  {self._words(i.start, i.stop)}",
                f"{kind}, {interval_angle_text(i.kind, i.size)}, {decision}",
            ]
            if not judged.supported:
                lines.append(
                    tr(
                        "The detector no longer finds this interval at the current τ. The "
                        "interval is kept because you decided on it or edited it."
                    )
                )
            if judged.note:
                lines.append(judged.note)
            return "\n".join(lines)
        spans = self._scenery.unreliable
        if np.any((spans[:, 0] - 0.5 <= frame) & (frame < spans[:, 1] - 0.5)):
            return self._scenery.unreliable_hint
        return ""
