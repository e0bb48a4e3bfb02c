"""The symbols and equations of [Choi26 §3], in one table: panel, 3D view and plots read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from inspector.teaching.taught_frame import degrees, numbers
from inspector.widgets.signed_numbers import signed
from inspector.widgets.theme import Theme
from twistcore.decomposition import Decomposition


@dataclass(frozen=True)
class Symbol:
    """A quantity: its TeX, the family that gives its colour, what it means in words.

    curves: plots of the time line and the first letter of their curves that show it.
    """

    tex: str
    family: str
    words: str
    curves: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Equation:
    """symbol = right, its number in the paper, and its value from the core's quantities.

    corrected: what the printed equation has otherwise, '' where it stands as printed; shown: the
    value in words, else the quantity of the symbol's name is shown.
    """

    symbol: str
    right: str
    number: str
    corrected: str = ""
    shown: Callable[[Decomposition], str] | None = None

    def value(self, quantities: Decomposition) -> str:
        """As a label shows it."""
        if self.shown is not None:
            return self.shown(quantities)
        value = getattr(quantities, self.symbol)
        return numbers(value) if isinstance(value, np.ndarray) else degrees(value)


SYMBOLS = {
    "a": Symbol(r"\mathbf{a}", "bone", "the bone P→C in P's own coordinates: the twist axis"),
    "q": Symbol(r"q_P", "bone", "P's rotation, local"),
    "w": Symbol(r"\mathbf{w}", "swing", "where q turns the bone to"),
    "n": Symbol(r"\mathbf{n}", "swing", "the axis of the swing, square to a and w"),
    "alpha": Symbol(r"\alpha", "swing", "the swing's angle: the smallest turn from a to w"),
    "swing": Symbol(r"q_\mathrm{swing}", "swing", "points the bone, without rolling it"),
    "twist": Symbol(r"q_\mathrm{twist}", "twist", "rolls about the bone, and only that"),
    "theta_p": Symbol(r"\theta_p", "twist", "the twist of P about its bone", (("theta", "p"),)),
    "dtheta_p": Symbol(
        r"\Delta\theta_p", "twist", "its change since the frame before", (("delta", "p"),)
    ),
    "v": Symbol(r"\mathbf{v}", "azimuth", "C→G, seen in P's coordinates"),
    "across": Symbol(
        r"\mathbf{v}_\perp",
        "azimuth",
        "the part of v across the bone: its direction is the azimuth",
        (("theta", "c"),),
    ),
    "dtheta_c": Symbol(
        r"\Delta\theta_c",
        "azimuth",
        "how far v⊥ has turned about the bone since the frame before",
        (("delta", "c"),),
    ),
    "product": Symbol(
        r"\Delta\theta_p\,\Delta\theta_c",
        "error",
        "below zero: parent and child twist against each other",
        (("delta", ""),),
    ),
    "m": Symbol(
        "m", "error", "the smaller of the two, where they are opposed", (("strength", "m"),)
    ),
}

MARKS = SYMBOLS | {  # of Fig. 2, in 3D only
    "P": Symbol("P", "bone", "the parent, whose twist is taken apart"),
    "C": Symbol("C", "bone", "the child"),
    "G": Symbol("G", "bone", "the grandchild, which shows where the child has turned to"),
    "real": Symbol(r"G_\mathrm{real}", "azimuth", "where G is"),
    "ideal": Symbol(r"G_\mathrm{ideal}", "error", "where G would be without the twist error"),
}

SECTIONS: dict[str, tuple[Equation, ...]] = {
    "Parent: swing and twist": (
        Equation("a", r"\mathrm{unit}(P\rightarrow C)", ""),
        Equation("q", r"q_\mathrm{swing}\,q_\mathrm{twist}", "2"),
        Equation("w", r"q_P\,\mathbf{a}\,q_P^{-1}", "3"),
        Equation(
            "n",
            r"(\mathbf{a}\times\mathbf{w})\,/\,\Vert\mathbf{a}\times\mathbf{w}\Vert",
            "4",
            shown=lambda d: numbers(d.n) if d.n.any() else "undefined",
        ),
        Equation(
            "alpha",
            r"\arccos(\mathbf{a}\cdot\mathbf{w})",
            "5",
            shown=lambda d: degrees(d.alpha).removeprefix("+"),
        ),
        Equation("swing", r"\cos\frac{\alpha}{2}+\sin\frac{\alpha}{2}\,\mathbf{n}", "6"),
        Equation(
            "twist",
            r"q_\mathrm{swing}^{-1}\,q_P",
            "7",
            "printed as q_P q_swing⁻¹, which is the twist about w: the same angle, another "
            "quaternion",
        ),
        Equation(
            "theta_p",
            r"2\,\mathrm{atan2}(\vec{q}_\mathrm{twist}\cdot\mathbf{a},\ w_\mathrm{twist})",
            "8",
            "printed with the norm of the vector part, which loses the sign",
        ),
        Equation(
            "dtheta_p",
            r"\mathrm{wrap}(\theta_p(t)-\theta_p(t{-}1))",
            "9",
            "printed without wrapping to (−180°, 180°]",
        ),
    ),
    "Child: azimuth about the same bone": (
        Equation("v", r"\mathbf{R}_C\,\mathbf{b}", "10"),
        Equation("across", r"\mathbf{v}-(\mathbf{v}\cdot\mathbf{a})\,\mathbf{a}", "11"),
        Equation(
            "dtheta_c",
            r"\angle_{\mathbf{a}}(\mathbf{v}_\perp(t{-}1),\ \mathbf{v}_\perp(t))",
            "12",
            "printed as θ_C(t), but it is the change from frame to frame: "
            "atan2((v⊥(t−1) × v⊥(t))·a, v⊥(t−1)·v⊥(t))",
        ),
    ),
    "Do they twist against each other?": (
        Equation("product", r"<0\ ?", "1", shown=lambda d: square_degrees(d.product)),
        Equation(
            "m",
            r"\min(|\Delta\theta_p|,|\Delta\theta_c|)",
            "13",
            shown=lambda d: degrees(d.strength).removeprefix("+"),
        ),
    ),
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


def typeset_texts() -> tuple[str, ...]:
    """Every TeX text that the tab shows."""
    equations = [e.right for rows in SECTIONS.values() for e in rows]
    return tuple(dict.fromkeys([*(mark.tex for mark in MARKS.values()), *equations]))


def square_degrees(product: float) -> str:
    """A product of two angles in radians."""
    return f"{signed(np.degrees(np.degrees(product)), 2)} (°)²"
