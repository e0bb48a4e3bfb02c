"""Export intervals as timeline markers for other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from twistcore.detection import Kind
from twistcore.review.model import Judged

_BLENDER = '''"""Timeline markers of {clip}: run this in Blender's text editor."""

import bpy

# (name, first frame, last frame), counted from 0 as in the review
INTERVALS = {intervals}

scene = bpy.context.scene
first = scene.frame_start
for name, start, last in INTERVALS:
    scene.timeline_markers.new(f"{{name}} [", frame=first + start)
    scene.timeline_markers.new(f"] {{name}}", frame=first + last)
'''


def blender_markers(
    clip: str,
    intervals: Iterable[Judged],
    verdict: Callable[[Judged], str] = lambda judged: judged.verdict,
) -> str:
    """Return a Blender script that sets two markers for each interval that is not rejected.

    Parameters
    ----------
    clip
        Name of the clip.
    intervals
        The intervals.
    verdict
        A function that returns the text of the verdict on an interval.
    """
    rows = [
        (
            f"{_what(j)} {j.reported.angle_text(1)} {verdict(j)}",
            j.interval.start,
            j.interval.stop - 1,
        )
        for j in intervals
        if j.decision.value != "rejected"
    ]
    listed = "[\n" + "".join(f"    ({n!a}, {a}, {b}),\n" for n, a, b in rows) + "]"
    # The name must not end the script's docstring or reverse the direction of its text.
    safe = ascii(clip)[1:-1].replace("\\", "/").replace('"', "'")
    return _BLENDER.format(clip=safe, intervals=listed)


def _what(judged: Judged) -> str:
    """Return the name of an interval's chain or wrong joint, with the kind of error.

    The kind is omitted for a counter-twist.
    """
    interval = judged.interval
    name = interval.chain if interval.repairable or not interval.joint else interval.joint
    return name + ("" if interval.kind == Kind.COUNTER_TWIST else f" {interval.kind}")
