"""The legend above the image: the meaning of the colours, and the selected limb's offset."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from inspector.language import tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.viewport.bone_colours import Role
from inspector.viewport.scene import Scene
from inspector.widgets.labels import bold, coloured_rich_text
from inspector.widgets.signed_numbers import format_number, format_signed_number
from inspector.widgets.theme import Theme
from twistcore.detection import Interval
from twistcore.detection.error_label import error_label
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb

_NO_CIRCLE = tr("the limb is straight or folded, so it has no swivel angle")


def frame_legend(
    document: Document,
    scene: Scene,
    theme: Theme,
    chain: Chain | None,
    fault: Interval | None,
    roles: Collection[int] = (),
    tracked: bool = False,
) -> str:
    """Return the legend of the current frame as rich text.

    Parameters
    ----------
    chain
        The selected chain or limb, or None.
    fault
        The selected interval if it is an error that cannot be corrected, or None.
    roles
        The roles of the bones in the image.
    tracked
        True if the corrected clip is also tracked.
    """
    degrees = 0.0
    if chain is not None:
        degrees = float(np.degrees(document.offset(chain.name)[document.frame]))
    of_body = fault is not None and fault.kind.info.whole_body
    swivel = isinstance(chain, Limb) and not of_body
    title = translate_core_sentence(chain.label) if chain is not None else ""
    if chain is not None and fault is not None:
        title = (
            translate_core_sentence(error_label(fault, chain)) if of_body else fault.joint or title
        )
    text = legend_text(
        theme,
        "split" if scene.split else document.show,
        title,
        degrees,
        tracked=tracked and (scene.accompanied or scene.split or document.show == Show.AFTER),
        swivel=swivel,
        fault=_fault_words(fault) if fault else "",
        chosen=Role.CHOSEN in roles,
        suggested=Role.SUGGESTED in roles,
    )
    if swivel and not scene.circled:
        text += coloured_rich_text(f"&nbsp;&nbsp; {_NO_CIRCLE}", theme.soft)
    return text


def legend_text(
    theme: Theme,
    show: str,
    chain: str,
    degrees: float,
    *,
    tracked: bool,
    swivel: bool = False,
    fault: str = "",
    chosen: bool = False,
    suggested: bool = False,
) -> str:
    """Return the legend as rich text: the colours before and after correction, and the offset.

    Parameters
    ----------
    show
        One of document.Show, or 'split' for two images.
    chain
        The name of the chain, or ''.
    degrees
        The offset of the chain in degrees.
    tracked
        True if there is a third figure or if the corrected figure is tracked.
    swivel
        True if the offset is a swivel angle.
    fault
        A text about an error that cannot be corrected, shown instead of the offset.
    chosen
        True if a limb is drawn in the colour of the selection.
    suggested
        True if the corrected image contains undecided corrections.
    """
    before = _key("□" if show == Show.BOTH else "■", theme.before, tr("before"))
    after = _key("■", theme.after, tr("after"))
    if tracked and show != Show.BOTH:
        after += f"&nbsp;{coloured_rich_text(_unbroken(tr('→ tracked')), theme.tracked)}"
    if show == "split":
        text = f"◧&nbsp;{before}&nbsp;&nbsp; ◨&nbsp;{after}"
    else:
        both = f"{before}&nbsp;&nbsp; {after}"
        text = {Show.BEFORE: before, Show.AFTER: after, Show.BOTH: both}[Show(show)]
    if suggested and show != Show.BEFORE:
        text += f"&nbsp;&nbsp; {_key('▥', theme.after, tr('suggested'))}"
    if chosen:
        text += f"&nbsp;&nbsp; {_key('■', theme.accent, tr('selected'))}"
    if chain:
        colour = theme.before if fault or abs(degrees) >= 0.05 else theme.soft
        angle = f"{format_signed_number(degrees)}°"
        words = (
            tr("swivel off by {angle}", angle=angle)
            if swivel
            else tr("off by {angle}", angle=angle)
        )
        text += f"&nbsp;&nbsp;&nbsp; {_unbroken(bold(chain))}&nbsp; "
        text += coloured_rich_text(_unbroken(fault or words), colour)
    if tracked and show == Show.BOTH:
        text += f"&nbsp;&nbsp;&nbsp; {_key('┄', theme.tracked, tr('tracked'))}"
    return text


def trails_text(apart: float) -> str:
    """Return rich text with the distance between the trails before and after correction.

    `apart` is this distance in figure heights.
    """
    same = "&lt; 0.001 %" if apart < 1e-5 else f"{100.0 * apart:.3f} %"
    return "<br>" + tr("hand and foot paths differ by {share} of the body height", share=same)


def _fault_words(interval: Interval) -> str:
    """Return the legend text for an interval that cannot be corrected."""
    degrees = float(np.degrees(interval.size))
    fields = {
        "size": f"{format_number(degrees)}°",
        "angle": f"{format_signed_number(degrees)}°",
        "joint": interval.joint,
    }
    kind = interval.kind
    return translate_core_sentence(kind.info.legend.format(**fields) if kind.info.legend else kind)


def _unbroken(text: str) -> str:
    return text.replace(" ", "&nbsp;")


def _key(mark: str, colour: str, text: str) -> str:
    return f"{coloured_rich_text(mark, colour)}&nbsp;{text}"
