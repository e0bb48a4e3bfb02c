"""The symbols of [Choi26 §3], in one table: panel, 3D view and plots read it."""

from __future__ import annotations

from dataclasses import dataclass

from inspector.language import tr
from inspector.widgets.theme import Theme


@dataclass(frozen=True)
class Symbol:
    """A quantity: its TeX, the family that gives its colour, what it means in words.

    curves: plots of the time line and the first letter of their curves that show it.
    """

    tex: str
    family: str
    words: str
    curves: tuple[tuple[str, str], ...] = ()


SYMBOLS = {
    "a": Symbol(r"\mathbf{a}", "bone", tr("the bone P→C in P's own coordinates: the twist axis")),
    "q": Symbol(r"q_P", "bone", tr("P's rotation, local")),
    "w": Symbol(r"\mathbf{w}", "swing", tr("where q turns the bone to")),
    "n": Symbol(r"\mathbf{n}", "swing", tr("the axis of the swing, square to a and w")),
    "alpha": Symbol(r"\alpha", "swing", tr("the swing's angle: the smallest turn from a to w")),
    "swing": Symbol(r"q_\mathrm{swing}", "swing", tr("points the bone, without rolling it")),
    "twist": Symbol(r"q_\mathrm{twist}", "twist", tr("rolls about the bone, and only that")),
    "theta_p": Symbol(r"\theta_p", "twist", tr("the twist of P about its bone"), (("theta", "p"),)),
    "dtheta_p": Symbol(
        r"\Delta\theta_p", "twist", tr("its change since the frame before"), (("delta", "p"),)
    ),
    "v": Symbol(r"\mathbf{v}", "azimuth", tr("C→G, seen in P's coordinates")),
    "across": Symbol(
        r"\mathbf{v}_\perp",
        "azimuth",
        tr("the part of v across the bone: its direction is the azimuth"),
        (("theta", "c"),),
    ),
    "dtheta_c": Symbol(
        r"\Delta\theta_c",
        "azimuth",
        tr("how far v⊥ has turned about the bone since the frame before"),
        (("delta", "c"),),
    ),
    "product": Symbol(
        r"\Delta\theta_p\,\Delta\theta_c",
        "error",
        tr("below zero: parent and child twist against each other"),
        (("delta", ""),),
    ),
    "m": Symbol(
        "m", "error", tr("the smaller of the two, where they are opposed"), (("strength", "m"),)
    ),
    "err": Symbol(
        r"\mathrm{err}(t)", "error", tr("what an event adds to the offset: m, with the sign of Δθp")
    ),
    "offset": Symbol(
        r"\mathrm{offset}(t)",
        "error",
        tr(
            "the paper's running sum of err since the first frame, with the τ of this chain; it "
            "need not come back to zero, as every natural event stays in it"
        ),
        (("offset", ""),),
    ),
    "taken": Symbol(
        r"\delta",
        "twist",
        tr(
            "what is taken off: the share that Apply sets of offset(t), or of the selected "
            "interval's own offset where one is selected at this frame and the frame is not altered"
        ),
        (("offset", ""),),
    ),
    "parent_after": Symbol(r"q\mathrm{ʹ}_P", "twist", tr("P with δ taken off its twist")),
    "child_after": Symbol(
        r"q\mathrm{ʹ}_C", "azimuth", tr("C turned back, so that it stands as it stood")
    ),
    "check": Symbol(
        r"q_P\,q_C", "bone", tr("C's rotation as P's parent sees it: it must not change")
    ),
}

MARKS = SYMBOLS | {  # of Fig. 2, in 3D only
    "P": Symbol("P", "bone", tr("the parent, whose twist is taken apart")),
    "C": Symbol("C", "bone", tr("the child")),
    "G": Symbol("G", "bone", tr("the grandchild, which shows where the child has turned to")),
    "real": Symbol(r"G_\mathrm{real}", "azimuth", tr("where G is")),
    "ideal": Symbol(r"G_\mathrm{ideal}", "error", tr("where G would be without the twist error")),
}

_COLOURS = {  # of the families, light and dark; each at least 4.5:1 on every paper of the theme
    "swing": ("#00696b", "#4ecdc4"),
    "twist": ("#a3195b", "#ff86b8"),
    "azimuth": ("#6b5300", "#e6c44c"),
}


def colour(family: str, theme: Theme) -> str:
    """A family's colour as '#rrggbb'."""
    if family == "bone":
        return theme.text
    if family == "error":
        return theme.tau
    return _COLOURS[family][1 if theme.dark else 0]
