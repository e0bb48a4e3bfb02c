"""Draw the figure of docs/method.md, Straight limbs.

    python -m benchmarks.straight_figure CLIP -o FILE

An error of 35°, which is typical of solvers, is injected into a chain wherever its limb is straight
for a while. The figure shows its effect on the twist of the parent P and the child C and on the
azimuth of C's bone, and the corrected curves.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, remove_twist
from twistcore.detection.straight_limbs.straight_spells import BENT, limb_bend_per_frame
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.synthesis.offset_shape import spans_with_straight_chain

BEFORE, AFTER, SOFT = "#a65300", "#1668b3", "#556170"
DELTA, ONSET = np.radians(35.0), 0.1  # radians; seconds


def curves(motion, chain):
    """Return the twists of parent and child, the azimuth, and the bend, each of shape (frames,).

    The first three are in degrees, and the bend is in radians. The azimuth is NaN where it is
    undefined.
    """
    q_p, q_c = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
    x, y = twist_increments(q_p, q_c, chain.axis)
    bend = limb_bend_per_frame(q_c, chain.axis, chain.arm, motion.fps)
    return *(np.degrees(np.cumsum(v)) for v in (x, y)), np.degrees(bend.azimuth), bend.angle


def draw(clip: Path, name: str, output: Path) -> None:
    """Draw the figure of the chain `name` into a file."""
    motion = read_bvh(clip).motion
    motion = motion.sliced(1, motion.frames)
    chain = next(c for c in analyse(motion).chains if c.name == name)
    offset = np.zeros(motion.frames)
    ramp = round(ONSET * motion.fps)
    for start, stop in spans_with_straight_chain(motion, chain):
        if start > 0 and stop < motion.frames and stop - start > ramp:
            level = [start - 1, start + ramp // 2, stop - 1 - ramp // 2, stop]
            own = np.interp(np.arange(start, stop), level, [0, 1, 1, 0])
            offset[start:stop] = DELTA * own
    erring = remove_twist(motion, [chain], {name: -offset})
    found = analyse(erring)
    intervals = automatic_corrections(found.detect(kinds="counter-twist"))
    after = refine(erring, found.chains, intervals)
    seconds = np.arange(motion.frames) / motion.fps
    figure, panels = plt.subplots(3, 1, figsize=(9, 6), sharex=True)
    for what, colour, style in ((erring, BEFORE, "-"), (after, AFTER, "-"), (motion, SOFT, ":")):
        x, y, azimuth, bend = curves(what, chain)
        label = {id(erring): "with the error", id(after): "corrected"}.get(id(what), "as captured")
        panels[0].plot(seconds, x, style, color=colour, label=f"P, {label}", lw=1.4)
        panels[0].plot(seconds, y, style, color=colour, lw=0.8)
        panels[1].plot(seconds, azimuth, style, color=colour, lw=1.4)
    panels[2].plot(seconds, np.degrees(bend), color=SOFT)
    panels[2].axhline(np.degrees(BENT), color=SOFT, lw=0.6, ls="--")
    titles = (
        "twist so far of P (thick) and C (thin)",
        "side to which C's bone leaves P's",
        "bend; above the dashes the twist is well determined",
    )
    with_titles(panels, titles)
    for panel in panels:
        for i in (i for i in intervals if i.chain == name):
            panel.axvspan(seconds[i.start], seconds[i.stop - 1], color=BEFORE, alpha=0.1, lw=0)
    figure.legend(*panels[0].get_legend_handles_labels(), frameon=False, fontsize=8, ncols=3)
    figure.tight_layout()
    figure.savefig(output, dpi=110)


def with_titles(panels: Sequence[Any], titles: Sequence[str]) -> None:
    """Set the titles and the axes, degrees and seconds, of panels that are one above the other."""
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, fontsize=9, loc="left")
        panel.set_ylabel("degrees")
        panel.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("seconds")


def main() -> None:
    """Draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clip", type=Path)
    parser.add_argument("--chain", default="RightArm")
    parser.add_argument("-o", "--output", type=Path, required=True)
    arguments = parser.parse_args()
    draw(arguments.clip, arguments.chain, arguments.output)


if __name__ == "__main__":
    main()
