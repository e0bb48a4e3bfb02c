"""Collect the data for the web page of a lesson.

For each clip, only the frames near the displayed frames are included.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from inspector.lessons.lesson_file import LessonFile, LessonPage
from inspector.lessons.page_in_clip import lesson_page_chain
from inspector.session.opening import Analysed
from inspector.teaching.taught_frame import joint_labels
from inspector.viewport.bodies import BoneSegment, find_bones
from inspector.viewport.ground import ground_at_lowest_joint
from inspector.viewport.web_figure import emphasised_bone_indices, figure_data, skin_data
from twistcore.analysis.correction.twist_removal import (
    offsets_by_chain,
    offsets_carried_to_child,
    remove_twist,
)
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.files.packed_numbers import encode_base64_array
from twistcore.skeleton.chain import Chain, find_chains, uncorrectable_joints
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.limb import Limb

_MORE = 10  # additional frames if a task asks the user to move by some frames


@dataclass(frozen=True)
class Window:
    """The range of frames that a page needs. It includes both `first` and `last`."""

    first: int
    last: int


class PageData:
    """Collects the data that the pages of a lesson show.

    Data for several pages are stored only once.
    """

    def __init__(
        self, lesson: LessonFile, open_clip: Callable[[Path], Analysed], seconds: float
    ) -> None:
        self._lesson = lesson
        self._clips = {page.place.clip: open_clip(page.place.clip) for page in lesson.pages}
        self._bones: dict[Path, tuple[BoneSegment, ...]] = {}
        self._figures: list[dict[str, Any]] = []
        self._figure_of: dict[Path, int] = {}
        self._windows = [self._window(page, seconds) for page in lesson.pages]
        self._spans: list[tuple[Path, Window]] = self._joined()
        self._chains: dict[tuple[int, str, float], dict[str, Any]] = {}
        self._numbers: dict[tuple[int, str, float], int] = {}

    def gathered(self) -> dict[str, Any]:
        """Return the figures, frame ranges (spans), chains and pages as JSON data."""
        for clip in self._clips:
            self._figure_of[clip] = len(self._figures)
            self._figures.append(self._figure(clip))
        pages = [
            self._page(page, window)
            for page, window in zip(self._lesson.pages, self._windows, strict=True)
        ]
        return {
            "figures": self._figures,
            "spans": [self._span(clip, window) for clip, window in self._spans],
            "chains": list(self._chains.values()),
            "pages": pages,
        }

    # -- which frames -------------------------------------------------------------------------

    def _window(self, page: LessonPage, seconds: float) -> Window:
        lesson_page_chain(self._lesson, page, self._clips[page.place.clip])
        motion = self._clips[page.place.clip].motion
        asked = [int(c.amount) + _MORE for c in page.done if c.name == "moved"]
        reach = max([round(seconds * motion.fps), 1, *asked])
        last = min(page.place.frame + reach, motion.frames - 1)
        return Window(max(page.place.frame - reach, 0), last)

    def _joined(self) -> list[tuple[Path, Window]]:
        """Return (clip, frame range) pairs, with overlapping ranges of the same clip joined.

        Each range also includes the frame before the one that the first page needs.
        """
        out: list[tuple[Path, Window]] = []
        wanted = zip((page.place.clip for page in self._lesson.pages), self._windows, strict=True)
        for clip, window in sorted(wanted, key=lambda w: (str(w[0]), w[1].first)):
            own = Window(max(window.first - 1, 0), window.last)
            if out and out[-1][0] == clip and own.first <= out[-1][1].last + 1:
                before = out.pop()[1]
                own = Window(before.first, max(before.last, own.last))
            out.append((clip, own))
        return out

    def _span_of(self, clip: Path, window: Window) -> int:
        for k, (other, span) in enumerate(self._spans):
            if other == clip and span.first <= window.first and window.last <= span.last:
                return k
        raise AssertionError(window)

    # -- their data ---------------------------------------------------------------------------

    def _figure(self, clip: Path) -> dict[str, Any]:
        """Return the mesh of a clip's figure, and the lines of the ground."""
        data = self._clips[clip]
        skeleton = data.motion.skeleton
        up = guess_up(data.positions, find_chains(data.motion), skeleton)
        height = figure_size(data.positions, skeleton)
        bones = self._bones[clip] = find_bones(data.motion, up, height)
        ground = ground_at_lowest_joint(data.positions, up, height)
        figure = figure_data(skeleton, bones, up, height, ground)
        if any(page.place.skin and page.place.clip == clip for page in self._lesson.pages):
            figure["skin"] = skin_data(bones, data.chains, height)
        return figure

    def _span(self, clip: Path, window: Window) -> dict[str, Any]:
        """Return the local rotations and the recorded positions in a range of frames."""
        motion = self._clips[clip].motion.sliced(window.first, window.last + 1)
        return {
            "figure": self._figure_of[clip],
            "first": window.first,
            "fps": motion.fps,
            "offsets": motion.skeleton.offsets.tolist(),
            "moving": list(motion.positioned),
            "rotations": encode_base64_array(motion.rotations, "f4"),
            "positions": encode_base64_array(motion.positions, "f4"),
        }

    def _chain(self, data: Analysed, chain: Chain, span: int, tau: float | None) -> int:
        """Return the index of a chain's data for a frame range, and add the data if they are new.

        `span` is the index of the frame range. `tau` is the τ of the page, or None for the
        detector's automatic τ.
        """
        if tau is None:
            tau = data.review.state.tau.get(chain.name, 0.0)
        key = span, chain.name, tau
        if key not in self._chains:
            self._numbers[key] = len(self._chains)
            window = self._spans[span][1]
            frames = slice(window.first, window.last + 1)
            own, signals = chain.sliced(frames.start, frames.stop), data.signals[chain.name]
            self._chains[key] = {
                "span": span,
                "parent": chain.parent,
                "child": chain.child,
                "grandchild": chain.grandchild,
                "children": list(data.motion.skeleton.children[chain.parent]),
                "free": not uncorrectable_joints(data.motion, chain),
                "tau": tau,
                "axes": encode_base64_array(own.axis, "f4"),
                "arms": encode_base64_array(own.arm, "f4"),
                "running": encode_base64_array(
                    paper_detector_running_offset(signals, tau)[frames], "f4"
                ),
                **{
                    name: encode_base64_array(getattr(signals, name)[frames], "f4")
                    for name in ("theta_p", "theta_c", "strength")
                },
            }
        return self._numbers[key]

    def _page(self, page: LessonPage, window: Window) -> dict[str, Any]:
        place, data = page.place, self._clips[page.place.clip]
        span, chain = self._span_of(place.clip, window), lesson_page_chain(self._lesson, page, data)
        taught = chain is not None and not isinstance(chain, Limb) and place.tab == "teaching"
        curves = chain is not None and not isinstance(chain, Limb)
        up = np.array(self._figures[self._figure_of[place.clip]]["room"]["up"])
        ahead = figure_facing_direction(data.positions[place.frame], find_chains(data.motion), up)
        return {
            "span": span,
            "chain": self._chain(data, chain, span, place.tau) if chain and curves else None,
            "limb": _ends(chain),
            "label": chain.label if chain else "",
            "taught": taught,
            "joints": joint_labels(data.motion.skeleton, chain) if chain and curves else {},
            "strong": emphasised_bone_indices(self._bones[place.clip], chain, data.motion.skeleton),
            "ahead": ahead.tolist(),
            "frame": place.frame,
            "first": window.first,
            "last": window.last,
            "camera": asdict(place.camera) if place.camera else None,
            "show": list(place.show),
            "lit": place.lit,
            "whatIf": asdict(place.what_if),
            "stage": place.stage,
            "look": place.look,
            "skin": place.skin,
            "after": None if taught else self._after(data, span),
            "done": [asdict(condition) for condition in page.done],
        }

    def _after(self, data: Analysed, span: int) -> dict[str, Any] | None:
        """Return the joints that the corrections change, and their corrected rotations.

        All intervals of the review are corrected. Returns None if no joint changes.
        """
        window = self._spans[span][1]
        start, stop = window.first, window.last + 1
        motion = data.motion.sliced(start, stop)
        intervals = [judged.interval for judged in data.review.state.intervals]
        offsets, carried = (
            {name: offset[start:stop] for name, offset in of(intervals, data.motion.frames).items()}
            for of in (offsets_by_chain, offsets_carried_to_child)
        )
        chains = [c.sliced(start, stop) for c in data.chains_and_limbs]
        after = remove_twist(motion, chains, offsets, carried).rotations
        joints = np.flatnonzero((after != motion.rotations).any(axis=(0, 2)))
        if not len(joints):
            return None
        rotations = encode_base64_array(after[:, joints], "f4")
        return {"joints": joints.tolist(), "first": start, "rotations": rotations}


def _ends(chain: Chain | None) -> dict[str, int] | None:
    """Return the joint indices of a chain's parent and child, and of a limb's end joint.

    The end joint is −1 if the chain is not a limb. Returns None if `chain` is None.
    """
    if chain is None:
        return None
    end = chain.end if isinstance(chain, Limb) else -1
    return {"parent": chain.parent, "child": chain.child, "end": end}
