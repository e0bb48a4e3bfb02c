"""Draw figures for docs/method.md.

    python -m benchmarks.figures CLIPS --benchmark RESULT.json -o DIR

mae_by_segment.png shows the mean absolute error (MAE) by segment before and after correction, for
both detectors [Choi26 Fig. 6]. flips.png shows the real flips in CLIPS that the benchmark's audit
finds, with the joint's rotation per frame as evidence independent of the detector; the flips are
also printed as a table. With --alarms FOLDER…, alarms.png shows the detections in clips without
injected errors, with Δθp and Δθc around them.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt

from twistcore.analysis.clip_analysis import analyse, detect
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.detection.natural_events import FLIP, NaturalEvent, natural_events
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.synthesis.protocol import parent_and_child_twist_increments

BEFORE, AFTER, SOFT = "#a65300", "#1668b3", "#556170"
SEGMENTS = ("Shoulder", "Arm", "ForeArm", "UpLeg", "Leg")


def mae_by_segment(result: dict, path: Path) -> None:
    """Plot the mean absolute error before and after correction, with one panel per detector."""
    methods = [m for m in ("paper", "consistency") if any(r["method"] == m for r in result["rows"])]
    figure, panels = plt.subplots(1, len(methods), figsize=(9, 3.2), sharey=True, squeeze=False)
    for panel, method in zip(panels[0], methods, strict=True):
        rows = {
            (r["side"], r["segment"]): r
            for r in result["rows"]
            if r["method"] == method and r["protocol"] == "P0" and not r["audited"]
        }
        keys = [(s, g) for s in ("Left", "Right") for g in SEGMENTS if (s, g) in rows]
        at = np.arange(len(keys))
        before = [rows[k]["mae_before_deg"] for k in keys]
        after = [rows[k]["mae_after_deg"] for k in keys]
        panel.bar(
            at - 0.2, before, 0.4, color="white", edgecolor=BEFORE, hatch="//", label="before"
        )
        panel.bar(at + 0.2, after, 0.4, color=AFTER, label="after")
        for x, value in zip(at, after, strict=True):
            panel.text(x + 0.2, value + 1, f"{value:.1f}", ha="center", fontsize=7, color=AFTER)
        panel.set_xticks(at, [f"{s[0]} {g}" for s, g in keys], rotation=60, fontsize=8)
        panel.set_title({"paper": "paper's detector", "consistency": "ours"}[method], fontsize=10)
        panel.spines[["top", "right"]].set_visible(False)
    panels[0][0].set_ylabel("MAE, degrees")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=8, ncols=2, loc="upper right")
    figure.tight_layout()
    figure.savefig(path, dpi=130)


def turns(motion: Motion, joint: int) -> np.ndarray:
    """Return the rotation of a joint between consecutive frames, in degrees, (frames − 1,)."""
    q = motion.rotations[:, joint]
    return np.degrees(geodesic_angle(q[:-1], q[1:]))


def flips(folder: Path) -> list[tuple[str, str, Motion, NaturalEvent]]:
    """Return the clip's name, the joint, the motion and the event of every flip in a folder."""
    found = []
    for path in clip_paths_in_folder(folder, suffixes=BVH):
        motion = read_bvh(path).motion
        names = motion.skeleton.names
        given = analyse(motion)
        events = natural_events(given.chains, given.by())
        found += [(path.stem, names[e.joint], motion, e) for e in events if e.kind == FLIP]
    return found


def flip_figure(found: list[tuple[str, str, Motion, NaturalEvent]], path: Path) -> None:
    """Draw the rotation per frame of the joint that flips most often, one panel per clip."""
    clips = list(dict.fromkeys(clip for clip, *_ in found))
    columns = 2
    rows = -(-len(clips) // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(10, 1.6 * rows), squeeze=False)
    for panel in panels.flat[len(clips) :]:
        panel.set_visible(False)
    for panel, clip in zip(panels.flat, clips, strict=False):
        own = [f for f in found if f[0] == clip]
        joints = [joint for _, joint, _, _ in own]
        joint = max(dict.fromkeys(joints), key=joints.count)
        events = [(m, e) for _, j, m, e in own if j == joint]
        motion = events[0][0]
        turned = turns(motion, events[0][1].joint)
        panel.plot(np.arange(1, motion.frames), turned, color=SOFT, lw=0.8)
        at = np.array([e.start for _, e in events])
        panel.plot(at, turned[at - 1], "v", color=BEFORE, ms=4, mfc="none")
        panel.set_title(f"{clip} {joint}", fontsize=8, loc="left")
        panel.set_ylim(0, 190)
        panel.set_xlim(max(0, min(at) - 60), min(motion.frames, max(at) + 60))
        panel.tick_params(labelsize=7)
        panel.spines[["top", "right"]].set_visible(False)
    figure.supylabel("turn of the joint per frame, degrees", fontsize=8)
    figure.supxlabel("frame", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=130)


def flip_table(found: list[tuple[str, str, Motion, NaturalEvent]]) -> str:
    """Return a table with the frames and the angles of the flips, one line per clip and joint."""
    lines = ["| clip | joint | frame (degrees about the bone) |", "|---|---|---|"]
    for key in dict.fromkeys((clip, joint) for clip, joint, *_ in found):
        events = [e for clip, joint, _, e in found if (clip, joint) == key]
        listed = ", ".join(f"{e.start} ({e.degrees:+.0f}°)" for e in events)
        lines.append(f"| {key[0]} | {key[1]} | {listed} |")
    return "\n".join(lines) + "\n"


def alarm_figure(folders: list[Path], path: Path) -> int:
    """Draw Δθp and Δθc around each detection in the clips. Return the number of detections."""
    found = []
    for clip in (c for folder in folders for c in clip_paths_in_folder(folder, suffixes=BVH)):
        motion = read_bvh(clip).motion
        first = count_leading_rest_frames(motion)
        motion = motion.sliced(first, motion.frames)
        chains = find_chains(motion)
        found += [(clip.stem, motion, chains, i, first) for i in detect(motion, chains)]
    columns = 3
    rows = max(1, -(-len(found) // columns))
    figure, panels = plt.subplots(rows, columns, figsize=(10, 1.9 * rows), squeeze=False)
    for panel in panels.flat[len(found) :]:
        panel.set_visible(False)
    for panel, (clip, motion, chains, interval, first) in zip(panels.flat, found, strict=False):
        chain = next(c for c in chains if c.name == interval.chain)
        x, y = parent_and_child_twist_increments(motion, chain)
        low, high = max(0, interval.start - 25), min(motion.frames, interval.stop + 25)
        at = np.arange(low, high)
        panel.axvspan(interval.start - 0.5 + first, interval.stop - 0.5 + first, color="#dddddd")
        panel.plot(at + first, np.degrees(x[low:high]), color=BEFORE, lw=0.9, label="Δθp, parent")
        panel.plot(
            at + first, np.degrees(y[low:high]), color=AFTER, lw=0.9, ls="--", label="Δθc, child"
        )
        delta = np.degrees(interval.delta)
        panel.set_title(f"{clip} {chain.name} {delta:+.1f}°", fontsize=8, loc="left")
        panel.tick_params(labelsize=7)
        panel.spines[["top", "right"]].set_visible(False)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=8, ncols=2, loc="lower right")
    figure.supylabel("twist per frame, degrees", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    return len(found)


def main() -> None:
    """Write the chosen figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clips", type=Path)
    parser.add_argument("--benchmark", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    parser.add_argument("--alarms", type=Path, nargs="*", default=[])
    arguments = parser.parse_args()
    result = json.loads(arguments.benchmark.read_text(encoding="utf-8"))
    mae_by_segment(result, arguments.output / "mae_by_segment.png")
    found = flips(arguments.clips)
    flip_figure(found, arguments.output / "flips.png")
    print(flip_table(found))
    if arguments.alarms:
        print(alarm_figure(arguments.alarms, arguments.output / "alarms.png"), "alarms")


if __name__ == "__main__":
    main()
