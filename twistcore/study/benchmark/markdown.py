"""Write the benchmark's results as Markdown, which is also readable as plain text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from twistcore.detection import DETECTORS
from twistcore.study.benchmark.clip_run import BenchmarkSettings
from twistcore.study.benchmark.runner import BenchmarkSummary
from twistcore.study.benchmark.tables import (
    OVERALL,
    BenchmarkRow,
    benchmark_method_description,
    benchmark_method_label,
    benchmark_protocol_description,
    benchmark_rows,
    lag_and_peak_loss_rows,
)

BAR = 40  # number of characters of the longest bar
_COLUMNS = (
    ("FSR %", "fsr_percent", 2),
    ("worse %", "worse_percent", 2),
    ("MAE before °", "mae_before_deg", 2),
    ("MAE after °", "mae_after_deg", 3),
    ("RMSE before °", "rmse_before_deg", 2),
    ("RMSE after °", "rmse_after_deg", 2),
    ("RER %", "rer_percent", 2),
    ("damage %", "damage_percent", 3),
    ("of target %", "damage_target_percent", 3),
    ("damage °", "damage_mean_deg", 3),
    ("natural %", "natural_percent", 3),
    ("precision %", "precision_percent", 2),
    ("recall %", "recall_percent", 2),
    ("alarms/min", "false_alarms_per_minute", 2),
)
_COSTS = (
    ("lag frames", "lag_frames", 2),
    ("lag ms", "lag_ms", 1),
    ("peak loss %", "peak_loss_percent", 2),
    ("fast: lag ms", "fast_lag_ms", 1),
    ("fast: peak loss %", "fast_peak_loss_percent", 2),
)
_OF_TABLE_2 = (
    ("MAE After (°)", "mae_after_deg", 2),
    ("RER (%)", "rer_percent", 2),
    ("FSR (%)", "fsr_percent", 2),
)
_LEGEND = """\
FSR: error frames with at least 80 % of the error removed; worse: error frames whose error grew by
more than 0.5°. Frames with an error below 0.5° count neither as error frames nor as clean ones.
Damage: clean (joint, frame) pairs of all chains that a method changed by more than 1° but not in
the clean clip, and the mean change by damage over all pairs; 'of target': only the injected
chain's two joints. Natural: pairs that the method changes in the clean clip in the same way
(within 1°), counted separately. Precision, recall: intervals with an overlap (IoU) of at least
0.5; detections also made in the clean clip are excluded. Alarms: intervals found in the clean
clips, all chains together. Oracles know the true frames."""


def benchmark_to_markdown(
    summary: BenchmarkSummary, settings: BenchmarkSettings, source: str
) -> str:
    """Return the benchmark's results as a Markdown page.

    `source` is the description of the clips in the title.
    """
    rows = benchmark_rows(summary, settings)
    minutes = summary.micros / 6e7
    seeds = ", ".join(str(s) for s in settings.seeds)
    parts = [
        f"# Benchmark of {source}",
        f"{summary.clips} clips, {minutes:.1f} minutes, seeds {seeds}, without {summary.dropped} "
        "frames at the start of clips that are a T-pose or a blend out of it. "
        + (f"**{summary.missing} clips are missing.**" if summary.missing else ""),
        _LEGEND,
    ]
    for protocol in settings.protocols:
        chosen = [r for r in rows if r.protocol == protocol]
        parts += _protocol_parts(protocol, chosen, settings)
    parts += _fidelity_parts(summary, settings)
    parts.append("## Methods")
    parts.append(
        "\n".join(
            f"- **{benchmark_method_label(m)}** (`{m}`): {benchmark_method_description(m)}."
            for m in settings.methods
        )
    )
    parts += _event_parts(summary)
    if summary.problems:
        parts.append("## Could not be processed")
        parts.append("\n".join(f"- {problem}" for _, problem in summary.problems))
    return "\n\n".join(part.rstrip() for part in parts) + "\n"


def _protocol_parts(
    protocol: str, rows: Sequence[BenchmarkRow], settings: BenchmarkSettings
) -> list[str]:
    title = "P0 (P0-all)" if protocol == "P0" else protocol
    parts = [f"## {title}: {benchmark_protocol_description(protocol)}"]
    parts.append(_overall(rows, audited=False))
    if not any(row.tally.frames for row in rows):
        return parts
    parts.append(
        f"Audited: only passes whose target chains have no natural event "
        f"(detections by `{settings.auditor}` in the clean clip, and flips of a single joint)."
    )
    parts.append(_overall(rows, audited=True))
    parts.append("FSR % by segment")
    parts.append(_by_segment(rows, settings))
    for method in settings.methods:
        if method in DETECTORS:
            own = [r for r in rows if r.method == method and not r.audited]
            parts += _paper_layout(method, [row for row in own if row.tally.frames])
    return parts


def _overall(rows: Sequence[BenchmarkRow], *, audited: bool) -> str:
    place = (audited, "", OVERALL)
    chosen = (r for r in rows if (r.audited, r.side, r.segment) == place)
    return _listed(
        ["method"], (([benchmark_method_label(r.method)], r.to_json()) for r in chosen), _COLUMNS
    )


def _by_segment(rows: Sequence[BenchmarkRow], settings: BenchmarkSettings) -> str:
    known: dict[tuple[str, str], dict[str, Any]] = {}
    for row in rows:
        if not row.audited:
            known.setdefault((row.side, row.segment), {})[row.method] = row.to_json()
    lines = [
        [side or "both", segment]
        + [_number(v.get(m, {}).get("fsr_percent"), 2) for m in settings.methods]
        for (side, segment), v in known.items()
    ]
    return aligned_markdown_table(
        ["side", "segment", *(benchmark_method_label(m) for m in settings.methods)], lines
    )


def _paper_layout(method: str, rows: Sequence[BenchmarkRow]) -> list[str]:
    """Return the results of a method in the layout of Tables 1 and 2 and Fig. 6 of [Choi26]."""
    by_place = {(row.side, row.segment): row.to_json() for row in rows}
    if ("", OVERALL) not in by_place:
        return []
    name = benchmark_method_label(method)
    total = by_place.pop(("", OVERALL))
    first = aligned_markdown_table(
        ["Metric", "Before Refinement", "After Refinement", "Performance Improvement"],
        [
            _change("MAE (deg)", total["mae_before_deg"], total["mae_after_deg"]),
            _change("RMSE (deg)", total["rmse_before_deg"], total["rmse_after_deg"]),
            ["FSR (%)", "–", "–", _number(total["fsr_percent"], 2)],
        ],
    )
    segments = {k: v for k, v in by_place.items() if k[0] and k[1] != OVERALL} or by_place
    second = _listed(["Side", "Segment"], segments.items(), _OF_TABLE_2)
    return [
        f"### {name}, as in the paper's Table 1",
        first,
        f"### {name}, as in the paper's Table 2",
        second,
        f"### {name}, as in the paper's Fig. 6: MAE before (░) and after (█), degrees",
        benchmark_bar_chart(segments),
    ]


def _change(metric: str, before: float, after: float) -> list[str]:
    better = f"{100.0 * (1.0 - after / before):.2f}% reduction" if before else "–"
    return [metric, f"{before:.2f}", f"{after:.2f}", better]


def benchmark_bar_chart(segments: Mapping[tuple[str, str], Mapping[str, Any]]) -> str:
    """Return a text bar chart of the error in each segment, before and after the correction."""
    highest = max(
        (v[k] for v in segments.values() for k in ("mae_before_deg", "mae_after_deg")), default=0.0
    )
    lines = []
    for (side, segment), v in segments.items():
        title = f"{side} {segment}".strip()
        for mark, key in (("░", "mae_before_deg"), ("█", "mae_after_deg")):
            length = round(BAR * v[key] / highest) if highest else 0
            value = f"{v[key]:.2f}"
            lines.append(" ".join(part for part in (f"{title:<16}", mark * length, value) if part))
            title = ""
    return "\n".join(["```text", *lines, "```"])


def _fidelity_parts(summary: BenchmarkSummary, settings: BenchmarkSettings) -> list[str]:
    rows = lag_and_peak_loss_rows(summary, settings)
    if not rows:
        return []
    fast = rows[0]["fast_clips"]
    return [
        "## Cost of a method on a clean clip",
        f"Medians over clips. Lag: best cross-correlation of angular speeds. Peak loss: in the "
        f"fastest joint's highest mean speed over 50 ms. Fast: the {fast} fastest of "
        f"{rows[0]['clips']} clips, {rows[0]['fast_peak_deg_per_s']:.0f}°/s.",
        _listed(["method"], (([benchmark_method_label(r["method"])], r) for r in rows), _COSTS),
    ]


def _event_parts(summary: BenchmarkSummary) -> list[str]:
    if not summary.events:
        return []
    lines = [
        [clip, e.chain, e.kind, f"{e.start}-{e.stop}", f"{e.degrees:+.1f}"]
        for clip, e in summary.events[:50]
    ]
    said = f"{len(summary.events)} in the clips as captured"
    more = "; the first 50 (all: --json)" if len(summary.events) > 50 else ""
    return [
        "## Natural events",
        f"{said}{more}.",
        aligned_markdown_table(["clip", "chain", "kind", "frames", "degrees"], lines),
    ]


def aligned_markdown_table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table with aligned columns. Numbers are aligned to the right."""
    columns = []
    for title, *cells in zip(head, *lines, strict=True):
        width = max(map(len, (title, *cells)))
        bare = [c.lstrip("+-–").replace(".", "") for c in cells if c != "–"]
        right = bool(cells) and all(map(str.isdigit, bare))
        top, *below = (f" {c.rjust(width) if right else c.ljust(width)} " for c in (title, *cells))
        columns.append([top, "-" * (width + 1) + (":" if right else "-"), *below])
    return "\n".join(f"|{'|'.join(row)}|" for row in zip(*columns, strict=True))


def _listed(
    names: Sequence[str],
    rows: Iterable[tuple[Sequence[str], Mapping[str, Any]]],
    columns: Sequence[tuple[str, str, int]],
) -> str:
    """Return a Markdown table. Each row is a pair: its first cells, and its values keyed by name.

    `names` are the titles of the first columns. `columns` lists the title, the key and the number
    of decimals of each of the remaining columns.
    """
    lines = [[*own, *(_number(values[k], n) for _, k, n in columns)] for own, values in rows]
    return aligned_markdown_table([*names, *(title for title, _, _ in columns)], lines)


def _number(value: float | None, digits: int) -> str:
    # Adding 0.0 turns a rounded −0.0 into 0.0.
    return "–" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"
