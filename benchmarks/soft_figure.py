"""Draw the figure of docs/method.md, Soft errors: python -m benchmarks.soft_figure CLIP -o FILE.

Errors of 10-40°, low-pass filtered at 10 Hz (as in F10), are injected into a clip in which both
joints of every chain, parent P and child C, twist independently. The figure shows

- the twist of P and C,
- the part of P's twist that follows the sum of both twists, which no error changes,
- the differences between the twists and a bridge (an interpolation across the interval), and
- δ as found and as injected.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt

from benchmarks.straight_figure import with_titles
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection.soft_errors.departures import overlapping_frame_spans_by_length
from twistcore.detection.soft_errors.natural_scale import (
    natural_twist_departure_scales,
    unnaturally_large_twist_increments,
)
from twistcore.formats.bvh import read_bvh
from twistcore.synthesis import (
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)
from twistcore.synthesis.protocol import parent_and_child_twist_increments

BEFORE, AFTER, SOFT = "#a65300", "#1668b3", "#556170"
SPAN = 32  # length in frames of the drawn departures


def draw(clip: Path, name: str, seed: int, output: Path) -> None:
    """Draw the figure of the chain `name` into a file."""
    motion = read_bvh(clip).motion
    motion = motion.sliced(1, motion.frames)
    protocol = replace(parse_protocol("H12+F10"), delta=(10.0, 40.0))
    clean = prepare_clean_motion_for_injection(motion, analyse(motion).chains, protocol)
    chains = analyse(clean).chains
    chain = next(c for c in chains if c.name == name)
    errors = draw_errors(clean, [chain], clip_random_generator(seed, clip.name), protocol)
    erring = inject(clean, chains, errors)
    true, found = np.zeros(clean.frames), np.zeros(clean.frames)
    for e in errors:
        true[e.start : e.stop] = e.offset
    for i in automatic_corrections(analyse(erring).detect(kinds="counter-twist")):
        if i.chain == name:
            found[i.start : i.stop] += i.offset
    x, y = (v[None] for v in parent_and_child_twist_increments(erring, chain))
    bad = unnaturally_large_twist_increments(x, y, erring.fps)
    natural = natural_twist_departure_scales(
        x, y, erring.fps, overlapping_frame_spans_by_length(erring.fps, erring.frames), bad
    )
    n = min(natural, key=lambda n: abs(n.span.length - SPAN))
    u, total = n.rest(*(n.span.departures(np.cumsum(v, axis=1)) for v in (x, y)))
    spread, middle = n.spread(total)[1, 0], n.span.reach + n.span.length // 2
    at = (n.span.step * np.arange(u.shape[-1]) + middle) / erring.fps
    seconds = np.arange(clean.frames) / clean.fps
    beta = float(n.beta[0])
    figure, panels = plt.subplots(3, 1, figsize=(9, 6.5), sharex=True)
    level_x, level_y = (np.degrees(np.cumsum(v[0])) for v in (x, y))
    panels[0].plot(seconds, level_x, color=BEFORE, lw=1.4, label="P")
    panels[0].plot(seconds, level_y, color=AFTER, lw=1.4, label="C")
    with_sum = beta * (level_x + level_y)
    label = f"the part of P that follows P + C ({beta:.2f} of it)"
    panels[0].plot(seconds, with_sum, ":", color=SOFT, lw=1.4, label=label)
    panels[1].fill_between(
        at,
        *np.degrees([-3.0 * spread, 3.0 * spread]),
        color=SOFT,
        alpha=0.2,
        lw=0,
        label="natural: 3 σ",
    )
    panels[1].plot(at, np.degrees(u[1, 0]), ".-", ms=3, color=BEFORE, lw=1.0, label="u")
    panels[2].plot(seconds, np.degrees(true), color=SOFT, lw=3.0, alpha=0.4, label="injected")
    panels[2].plot(seconds, np.degrees(found), color=AFTER, lw=1.4, label="found")
    titles = (
        "twist so far of P and C, with the errors",
        f"departures from bridges over {n.span.length} frames, at their middle",
        "δ",
    )
    with_titles(panels, titles)
    for panel in panels:
        panel.legend(
            frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1, 0.98), ncols=3
        )
    figure.tight_layout()
    figure.savefig(output, dpi=110)


def main() -> None:
    """Draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clip", type=Path)
    parser.add_argument("--chain", default="LeftArm")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("-o", "--output", type=Path, required=True)
    arguments = parser.parse_args()
    draw(arguments.clip, arguments.chain, arguments.seed, arguments.output)


if __name__ == "__main__":
    main()
