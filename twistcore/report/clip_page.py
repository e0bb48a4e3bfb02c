"""Write a clip page with pictures of the worst intervals, curves, decisions and changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.corrected import Corrected
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Kind
from twistcore.errors import TwistError
from twistcore.export.compare import compare_motions
from twistcore.export.detection_json import intervals_to_json
from twistcore.report.changes import (
    check_fidelity_of_written_clip,
    detect_remaining_errors,
    joint_changes,
)
from twistcore.report.curve_drawing import ClipCurves
from twistcore.report.document import Report, moved_joints_for_page
from twistcore.report.page_templates import render_page_template
from twistcore.report.picture_job import SIZE, Drawn
from twistcore.report.worst_finds import interval_page_data, player_page_data, worst_intervals
from twistcore.skeleton.notes import NOT_EXAMINED, UNEXAMINED
from twistcore.skeleton.rotation import largest_and_rms_angle_degrees
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Home:
    """The overview page of the batch report to which a clip page belongs.

    Attributes
    ----------
    title
        The text of the link to the overview page.
    address
        Path of the overview page, relative to the clip page.
    """

    title: str
    address: str


def clip_page_html(
    document: Mapping[str, Any],
    report: Report,
    drawn: Drawn | None = None,
    home: Home | None = None,
) -> str:
    """Return a clip page as HTML.

    Parameters
    ----------
    document
        The report as JSON data, from :func:`document.report_to_json`.
    report
        The report.
    drawn
        The pictures, or None for a page without pictures.
    home
        The overview page, if the clip belongs to a batch.
    """
    analysis = report.analysed
    state, corrected = report.state, Corrected(analysis)
    corrected.take(report.applied)
    method = _strength_by(analysis, state.method)
    drawing = ClipCurves(analysis, method, state.tau, state.intervals, report.verdict)
    curves, left_out = drawing.panels(corrected)
    return render_page_template(
        "clip.html",
        report=document,
        home=home,
        size=SIZE,
        finds=interval_page_data(report, analysis, drawing, worst_intervals(report), drawn),
        play=player_page_data(report, analysis, drawing, drawn),
        no_pictures=drawn.problem if drawn is not None else "",
        curves=curves,
        curves_left_out=left_out,
        rows=_decisions(document, report),
        assumptions=list(map(str, report.clip.warnings)),
        left_out=[str(note) for note in report.notes if note.kind in (NOT_EXAMINED, UNEXAMINED)],
        notes=[
            *(str(n) for n in report.notes if n.kind not in (NOT_EXAMINED, UNEXAMINED)),
            *_not_usable(analysis, state.method),
        ],
        not_corrected=report.not_corrected,
        parameters=dict(report.parameters),
        **moved_joints_for_page(document, report),
        **_changes(report),
    )


# -- decisions and changes -------------------------------------------------------------------------


def _decisions(
    document: Mapping[str, Any], report: Report
) -> list[tuple[Mapping[str, Any], dict[str, Any]]]:
    """Return the JSON entry of each interval, with further data that the page shows."""
    out = []
    for row, one in zip(document["intervals"], report.state.intervals, strict=True):
        largest, rms = largest_and_rms_angle_degrees(one.interval.offset)
        more = {
            "max_deg": largest,
            "rms_deg": rms,
            "reason": one.reason,
            "edited": one.edited,
            "by_hand": one.by_hand,
            "shown_deg": float(np.degrees(one.interval.shown)),
            "correctable": one.counts and one.id not in report.stuck,
            "lone": not one.counts,
            "alone": one.corrects and not one.interval.repairable,
            "somebody": bool(one.reviewer or one.decided_at or one.note or one.reason),
        }
        out.append((row, more))
    return out


def _changes(report: Report) -> dict[str, Any]:
    motion = report.clip.motion
    changes = joint_changes(motion, report.refined, compare_motions(motion, report.refined))
    kept, trouble = None, ""
    if report.written is not None:
        try:
            kept = check_fidelity_of_written_clip(report.clip, report.refined, report.written)
        except TwistError as error:
            trouble = str(error)
    left = report.left
    method = report.state.method
    if left is None and changes and _strength_by(report.analysed, method) == method:
        left = intervals_to_json(
            detect_remaining_errors(report.refined, report.chains, report.state)
        )
    if left is not None:
        left = [
            {**e, "before": _earlier_verdict(e, report), "lone": not Kind(e["kind"]).repairable}
            for e in left
        ]
    return {"changes": changes, "kept": kept, "trouble": trouble, "left": left}


def _strength_by(analysis: ClipAnalysis, method: str) -> str:
    """Return the name of the detector that computes the strength shown on the page.

    The default detector replaces the review's detector if that is missing or fails on the clip.
    """
    with suppress(TwistError):
        analysis.by(DETECTORS.usable(method))
    return analysis.usable(method)


def _not_usable(analysis: ClipAnalysis, method: str) -> Iterator[str]:
    """Yield a note if the review's detector is missing or fails on the clip."""
    if analysis.usable(method) != method:
        why = analysis.failure(method)
        why = f"fails on the clip ({why})" if why else "is not installed here"
        yield (
            f"The review's detector, {method!r}, {why}: the strength shown is from "
            f"{DEFAULT_METHOD!r}, and the corrected clip was not searched again."
        )


def _earlier_verdict(entry: Mapping[str, Any], report: Report) -> str:
    """Return the review's verdict on an error found in the corrected clip, or 'new' if none."""
    name = entry.get("limb") or entry["chain"]
    same = [
        j
        for j in report.state.intervals
        if (j.interval.chain, j.interval.kind) == (name, entry["kind"])
    ]
    shared = [
        (
            min(j.interval.stop, entry["stop"]) - max(j.interval.start, entry["start"]),
            report.verdict(j),
        )
        for j in same
    ]
    frames, verdict = max(shared, default=(0, ""))
    return verdict if frames > 0 else "new"
