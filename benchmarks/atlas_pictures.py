"""Draw detections: the limb before, during and after the interval, and its curves over time.

The two joints of a chain are called P (parent) and C (child), and E is the end of a limb. Only the
skeleton is drawn. Bones are flat bodies with a light and a dark face, so that their roll is
visible. :mod:`benchmarks.atlas` uses this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.patches import Polygon

from twistcore.detection import Kind
from twistcore.detection.limb_flips.swivel import compute_limb_swivel
from twistcore.detection.lone_jumps import largest_natural_turn
from twistcore.detection.straight_limbs.straight_spells import limb_bend_per_frame
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rig import AS_FOUND
from twistcore.skeleton.rotation import conjugate, multiply, rotate, twist_angle, wrap
from twistcore.skeleton.signals import counter_rotation
from twistcore.skeleton.twist_increments import twist_increments

Array = NDArray[np.float64]

WRONG, RIGHT, SOFT, INK = "#a65300", "#1668b3", "#8794a3", "#222222"
FACES = (("#e8a15c", "#7a3d00"), ("#8fbde6", "#0e4a80"))  # light and dark face of P and of C
WIDTH = 0.16  # half of a body's width as a share of the bone's length
STRAIGHT = 8.0  # degrees; the azimuth is undefined if the limb is bent by less
AROUND = 0.35  # seconds of curve on either side, or half of the interval if this is longer
A_SHEET, COLUMNS = 12, 2


def sheet(rows: Sequence[tuple[str, Path, Any]], output: Path, start: int = 0) -> None:
    """Draw numbered detections in a grid, from number `start` on.

    Each of `rows` is (set, path of the clip, Find).
    """
    figure = plt.figure(figsize=(17.2, 2.85 * -(-len(rows) // COLUMNS)), dpi=72)
    grid = figure.subfigures(-(-len(rows) // COLUMNS), COLUMNS, squeeze=False)
    for k, (name, clip, find) in enumerate(rows):
        one(grid[k // COLUMNS, k % COLUMNS], f"#{start + k}  {name}", clip, find)
    figure.savefig(output)
    plt.close(figure)


def one(figure: Any, title: str, clip: Path, find: Any) -> None:
    """Draw a detection into a figure: three poses from two sides, the twists, and the evidence."""
    motion = read_motion(clip)
    chain = next(c for c in AS_FOUND.chains(motion) if c.name == find.chain)
    sure = "–" if find.confidence is None else f"{find.confidence:.2f}"
    told = f"{'applied' if find.applied else 'shown'}{', open' if find.open else ''}"
    figure.suptitle(
        f"{title} · {clip.stem[-34:]} · {find.chain} {find.joint} [{find.start}, {find.stop}) of "
        f"{motion.frames} @ {motion.fps:.0f} · {find.kind} {find.degrees:+.0f}° · {sure} {told}",
        fontsize=8.5,
        x=0.01,
        ha="left",
    )
    _panels(figure, motion, chain, find, bare=False)


def picture(clip: Path, find: Any, output: Path, *, bare: bool) -> None:
    """Draw a detection into a file. If `bare` is True, draw bones as lines instead of bodies."""
    motion = read_motion(clip)
    chain = next(c for c in AS_FOUND.chains(motion) if c.name == find.chain)
    figure = plt.figure(figsize=(9.6, 2.9), dpi=74)
    _panels(figure, motion, chain, find, bare=bare)
    figure.savefig(output, pil_kwargs={"optimize": True})
    plt.close(figure)


def _panels(figure: Any, motion: Motion, chain: Chain, find: Any, *, bare: bool) -> None:
    poses, turns, evidence = figure.subplots(
        1, 3, gridspec_kw={"width_ratios": (1.0, 1.25, 1.25), "left": 0.0, "right": 0.965}
    )
    figure.subplots_adjust(top=0.86, bottom=0.1, wspace=0.14)
    frames = _window(motion, find)
    draw_poses(poses, motion, chain, find, bare=bare)
    _curves(turns, evidence, motion, chain, find, frames)
    for panel in (turns, evidence):
        panel.axvspan(find.start - 0.5, find.stop - 0.5, color=WRONG, alpha=0.12, lw=0)
        panel.set_xlim(frames[0], frames[-1])
        panel.tick_params(labelsize=7.5, pad=1)
        panel.spines[["top", "right"]].set_visible(False)
        panel.legend(
            fontsize=7.5,
            frameon=False,
            loc="lower left",
            ncols=4,
            borderpad=0,
            bbox_to_anchor=(0.0, 0.99),
            columnspacing=1.0,
            handlelength=1.4,
        )


_kept: dict[Path, Motion] = {}


def read_motion(clip: Path) -> Motion:
    """Return the motion of a clip. The motion of the last clip is cached."""
    if clip not in _kept:
        _kept.clear()
        _kept[clip] = read_clip(clip).motion
    return _kept[clip]


def _window(motion: Motion, find: Any) -> NDArray[np.int64]:
    beside = round(max(AROUND * motion.fps, 0.5 * (find.stop - find.start), 8))
    return np.arange(max(find.start - beside, 0), min(find.stop + beside, motion.frames))


def draw_poses(panel: Any, motion: Motion, chain: Chain, find: Any, *, bare: bool = False) -> None:
    """Draw the bones of P and C before, during and after the interval, from two sides.

    The poses are in the coordinates of P's parent, so that only the limb moves and all poses are
    seen from the same direction.
    """
    middle = (find.start + find.stop - 1) // 2
    shown = [max(find.start - 2, 0), middle, min(find.stop + 1, motion.frames - 1)]
    part = motion.sliced(min(shown), max(shown) + 1)
    rotations, positions = forward_kinematics(part)
    at = [f - min(shown) for f in shown]
    above = int(motion.skeleton.parents[chain.parent])
    back = conjugate(rotations[at, above]) if above >= 0 else np.tile([1.0, 0, 0, 0], (len(at), 1))
    tip = _tip(chain, rotations, positions, motion)
    places_of = [positions[:, chain.parent], positions[:, chain.child], tip]
    p, c, g = (rotate(back, (v - positions[:, chain.parent])[at]) for v in places_of)
    turned = [multiply(back, rotations[at, j]) for j in (chain.parent, chain.child)]
    sideways = np.cross(c[0] - p[0], g[0] - c[0])
    if np.linalg.norm(sideways) < 0.05 * np.linalg.norm(c[0]) * np.linalg.norm(g[0] - c[0]):
        sideways = np.cross(c[0] - p[0], np.eye(3)[int(np.argmin(np.abs(c[0] - p[0])))])
    view = sideways / max(float(np.linalg.norm(sideways)), 1e-9)
    up = (p[0] - g[0]) - view * float(view @ (p[0] - g[0]))
    up /= max(float(np.linalg.norm(up)), 1e-9)
    length = float(np.linalg.norm(c[0] - p[0]) + np.linalg.norm(g[0] - c[0]))
    for row, eye in enumerate((view, np.cross(up, view))):
        right = np.cross(up, eye)
        for k in range(3):
            origin = np.array([k * 0.95, -row * 1.2])
            for b, (a, z, q) in enumerate(((p[k], c[k], turned[0][k]), (c[k], g[k], turned[1][k]))):
                draw_bone(
                    panel, (a / length, z / length), q, (right, up, eye), origin, FACES[b], bare
                )
    for k, word in enumerate(("before", "inside", "after")):
        panel.text(k * 0.95, 0.16, f"{word} {shown[k]}", ha="center", fontsize=7.5, color=INK)
    panel.set_xlim(-0.6, 2.5)
    panel.set_ylim(-2.45, 0.3)
    panel.set_aspect("equal")
    panel.axis("off")


def _tip(chain: Chain, rotations: Array, positions: Array, motion: Motion) -> Array:
    """Return the end of C's bone, (frames, 3): the grandchild, or a point along C's axis."""
    if chain.grandchild >= 0:
        return positions[:, chain.grandchild]
    size = 0.6 * float(np.linalg.norm(motion.skeleton.offsets[chain.child]))
    arm = chain.arm if chain.arm.ndim == 1 else chain.arm[: len(positions)]
    return positions[:, chain.child] + size * rotate(rotations[:, chain.child], arm)


def draw_bone(panel: Any, ends: Any, q: Array, view: Any, at: Array, face: Any, bare: bool) -> None:
    """Draw a flat body between two joints. Its wide side is fixed to the joint.

    Parameters
    ----------
    panel
        The axes of matplotlib.
    ends
        The positions of both joints.
    q
        The rotation of the joint, a quaternion (w, x, y, z).
    view
        The directions to the right, upward and to the viewer.
    at
        The position of the origin in the panel.
    face
        The light and the dark colour.
    bare
        True to draw a line instead.
    """
    right, up, eye = view
    a, z = ends
    along = (z - a) / max(float(np.linalg.norm(z - a)), 1e-9)
    own = rotate(conjugate(q), along)
    least = np.eye(3)[int(np.argmin(np.abs(own)))]
    side = rotate(q, np.cross(own, least) / np.linalg.norm(np.cross(own, least)))
    light = float(np.cross(along, side) @ eye) > 0.0
    wide = WIDTH * float(np.linalg.norm(z - a)) * side
    line = [at + np.array([v @ right, v @ up]) for v in (a, z)]
    panel.plot(
        *np.transpose(line), color=INK, lw=2.0 if bare else 0.7, marker="o" if bare else "", ms=3
    )
    if bare:
        return
    corners = (a - wide, a + wide, z + 0.45 * wide, z - 0.45 * wide)
    flat = [at + np.array([v @ right, v @ up]) for v in corners]
    panel.add_patch(Polygon(flat, fc=face[0] if light else face[1], ec=INK, lw=0.5))
    edge = [at + np.array([v @ right, v @ up]) for v in (a + wide, z + 0.45 * wide)]
    panel.plot(*np.transpose(edge), color="#d0006f", lw=1.6)


def _curves(
    turns: Any, evidence: Any, motion: Motion, chain: Chain, find: Any, frames: Any
) -> None:
    """Plot the twists with and without the interval's offset, and the evidence."""
    offset = np.zeros(motion.frames)
    offset[find.start : find.stop] = find.offset
    if isinstance(chain, Limb):
        _of_a_limb(turns, evidence, motion, chain, offset, frames)
        return
    q_p, q_c = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
    x, y = (np.degrees(v) for v in twist_increments(q_p, q_c, chain.axis))
    sums = [np.cumsum(v)[frames] for v in (x, y)]
    for total, colour, word in zip(sums, (WRONG, RIGHT), ("P", "C"), strict=True):
        turns.plot(frames, total - total[0], color=colour, lw=1.5, label=f"{word} turned")
    turns.plot(frames, sum(t - t[0] for t in sums), color=SOFT, lw=0.9, label="P + C")
    if find.kind != Kind.LONE_JUMP:
        off = np.unwrap(np.radians(offset))[frames] * 180 / np.pi
        off = off - off[0]
        turns.plot(frames, sums[0] - sums[0][0] - off, ":", color=WRONG, lw=1.3, label="without")
        turns.plot(frames, sums[1] - sums[1][0] + off, ":", color=RIGHT, lw=1.3)
    bend = np.degrees(limb_bend_per_frame(q_c, chain.axis, chain.arm, motion.fps).angle)
    if find.kind == Kind.LONE_JUMP:
        _of_a_joint(evidence, motion, find, frames)
        return
    m = np.degrees(counter_rotation(np.radians(x), np.radians(y)))
    evidence.plot(frames, m[frames], color=INK, lw=1, label="strength °/frame")
    azimuth = _azimuth(q_c, chain)
    _bend(evidence, bend, frames)
    told = bend > STRAIGHT
    own = np.where(told, azimuth, np.nan)[frames]
    evidence.plot(frames, own, color=WRONG, lw=1.2, label="azimuth")
    after = np.where(told, wrap(np.radians(azimuth + offset)) * 180 / np.pi, np.nan)[frames]
    evidence.plot(frames, after, ":", color=WRONG, lw=1.2)


def _bend(panel: Any, bend: Array, frames: Any) -> None:
    """Plot the bend of the limb on a second axis, from 0 to 180 degrees."""
    own = panel.twinx()
    own.fill_between(frames, bend[frames], color=SOFT, alpha=0.18, lw=0)
    own.set_ylim(0, 180)
    own.tick_params(labelsize=7, pad=1, colors=SOFT)
    own.spines[["top", "left"]].set_visible(False)


def _azimuth(q_c: Array, chain: Chain) -> Array:
    """Return the direction of C's bone about P's bone axis, degrees from its mean, (frames,)."""
    v = rotate(q_c, chain.arm)
    axis = np.broadcast_to(chain.axis, v.shape)
    across = v - np.einsum("fi,fi->f", v, axis)[:, None] * axis
    beside = np.cross(axis[0], np.eye(3)[int(np.argmin(np.abs(axis[0])))])
    first = beside / np.linalg.norm(beside)
    x, y = (across @ first, np.einsum("fi,fi->f", across, np.cross(axis, first)))
    return np.degrees(wrap(np.arctan2(y, x) - np.arctan2(y.sum(), x.sum())))


def _of_a_joint(panel: Any, motion: Motion, find: Any, frames: Any) -> None:
    """Plot the twist of the jumping joint about its axis, global and relative to its parent."""
    joint = motion.skeleton.index(find.joint)
    axis = own_bone_axis(motion.skeleton, joint)
    part = motion.sliced(int(frames[0]), int(frames[-1]) + 1)
    for q, colour, word in (
        (forward_kinematics(part)[0][:, joint], INK, "in the room"),
        (part.rotations[:, joint], WRONG, "own"),
    ):
        turn = np.degrees(twist_angle(multiply(conjugate(q[:-1]), q[1:]), axis))
        panel.plot(frames[1:], turn, color=colour, lw=1.1, label=f"{find.joint} {word} °/frame")
    for sign in (-1, 1):
        panel.axhline(
            sign * np.degrees(largest_natural_turn(motion.fps)), color=SOFT, lw=0.6, ls="--"
        )


def _of_a_limb(
    turns: Any, evidence: Any, motion: Motion, limb: Limb, offset: Array, frames: Any
) -> None:
    """Plot a limb's swivel with and without the interval's offset, its bend, and E's motion."""
    swivel = compute_limb_swivel(motion, limb)
    angle = np.degrees(swivel.angle)
    turns.plot(frames, angle[frames], ".-", ms=3, color=WRONG, lw=1.2, label="swivel °")
    after = np.degrees(wrap(np.radians(angle - offset)))[frames]
    turns.plot(frames, after, ":", color=WRONG, lw=1.2, label="without")
    jump = np.degrees(swivel.jump)[frames]
    evidence.plot(frames, jump, color=INK, lw=1, label="turn °/frame")
    share = 1000 * swivel.height[frames]
    evidence.plot(frames, share, color=SOFT, lw=1, label="C off the line ‰")
    evidence.plot(frames, 1000 * swivel.step[frames], color=RIGHT, lw=1, label="E's step ‰")
