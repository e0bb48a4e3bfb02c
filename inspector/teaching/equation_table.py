"""A table of the equations of [Choi26 §3], each with a function that formats its value."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from inspector.language import tr, tr_as
from inspector.teaching.symbols import MARKS
from inspector.teaching.taught_frame import (
    FrameNumbers,
    degree_text,
    padded_vector_text,
    reliability_text,
)
from inspector.widgets.signed_numbers import format_number
from twistcore.analysis.decomposition import UNDEFINED, Decomposition, FrameCorrection

NEAR_SWING = 0.10  # if the reliability of θp is smaller, it is shown: a swing beyond 168°
NEAR_STRAIGHT = 0.17  # the same for the azimuth: a limb straighter than 10°
# A larger strength m is not due to the rounding of numbers in a file
LEAST = float(np.radians(0.005))
_UNDEFINED = tr("undefined")
_IF, _ELSE = tr_as("equation", "if"), tr_as("equation", "else")
_SHARE = tr_as("equation", "share")
_NOT_YET = "–"  # shown while the parent's rotation is animated
_STAGED = frozenset(("a", "q", "w", "n", "alpha", "swing", "twist", "theta_p"))


@dataclass(frozen=True)
class Equation:
    """An equation of the form "symbol = right-hand side".

    Attributes
    ----------
    symbol
        The symbol on the left, a key of SYMBOLS.
    right
        The right-hand side as TeX.
    number
        The number of the equation in the paper, or ''.
    corrected
        How the equation differs from its printed form in the paper, or ''.
    shown
        A function that returns the value as text. By default, the value is the quantity named by
        the symbol.
    """

    symbol: str
    right: str
    number: str
    corrected: str = ""
    shown: Callable[[FrameNumbers], str] | None = None

    def value(self, of: FrameNumbers) -> str:
        """Return the value of the left-hand side as text. `of` contains the frame's numbers."""
        if of.staged and self.symbol not in _STAGED:
            return _NOT_YET
        if self.shown is not None:
            return self.shown(of)
        value = getattr(of.frame, self.symbol)
        return padded_vector_text(value) if isinstance(value, np.ndarray) else degree_text(value)


@dataclass(frozen=True)
class Section:
    """A heading and the equations below it.

    Attributes
    ----------
    title
        The text of the heading, with {P}, {C} and {G} for the names of the parent, the child and
        the grandchild.
    """

    title: str
    rows: tuple[Equation, ...]

    @property
    def bare_title(self) -> str:
        """The title without joint names, shown if no chain is selected."""
        return re.sub(r" = \{.\}", "", self.title)


def _of_one_swing(value_of: Callable[[Decomposition], str]) -> Callable[[FrameNumbers], str]:
    """Return a function that calls `value_of`, but returns 'undefined' at a swing of 180°."""
    return lambda of: value_of(of.frame) if of.frame.swing_is_one else _UNDEFINED


def _theta(d: Decomposition) -> str:
    return degree_text(d.theta_p) + _unsure(d.swing_reliability, NEAR_SWING)


def _dtheta_p(of: FrameNumbers) -> str:
    d = of.frame
    if not d.dtheta_p_is_defined:
        return _UNDEFINED
    return degree_text(d.dtheta_p) + _unsure(d.swing_reliability, NEAR_SWING)


def _across(of: FrameNumbers) -> str:
    d = of.frame
    return padded_vector_text(d.across) + (
        tr(", no\u00a0direction") if d.azimuth_reliability <= UNDEFINED else ""
    )


def _dtheta_c(of: FrameNumbers) -> str:
    d = of.frame
    if not d.dtheta_c_is_defined:
        return _UNDEFINED
    return degree_text(d.dtheta_c) + _unsure(d.azimuth_reliability, NEAR_STRAIGHT)


def _opposed(of: FrameNumbers) -> str:
    """Return the product Δθp Δθc as text, stating whether it is negative."""
    if not of.frame.strength_is_defined:
        return _UNDEFINED
    product = float(np.degrees(np.degrees(of.frame.product)))
    size = f"{abs(product):.{2 if abs(product) >= 0.01 else 4}f}"
    sign = "−" if product < 0.0 else "+" if product > 0.0 else ""
    answer = (
        tr("yes")
        if of.frame.strength >= LEAST
        else tr("no, only rounding error")
        if sign == "−"
        else tr("no")
    )
    return f"{answer}: {sign}{size} (°)²"


def _strength(of: FrameNumbers) -> str:
    """Return the strength m as text, stating whether it is at least τ."""
    if not of.frame.strength_is_defined:
        return _UNDEFINED
    m, tau = of.frame.strength, of.correction.tau
    return f"{_unsigned(m)} {'≥' if m >= tau else '<'} τ {format_number(np.degrees(tau))}°"


def _err(of: FrameNumbers) -> str:
    c = of.correction
    return degree_text(c.err) if c.before.strength_is_defined else _UNDEFINED


def _offset(of: FrameNumbers) -> str:
    c = of.correction
    return f"{degree_text(c.offset_before)} {'−' if c.err < 0.0 else '+'} {_unsigned(abs(c.err))}"


def _taken(of: FrameNumbers) -> str:
    c = of.correction
    fields = {"share": format_number(100.0 * c.applied, 0), "whole": degree_text(c.whole)}
    if of.own:
        text = tr(
            "{share} % of the interval’s {whole}: {taken}", **fields, taken=degree_text(c.taken)
        )
    else:
        text = tr("{share} % of {whole}: {taken}", **fields, taken=degree_text(c.taken))
    return text


def _apart(c: FrameCorrection) -> str:
    return tr("{angle}° apart", angle=format_number(np.degrees(c.difference), 3))


def _unsigned(angle: float) -> str:
    return degree_text(angle).removeprefix("+")


def _unsure(reliability: float, near: float) -> str:
    return f" ({reliability_text(reliability)})" if reliability < near else ""


SECTIONS = (
    Section(
        tr("Parent P = {P}: swing and twist"),
        (
            Equation("a", r"\mathrm{unit}(P\rightarrow C)", ""),
            Equation("q", r"q_\mathrm{swing}\,q_\mathrm{twist}", "2"),
            Equation("w", r"q_P\,\mathbf{a}\,q_P^{-1}", "3"),
            Equation(
                "n",
                r"(\mathbf{a}\times\mathbf{w})\,/\,\Vert\mathbf{a}\times\mathbf{w}\Vert",
                "4",
                shown=lambda of: (
                    padded_vector_text(of.frame.n) if of.frame.n_is_defined else _UNDEFINED
                ),
            ),
            Equation(
                "alpha",
                r"\arccos(\mathbf{a}\cdot\mathbf{w})",
                "5",
                shown=lambda of: _unsigned(of.frame.alpha),
            ),
            Equation(
                "swing",
                r"\cos\frac{\alpha}{2}+\sin\frac{\alpha}{2}\,\mathbf{n}",
                "6",
                shown=_of_one_swing(lambda d: padded_vector_text(d.swing)),
            ),
            Equation(
                "twist",
                r"q_\mathrm{swing}^{-1}\,q_P",
                "7",
                tr(
                    "printed as q_P q_swing⁻¹, which is the twist about w: the same angle, but a "
                    "different quaternion"
                ),
                shown=_of_one_swing(lambda d: padded_vector_text(d.twist)),
            ),
            Equation(
                "theta_p",
                r"2\,\mathrm{atan2}(\vec{q}_\mathrm{twist}\cdot\mathbf{a},\ w_\mathrm{twist})",
                "8",
                tr("printed with the norm of the vector part, which loses the sign"),
                shown=_of_one_swing(_theta),
            ),
            Equation(
                "dtheta_p",
                r"\mathrm{wrap}(\theta_p(t)-\theta_p(t{-}1))",
                "9",
                tr("printed without wrapping to (−180°, 180°]"),
                shown=_dtheta_p,
            ),
        ),
    ),
    Section(
        tr("Child C = {C}, G = {G}: azimuth about the bone"),
        (
            Equation("v", r"\mathbf{R}_C\,\mathbf{b}", "10"),
            Equation(
                "across",
                r"\mathbf{v}-(\mathbf{v}\cdot\mathbf{a})\,\mathbf{a}",
                "11",
                shown=_across,
            ),
            Equation(
                "dtheta_c",
                r"\angle_{\mathbf{a}}(\mathbf{v}_\perp(t{-}1),\ \mathbf{v}_\perp(t))",
                "12",
                tr(
                    "printed as θ_C(t), but it is the change from frame to frame: "
                    "atan2((v⊥(t−1) × v⊥(t))·a, v⊥(t−1)·v⊥(t))"
                ),
                shown=_dtheta_c,
            ),
        ),
    ),
    Section(
        tr("Do parent and child twist against each other?"),
        (
            Equation("product", r"<0\ ?", "1", shown=_opposed),
            Equation("m", r"\min(|\Delta\theta_p|,|\Delta\theta_c|)", "13", shown=_strength),
        ),
    ),
    Section(
        tr("Remove the error, keep the child's orientation"),
        (
            Equation(
                "err",
                r"\mathrm{sign}(\Delta\theta_p)\,m\ \ "
                rf"\mathrm{{{_IF}}}\ m\geq\tau,\ \mathrm{{{_ELSE}}}\ 0",
                "",
                shown=_err,
            ),
            Equation("offset", r"\mathrm{offset}(t{-}1)+\mathrm{err}(t)", "", shown=_offset),
            Equation("taken", rf"\mathrm{{{_SHARE}}}\cdot\mathrm{{offset}}", "", shown=_taken),
            Equation(
                "parent_after",
                r"q_P\,R_{\mathbf{a}}(-\delta)",
                "",
                shown=lambda of: padded_vector_text(of.correction.parent_after),
            ),
            Equation(
                "child_after",
                r"{q\mathrm{ʹ}_P}^{-1}\,q_P\,q_C",
                "15",
                shown=lambda of: padded_vector_text(of.correction.child_after),
            ),
            Equation(
                "check",
                r"q\mathrm{ʹ}_P\,q\mathrm{ʹ}_C",
                "14",
                shown=lambda of: _apart(of.correction),
            ),
        ),
    ),
)


OTHER_FORMS = {  # other forms of the parent's rotation as TeX, see other_forms
    "swing first": r"q_P=q_\mathrm{swing}\,q_\mathrm{twist}",
    "twist first": r"q_P=q_\mathrm{twist}\,q\mathrm{ʹ}_\mathrm{swing}",
    "as it is": r"q_P",
    "negative": r"-q_P",
}


def teaching_tab_formulas() -> tuple[str, ...]:
    """Return all TeX formulas that the teaching tab shows."""
    equations = [e.right for section in SECTIONS for e in section.rows]
    return tuple(
        dict.fromkeys([*(mark.tex for mark in MARKS.values()), *equations, *OTHER_FORMS.values()])
    )
