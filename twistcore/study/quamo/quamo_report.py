"""The table of what QuaMo must show: the paper's ratio, the bar, ours, met or not; Markdown, JSON.

The paper's column is of other data [Le26 Tables 1, 3]: only ratios to the input can be put side by
side at all, and none of them reproduces the paper's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from twistcore.quamo.network import VARIANTS, Network
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.study.quamo.pose_errors import METRICS
from twistcore.study.quamo.quamo_tables import (
    CONDITIONS,
    HAND,
    HAND_ALPHA,
    HAND_FIRST_ORDER,
    Condition,
    Method,
    Scores,
    baseline_methods,
    hand_methods,
    learned_method,
    markdown_table,
    representation_methods,
    score,
    scores_to_json,
    scores_to_markdown,
    turning,
)
from twistcore.study.quamo.representations import REPRESENTATIONS, open_loop_drift
from twistcore.study.quamo.sequences import Sequence24

Networks = Mapping[str, Mapping[str, Network]]
Tell = Callable[[str], None]
FULL = "learned, full"
# [Le26 Table 3] as ratios to its input, in the order of METRICS; it lists no GRE.
PAPER_STEPS = (
    ("PD only", (0.96, 0.99, 0.30, 0.91, None, 0.18, 0.24)),
    ("+ f_ω", (0.94, 0.98, 0.27, 0.79, None, 0.19, 0.17)),
    ("+ S³", (0.92, 0.97, 0.27, 0.78, None, 0.18, 0.13)),
    ("+ α", (0.91, 0.95, 0.31, 0.78, None, 0.19, 0.12)),
)
SPEEDS = (("π", np.pi), ("2π", 2.0 * np.pi), ("12", 12.0))


class Demand(NamedTuple):
    """A ratio of two methods in a metric, the paper's and the bound (None: it is shown alone).

    above: it must be at least the bound; systematic: the bound with systematic noise, if another.
    """

    what: str
    over: str
    under: str
    metric: str
    paper: str
    bound: float | None
    above: bool = False
    systematic: float | None = None


MAIN = (
    Demand("full model", FULL, "input", "MPJPE", "0.91", 1.02, systematic=0.92),
    Demand("full model", FULL, "input", "Accel", "0.30", 0.40),
    Demand("full model", FULL, "input", "G-Accel", "0.20", 0.30),
    Demand("full model", FULL, "input", "G-MPJPE", "0.81", 0.95),
    Demand("full model", FULL, "input", "FS", "0.08", 0.40),
    Demand("PD only, hand gains", HAND, "input", "MPJPE", "0.96", 1.03),
    Demand("PD only, hand gains", HAND, "input", "Accel", "0.30", 0.45),
)
STEPS = (
    Demand("PD only, learned gains", "learned, pd", "input", "MPJPE", "0.96", 1.03),
    Demand("PD only, learned gains", "learned, pd", "input", "Accel", "0.30", 0.45),
    Demand("PD + f_ω", "learned, bias", "input", "G-MPJPE", "0.79", 0.97),
    Demand("with α ÷ without, learned", FULL, "learned, s3", "MPJPE", "0.99", 1.00),
    Demand("with α ÷ without, learned", FULL, "learned, s3", "Accel", "1.13", 1.30),
    Demand("exact ÷ first-order, learned", "learned, s3", "learned, bias", "MPJPE", "0.98", None),
    Demand("exact ÷ first-order, hand", HAND, HAND_FIRST_ORDER, "MPJPE", "0.98", None),
    Demand("with α ÷ without, hand", HAND_ALPHA, HAND, "MPJPE", "0.99", 1.00),
    Demand("with α ÷ without, hand", HAND_ALPHA, HAND, "Accel", "1.13", 1.30),
)
TURNS = tuple(
    Demand(f"{rep.name} ÷ quaternion", rep.name, HAND, "MPJPE", paper, bound, above=True)
    for rep, paper, bound in zip(
        REPRESENTATIONS, ("1.38", "1.32", "1.13"), (1.3, 1.2, 1.1), strict=False
    )
)


@dataclass(frozen=True, eq=False)
class Report:
    """The same content twice."""

    markdown: str
    document: dict[str, Any]


@dataclass(frozen=True)
class Bar:
    """A line of the table: a ratio with its bound; above: it must be at least the bound.

    bound: None where the ratio is shown and nothing is demanded of it.
    """

    check: str
    paper: str
    bound: float | None
    value: float
    spread: float
    above: bool = False

    @property
    def met(self) -> bool:
        """Whether the mean over seeds keeps the bound."""
        if self.bound is None:
            return True
        return self.value >= self.bound if self.above else self.value <= self.bound

    def line(self) -> str:
        """As a row of Markdown."""
        bound = "–" if self.bound is None else f"{'≥' if self.above else '≤'} {self.bound:.2f}"
        verdict = "" if self.bound is None else "met" if self.met else "**not met**"
        return (
            f"| {self.check} | {self.paper} | {bound} | "
            f"{self.value:.3f} ± {self.spread:.3f} | {verdict} |"
        )


def evaluation_report(
    sequences: Sequence[Sequence24], networks: Networks, seeds: Sequence[int], tell: Tell
) -> Report:
    """Learned and hand gains beside the baselines, every condition, and the bars they must meet.

    Of the clips only those whose subject some network of the variant 'full' was trained without.
    """
    sequences = _known(sequences, networks)
    methods = {**baseline_methods(sequences), HAND: hand_methods()[HAND]}
    if networks.get("full"):
        methods[FULL] = learned_method(networks["full"])
    scores = score(sequences, methods, seeds, tell=tell)
    bars = [bar for c in CONDITIONS for bar in _bars(scores, c, MAIN)]
    parts = [
        _heading(sequences, seeds),
        _bar_table(bars),
        *(scores_to_markdown(scores, ["input", *methods], c) for c in CONDITIONS),
    ]
    return Report("\n".join(parts), _document("evaluation", scores, bars, seeds))


def ablation_report(
    sequences: Sequence[Sequence24], networks: Networks, seeds: Sequence[int], tell: Tell
) -> Report:
    """Steps of [Le26 Table 3], representations on turning clips, integration, acceleration.

    Steps are compared on the clips for which every trained variant has a network.
    """
    everything = sequences
    sequences = _known(sequences, networks)
    learned: dict[str, Method] = {
        f"learned, {v}": learned_method(networks[v]) for v in VARIANTS if networks.get(v)
    }
    steps = {**hand_methods(), **learned}
    scores = score(sequences, steps, seeds, tell=tell)
    turns = turning(everything)
    others = representation_methods()
    shown = {HAND: hand_methods()[HAND], **others}
    tell(f"representations on {len(turns)} turning clips")
    turned = score(turns, shown, seeds, tell=tell) if turns else None
    bars: list[Bar] = []
    for condition in CONDITIONS:
        bars += _bars(scores, condition, STEPS)
        if turned:
            bars += _bars(turned, condition, TURNS)
    parts = [_heading(sequences, seeds), _bar_table(bars)]
    parts.append(_paper_steps())
    parts += [scores_to_markdown(scores, ["input", *steps], c) for c in CONDITIONS]
    if turned:
        parts.append(f"Clips with full turns: {', '.join(turned.clips)}\n")
        parts += [scores_to_markdown(turned, ["input", *shown], c) for c in CONDITIONS]
    drift = _drift()
    rows = [(f"{n} rad/s", f"{e:.1e}°", f"{f:.2f}°") for n, _, e, f in drift]
    parts.append(markdown_table(("open loop, 100 steps of 0.04 s", "exact", "first-order"), rows))
    document = _document("ablation", scores, bars, seeds)
    if turned:
        document["turning"] = scores_to_json(turned)
    document["drift_deg"] = [{"rad_s": s, "exact": e, "first_order": f} for _, s, e, f in drift]
    return Report("\n".join(parts), document)


def _known(sequences: Sequence[Sequence24], networks: Networks) -> tuple[Sequence24, ...]:
    """Clips of subjects that every variant with any network has one for."""
    trained = [set(by_subject) for by_subject in networks.values() if by_subject]
    return tuple(s for s in sequences if all(s.subject in t for t in trained))


def _bars(scores: Scores, c: Condition, demands: Sequence[Demand]) -> Iterator[Bar]:
    """A line for every demand whose two methods were run."""
    for d in demands:
        if {(d.over, c), (d.under, c)} <= scores.by_method.keys():
            values = scores.ratios(d.over, c, d.under)[:, METRICS.index(d.metric)]
            spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
            bound = d.systematic if c.systematic and d.systematic else d.bound
            check, value = f"{c}: {d.what}, {d.metric}", float(values.mean())
            yield Bar(check, d.paper, bound, value, spread, d.above)


def _heading(sequences: Sequence[Sequence24], seeds: Sequence[int]) -> str:
    subjects = ", ".join(sorted({s.subject for s in sequences}))
    frames = sum(len(s.q) for s in sequences)
    return (
        f"{len(sequences)} clips of subjects {subjects}, {frames} frames at 25 Hz, noise seeds "
        f"{', '.join(map(str, seeds))}; ratios are output / input, ± over seeds. The paper's "
        "column is of other data and other inputs.\n"
    )


def _bar_table(bars: Sequence[Bar]) -> str:
    head = "| check | in the paper | bar | here | |\n|---|---|---|---|---|\n"
    return head + "\n".join(bar.line() for bar in bars) + "\n"


def _paper_steps() -> str:
    rows = [(step, *("–" if v is None else f"{v:.2f}" for v in row)) for step, row in PAPER_STEPS]
    return markdown_table(("the paper's Table 3, ratios", *METRICS), rows)


def _drift() -> list[tuple[str, float, float, float]]:
    """Name and speed in rad/s, degrees off the truth: exact, first-order."""
    found = []
    for name, speed in SPEEDS:
        exact, first_order = np.degrees(open_loop_drift(speed, NETWORK_DT)).tolist()
        found.append((name, speed, exact, first_order))
    return found


def _document(
    kind: str, scores: Scores, bars: Sequence[Bar], seeds: Sequence[int]
) -> dict[str, Any]:
    return {
        "schema": f"twistcore.quamo-{kind}/1",
        "seeds": list(seeds),
        "metrics": list(METRICS),
        "bars": [{**vars(bar), "met": bar.met} for bar in bars],
        **scores_to_json(scores),
    }
