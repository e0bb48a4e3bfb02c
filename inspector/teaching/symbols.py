"""The table of the symbols of [Choi26 §3], used by the teaching tab, the 3D view and the plots."""

from __future__ import annotations

from dataclasses import dataclass

from inspector.language import tr
from inspector.widgets.theme import Theme


@dataclass(frozen=True)
class Symbol:
    """A quantity of the paper.

    Attributes
    ----------
    tex
        The symbol as TeX.
    family
        The family of quantities, which determines the colour.
    words
        The meaning in words.
    curves
        The plotted curves of the quantity, as pairs (key of a plot, beginning of a curve's name).
    """

    tex: str
    family: str
    words: str
    curves: tuple[tuple[str, str], ...] = ()


SYMBOLS = {
    "a": Symbol(r"\mathbf{a}", "bone", tr("the bone P→C in P's own coordinates: the twist axis")),
    "q": Symbol(r"q_P", "bone", tr("P's rotation, local")),
    "w": Symbol(r"\mathbf{w}", "swing", tr("the direction of the bone after the rotation q")),
    "n": Symbol(r"\mathbf{n}", "swing", tr("the axis of the swing, perpendicular to a and w")),
    "alpha": Symbol(
        r"\alpha", "swing", tr("the angle of the swing, the shortest turn from a to w")
    ),
    "swing": Symbol(
        r"q_\mathrm{swing}", "swing", tr("the rotation that points the bone without rolling it")
    ),
    "twist": Symbol(r"q_\mathrm{twist}", "twist", tr("the rotation that only rolls the bone")),
    "theta_p": Symbol(r"\theta_p", "twist", tr("the twist of P about its bone"), (("theta", "p"),)),
    "dtheta_p": Symbol(
        r"\Delta\theta_p",
        "twist",
        tr("the change in θp since the previous frame"),
        (("delta", "p"),),
    ),
    "v": Symbol(r"\mathbf{v}", "azimuth", tr("the bone C→G in P's coordinates")),
    "across": Symbol(
        r"\mathbf{v}_\perp",
        "azimuth",
        tr("the part of v across the bone; its direction is the azimuth θc"),
        (("theta", "c"),),
    ),
    "dtheta_c": Symbol(
        r"\Delta\theta_c",
        "azimuth",
        tr("how far v⊥ has turned about the bone since the previous frame"),
        (("delta", "c"),),
    ),
    "product": Symbol(
        r"\Delta\theta_p\,\Delta\theta_c",
        "error",
        tr(
            "the product of Δθp and Δθc; if it is negative, parent and child twist against "
            "each other"
        ),
        (("delta", ""),),
    ),
    "m": Symbol(
        "m",
        "error",
        tr("the smaller of |Δθp| and |Δθc|, if Δθp and Δθc have opposite signs"),
        (("strength", "m"),),
    ),
    "err": Symbol(
        r"\mathrm{err}(t)",
        "error",
        tr("the change in the offset at a jump: m with the sign of Δθp"),
    ),
    "offset": Symbol(
        r"\mathrm{offset}(t)",
        "error",
        tr(
            "the paper's running sum of err since the first frame, using this chain's τ; natural "
            "events are included, so the sum need not return to zero"
        ),
        (("offset", ""),),
    ),
    "taken": Symbol(
        r"\delta",
        "twist",
        tr(
            "the part of the offset that Apply removes: part of the selected interval's offset in "
            "frames that are not altered, and part of offset(t) in all other frames"
        ),
        (("offset", ""),),
    ),
    "parent_after": Symbol(
        r"q\mathrm{ʹ}_P", "twist", tr("P's rotation after removing δ from its twist")
    ),
    "child_after": Symbol(
        r"q\mathrm{ʹ}_C", "azimuth", tr("C's rotation, turned so that C keeps its orientation")
    ),
    "check": Symbol(
        r"q_P\,q_C", "bone", tr("C's rotation relative to P's parent, which must not change")
    ),
}

MARKS = SYMBOLS | {  # labels of Fig. 2 of the paper, shown only in 3D
    "P": Symbol("P", "bone", tr("the parent, whose rotation is split")),
    "C": Symbol("C", "bone", tr("the child")),
    "G": Symbol("G", "bone", tr("the grandchild, which shows the direction of the child")),
    "real": Symbol(r"G_\mathrm{real}", "azimuth", tr("the actual position of G")),
    "ideal": Symbol(
        r"G_\mathrm{ideal}", "error", tr("the position of G if the child had not counter-rotated")
    ),
}

# Keyed by family: colours in the light and the dark theme, with a contrast of at least 4.5:1
_COLOURS = {
    "swing": ("#00696b", "#4ecdc4"),
    "twist": ("#a3195b", "#ff86b8"),
    "azimuth": ("#6b5300", "#e6c44c"),
}


def symbol_family_colour(family: str, theme: Theme) -> str:
    """Return the colour of a family as '#rrggbb'."""
    if family == "bone":
        return theme.text
    if family == "error":
        return theme.tau
    return _COLOURS[family][1 if theme.dark else 0]
