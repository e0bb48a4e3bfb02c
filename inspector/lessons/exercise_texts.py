"""The texts of an exercise: the page that explains it, and its result."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from inspector.bundled import EXERCISE_PAGE
from inspector.language import plural, tr, translated_page_path
from inspector.lessons.lesson_file import body_and_task
from inspector.widgets.signed_numbers import format_signed_number
from twistcore.detection import Interval
from twistcore.study.exercise import ExerciseScore
from twistcore.synthesis import InjectedError


def exercise_page() -> tuple[str, str, str]:
    """Return the title, the text and the task of the page that explains the exercise."""
    head, _, text = translated_page_path(EXERCISE_PAGE).read_text(encoding="utf-8").partition("\n")
    return (head.removeprefix("# ").strip(), *body_and_task(text.splitlines()))


def score_text(result: ExerciseScore, first_frame: int, label: Callable[[str], str]) -> str:
    """Return the result of an exercise as Markdown.

    `first_frame` is the number of the clip's first frame. `label` returns the displayed name of a
    chain.
    """
    lines = [
        tr(
            "**Hits {hits}** · **misses {misses}** · **false verdicts {wrong}**",
            hits=len(result.hits),
            misses=len(result.misses),
            wrong=result.false_verdicts,
        ),
        "",
    ]
    for title, rows in (
        (tr("Found"), result.hits),
        (tr("Missed"), result.misses),
        (tr("Errors that you rejected"), result.false_rejected),
        (tr("Natural motion that you accepted"), result.false_accepted),
    ):
        if rows:
            lines += [f"{title}:", ""]
            lines += [_row(r, first_frame, label(r.chain)) for r in rows]
            lines.append("")
    if result.left:
        lines.append(
            plural("{n} interval has no verdict.", "{n} intervals have no verdict.", result.left)
        )
    then = tr(
        "Next: click the places above and look at the stripes on the skin there. Then "
        "press *Next exercise* for new errors."
    )
    return "\n".join([*lines, "", then])


def _row(found: InjectedError | Interval, first: int, chain: str) -> str:
    largest = found.offset[int(np.argmax(np.abs(found.offset)))]
    degrees = f"{format_signed_number(np.degrees(largest), 0)}°"
    frames = tr(
        "{start} to {stop}", start=found.start + first, stop=found.stop + first
    )  # as in the columns Start and Stop of the table
    place = f"{chain}, {frames}, {degrees}"
    return f"- [{place}](at:{found.chain}/{found.start})"
