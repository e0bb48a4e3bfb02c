"""Group benchmark results by protocol, method, side and segment, and write CSV or JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from twistcore.detection import DETECTORS
from twistcore.files.encoding import csv_text
from twistcore.files.version import __version__
from twistcore.study.benchmark.baselines import BASELINES
from twistcore.study.benchmark.clip_run import BenchmarkSettings
from twistcore.study.benchmark.filtering_cost import Fidelity
from twistcore.study.benchmark.hinge import HINGE
from twistcore.study.benchmark.hinge import LABEL as HINGE_LABEL
from twistcore.study.benchmark.hinge import WHY as HINGE_WHY
from twistcore.study.benchmark.runner import BenchmarkSummary
from twistcore.study.benchmark.tally import MICRO, Key, Tally
from twistcore.study.evaluation import body_segment_sort_key
from twistcore.synthesis import parse_protocol

SCHEMA = "twistcore.benchmark/1"
OVERALL = "Overall"
FAST_SHARE = 0.1


@dataclass(frozen=True)
class BenchmarkRow:
    """The results of a method under a protocol, for one body side and segment.

    Attributes
    ----------
    protocol, method
        Names of protocol and method.
    audited
        True if only chains without natural events are counted.
    side, segment
        The side ('' for both), and the segment (OVERALL for all).
    tally
        Counts and sums.
    minutes
        Duration of all clips.
    """

    protocol: str
    method: str
    audited: bool
    side: str
    segment: str
    tally: Tally
    minutes: float

    def to_json(self) -> dict[str, Any]:
        """Return the row as rounded numbers, in degrees and per cent. Missing values are None."""
        t = self.tally
        detector = self.method in DETECTORS
        found = detector and t.truths > 0
        before, after = _mean(t.before, t.frames), _mean(t.after, t.frames)
        return {
            "protocol": self.protocol,
            "method": self.method,
            "audited": self.audited,
            "side": self.side,
            "segment": self.segment,
            "passes": t.passes,
            "frames": t.frames,
            "mae_before_deg": before,
            "mae_after_deg": after,
            "rmse_before_deg": _root(t.before_squared, t.frames),
            "rmse_after_deg": _root(t.after_squared, t.frames),
            "rer_percent": _percent(t.after, t.before),
            "fsr_percent": _percent(t.repaired, t.frames),
            "worse_percent": _percent(t.worse, t.frames),
            "damage_percent": _percent(t.damaged, t.pairs),
            "damage_mean_deg": _mean(t.damage, t.pairs),
            "damage_target_percent": _percent(t.target_damaged, t.target_pairs),
            "natural_percent": _percent(t.natural, t.pairs),
            "natural_mean_deg": _mean(t.natural_change, t.pairs),
            "precision_percent": _percent(t.matched, t.found) if found else None,
            "recall_percent": _percent(t.matched, t.truths) if found else None,
            "intervals": t.truths,
            "false_alarms": t.alarms if detector and not self.audited else None,
            "false_alarms_per_minute": (
                round(t.alarms / self.minutes, 6)
                if detector and not self.audited and self.minutes
                else None
            ),
        }


def benchmark_rows(summary: BenchmarkSummary, settings: BenchmarkSettings) -> list[BenchmarkRow]:
    """Return the rows of each protocol, sorted by side and segment.

    The rows for all chains come first, then the rows for chains without natural events.
    """
    minutes = summary.micros / MICRO / 60.0
    rows = []
    for protocol in settings.protocols:
        for audited in (False, True):
            for method in settings.methods:
                chosen = {
                    k: t
                    for k, t in summary.tallies.items()
                    if (k.protocol, k.method) == (protocol, method) and (k.audited or not audited)
                }
                for side, segment in _places(chosen):
                    own = [
                        t
                        for k, t in chosen.items()
                        if side in ("", k.side) and segment in (OVERALL, k.segment)
                    ]
                    tally = sum(own, Tally())
                    rows.append(
                        BenchmarkRow(protocol, method, audited, side, segment, tally, minutes)
                    )
    return rows


def _places(keys: Iterable[Key]) -> list[tuple[str, str]]:
    """Return (side, segment) of each table row: the segments of each side, then the totals."""
    both = {(k.side, k.segment) for k in keys}
    sides = sorted({side for side, _ in both if side})
    segments = sorted({segment for _, segment in both}, key=body_segment_sort_key)
    lines = [(side, s) for side in sides for s in segments if (side, s) in both]
    lines += [(side, OVERALL) for side in sides]
    lines += [("", s) for s in segments]
    return [*lines, ("", OVERALL)]


def _mean(total: int, count: int) -> float | None:
    return round(total / MICRO / count, 6) if count else None


def _root(total: int, count: int) -> float | None:
    return round(math.sqrt(total / MICRO / count), 6) if count else None


def _percent(part: int, whole: int) -> float | None:
    return round(100.0 * part / whole, 6) if whole else None


def lag_and_peak_loss_rows(
    summary: BenchmarkSummary, settings: BenchmarkSettings
) -> list[dict[str, Any]]:
    """Return each method's median lag and median loss of peak speed over all clean clips.

    Each row has a second set of values, for the fastest tenth of the clips.
    """
    out = []
    for method in settings.methods:
        measured = [f for _, f in summary.fidelity.get(method, [])]
        if not measured:
            continue
        fastest = sorted(measured, key=lambda f: -f.peak)
        fast = fastest[: max(1, math.ceil(FAST_SHARE * len(fastest)))]
        out.append(
            {
                "method": method,
                "clips": len(measured),
                "lag_frames": median([f.lag_frames for f in measured]) / 1e6,
                "lag_ms": median([f.lag for f in measured]) / 1e3,
                "peak_loss_percent": _loss(measured),
                "fast_clips": len(fast),
                "fast_peak_deg_per_s": median([f.peak for f in fast]) / 1e3,
                "fast_lag_ms": median([f.lag for f in fast]) / 1e3,
                "fast_peak_loss_percent": _loss(fast),
            }
        )
    return out


def _loss(measured: Sequence[Fidelity]) -> float:
    """Return the median loss of peak speed in per cent."""
    return round(100.0 - median([f.kept for f in measured]) / 1e4, 4)


def benchmark_method_label(method: str) -> str:
    """Return the name of a method in tables."""
    if method == HINGE:
        return HINGE_LABEL
    return BASELINES[method].label if method in BASELINES else method


def benchmark_method_description(method: str) -> str:
    """Return a one-line description of a method."""
    if method in BASELINES:
        return BASELINES[method].why
    if method == HINGE:
        return HINGE_WHY
    info = DETECTORS.info(method)
    return info.note or info.measures.rstrip(".") or "detector, τ auto"


def benchmark_protocol_description(name: str) -> str:
    """Return a one-line description of a protocol and its passes."""
    protocol = parse_protocol(name)
    if protocol.clean:
        return protocol.text
    if protocol.both:
        return f"{protocol.text}; a pass is a chain and the one below it"
    return f"{protocol.text}; each {'limb' if protocol.limb else 'chain'} in turn, one per pass"


def benchmark_to_json(
    summary: BenchmarkSummary, settings: BenchmarkSettings, source: str
) -> dict[str, Any]:
    """Return settings, rows and failures of the benchmark as a JSON document."""
    return {
        "schema": SCHEMA,
        "version": __version__,
        "source": source,
        "complete": summary.missing == 0,
        "clips": summary.clips,
        "minutes": round(summary.micros / MICRO / 60.0, 6),
        "dropped_frames": summary.dropped,
        "seeds": list(settings.seeds),
        "auditor": settings.auditor,
        "protocols": [
            {"name": p, "text": benchmark_protocol_description(p)} for p in settings.protocols
        ],
        "methods": [
            {
                "name": m,
                "label": benchmark_method_label(m),
                "detector": m in DETECTORS,
                "oracle": m in BASELINES and BASELINES[m].oracle,
                "text": benchmark_method_description(m),
            }
            for m in settings.methods
        ],
        "rows": [row.to_json() for row in benchmark_rows(summary, settings)],
        "filtering": lag_and_peak_loss_rows(summary, settings),
        "natural_events": [{"clip": clip, **event.to_json()} for clip, event in summary.events],
        "problems": [{"clip": clip, "problem": problem} for clip, problem in summary.problems],
    }


def rows_to_csv(rows: Iterable[BenchmarkRow]) -> str:
    """Return the rows as CSV, with empty cells for missing values."""
    documents = [row.to_json() for row in rows]
    return csv_text(documents[0], documents) if documents else ""
