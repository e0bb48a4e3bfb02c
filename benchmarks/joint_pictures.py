"""Draw detections of any kind at a joint: the body, the joint's bones, and curves over time.

A judge sees the same panels for every kind of error, so that the picture does not reveal the kind.
The joint is marked, and the frames of the detection are shaded. Dotted lines show the corrected
motion, if there is one. These pictures suit kinds that concern one joint or the whole body;
:mod:`benchmarks.atlas_pictures` shows more about the two joints of a chain.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from benchmarks.atlas_pictures import FACES, INK, RIGHT, SOFT, WRONG, draw_bone, read_motion
from benchmarks.atlas_pictures import plt as plots
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.interval import Interval, Kind
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rig import AS_FOUND
from twistcore.skeleton.rotation import (
    conjugate,
    geodesic_angle,
    multiply,
    rotate,
    twist_angle,
    wrap,
)

Array = NDArray[np.float64]
Frames = NDArray[np.int64]

SECONDS, FEWEST, MOST = 0.4, 12, 90  # seconds, and limits in frames, of the curves on either side
LEAST, LARGEST = 0.3, 60.0  # degrees per frame, the range of the colours for all joints
BOX, ABOVE = np.array([0.92, 0.9]), 0.12  # the size of a drawn limb, and of the bone above it
PINK = "#d0006f"
OTHER = ("#c9862a", "#3f87c5")  # colours of the left and of the right side


@dataclass(frozen=True, eq=False)
class Scene:
    """A detection in its clip.

    Attributes
    ----------
    motion
        The motion of the clip.
    after
        The corrected motion, or None if the detection is not corrected.
    chains
        The chains and limbs.
    own
        The chain if the error is of two joints, or None if it is of one joint.
    joint
        Index of the joint.
    start, stop
        The frames [start, stop).
    """

    motion: Motion
    after: Motion | None
    chains: tuple[Chain, ...]
    own: Chain | None
    joint: int
    start: int
    stop: int

    @staticmethod
    def of(motion: Motion, found: Interval) -> Scene:
        """Return the scene of an interval, whose offset is the angle that a correction removes."""
        chains = AS_FOUND.chains(motion)
        own = next(c for c in chains if c.name == found.chain)
        joint = motion.skeleton.index(found.joint) if found.joint else own.parent
        after = refine(motion, chains, [found]) if found.offset.any() else None
        two = None if found.joint else own
        return Scene(motion, after, chains, two, joint, found.start, found.stop)

    @cached_property
    def window(self) -> Frames:
        """The frames for which curves are drawn, an array."""
        margin = max(round(SECONDS * self.motion.fps), FEWEST, (self.stop - self.start) // 2)
        margin = min(margin, MOST)
        return np.arange(max(self.start - margin, 0), min(self.stop + margin, self.motion.frames))

    @cached_property
    def poses(self) -> Frames:
        """The frames in which the body is drawn: before, during and after the detection."""
        start, last = self.start, self.stop - 1
        inside = (
            {start, last, (start + last) // 2} if last - start > 2 else set(range(start, self.stop))
        )
        margin = (4 - (len(inside) - 1) // 2) if len(inside) < 3 else 3
        around = {start - k for k in range(1, margin + 1)} | {
            last + k for k in range(1, margin + 1)
        }
        return np.array(sorted(f for f in inside | around if 0 <= f < self.motion.frames))

    @cached_property
    def path(self) -> list[int]:
        """The indices of the joint, of the end of its bone, and of the end of the next bone.

        A joint at the same position as its parent is left out.
        """
        children, offsets = self.motion.skeleton.children, self.motion.skeleton.offsets
        by_parent = {c.parent: c for c in self.chains if not isinstance(c, Limb)}
        found = [self.joint]
        at = self.joint
        while len(found) < 3 and children[at]:
            own = by_parent.get(at)
            at = own.child if own else max(children[at], key=self._below)
            if np.any(offsets[at]) or at in self.motion.positioned:
                found.append(at)
        return found

    def _below(self, joint: int) -> int:
        return 1 + sum(map(self._below, self.motion.skeleton.children[joint]))

    @cached_property
    def hinge(self) -> Chain | None:
        """The chain of the detection, or a chain whose child or parent is the joint, or None."""
        if self.own is not None:
            return self.own
        own = [c for c in self.chains if not isinstance(c, Limb) and c.axis.ndim == c.arm.ndim == 1]
        as_child = (c for c in own if c.child == self.joint)
        return next(as_child, next((c for c in own if c.parent == self.joint), None))


def joint_picture(clip: Path, find: Any, output: Path, title: str = "") -> None:
    """Draw a detection into a file. `find` is a `Find` of :mod:`benchmarks.atlas`."""
    offset = np.radians(np.array(find.offset))
    found = Interval(
        find.chain,
        find.start,
        find.stop,
        offset,
        kind=Kind(find.kind),
        carried=find.carried,
        joint=find.joint,
    )
    picture(read_motion(clip), found, output, title)


def picture(motion: Motion, found: Interval, output: Path, title: str = "") -> None:
    """Draw an interval into a file. Its offset is the angle that a correction removes."""
    scene = Scene.of(motion, found)
    figure = plots.figure(figsize=(18, 17.6), dpi=72)
    figure.text(0.01, 0.985, title, fontsize=12, weight="bold")
    last = motion.frames - 1
    figure.text(
        0.09,
        0.985,
        f"frames {found.start}–{found.stop - 1} of 0–{last}, {motion.fps:.0f} a second; the joint "
        "in question is pink. Dotted: after the correction (if there is one).",
        fontsize=11,
    )
    count = len(scene.poses)
    bodies = figure.add_axes((0.0, 0.715, 1.0, 0.265))
    _bodies(bodies, scene)
    near = figure.add_axes((0.0, 0.335, 1.0, 0.38))
    _close_up(near, scene, count)
    _curves(figure, scene)
    figure.savefig(output, pil_kwargs={"optimize": True})
    plots.close(figure)


def _up(chains: tuple[Chain, ...], places: Array) -> Array:
    """Return the upward direction of the body, along one of the coordinate axes.

    `places` are global positions, shape (frames, joints, 3).
    """
    feet = [c.child for c in chains if c.segment == "Leg"]
    if not feet:
        return np.array([0.0, 1.0, 0.0])
    mean = (places[:, :1] - places[:, feet]).mean(axis=(0, 1))
    axis = int(np.argmax(np.abs(mean)))
    return np.eye(3)[axis] * np.sign(mean[axis])


def _across(chains: tuple[Chain, ...], places: Array) -> Array:
    """Return the mean direction from the right to the left side of the body.

    `places` are global positions, shape (frames, joints, 3).
    """
    sides = [
        [c.child for c in chains if c.side == s and not isinstance(c, Limb)]
        for s in ("Left", "Right")
    ]
    if not all(sides):
        return np.array([1.0, 0.0, 0.0])
    left, right = (places[:, own].mean(axis=(0, 1)) for own in sides)
    return left - right


def _bodies(panel: Any, scene: Scene) -> None:
    motion, at = scene.motion, scene.poses
    part = motion.at(at)
    places = forward_kinematics(part)[1]
    sample = motion.at(np.linspace(0, motion.frames - 1, 24).astype(int))
    up = _up(scene.chains, forward_kinematics(sample)[1])
    across = _across(scene.chains, places)
    across = across - up * (up @ across)
    across /= max(float(np.linalg.norm(across)), 1e-9)
    ahead = np.cross(across, up)
    middle = places[len(at) // 2].mean(axis=0)
    size = max(
        float(np.ptp((places - middle) @ up)), float(np.ptp(places[len(at) // 2], axis=0).max())
    )
    side_of = {c.child: c.side for c in scene.chains if not isinstance(c, Limb)}
    lines: dict[str, list[Array]] = {}
    for row, right in enumerate((across, ahead)):
        for k in range(len(at)):
            origin = np.array([k, -1.08 * row])
            flat = np.stack([(places[k] - middle) @ right, (places[k] - middle) @ up], axis=1)
            flat = flat / size * 0.95 + origin
            for joint, above in enumerate(motion.skeleton.parents):
                if above >= 0:
                    side = _side(motion, side_of, joint)
                    colour = {"Left": OTHER[0], "Right": OTHER[1]}.get(side, "#555555")
                    lines.setdefault(colour, []).append(flat[[above, joint]])
            panel.plot(*flat[scene.path[:2]].T, color=PINK, lw=2.4)
            panel.plot(*flat[scene.joint], "o", color=PINK, ms=6)
            if row == 0:
                _number(panel, scene, int(at[k]), (k, 0.54))
    for colour, own in lines.items():
        panel.add_collection(LineCollection(own, colors=colour, linewidths=1.6, zorder=1))
    for row, word in enumerate(("front", "side")):
        panel.text(-0.55, -1.08 * row, word, fontsize=9, color=SOFT, rotation=90)
    panel.set_xlim(-0.6, max(len(at), 7) - 0.4)
    panel.set_ylim(-1.62, 0.62)
    panel.axis("off")
    panel.set_aspect("equal")


def _side(motion: Motion, side_of: dict[int, str], joint: int) -> str:
    while joint >= 0 and joint not in side_of:
        joint = int(motion.skeleton.parents[joint])
    return side_of.get(joint, "")


def _number(panel: Any, scene: Scene, frame: int, at: tuple[float, float]) -> None:
    inside = scene.start <= frame < scene.stop
    panel.text(
        *at,
        f"{frame} in" if inside else f"{frame}",
        ha="center",
        fontsize=10,
        color=PINK if inside else INK,
        weight="bold" if inside else "normal",
    )


def _close_up(panel: Any, scene: Scene, count: int) -> None:
    """Draw the joint's bone and the next two in the parent's coordinates, from two sides.

    `count` is the number of poses.
    """
    at = scene.poses
    turned, ends = _limb(scene.motion.at(at), scene)
    sight, up = _view(ends[0])
    looks = (sight, np.cross(up, sight))
    rows = [(turned, ends, looks[0], "side 1"), (turned, ends, looks[1], "side 2")]
    if scene.after is not None:
        rows.append((*_limb(scene.after.at(at), scene), looks[0], "corrected"))
    boxes = [_flat(e[:, 1:], look, up) for _, e, look, _ in rows]
    low = np.min([b.min(axis=(0, 1)) for b in boxes], axis=0)
    high = np.max([b.max(axis=(0, 1)) for b in boxes], axis=0)
    scale = float((BOX / np.maximum(high - low, 1e-9)).min())
    for row, (rotations, points, look, word) in enumerate(rows):
        for k in range(len(at)):
            origin = np.array([k, -row]) - scale * 0.5 * (low + high)
            line = scale * _flat(points[k], look, up) + origin
            above = line[0] - line[1]
            above *= min(1.0, ABOVE / max(float(np.linalg.norm(above)), 1e-9))
            panel.plot(*np.stack([line[1] + above, line[1]]).T, color=SOFT, lw=2.0)
            for b in range(1, points.shape[1] - 1):
                bone = (scale * points[k, b], scale * points[k, b + 1])
                if not np.linalg.norm(bone[1] - bone[0]) > 1e-6:
                    continue  # two joints in the same place
                own = rotations[k, min(b, rotations.shape[1]) - 1]
                view = (np.cross(up, look), up, look)
                draw_bone(panel, bone, own, view, origin, FACES[(b - 1) % 2], bare=False)
            panel.plot(*line[1], "o", color=PINK, ms=5)
        panel.text(-0.55, -row, word, fontsize=9, color=SOFT, rotation=90, va="center")
    for k in range(len(at)):
        _number(panel, scene, int(at[k]), (k, 0.52))
    panel.set_xlim(-0.6, max(count, 7) - 0.4)
    panel.set_ylim(0.47 - len(rows), 0.66)
    panel.axis("off")
    panel.set_aspect("equal")


def _flat(points: Array, look: Array, up: Array) -> Array:
    """Project points, (…, 3), onto the plane perpendicular to the direction `look`, (…, 2)."""
    return np.stack([points @ np.cross(up, look), points @ up], axis=-1)


def _limb(part: Motion, scene: Scene) -> tuple[Array, Array]:
    """Return the rotations of the joints in `path`, and the positions of the ends of their bones.

    Both are relative to the joint, in the coordinates of its parent. The first position is that
    joint's parent.
    """
    rotations, places = forward_kinematics(part)
    above = int(part.skeleton.parents[scene.joint])
    back = (
        conjugate(rotations[:, above]) if above >= 0 else np.tile([1.0, 0, 0, 0], (part.frames, 1))
    )
    own = places[:, scene.joint]
    first = places[:, above] if above >= 0 else own
    joints = list(scene.path)
    points = [first, *(places[:, j] for j in joints)]
    last = joints[-1]
    if (axis := own_bone_axis(part.skeleton, last)) is not None and not part.skeleton.children[
        last
    ]:
        end = part.skeleton.end_offsets.get(last, axis)
        points.append(places[:, last] + rotate(rotations[:, last], end))
    elif len(joints) == 1:
        size = 0.5 * float(np.linalg.norm(part.skeleton.offsets[last])) or 1.0
        points.append(places[:, last] + size * rotate(rotations[:, last], _bone_axis(part, last)))
    turned = np.stack([multiply(back, rotations[:, j]) for j in joints], axis=1)
    return turned, np.stack([rotate(back, p - own) for p in points], axis=1)


def _bone_axis(motion: Motion, joint: int) -> Array:
    """Return the axis of a joint's bone, or the direction from its parent if it has no bone."""
    if (axis := own_bone_axis(motion.skeleton, joint)) is not None:
        return axis
    offset = motion.skeleton.offsets[joint]
    size = float(np.linalg.norm(offset))
    return offset / size if size > 0 else np.array([0.0, 1.0, 0.0])


def _view(first: Array) -> tuple[Array, Array]:
    """Return a viewing direction across the bones of the first pose, and the upward direction.

    `first` are the positions of the bones' ends, shape (points, 3).
    """
    bones = np.diff(first, axis=0)
    own = bones[1] if len(bones) > 1 else bones[0]
    other = bones[2] if len(bones) > 2 else bones[0]
    sight = np.cross(own, other)
    if np.linalg.norm(sight) < 0.05 * np.linalg.norm(own) * np.linalg.norm(other) + 1e-12:
        sight = np.cross(own, np.eye(3)[int(np.argmin(np.abs(own)))])
    sight /= max(float(np.linalg.norm(sight)), 1e-9)
    return sight, -own / max(float(np.linalg.norm(own)), 1e-9)


def _turns(motion: Motion, joint: int) -> Array:
    q = motion.rotations[:, joint]
    return np.concatenate([[0.0], np.degrees(geodesic_angle(q[:-1], q[1:]))])


def _curves(figure: Any, scene: Scene) -> None:
    motion, after, joint, frames = scene.motion, scene.after, scene.joint, scene.window
    names = motion.skeleton.names
    columns = (0.035, 0.365, 0.695)
    wide, high, low = 0.285, 0.118, (0.19, 0.028)
    own, roll, place = (figure.add_axes((x, low[0], wide, high)) for x in columns)
    every, sides, clip = (figure.add_axes((x, low[1], wide, high)) for x in columns)
    above = int(motion.skeleton.parents[joint])
    below = scene.path[1] if len(scene.path) > 1 else -1
    for j, colour, word, width in (
        (above, SOFT, "parent", 1.0),
        (below, RIGHT, "next", 1.0),
        (joint, PINK, "joint", 1.8),
    ):
        if j >= 0:
            own.plot(
                frames,
                _turns(motion, j)[frames],
                color=colour,
                lw=width,
                marker=".",
                ms=3,
                label=f"{word} {names[j][-18:]}",
            )
            if after is not None and j != above:
                own.plot(frames, _turns(after, j)[frames], ":", color=colour, lw=1.6)
    _titled(own, "turn from frame to frame, °")
    _rolls(roll, scene, frames)
    _places(place, scene, frames)
    _all_joints(every, scene, frames)
    _sides(sides, scene, frames)
    _whole_clip(clip, scene)
    for panel in (own, roll, place, every, sides):
        edges = (scene.start - 0.5, scene.stop - 0.5)
        if panel is every:
            for edge in edges:
                panel.axvline(edge, color=PINK, lw=1.0)
        else:
            panel.axvspan(*edges, color=PINK, alpha=0.10, lw=0)
        panel.set_xlim(frames[0] - 0.5, frames[-1] + 0.5)
    for panel in filter(Axes.get_visible, (own, roll, place, sides)):
        panel.legend(
            fontsize=7.5,
            frameon=False,
            ncols=4,
            loc="upper left",
            borderpad=0,
            handlelength=1.3,
            columnspacing=0.8,
        )
        panel.margins(y=0.16)


def _titled(panel: Any, words: str) -> None:
    panel.set_title(words, fontsize=9, loc="left", pad=3)
    panel.tick_params(labelsize=8, pad=1)
    panel.spines[["top", "right"]].set_visible(False)


def _unwrapped(angle: Array, frames: Frames, start: int) -> Array:
    """Return an angle in degrees over the frames, unwrapped, and 0 in the frame before `start`."""
    own = np.degrees(np.unwrap(angle[frames]))
    at = max(int(np.searchsorted(frames, start)) - 1, 0)
    return np.asarray(own - own[at])


def _rolls(panel: Any, scene: Scene, frames: Frames) -> None:
    """Plot the rolls of the joint and the next one, and the azimuth of the next bone."""
    known: dict[str, Array] = {}
    for shown, style in ((scene.motion, "-"), (scene.after, ":")):
        if shown is None:
            continue
        rolls = _rolls_of(shown, scene)
        for (word, angle), colour in zip(rolls.items(), (WRONG, RIGHT, INK), strict=False):
            values = _near(known, word, _unwrapped(angle, frames, scene.start))
            label = word if style == "-" else None
            panel.plot(frames, values, style, color=colour, lw=1.5, label=label)
    _titled(panel, "roll about the own bone, and side to which the next bone leaves, °")


def _rolls_of(motion: Motion, scene: Scene) -> dict[str, Array]:
    """Return the rolls of the joint and the next one, and the azimuth, keyed by label.

    All angles are in radians.
    """
    chain = next(
        (c for c in scene.chains if c.parent == scene.joint and not isinstance(c, Limb)), None
    )
    if chain is None or chain.axis.ndim != 1 or chain.arm.ndim != 1:
        words = ("joint", "next")
        return {
            word: twist_angle(motion.rotations[:, j], _bone_axis(motion, j))
            for word, j in zip(words, scene.path, strict=False)
        }
    signals = ChainSignals.of(motion, chain)
    turned = (np.radians(np.cumsum(v)) for v in (signals.x, signals.roll_turns))
    named = zip(("joint", "next"), turned, strict=True)
    return {**dict(named), "azimuth of next": np.radians(signals.azimuth)}


def _near(known: dict[str, Array], name: str, values: Array) -> Array:
    """Shift angles by multiples of 360°, so that they are near the first angles of the same name.

    `known` stores the first angles of each name.
    """
    first = known.setdefault(name, values)
    return np.asarray(first + (values - first + 180.0) % 360.0 - 180.0)


def _flexion(motion: Motion, chain: Chain) -> tuple[Array, Array]:
    """Return two bends of a chain's child in degrees: in its usual direction, and across it."""
    signals = ChainSignals.of(motion, chain)
    bend, azimuth = np.radians(signals.bend), np.radians(signals.azimuth)
    usual = np.arctan2(
        (np.sin(bend) * np.sin(azimuth)).sum(), (np.sin(bend) * np.cos(azimuth)).sum()
    )
    off = azimuth - usual
    return (
        np.degrees(np.arctan2(np.sin(bend) * np.cos(off), np.cos(bend))),
        np.degrees(np.arcsin(np.sin(bend) * np.sin(off))),
    )


def _places(panel: Any, scene: Scene, frames: Frames) -> None:
    """Plot the positions of the joint and of the end of its bone, as shares of the height."""
    motion = scene.motion
    low = int(frames[0])
    for shown, style in ((motion, "-"), (scene.after, ":")):
        if shown is None:
            continue
        places = forward_kinematics(shown.sliced(low, int(frames[-1]) + 1))[1]
        root = places[:, 0]
        size = motion.skeleton.height / 100.0
        end = scene.path[-1]
        for k, colour in enumerate(("#b2453c", "#3a8f4d", "#4a6fc4")):
            if style == "-":
                values = (places[:, scene.joint, k] - places[0, scene.joint, k]) / size
                panel.plot(frames, values, "-", color=colour, lw=1.5, label=f"joint {'xyz'[k]}")
            if end != scene.joint:
                values = (places[:, end, k] - root[:, k]) / size
                values = values - values[0]
                style_of = "--" if style == "-" else ":"
                panel.plot(
                    frames,
                    values,
                    style_of,
                    color=colour,
                    lw=1.0,
                    label="end−root" if style == "-" and k == 0 else None,
                )
    _titled(
        panel,
        f"place in the room, % of the height (end: {motion.skeleton.names[scene.path[-1]][-16:]})",
    )


def _all_joints(panel: Any, scene: Scene, frames: Frames) -> None:
    """Plot the rotation of each joint from frame to frame as colours."""
    motion = scene.motion
    low = max(int(frames[0]) - 1, 0)
    part = motion.sliced(low, int(frames[-1]) + 1)
    turns = np.stack([_turns(part, j) for j in range(len(motion.skeleton))])[:, frames[0] - low :]
    logs = np.log10(np.clip(turns, LEAST, LARGEST))
    panel.imshow(
        logs,
        aspect="auto",
        cmap="magma_r",
        vmin=np.log10(LEAST),
        vmax=np.log10(LARGEST),
        interpolation="nearest",
        extent=(frames[0] - 0.5, frames[-1] + 0.5, len(turns) - 0.5, -0.5),
    )
    panel.plot([frames[0] - 0.5], [scene.joint], ">", color=PINK, ms=8, clip_on=False)
    panel.set_yticks(
        range(len(turns)),
        [n[-12:] for n in motion.skeleton.names],
        fontsize=min(6.0, 190 / len(turns)),
    )
    _titled(panel, f"turn of every joint, °/frame: light {LEAST} … dark {LARGEST:.0f}")
    panel.tick_params(axis="y", labelsize=min(6.0, 190 / len(turns)))


def _sides(panel: Any, scene: Scene, frames: Frames) -> None:
    """Plot the bend of the joint, in its usual direction and across it."""
    chain = scene.hinge
    if chain is not None:
        names = scene.motion.skeleton.names
        for shown, style in ((scene.motion, "-"), (scene.after, ":")):
            if shown is not None:
                for values, colour, word in zip(
                    _flexion(shown, chain),
                    (INK, WRONG),
                    ("bend to the usual side", "across"),
                    strict=True,
                ):
                    panel.plot(
                        frames,
                        values[frames],
                        style,
                        color=colour,
                        lw=1.4,
                        label=word if style == "-" else None,
                    )
        panel.axhline(0, color=SOFT, lw=0.6)
        _titled(panel, f"bend at {names[chain.child]}, °")
    else:
        panel.set_visible(False)


def _whole_clip(panel: Any, scene: Scene) -> None:
    """Plot the rotation per frame, the roll and the bend of the joint over the whole clip."""
    motion, joint = scene.motion, scene.joint
    frames = np.arange(motion.frames)
    roll = np.degrees(wrap(twist_angle(motion.rotations[:, joint], _bone_axis(motion, joint))))
    panel.plot(frames, roll, ".", color=WRONG, ms=2.5, label="roll of the joint")
    panel.plot(frames, _turns(motion, joint), color=PINK, lw=0.8, label="turn per frame")
    if (chain := scene.hinge) is not None:
        panel.plot(
            frames, _flexion(motion, chain)[0], color=INK, lw=0.8, label="bend to the usual side"
        )
    panel.axvspan(scene.start - 0.5, scene.stop - 0.5, color=PINK, alpha=0.25, lw=1.0)
    panel.set_xlim(0, max(motion.frames - 1, 1))
    _titled(panel, "the whole clip, °")
    panel.legend(
        fontsize=7.5, frameon=False, ncols=3, loc="upper left", borderpad=0, handlelength=1.3
    )
    panel.margins(y=0.16)
