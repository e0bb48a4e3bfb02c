"""A BVH of two people, made of one clip twice."""

import re
from pathlib import Path

import numpy as np

from twistcore import read_clip

CLEAN = Path("assets/walk.bvh")
WRONG = Path("assets/walk_injected.bvh")


def two_people(pattern="*_B", *, root=False, apart=40.0, backwards=False, clips=(CLEAN, WRONG)):
    """The bytes: the clean walk, and the one with errors `apart` length units next to it.

    pattern: the second person's names, '*' is a joint's own; root: both hang on one joint;
    backwards: the second person walks from the last frame to the first; clips: others of equal
    length, instead of the walks.
    """
    clean, wrong = map(read_clip, clips)
    figures = []
    for clip, own in ((clean, "*"), (wrong, pattern)):
        head = clip.data[: clip.data_start].decode()
        head = head[head.index("ROOT") : head.index("MOTION")]
        renamed = re.sub(r"(ROOT|JOINT) (\S+)", rf"\1 {own.replace('*', chr(92) + '2')}", head)
        figures.append(renamed.replace("ROOT", "JOINT") if root else renamed)
    moved = wrong.values.copy()
    moved[:, 0] += apart
    moved = moved[::-1] if backwards else moved
    rows = np.hstack([clean.values, moved])
    body = "".join(figures)
    if root:
        body = f"ROOT World\n{{\nOFFSET 0 0 0\nCHANNELS 0\n{body}\n}}\n"
    text = "\n".join(" ".join(f"{v:.6f}" for v in row) for row in rows.tolist())
    timing = f"MOTION\nFrames: {len(rows)}\nFrame Time: {clean.frame_time:.7f}\n"
    return f"HIERARCHY\n{body}{timing}{text}\n".encode()
