"""Compare ratios of QuaMo's error metrics with the bounds that they must meet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from twistcore.study.quamo.methods import (
    BOTH_WAYS,
    FULL,
    HAND,
    HAND_ALPHA,
    HAND_FIRST_ORDER,
    HAND_ROOT_SUBSTEPS,
    SPLINE,
)
from twistcore.study.quamo.pose_errors import METRICS
from twistcore.study.quamo.representations import REPRESENTATIONS
from twistcore.study.quamo.tables import NoiseCondition, Scores

# The results of [Le26 Table 3] divided by those of its input, in the order of METRICS. GRE is not
# listed there.
PAPER_STEPS = (
    ("PD only", (0.96, 0.99, 0.30, 0.91, None, 0.18, 0.24)),
    ("+ f_ω", (0.94, 0.98, 0.27, 0.79, None, 0.19, 0.17)),
    ("+ S³", (0.92, 0.97, 0.27, 0.78, None, 0.18, 0.13)),
    ("+ α", (0.91, 0.95, 0.31, 0.78, None, 0.19, 0.12)),
)


# The best ratios of methods that use only past frames, or little more information, with their
# conditions, keyed by noise level. They were computed by benchmarks/quamo_bounds.py on the 37 clips
# of docs/quamo-study.md.
TaskBound = Mapping[str, tuple[float, str]]
_LATER = "even with a delay of 80 ms"
ACCEL_BOUND: TaskBound = {"A": (0.46, "at MPJPE ≤ 1.02"), "B": (0.53, _LATER)}
PD_ACCEL_BOUND: TaskBound = {"B": (0.53, _LATER)}
G_ACCEL_BOUND: TaskBound = {"B": (0.35, _LATER)}
_ORACLE = "with the true contacts given"
G_MPJPE_BOUND: TaskBound = {"A": (0.97, _ORACLE), "B": (0.97, _ORACLE)}


class Demand(NamedTuple):
    """A ratio between two methods in one metric, and the bound that it must meet.

    Attributes
    ----------
    what
        Description of the ratio.
    over, under
        Names of the methods in the numerator and the denominator.
    metric
        One of METRICS.
    paper
        The paper's value, as text.
    bound
        The bound, or None for a ratio that is reported but not checked.
    above
        True if the ratio must be at least the bound, False if it must be at most the bound.
    systematic
        Bound under systematic noise, None if the same.
    at_b
        Bound at noise level B, None if the same.
    task
        The best ratio that any method has reached, keyed by noise level, if known.
    plain
        True if the ratio is checked only without systematic noise.
    """

    what: str
    over: str
    under: str
    metric: str
    paper: str
    bound: float | None
    above: bool = False
    systematic: float | None = None
    at_b: float | None = None
    task: TaskBound | None = None
    plain: bool = False

    def bar_at(self, condition: NoiseCondition) -> float | None:
        """Return the bound under a noise condition."""
        if condition.systematic and self.systematic is not None:
            return self.systematic
        return self.at_b if condition.level == "B" and self.at_b is not None else self.bound


MAIN = (
    Demand("full model", FULL, "input", "MPJPE", "0.91", 1.02, systematic=0.92),
    Demand("full model", FULL, "input", "Accel", "0.30", 0.40, task=ACCEL_BOUND),
    Demand("full model", FULL, "input", "G-Accel", "0.20", 0.30, task=G_ACCEL_BOUND),
    Demand("full model", FULL, "input", "G-MPJPE", "0.81", 0.95, task=G_MPJPE_BOUND),
    Demand("full model, never above", FULL, "input", "G-MPJPE", "–", 1.05),
    Demand("full model", FULL, "input", "FS", "0.08", 0.40),
    Demand("PD only, hand gains", HAND, "input", "MPJPE", "0.96", 1.03),
    Demand("PD only, hand gains", HAND, "input", "Accel", "0.30", 0.45, task=PD_ACCEL_BOUND),
    *(
        Demand(method, method, "input", metric, "–", a, at_b=b, plain=True)
        for method in (BOTH_WAYS, SPLINE)
        for metric, a, b in (
            ("MPJPE", 1.00, 1.01),
            ("Accel", 0.37, 0.58),
            ("G-Accel", 0.23, 0.39),
            ("FS", 0.15, 0.23),
        )
    ),
)
STEPS = (
    Demand("PD only, learned gains", "learned, pd", "input", "MPJPE", "0.96", 1.03),
    Demand(
        "PD only, learned gains",
        "learned, pd",
        "input",
        "Accel",
        "0.30",
        0.45,
        task=PD_ACCEL_BOUND,
    ),
    Demand("PD + f_ω", "learned, bias", "input", "G-MPJPE", "0.79", 0.97, task=G_MPJPE_BOUND),
    Demand("with α ÷ without, learned", FULL, "learned, s3", "MPJPE", "0.99", 1.00),
    Demand("with α ÷ without, learned", FULL, "learned, s3", "Accel", "1.13", 1.30),
    Demand("exact ÷ first-order, learned", "learned, s3", "learned, bias", "MPJPE", "0.98", None),
    Demand("exact ÷ first-order, hand", HAND, HAND_FIRST_ORDER, "MPJPE", "0.98", None),
    Demand("with α ÷ without, hand", HAND_ALPHA, HAND, "MPJPE", "0.99", 1.00),
    Demand("with α ÷ without, hand", HAND_ALPHA, HAND, "Accel", "1.13", 1.30),
    Demand("root: one Euler step ÷ six, hand", HAND, HAND_ROOT_SUBSTEPS, "GRE", "–", None),
)
TURNS = tuple(
    Demand(f"{rep.name} ÷ quaternion", rep.name, HAND, "MPJPE", paper, bound, above=True)
    for rep, paper, bound in zip(
        REPRESENTATIONS, ("1.38", "1.32", "1.13"), (1.3, 1.2, 1.1), strict=False
    )
)


@dataclass(frozen=True)
class BoundCheck:
    """A row of the table of bounds: a ratio and its bound.

    Attributes
    ----------
    check
        Description of the ratio.
    paper
        The paper's value, as text.
    bound
        The bound, or None for a ratio that is reported but not checked.
    value, spread
        Mean and standard deviation of the ratio over noise seeds.
    above
        True if the ratio must be at least the bound, False if it must be at most the bound.
    task_bound
        The best ratio that any method has reached. None if it is unknown, meets the bound, or is
        worse than `value` (which is possible because it was measured on different clips).
    task
        The conditions of this best ratio.
    """

    check: str
    paper: str
    bound: float | None
    value: float
    spread: float
    above: bool = False
    task_bound: float | None = None
    task: str = ""

    @property
    def met(self) -> bool:
        """Return True if the mean over seeds meets the bound."""
        if self.bound is None:
            return True
        return self.value >= self.bound if self.above else self.value <= self.bound

    @property
    def verdict(self) -> str:
        """Return in Markdown whether the bound is met and, if not, the best known ratio."""
        if self.bound is None:
            return ""
        if self.met:
            return "met"
        if self.task_bound is not None:
            return f"**not met**; at best {self.task_bound:.2f} {self.task}"
        return "**not met**"

    def line(self) -> str:
        """Return the row of the Markdown table."""
        bound = "–" if self.bound is None else f"{'≥' if self.above else '≤'} {self.bound:.2f}"
        return (
            f"| {self.check} | {self.paper} | {bound} | "
            f"{self.value:.3f} ± {self.spread:.3f} | {self.verdict} |"
        )


def bound_checks(
    scores: Scores, c: NoiseCondition, demands: Sequence[Demand]
) -> Iterator[BoundCheck]:
    """Yield a row for each demand for which both methods were run under the noise condition `c`."""
    for d in demands:
        if d.plain and c.systematic:
            continue
        if {(d.over, c), (d.under, c)} <= scores.by_method.keys():
            values = scores.ratios(d.over, c, d.under)[:, METRICS.index(d.metric)]
            spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
            check, value, bound = f"{c}: {d.what}, {d.metric}", float(values.mean()), d.bar_at(c)
            bar = BoundCheck(check, d.paper, bound, value, spread, d.above)
            best, given = (d.task or {}).get(c.level, (0.0, ""))
            if bound is not None and bound < best < value:
                bar = replace(bar, task_bound=best, task=given)
            yield bar


def bound_check_table(lines: Sequence[BoundCheck]) -> str:
    """Return a Markdown table of bound checks."""
    head = "| check | in the paper | bar | here | |\n|---|---|---|---|---|\n"
    return head + "\n".join(bar.line() for bar in lines) + "\n"
