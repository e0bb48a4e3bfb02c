"""Create the reports of `quamo evaluate` and `quamo ablation`, with all checks and tables.

Reports are written as Markdown and as JSON. The paper's results come from different data [Le26
Tables 1, 3]. Therefore, only ratios to the input can be compared, and no table is a reproduction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from twistcore.quamo.network import VARIANTS, Network
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.bars import (
    MAIN,
    PAPER_STEPS,
    STEPS,
    TURNS,
    BoundCheck,
    bound_check_table,
    bound_checks,
)
from twistcore.study.quamo.methods import (
    BOTH_WAYS,
    FULL,
    FULL_BOTH_WAYS,
    HAND,
    SPLINE,
    baseline_methods,
    hand_tuned_methods,
    learned_method,
    measured_lags,
    select_root_discontinuity_clips,
    track_hand_tuned_forward_backward,
    tracking_methods_by_representation,
)
from twistcore.study.quamo.pose_errors import METRICS
from twistcore.study.quamo.representations import integration_errors_exact_first_order
from twistcore.study.quamo.rivals import RIVALS
from twistcore.study.quamo.sequences import Sequence24, split_into_windows
from twistcore.study.quamo.tables import (
    CONDITIONS,
    Method,
    Scores,
    error_ratios_to_markdown,
    markdown_table,
    score_methods,
    scores_to_json,
    scores_to_markdown,
)

Networks = Mapping[str, Mapping[str, Network]]
Tell = Callable[[str], None]
SPEEDS = (("π", np.pi), ("2π", 2.0 * np.pi), ("12", 12.0))
WINDOW = 100  # number of frames of a window [Le26 §4.2]


@dataclass(frozen=True, eq=False)
class StudyReport:
    """A report of a QuaMo study, as Markdown and as a JSON document."""

    markdown: str
    document: dict[str, Any]


def evaluation_report(
    sequences: Sequence[Sequence24], networks: Networks, seeds: Sequence[int], tell: Tell
) -> StudyReport:
    """Report how learned and hand-tuned gains compare with rival filters and with the bounds.

    A clip is used only if there is a network that was trained without the clip's subject.
    """
    sequences = _known(sequences, networks)
    methods = _evaluated(sequences, networks)
    scores = score_methods(sequences, methods, seeds, tell=tell)
    late = measured_lags(
        sequences, {name: methods[name] for name in methods if name != "constant offset"}
    )
    lines = [bar for c in CONDITIONS for bar in bound_checks(scores, c, MAIN)]
    lines += [
        BoundCheck(f"{name}, lag of {what} in ms", "–", 1.0, abs(float(late[name][k])), 0.0)
        for name in (BOTH_WAYS, SPLINE)
        for k, what in enumerate(("joints", "the root"))
    ]
    parts = [_heading(sequences, seeds), bound_check_table(lines)]
    parts += _tables(scores, methods)
    parts.append(_lag_table(late))
    document = _document("evaluation", scores, lines, seeds)
    document["lag_ms"] = {
        name: {"joints": round(float(ms[0]), 3), "root": round(float(ms[1]), 3)}
        for name, ms in late.items()
    }
    pieces = split_into_windows(sequences, WINDOW)
    if pieces:
        tell(f"{len(pieces)} windows of {WINDOW} frames")
        apart = [c for c in CONDITIONS if not c.systematic]
        cut = score_methods(pieces, methods, seeds, apart, from_truth=True)
        for c in apart:
            title = f"noise {c}, {len(pieces)} windows of {WINDOW} frames, ratios"
            parts.append(error_ratios_to_markdown(title, cut, list(methods), c))
        document["windows"] = scores_to_json(cut)
    return StudyReport("\n".join(parts), document)


def _evaluated(sequences: Sequence[Sequence24], networks: Networks) -> dict[str, Method]:
    """Return the evaluated methods: first the causal ones, then those needing the whole clip."""
    known = baseline_methods(sequences)
    offline = {rival.name for rival in RIVALS if not rival.causal}
    methods = {name: method for name, method in known.items() if name not in offline}
    methods[HAND] = hand_tuned_methods()[HAND]
    full = networks.get("full")
    if full:
        methods[FULL] = learned_method(full)
    methods |= {name: known[name] for name in known if name in offline}
    methods[BOTH_WAYS] = track_hand_tuned_forward_backward
    if full:
        methods[FULL_BOTH_WAYS] = learned_method(full, both_ways=True)
    return methods


def _lag_table(late: Mapping[str, Array]) -> str:
    rows = [(name, *(f"{round(v, 1) + 0.0:.1f}" for v in ms)) for name, ms in late.items()]
    return markdown_table(("lag in ms, clips without noise", "joints", "root"), rows)


def ablation_report(
    sequences: Sequence[Sequence24], networks: Networks, seeds: Sequence[int], tell: Tell
) -> StudyReport:
    """Report the effects of the steps of [Le26 Table 3] and of other choices.

    The other choices are the representation of rotations, the integration and the acceleration
    term. The steps are compared on the clips for which every trained variant has a network.
    """
    everything = sequences
    sequences = _known(sequences, networks)
    learned: dict[str, Method] = {
        f"learned, {v}": learned_method(networks[v]) for v in VARIANTS if networks.get(v)
    }
    steps = {**hand_tuned_methods(), **learned}
    scores = score_methods(sequences, steps, seeds, tell=tell)
    turns = select_root_discontinuity_clips(everything)
    others = tracking_methods_by_representation()
    shown = {HAND: hand_tuned_methods()[HAND], **others}
    tell(f"representations on {len(turns)} turning clips")
    turned = score_methods(turns, shown, seeds, tell=tell) if turns else None
    lines: list[BoundCheck] = []
    for condition in CONDITIONS:
        lines += bound_checks(scores, condition, STEPS)
        if turned:
            lines += bound_checks(turned, condition, TURNS)
    parts = [_heading(sequences, seeds), bound_check_table(lines)]
    parts.append(_paper_steps())
    parts += _tables(scores, steps)
    if turned:
        parts.append(f"Clips with full turns: {', '.join(turned.clips)}\n")
        parts += _tables(turned, shown)
    drift = _drift()
    rows = [(f"{n} rad/s", f"{e:.1e}°", f"{f:.2f}°") for n, _, e, f in drift]
    parts.append(markdown_table(("open loop, 100 steps of 0.04 s", "exact", "first-order"), rows))
    document = _document("ablation", scores, lines, seeds)
    if turned:
        document["turning"] = scores_to_json(turned)
    document["drift_deg"] = [{"rad_s": s, "exact": e, "first_order": f} for _, s, e, f in drift]
    return StudyReport("\n".join(parts), document)


def _known(sequences: Sequence[Sequence24], networks: Networks) -> tuple[Sequence24, ...]:
    """Return the clips of subjects for which every trained variant has a network."""
    trained = [set(by_subject) for by_subject in networks.values() if by_subject]
    return tuple(s for s in sequences if all(s.subject in t for t in trained))


def _heading(sequences: Sequence[Sequence24], seeds: Sequence[int]) -> str:
    subjects = ", ".join(sorted({s.subject for s in sequences}))
    frames = sum(len(s.q) for s in sequences)
    return (
        f"{len(sequences)} clips of subjects {subjects}, {frames} frames at 25 Hz, noise seeds "
        f"{', '.join(map(str, seeds))}; ratios are output / input, ± over seeds. The paper's "
        "column comes from other data and other inputs.\n"
    )


def _tables(scores: Scores, methods: Mapping[str, Method]) -> list[str]:
    """Return the tables of metrics under each noise condition.

    Under systematic noise, the tables contain only ratios to the input.
    """
    return [
        error_ratios_to_markdown(f"noise {c}, ratios", scores, list(methods), c)
        if c.systematic
        else scores_to_markdown(scores, ["input", *methods], c)
        for c in CONDITIONS
    ]


def _paper_steps() -> str:
    rows = [(step, *("–" if v is None else f"{v:.2f}" for v in row)) for step, row in PAPER_STEPS]
    return markdown_table(("the paper's Table 3, ratios", *METRICS), rows)


def _drift() -> list[tuple[str, float, float, float]]:
    """Return the integration errors of exact and first-order steps at several speeds.

    Each row contains the name of the speed, the speed in rad/s, and both errors in degrees.
    """
    found = []
    for name, speed in SPEEDS:
        exact, first_order = np.degrees(
            integration_errors_exact_first_order(speed, NETWORK_DT)
        ).tolist()
        found.append((name, speed, exact, first_order))
    return found


def _document(
    kind: str, scores: Scores, lines: Sequence[BoundCheck], seeds: Sequence[int]
) -> dict[str, Any]:
    return {
        "schema": f"twistcore.quamo-{kind}/1",
        "seeds": list(seeds),
        "metrics": list(METRICS),
        "bars": [{**vars(bar), "met": bar.met} for bar in lines],
        **scores_to_json(scores),
    }
