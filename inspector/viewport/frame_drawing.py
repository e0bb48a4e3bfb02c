"""The document's frame in a scene: its pose, what is drawn along with it, what the legend says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from inspector.language import of_core, tr
from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.viewport.bodies import BoneSegment
from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.dashed_figure import Companion
from inspector.viewport.limb_circle import circle_of, helper_circle, limb_bones
from inspector.viewport.mesh_actor import Index
from inspector.viewport.overlays import legend_text, trails_text
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose, Style
from inspector.widgets.labels import inked
from inspector.widgets.signed_numbers import plain, signed
from inspector.widgets.theme import Theme
from twistcore.detection import Interval
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array

_NO_CIRCLE = tr("straight or folded: no angle")


class Guest(Protocol):
    """Who draws something of their own into the view, and says which pose is seen with it."""

    def pose(self, scene: Scene, show: Show) -> Pose:
        """The figure, instead of before, after or both."""

    def legend(self) -> str:
        """Rich text instead of the legend's."""

    def draw(self, scene: Scene, pose: Pose, camera: OrbitCamera) -> None:
        """Draw along with every picture."""

    def aim(self, scene: Scene) -> tuple[Array, Array] | None:
        """Points (n, 3) to be framed and the unit vector (3,) to look from, for the focus."""

    def leave(self) -> None:
        """Take everything out: the scene goes, or the guest is sent away."""


@dataclass(frozen=True)
class Looks:
    """How a person wants to see the figure."""

    style: Style = Style.WEDGES
    split: bool = False  # before on the left and after on the right
    trails: bool = False
    by_offset: bool = False  # bones coloured by |offset|
    triads: bool = True  # the axes of the selected chain's parent and child


class FrameDrawing:
    """Draws the document's frame by the looks, with a third figure or a guest where there is one.

    A guest's figure stands instead of before and after, without a third figure and axes.
    """

    def __init__(self, document: Document) -> None:
        self.looks = Looks()
        self.guest: Guest | None = None
        self.companion: Companion | None = None
        self._document = document
        self._drawn_offsets: tuple[float, ...] = ()

    def draw(self, scene: Scene, camera: OrbitCamera) -> None:
        """Move and paint everything, as seen from the camera. The caller repaints."""
        document, looks = self._document, self.looks
        self._drawn_offsets = self._offsets()
        scene.set_style(looks.style)
        if (scene.trails is not None) != looks.trails:
            scene.set_trails(looks.trails)
        if scene.split:
            pose = self.pose(scene, Show.AFTER)
            scene.draw(self.pose(scene, Show.BEFORE), pose)
        else:
            pose = self.pose(scene)
            scene.draw(pose)
        seen = self.guest is None and (scene.split or document.show != Show.BEFORE)
        third = self.companion.pose(document.frame) if self.companion and seen else None
        scene.draw_companion(third, pose)
        triads = looks.triads and self.guest is None
        scene.draw_triads(pose, selected_chain(document) if triads else None)
        both = scene.split or document.show == Show.BOTH
        before, after = both or document.show == Show.BEFORE, both or document.show == Show.AFTER
        self._draw_circle(scene, pose, before=before, after=after)
        if scene.trails is not None:
            scene.trails.draw(document.frame, camera.position, before=before, after=after)
        scene.show_from(camera)
        if self.guest is not None:
            self.guest.draw(scene, pose, camera)

    def _draw_circle(self, scene: Scene, pose: Pose, *, before: bool, after: bool) -> None:
        """Draw the circle of the selected limb or twist bone.

        before, after: which marks are seen, after as the pose has it.
        """
        document, chain = self._document, selected_chain(self._document)
        if not isinstance(chain, Limb | Helper) or self.guest is not None:
            scene.draw_circle(None)
            return
        now = document.pose(document.frame, after=False)
        offset = float(document.offset(chain.name)[document.frame])
        if isinstance(chain, Limb):
            circle = circle_of(chain, now[1])
            there = pose.positions[chain.child]
        else:
            skeleton = scene.data.motion.skeleton
            circle = helper_circle(chain, skeleton, now, scene.height)
            turned = pose.rotations, pose.positions
            placed = helper_circle(chain, skeleton, turned, scene.height) or circle
            there = np.zeros(3) if placed is None else placed.centre + placed.aside
        scene.draw_circle(circle, offset, before=before, after=there if after else None)

    def pose(self, scene: Scene, show: Show | None = None) -> Pose:
        """What is to be seen of the frame; show: else the document's choice."""
        document = self._document
        if self.guest is not None:
            return self.guest.pose(scene, Show.BOTH if show is None else show)
        show, frame = document.show if show is None else show, document.frame
        before, positions = document.pose(frame, after=False)
        after, after_positions = document.pose(frame, after=True)
        differs = scene.shapes.differing(before, after)
        roles = _roles(scene.bones, selected_chain(document), scene.data.motion.skeleton)
        roles[differs] = Role.BEFORE if show == Show.BEFORE else Role.AFTER
        offsets = _bone_offsets(document, scene) if self.looks.by_offset else None
        if show == Show.BEFORE:
            return Pose(before, positions, roles, None, offsets)
        ghost = (before, differs) if show == Show.BOTH else None
        return Pose(after, after_positions, roles, ghost, offsets, positions)

    def legend(self, scene: Scene, theme: Theme) -> str:
        """What was drawn, as rich text."""
        document = self._document
        if self.guest is not None:
            text = self.guest.legend()
        else:
            chain, degrees = selected_chain(document), 0.0
            fault = fault_at(document)
            if chain is not None:
                degrees = float(np.degrees(document.offset(chain.name)[document.frame]))
            name = of_core(chain.label) if chain is not None else ""
            show = "split" if scene.split else document.show
            tracked, swivel = scene.accompanied, isinstance(chain, Limb)
            text = legend_text(
                theme, show, name, degrees,
                tracked=tracked, swivel=swivel, fault=_fault_words(fault) if fault else "",
            )  # fmt: skip
            if swivel and not scene.circled:
                text += inked(f"&nbsp;&nbsp; {_NO_CIRCLE}", theme.soft)
        if scene.trails is not None:
            text += trails_text(scene.trails.apart / scene.height)
        return text

    def is_current(self) -> bool:
        """Whether the review takes out of the frame what it did when the frame was drawn."""
        return self._offsets() == self._drawn_offsets

    def _offsets(self) -> tuple[float, ...]:
        """What the review takes out of every chain and limb at the frame, radians."""
        document = self._document
        if document.data is None:
            return ()
        chains = document.data.chains_and_limbs
        parts = (document.corrected.offset, document.corrected.carried)
        return tuple(float(of(c.name)[document.frame]) for of in parts for c in chains)


def selected_chain(document: Document) -> Chain | None:
    """The chain that the person is at, None without a clip or chains."""
    try:
        return document.find_chain(document.chain)
    except KeyError:
        return None


def fault_at(document: Document) -> Interval | None:
    """The selected interval if it is of a kind that is only shown and the frame is in it."""
    judged = document.interval
    if judged is None or judged.interval.repairable:
        return None
    interval = judged.interval
    return interval if interval.start <= document.frame < interval.stop else None


def _fault_words(interval: Interval) -> str:
    """What the legend says of a lone jump, a noise burst or frozen frames."""
    degrees = float(np.degrees(interval.residual))
    told = {"size": f"{plain(degrees)}°", "angle": f"{signed(degrees)}°", "joint": interval.joint}
    kind = interval.kind
    return of_core(kind.info.legend.format(**told) if kind.info.legend else kind)


def selected_limb(document: Document) -> Limb | None:
    """The limb that the person is at; None at a chain."""
    chain = selected_chain(document)
    return chain if isinstance(chain, Limb) else None


def altered_pose(document: Document, scene: Scene, altered: tuple[Array, Array] | None) -> Pose:
    """The captured figure, or an altered one (global rotations, positions) with it as a ghost.

    Where an alteration moves a bone, the ghost stays behind only if it keeps the bone's place.
    All but the selected chain is faint.
    """
    before, positions = document.pose(document.frame, after=False)
    roles = _roles(scene.bones, selected_chain(document), scene.data.motion.skeleton)
    faint = roles != Role.CHOSEN
    if altered is None:
        return Pose(before, positions, roles, faint=faint)
    rotations, moved = altered
    differs = scene.shapes.differing(before, rotations)
    roles[differs] = Role.AFTER
    still = np.array([np.allclose(moved[b.parent], positions[b.parent]) for b in scene.bones])
    return Pose(rotations, moved, roles, (before, differs & still), faint=faint)


def _roles(bones: tuple[BoneSegment, ...], chain: Chain | None, skeleton: Skeleton) -> Index:
    """Chosen are the selected chain's bones, P→C and, where there is one, C→G; (bones,).

    Of a limb all from P to E; of a twist bone its own, and the bone that it lies in.
    """
    pairs = {(chain.parent, chain.child), (chain.child, chain.grandchild)} if chain else set()
    if isinstance(chain, Limb):
        pairs = set(limb_bones(chain, skeleton))
    elif isinstance(chain, Helper):
        pairs = {*_own_bones(chain, skeleton), (skeleton.parents[chain.parent], chain.child)}
    chosen = np.array([(b.parent, b.child) in pairs for b in bones], dtype=bool)
    return np.where(chosen, Role.CHOSEN, Role.PLAIN).astype(np.int64)


def _own_bones(helper: Helper, skeleton: Skeleton) -> list[tuple[int, int]]:
    """What hangs on a twist bone, by joints; −1 is its End Site."""
    return [(helper.parent, joint) for joint in (*skeleton.children[helper.parent], -1)]


def _bone_offsets(document: Document, scene: Scene) -> Array:
    """|offset| at the frame of the chain whose P→C a bone is, or of its limb, radians, (bones,).

    Where a bone has both, the larger one.
    """
    by_pair: dict[tuple[int, int], float] = {}
    for chain in scene.data.chains_and_limbs:
        pairs = [(chain.parent, chain.child)]
        if isinstance(chain, Limb):
            pairs = limb_bones(chain, scene.data.motion.skeleton)
        elif isinstance(chain, Helper):
            pairs = _own_bones(chain, scene.data.motion.skeleton)
        offset = abs(float(document.offset(chain.name)[document.frame]))
        by_pair |= {pair: max(offset, by_pair.get(pair, 0.0)) for pair in pairs}
    return np.array([by_pair.get((b.parent, b.child), 0.0) for b in scene.bones])
