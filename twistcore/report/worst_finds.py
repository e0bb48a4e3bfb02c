"""Prepare the pictures, the curves and the animated figure of the worst intervals of a clip."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.correction.twist_removal import refine
from twistcore.report.curve_drawing import ClipCurves, interval_severity
from twistcore.report.document import Report
from twistcore.report.picture_job import Drawn, Figure, draw_figures, make_clip_figure
from twistcore.report.played_finds import (
    merge_applied_intervals,
    pictured_frame,
    player_script_data,
    select_intervals_to_play,
)
from twistcore.review.model import Decision, Judged
from twistcore.skeleton.limb import Limb

WORST = 3  # intervals shown in pictures


def worst_intervals_figure(report: Report, play: bool = False) -> Figure | None:
    """Return the figure to draw for a page, or None if there is nothing to draw.

    If `play` is True, the figure includes views of the intervals that the page plays.
    """
    played = select_intervals_to_play(report)[0] if play else []
    worst, motion = worst_intervals(report), report.clip.motion
    if not (worst or played):
        return None
    chosen = [j.interval for j in worst]
    after = refine(motion, report.chains, merge_applied_intervals(report, *chosen))
    wanted = [(i.chain, pictured_frame(i)) for i in chosen]
    views = [
        (f.judged.interval.chain, motion.at(one), f.after.at(one - f.span[0]))
        for f in played
        for one in [np.array([f.frame])]
    ]
    return make_clip_figure(motion, after, report.chains, wanted, views)


def draw_pictures(report: Report, play: bool = False) -> Drawn:
    """Draw the pictures for a clip's page and, if `play` is True, prepare the animated figure."""
    figure = worst_intervals_figure(report, play)
    return draw_figures([figure])[0] if figure else Drawn()


def worst_intervals(report: Report) -> list[Judged]:
    """Return up to WORST intervals that are not rejected, sorted by degrees × frames."""
    names = {chain.name for chain in report.chains}
    may = [
        j
        for j in report.state.intervals
        if j.counts and j.decision != Decision.REJECTED and j.interval.chain in names
    ]
    return sorted(may, key=lambda j: (-interval_severity(j), j.interval.start))[:WORST]


def interval_page_data(
    report: Report,
    analysis: ClipAnalysis,
    drawing: ClipCurves,
    judged_finds: Sequence[Judged],
    drawn: Drawn | None = None,
) -> list[dict[str, Any]]:
    """Return the data that the page shows for the given intervals.

    Parameters
    ----------
    report
        The report.
    analysis
        The analysis of the clip.
    drawing
        Draws the curves.
    judged_finds
        The intervals.
    drawn
        Pictures of the first intervals, or None.
    """
    chains = {chain.name: chain for chain in report.chains}
    out = []
    for k, judged in enumerate(judged_finds):
        interval, chain = judged.interval, chains[judged.interval.chain]
        alone = Corrected(analysis)
        alone.take(merge_applied_intervals(report, interval))
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


def player_page_data(
    report: Report, analysis: ClipAnalysis, drawing: ClipCurves, drawn: Drawn | None
) -> dict[str, Any] | None:
    """Return the data that a page needs to play intervals, or None if `drawn` has no such data."""
    player = drawn.player if drawn is not None else {}
    if not player or "problem" in player:
        return {**player, "finds": ()} if player else None
    played, left_out = select_intervals_to_play(report)
    finds = interval_page_data(report, analysis, drawing, [find.judged for find in played])
    return {
        "problem": "",
        "finds": [f | {"plays": p} for f, p in zip(finds, played, strict=True)],
        "left_out": [judged.interval for judged in left_out],
        "data": player_script_data(report, played, player),
        "scripts": list(map(Markup, player["scripts"])),
    }


def _as_address(picture: bytes) -> str:
    return f"data:image/jpeg;base64,{base64.b64encode(picture).decode()}"
