"""Draw the figures for docs/jitter.md: python -m benchmarks.quamo_figures -o DIR.

A bundled clip at 25 Hz with synthetic noise of level A is tracked as a stream with hand-tuned
gains, and smoothed as a file. The figures show one second before and after, compared with the truth
[Le26 Fig. 3], onion-skin trails coloured by the error [Le26 Fig. 7], and the path of the root [Le26
Fig. 8].
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import LineCollection

from twistcore.formats.smpl.skeleton import ANKLES, PARENTS
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.methods import SPLINE, hand_tuned_method
from twistcore.study.quamo.noise import LEVELS, Noise
from twistcore.study.quamo.pose_errors import (
    pose_metrics,
    positions_relative_to_root,
    second_difference,
)
from twistcore.study.quamo.rivals import RIVALS
from twistcore.study.quamo.sequences import Sequence24, read_cmu_bvh_sequence
from twistcore.study.quamo.tables import noisy_clip

ASSETS = Path(__file__).resolve().parent.parent / "assets"
SEED = 0
TRUTH = "#333333"
STREAM_NAME, FILE_NAME = "stream (hand gains, causal)", "file (spline)"
COLOURS = {"truth": TRUTH, "input": "#d95f02", STREAM_NAME: "#1f78b4", FILE_NAME: "#6a3d9a"}
WRISTS, HEAD = (20, 21), 15
TURNED = 35.0  # viewing angle of figures in degrees
GHOST_EVERY = 8  # frames
LARGEST = 60.0  # mm/frame², the end of the colour scale
STYLE = {
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 110,
}


class Made:
    """The positions of joints in a clip in mm, shape (frames, 24, 3).

    Attributes
    ----------
    clip
        The clip.
    truth
        The true positions.
    shown
        The positions of the noisy input and of each result, keyed by name.
    """

    def __init__(self, name: str) -> None:
        self.clip: Sequence24 = read_cmu_bvh_sequence(ASSETS / f"{name}.bvh")
        q_hat, r_hat = noisy_clip(self.clip, Noise(LEVELS["A"]), SEED)
        of_file = next(rival for rival in RIVALS if rival.name == SPLINE)
        self.truth = self.clip.places_mm(self.clip.q, self.clip.r)
        self.shown: dict[str, Array] = {
            "input": self.clip.places_mm(q_hat, r_hat),
            STREAM_NAME: self.clip.places_mm(*hand_tuned_method()(self.clip, q_hat, r_hat)),
            FILE_NAME: self.clip.places_mm(*of_file.run(q_hat, r_hat, NETWORK_DT)),
        }


def seen(places: Array, turned: float) -> Array:
    """Project positions (…, 3) horizontally, and return (…, 2) in mm.

    `turned` is the angle of the view about the vertical, in degrees.
    """
    a = np.radians(turned)
    x = np.cos(a) * places[..., 0] + np.sin(a) * places[..., 2]
    return np.stack([x, places[..., 1]], axis=-1)


def bones(flat: Array) -> Array:
    """Return the lines of a pose from each joint to its parent, shape (23, 2, 2).

    `flat` are projected positions, (24, 2).
    """
    return np.stack([flat[1:], flat[list(PARENTS[1:])]], axis=1)


def spread(frames: int, apart: float) -> Array:
    """Return the shift of the figure to the right in each frame, (frames, 1, 2), in mm.

    `apart` is the distance between the figures of consecutive frames.
    """
    return np.stack([np.arange(frames) * apart, np.zeros(frames)], axis=1)[:, None]


def the_same_second(made: Made, start: int, folder: Path) -> None:
    """Draw six poses of one second from frame `start` on, and the acceleration of all joints."""
    at = slice(start, start + 26)
    fig, axes = plt.subplots(
        3, 2, figsize=(10.0, 6.6), width_ratios=(1.9, 1.0), layout="constrained", sharex="col"
    )
    there = seen(positions_relative_to_root(made.truth)[at], TURNED) + spread(26, 150.0)
    t = 40.0 * np.arange(26)
    for (skins, curve), (name, places) in zip(axes, made.shown.items(), strict=True):
        here = seen(positions_relative_to_root(places)[at], TURNED) + spread(26, 150.0)
        for f in range(0, 26, 5):
            skins.add_collection(LineCollection(bones(there[f]), colors=TRUTH, lw=1.0, alpha=0.6))
            skins.add_collection(LineCollection(bones(here[f]), colors=COLOURS[name], lw=2.0))
        for joint in WRISTS:
            skins.plot(*there[:, joint].T, color=TRUTH, lw=0.8, alpha=0.6)
            skins.plot(*here[:, joint].T, color=COLOURS[name], lw=1.2)
        found = pose_metrics(places[at], made.truth[at])
        skins.set_title(
            f"{name}: MPJPE {found.mpjpe:.0f} mm, Accel {found.accel:.1f} mm/frame²", loc="left"
        )
        skins.set_aspect("equal")
        skins.set_axis_off()
        for what, colour, width in ((made.truth, TRUTH, 1.2), (places, COLOURS[name], 1.8)):
            size = np.linalg.norm(
                second_difference(positions_relative_to_root(what)), axis=-1
            ).mean(axis=1)
            curve.plot(t, size[start - 1 : start + 25], color=colour, lw=width)
        curve.set_xlim(0.0, 1000.0)
        curve.set_ylim(0.0, 50.0)
    axes[0, 1].set_title("acceleration, mean of the joints, mm/frame²", loc="left")
    axes[-1, 1].set_xlabel("ms")
    legend(fig, list(made.shown))
    save(fig, folder / "jitter-second.png")


def trails(made: Made, folder: Path) -> None:
    """Draw poses, and the paths of limbs and head coloured by the error of their acceleration."""
    fig, axes = plt.subplots(3, 1, figsize=(10.0, 7.4), layout="constrained", sharex=True)
    mapped = mpl.cm.ScalarMappable(mpl.colors.Normalize(0.0, LARGEST), "plasma_r")
    truth = second_difference(positions_relative_to_root(made.truth))
    for ax, (name, places) in zip(axes, made.shown.items(), strict=True):
        here = positions_relative_to_root(places)
        off = np.linalg.norm(second_difference(here) - truth, axis=-1)
        flat = seen(here, TURNED) + spread(len(here), 90.0)
        for f in range(1, len(flat), GHOST_EVERY):
            ghost = LineCollection(bones(flat[f]), colors="#bbbbbb", lw=1.2, zorder=1)
            ax.add_collection(ghost)
        for joint in (*WRISTS, *ANKLES, HEAD):
            way = np.stack([flat[1:-2, joint], flat[2:-1, joint]], axis=1)
            colours = mapped.to_rgba(0.5 * (off[:-1, joint] + off[1:, joint]))
            ax.add_collection(LineCollection(way, colors=colours, lw=2.4, capstyle="round"))
        ax.set_title(name, loc="left")
        ax.autoscale_view()
        ax.set_aspect("equal")
        ax.set_axis_off()
    bar = fig.colorbar(mapped, ax=axes, shrink=0.6, pad=0.02, extend="max")
    bar.set_label("error of the acceleration, mm/frame²")
    save(fig, folder / "jitter-trails.png")


def root_path(made: Made, folder: Path) -> None:
    """Draw the path of the root from above, and its error in depth over time."""
    fig, (above, depth) = plt.subplots(
        1, 2, figsize=(10.0, 4.6), width_ratios=(1.0, 1.8), layout="constrained"
    )
    t = 0.04 * np.arange(len(made.truth))
    for name, places in {"truth": made.truth, **made.shown}.items():
        # The input is broad and pale, so that it is visible below other lines.
        width, alpha = (3.2, 0.5) if name == "input" else (1.5, 1.0)
        root = places[:, 0] / 1000.0
        above.plot(root[:, 0], root[:, 2], color=COLOURS[name], lw=width, alpha=alpha)
        off = 1000.0 * (root[:, 2] - made.truth[:, 0, 2] / 1000.0)
        depth.plot(t, off, color=COLOURS[name], lw=width, alpha=alpha)
    above.set_xlabel("sideways, m")
    above.set_ylabel("depth, m")
    above.set_aspect("equal", adjustable="datalim")
    above.set_title("path of the root, from above", loc="left")
    depth.set_xlabel("s")
    depth.set_ylabel("mm")
    depth.set_title("error of its depth", loc="left")
    legend(fig, list(made.shown))
    save(fig, folder / "jitter-root.png")


def legend(fig: Any, names: list[str]) -> None:
    """Draw one legend for all panels, below them."""
    shown = ["truth", *names]
    lines = [plt.Line2D([], [], color=COLOURS[name], lw=2.0) for name in shown]
    fig.legend(lines, shown, loc="outside lower center", ncols=len(shown), frameon=False)


def save(fig: Any, path: Path) -> None:
    """Save a figure as a PNG, optimised so that the file is small."""
    fig.savefig(path, pil_kwargs={"optimize": True})
    plt.close(fig)
    print(path)


def main() -> None:
    """Write the three figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        made = Made("dance")
        the_same_second(made, 20, folder)
        trails(made, folder)
        root_path(made, folder)


if __name__ == "__main__":
    mpl.use("agg")
    main()
