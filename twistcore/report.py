"""The QA report of a clip: one HTML page, the intervals as CSV, everything as JSON."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import numpy as np

from twistcore.atomic import write_atomically
from twistcore.bvh import Clip
from twistcore.chain import Chain
from twistcore.compare import compare
from twistcore.encoding import encoded, json_bytes
from twistcore.markers import blender_markers
from twistcore.motion import Motion
from twistcore.review.model import Decision, Judged, ReviewState
from twistcore.review.session import tracking_to_json

SCHEMA = "twistcore.report/1"
_COLUMNS = (
    "id",
    "chain",
    "start",
    "stop",
    "frames",
    "start_s",
    "delta_deg",
    "confidence",
    "open",
    "decision",
    "reviewer",
    "decided_at",
    "note",
    "tracked_after",
)


@dataclass(frozen=True, eq=False)
class Report:
    """What is reported: the clip, the review, the motion before and after."""

    clip: Clip
    chains: Sequence[Chain]
    state: ReviewState
    refined: Motion


def write_report(folder: Path, report: Report) -> tuple[Path, ...]:
    """Write the report into `folder`, made if missing; returns the paths.

    NAME.report.html and .json, NAME.intervals.csv, and NAME.markers.py for Blender.
    """
    folder.mkdir(parents=True, exist_ok=True)
    stem = report.clip.path.stem
    document = report_to_json(report)
    written = {
        folder / f"{stem}.report.html": encoded(_html(document)),
        folder / f"{stem}.intervals.csv": encoded(intervals_csv(report)),
        folder / f"{stem}.markers.py": encoded(
            blender_markers(report.clip.name, report.state.intervals)
        ),
        folder / f"{stem}.report.json": json_bytes(document),
    }
    for path, data in written.items():
        write_atomically(path, data)
    return tuple(written)


def report_to_json(report: Report) -> dict[str, Any]:
    """The report as one document; degrees, seconds and frames.

    tracking: what was tracked with QuaMo after the correction, as in a session, or null.
    """
    motion, state = report.clip.motion, report.state
    difference = compare(motion, report.refined)
    return {
        "schema": SCHEMA,
        "clip": report.clip.name,
        "sha256": report.clip.sha256,
        "frames": motion.frames,
        "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time,
        "method": state.method,
        "decisions": {d.value: sum(j.decision == d for j in state.intervals) for d in Decision},
        "chains": [
            {
                "chain": chain.name,
                "label": chain.label,
                "tau_deg": float(np.degrees(state.tau[chain.name])),
                "intervals": len(state.of_chain(chain.name)),
                "warnings": list(chain.warnings),
            }
            for chain in report.chains
        ],
        "intervals": [_row(j, report) for j in state.intervals],
        "tracking": state.tracking and tracking_to_json(state.tracking),
        "changed": {
            "frames": difference.frames,
            "joints": sorted({j.joint for j in difference.joints}),
            "max_deg": max((j.max_degrees for j in difference.joints), default=0.0),
            "max_position_of_height": difference.max_position_of_height,
        },
        "warnings": list(map(str, report.clip.warnings)),
    }


def intervals_csv(report: Report) -> str:
    """One line an interval, the columns of the table; degrees and seconds.

    tracked_after: joints of the interval's chain that were tracked after the correction.
    """
    out = io.StringIO()
    writer = csv.DictWriter(out, _COLUMNS, lineterminator="\n")
    writer.writeheader()
    for judged in report.state.intervals:
        writer.writerow(_row(judged, report) | {"tracked_after": _tracked(judged, report)})
    return out.getvalue()


def _tracked(judged: Judged, report: Report) -> str:
    tracking, names = report.state.tracking, report.clip.motion.skeleton.names
    chain = next((c for c in report.chains if c.name == judged.interval.chain), None)
    if tracking is None or chain is None:
        return ""
    ends = (names[chain.parent], names[chain.child])
    return " ".join(name for name in ends if name in tracking.joints)


def _row(judged: Judged, report: Report) -> dict[str, Any]:
    interval, fps = judged.interval, report.clip.motion.fps
    return {
        "id": judged.id,
        "chain": interval.chain,
        "start": interval.start,
        "stop": interval.stop,
        "frames": interval.frames,
        "start_s": round(interval.start / fps, 4),
        "delta_deg": round(float(np.degrees(interval.delta)), 4),
        "confidence": interval.confidence,
        "open": interval.open,
        "decision": judged.decision.value,
        "reviewer": judged.reviewer,
        "decided_at": judged.decided_at,
        "note": judged.note,
    }


def _html(document: dict[str, Any]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html").render(report=document)
