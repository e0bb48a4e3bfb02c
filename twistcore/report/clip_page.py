"""Write the page of a clip, with pictures of its worst intervals, curves, decisions and changes."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from markupsafe import Markup

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction import Corrected, refine
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Kind
from twistcore.errors import TwistError
from twistcore.export.compare import compare
from twistcore.export.detection_json import intervals_to_json
from twistcore.report.changes import (
    check_fidelity,
    joint_changes,
    remaining_detection,
)
from twistcore.report.curve_drawing import ClipCurves, weight
from twistcore.report.document import Report, reported_moves
from twistcore.report.page_templates import rendered
from twistcore.report.picture_job import SIZE, Drawn, Figure, draw_figures, figure_of
from twistcore.report.played_finds import (
    NOTHING_PLAYED,
    Played,
    applied_and,
    pictured_frame,
    played_data,
)
from twistcore.review.model import Decision, Judged
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.notes import NOT_EXAMINED, UNEXAMINED
from twistcore.skeleton.rotation import largest_and_rms
from twistcore.work.frozen import dataclass

WORST = 3  # intervals shown in pictures


@dataclass(frozen=True)
class Home:
    """The folder page to which a clip's page belongs.

    `address` is the path of the folder page relative to the clip's page.
    """

    title: str
    address: str


def clip_page(
    document: Mapping[str, Any],
    report: Report,
    drawn: Drawn | None = None,
    home: Home | None = None,
    played: Played = NOTHING_PLAYED,
) -> str:
    """Return the page of a clip as HTML.

    `document` is the result of :func:`document.report_to_json`. `drawn` are the pictures; without
    them, the page does not mention pictures. `played` are the intervals that the page plays if
    `drawn` has the figure for them.
    """
    analysis = report.analysed
    state, corrected = report.state, Corrected(analysis)
    corrected.take(report.applied)
    method = _strength_by(analysis, state.method)
    drawing = ClipCurves(analysis, method, state.tau, state.intervals, report.verdict)
    curves, left_out = drawing.panels(corrected)
    return rendered(
        "clip.html",
        report=document,
        home=home,
        size=SIZE,
        finds=_finds(report, analysis, drawing, _worst(report), drawn),
        play=_play(report, analysis, drawing, drawn, played),
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
        **reported_moves(document, report),
        **_changes(report),
    )


def figure_of_worst(report: Report, played: Played = NOTHING_PLAYED) -> Figure | None:
    """Return the figure to draw for a page, or None if there is nothing to draw."""
    worst, motion = _worst(report), report.clip.motion
    if not (worst or played.finds):
        return None
    chosen = [j.interval for j in worst]
    after = refine(motion, report.chains, applied_and(report, *chosen))
    wanted = [(i.chain, pictured_frame(i)) for i in chosen]
    views = [
        (f.judged.interval.chain, motion.at(one), f.after.at(one - f.span[0]))
        for f in played.finds
        for one in [np.array([f.frame])]
    ]
    return figure_of(motion, after, report.chains, wanted, views)


def drawn_with(report: Report, played: Played = NOTHING_PLAYED) -> Drawn:
    """Draw the pictures for the page of a clip, and prepare the figure that plays."""
    figure = figure_of_worst(report, played)
    return draw_figures([figure])[0] if figure else Drawn()


# -- the worst intervals ---------------------------------------------------------------------------


def _worst(report: Report) -> list[Judged]:
    """Return up to WORST intervals that are not rejected, sorted by degrees × frames."""
    names = {chain.name for chain in report.chains}
    may = [
        j
        for j in report.state.intervals
        if j.counts and j.decision != Decision.REJECTED and j.interval.chain in names
    ]
    return sorted(may, key=lambda j: (-weight(j), j.interval.start))[:WORST]


def _finds(
    report: Report,
    analysis: ClipAnalysis,
    drawing: ClipCurves,
    judged_finds: Sequence[Judged],
    drawn: Drawn | None = None,
) -> list[dict[str, Any]]:
    chains = {chain.name: chain for chain in report.chains}
    out = []
    for k, judged in enumerate(judged_finds):
        interval, chain = judged.interval, chains[judged.interval.chain]
        alone = Corrected(analysis)
        alone.take(applied_and(report, interval))
        stuck = report.stuck.get(judged.id, ())
        find: dict[str, Any] = {
            "id": judged.id,
            "label": chain.label,
            "limb": isinstance(chain, Limb),
            "alone": "" if interval.repairable else interval.joint,
            "kind": interval.kind.value,
            "interval": interval,
            "degrees": float(np.degrees(interval.shown)),
            "frame": pictured_frame(interval),
            "seconds": pictured_frame(interval) / report.clip.motion.fps,
            "verdict": report.verdict(judged),
            "applied": judged.decision == Decision.ACCEPTED,
            "stuck": stuck,
            "panel": drawing.near(alone, judged),
            "pictures": None,
        }
        if drawn is not None and k < len(drawn.pictures):
            # An interval that cannot be corrected has no picture of a corrected pose.
            pictures = drawn.pictures[k][:1] if stuck else drawn.pictures[k]
            find["pictures"] = [_as_address(picture) for picture in pictures]
        out.append(find)
    return out


def _play(
    report: Report,
    analysis: ClipAnalysis,
    drawing: ClipCurves,
    drawn: Drawn | None,
    played: Played,
) -> dict[str, Any] | None:
    """Return what the page needs to play its intervals, or None if it does not play any."""
    player = drawn.player if drawn is not None else {}
    if not (played.finds and player):
        return None
    if "problem" in player:
        return {**player, "finds": ()}
    finds = _finds(report, analysis, drawing, [find.judged for find in played.finds])
    return {
        "problem": "",
        "finds": [f | {"plays": p} for f, p in zip(finds, played.finds, strict=True)],
        "left_out": [judged.interval for judged in played.left_out],
        "data": played_data(report, played, player),
        "scripts": list(map(Markup, player["scripts"])),
    }


def _as_address(picture: bytes) -> str:
    return f"data:image/jpeg;base64,{base64.b64encode(picture).decode()}"


# -- decisions and changes -------------------------------------------------------------------------


def _decisions(
    document: Mapping[str, Any], report: Report
) -> list[tuple[Mapping[str, Any], dict[str, Any]]]:
    """Return the entries of all intervals, with additional data for the page."""
    out = []
    for row, one in zip(document["intervals"], report.state.intervals, strict=True):
        largest, rms = largest_and_rms(one.interval.offset)
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
    changes = joint_changes(motion, report.refined, compare(motion, report.refined))
    kept, trouble = None, ""
    if report.written is not None:
        try:
            kept = check_fidelity(report.clip, report.refined, report.written)
        except TwistError as error:
            trouble = str(error)
    left = report.left
    method = report.state.method
    if left is None and changes and _strength_by(report.analysed, method) == method:
        left = intervals_to_json(remaining_detection(report.refined, report.chains, report.state))
    if left is not None:
        left = [
            {**e, "before": _earlier_verdict(e, report), "lone": not Kind(e["kind"]).repairable}
            for e in left
        ]
    return {"changes": changes, "kept": kept, "trouble": trouble, "left": left}


def _strength_by(analysis: ClipAnalysis, method: str) -> str:
    """Return the name of the review's detector, or of the default if it is missing or fails."""
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
    """Return the earlier verdict on a remaining interval, or 'new' if there was none.

    `entry` is the interval as in `detect --json`.
    """
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
