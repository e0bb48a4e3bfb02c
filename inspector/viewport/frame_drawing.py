"""Draw the document's current frame in a scene, and compose the legend."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.viewport.bodies import BoneSegment
from inspector.viewport.bone_colours import Role
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.dashed_figure import Companion
from inspector.viewport.legend import frame_legend, trails_text
from inspector.viewport.limb_circle import limb_bones
from inspector.viewport.limb_turn import LEAST_ANGLE, Turn, limb_correction_turn
from inspector.viewport.mesh_actor import Index
from inspector.viewport.occlusion import occluding_bone_mask
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose, Style
from inspector.widgets.theme import Theme
from twistcore.detection import Interval
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb, joint_path
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, normalise

_SHORT = 0.01  # relative to the longest bone; a shorter bone is not visible
_FIN = 0.4  # distance of a fin from the bone, in radii of the fan
_THINNED = 3  # every third point of an error is tested for bones in front of it
_ALONG = np.linspace(0.0, 1.0, 12)[:, None]  # positions along a bone


class Guest(Protocol):
    """A feature that temporarily determines the pose in the view and draws into the view."""

    def pose(self, scene: Scene, show: Show) -> Pose:
        """Return the pose to show instead of the captured and the corrected pose."""

    def legend(self) -> str:
        """Return the legend as rich text."""

    def draw(self, scene: Scene, pose: Pose, camera: OrbitCamera) -> None:
        """Draw this feature's additional objects. Called each time the view is drawn."""

    def aim(self, scene: Scene) -> tuple[Array, Array] | None:
        """Return what the camera should show, or None to show the selected limb.

        The result is the points to show, (n, 3), and the unit vector to the camera, (3,).
        """

    def leave(self) -> None:
        """Remove this feature's additional objects from the view."""


@dataclass(frozen=True)
class Looks:
    """The display options of the figure.

    Attributes
    ----------
    style
        The style of the bodies.
    split
        True to show the figure before and after correction in two images, on the left and right.
    trails
        True to show the trails of hands and feet.
    by_offset
        True to colour each bone by its |offset|.
    triads
        True to show the axes of two joints of the selected chain or limb.
    """

    style: Style = Style.WEDGES
    split: bool = False
    trails: bool = False
    by_offset: bool = False
    triads: bool = True


class LoneJoint(Chain):
    """A chain that represents a single joint outside all chains, with one of the joint's bones."""


@dataclass(frozen=True, eq=False)
class AngleSign:
    """An angle to show as text in the image, next to the wrong bone.

    Attributes
    ----------
    degrees
        The angle in degrees.
    bone
        The ends of the wrong bone before correction, (2, 3).
    turn
        The rotation that is drawn as a fan (a circular sector), or None.
    """

    degrees: float
    bone: Array
    turn: Turn | None

    @cached_property
    def points(self) -> Array:
        """Points that should be visible, (n, 3). Bones that hide them are drawn translucent.

        The points are on the wrong bone, along its captured and its corrected front, and on the
        fan.
        """
        start, stop = self.bone
        points = [start + _ALONG * (stop - start)]
        if self.turn is not None:
            circle = self.turn.circle
            fins = (circle.aside, self.turn.after - circle.centre)
            points += [points[0] + _FIN * fin for fin in fins]
            points.append(self.turn.fan)
        return np.vstack(points)


class FrameDrawing:
    """A drawing of the document's current frame and of any additional figure.

    Attributes
    ----------
    looks
        The display options.
    guest
        A feature that chooses the pose to show, or None. With a guest, the companion's figure and
        the axes of joints are hidden.
    companion
        The source of a third, dashed figure, such as the tracked motion, or None.
    left
        The pose that was last drawn in the left or only image, or None.
    roles
        The roles of the bones that were last drawn, in all images.
    sign
        The angle to show in the last drawn image, or None.
    """

    def __init__(self, document: Document) -> None:
        self.looks = Looks()
        self.guest: Guest | None = None
        self.companion: Companion | None = None
        self._document = document
        self.left: Pose | None = None
        self.roles: frozenset[int] = frozenset()
        self._drawn_offsets: tuple[object, ...] = ()
        self.sign: AngleSign | None = None

    def draw(self, scene: Scene, camera: OrbitCamera, goal: OrbitCamera) -> None:
        """Draw the current frame into the scene, without repainting the view.

        Parameters
        ----------
        scene
            The scene of the open clip.
        camera
            The camera from which the image is seen.
        goal
            The camera at the end of the running animation or, without an animation, `camera`. Bones
            that hide the error from `goal` are translucent.
        """
        document, looks = self._document, self.looks
        self._drawn_offsets = self._offsets()
        scene.set_style(looks.style)
        if (scene.trails is not None) != looks.trails:
            scene.set_trails(looks.trails)
        turn = self.turn(scene)
        self.sign = self._angle_to_show(scene, turn)
        self.left = pose = self.pose(scene, Show.BEFORE if scene.split else None)
        faint = self._covering_bones(scene, pose, goal)
        if faint is not None:
            self.left = pose = replace(pose, faint=faint)
        if scene.split:
            pose = replace(self.pose(scene, Show.AFTER), faint=pose.faint)
            scene.draw(self.left, pose)
        else:
            scene.draw(pose)
        self.roles = frozenset(np.unique((self.left.roles, pose.roles)).tolist())
        seen = self.guest is None and not scene.split and document.show == Show.BOTH
        scene.draw_companion(self._tracked_pose() if seen else None, pose)
        turned = turn is not None and bool(turn.drawn)
        chain = selected_chain(document) if turned else None
        scene.draw_corrected(chain, self.left, pose, camera)
        # The axes of joints would overlap the fan.
        triads = looks.triads and self.guest is None and not turned
        scene.draw_triads(pose, _ends(pictured_chain(document)) if triads else ())
        both = scene.split or document.show == Show.BOTH
        before, after = both or document.show == Show.BEFORE, both or document.show == Show.AFTER
        if turn is None:
            scene.draw_circle(None)
        else:
            scene.draw_circle(
                turn.circle, turn.drawn, before=before, after=turn.after if after else None,
                line=turn.line,
            )  # fmt: skip
        if scene.trails is not None:
            scene.trails.draw(document.frame, camera.position, before=before, after=after)
        scene.show_from(camera)
        if self.guest is not None:
            self.guest.draw(scene, pose, camera)

    def turn(self, scene: Scene) -> Turn | None:
        """Return the rotation that corrects the selected chain or limb.

        The result is None if the rotation cannot be drawn as a circle.
        """
        document, chain = self._document, pictured_chain(self._document)
        if chain is None or isinstance(chain, LoneJoint) or self.guest is not None:
            return None
        now, then = (document.pose(document.frame, after=after) for after in (False, True))
        offset = float(document.offset(chain.name)[document.frame])
        skeleton = scene.data.motion.skeleton
        return limb_correction_turn(chain, offset, now, then, scene.bones, skeleton, scene.height)

    def pose(self, scene: Scene, show: Show | None = None) -> Pose:
        """Return the pose of the current frame, with the data for the colours of its bones.

        `show` selects the figure before correction, after correction, or both. By default, use the
        document's setting.
        """
        document = self._document
        if self.guest is not None:
            return self.guest.pose(scene, Show.BOTH if show is None else show)
        show, frame = document.show if show is None else show, document.frame
        before, positions = document.pose(frame, after=False)
        after, after_positions = document.pose(frame, after=True)
        roles = _roles(scene.bones, pictured_chain(document), scene.data.motion.skeleton)
        turned = scene.shapes.turned(before, after)
        if (turned & (roles == Role.CHOSEN)).any():  # colour only the selected limb
            turned &= roles == Role.CHOSEN
            roles[:] = Role.PLAIN
        elif (
            selected_unrepairable_interval(document) is not None
        ):  # no correction: the limb is wrong in all images
            roles[roles == Role.CHOSEN] = Role.BEFORE
        roles[turned] = Role.BEFORE if show == Show.BEFORE else Role.AFTER
        if show != Show.BEFORE:
            roles[turned & suggested_bones(document, scene)] = Role.SUGGESTED
        offsets = _bone_offsets(document, scene) if self.looks.by_offset else None
        if show == Show.BEFORE:
            return Pose(before, positions, roles, None, offsets)
        both = show == Show.BOTH
        ghost = (before, scene.shapes.differing(before, after)) if both else None
        # Without the captured figure, show the tracked motion, which is the final result.
        if not both and (tracked := self._tracked_pose()):
            after, after_positions = tracked
        return Pose(after, after_positions, roles, ghost, offsets, positions)

    def _tracked_pose(self) -> tuple[Array, Array] | None:
        return self.companion.pose(self._document.frame) if self.companion else None

    def legend(self, scene: Scene, theme: Theme) -> str:
        """Return the legend of the image as rich text."""
        if self.guest is not None:
            text = self.guest.legend()
        else:
            chain, fault = (
                selected_chain(self._document),
                selected_unrepairable_interval(self._document),
            )
            tracked = self._tracked_pose() is not None
            text = frame_legend(self._document, scene, theme, chain, fault, self.roles, tracked)
        if scene.trails is not None:
            text += trails_text(scene.trails.apart / scene.height)
        return text

    def _angle_to_show(self, scene: Scene, turn: Turn | None) -> AngleSign | None:
        """Return the angle to show in the image, or None.

        The angle is the offset of the selected chain or limb or, for an error that cannot be
        corrected, the size of the error.
        """
        document, chain = self._document, pictured_chain(self._document)
        hidden = not scene.split and document.show == Show.AFTER
        if chain is None or self.guest is not None or hidden:
            return None
        fault = selected_unrepairable_interval(document)
        offset = float(document.offset(document.chain)[document.frame])
        degrees = float(np.degrees(fault.size if fault else offset))
        if abs(degrees) < LEAST_ANGLE:
            return None
        _, positions = document.pose(document.frame, after=False)
        bone = positions[[chain.parent, chain.child]]
        return AngleSign(degrees, bone, None if fault else turn)

    def _covering_bones(
        self, scene: Scene, pose: Pose, camera: OrbitCamera
    ) -> NDArray[np.bool_] | None:
        """Return a mask of the bodies that hide the error, (bodies,), or None to hide no body."""
        if self.sign is None:
            return None
        points = self.sign.points[::_THINNED]
        ends = scene.ends(pose)
        own = np.zeros(len(ends), dtype=bool)
        own[: len(pose.roles)] = pose.roles != Role.PLAIN
        towards = normalise(camera.position - points.mean(axis=0))
        return occluding_bone_mask(ends, scene.rods.width, own, scene.height, points, towards)

    def own_joints(self, scene: Scene) -> tuple[int, ...]:
        """Return the joints of the selected chain's person, or of the first person."""
        chain = selected_chain(self._document)
        first = next(iter(scene.people.values()))
        return first if chain is None else scene.people.get(chain.person, first)

    def sides(self) -> Mapping[str, int]:
        """Return the joint that marks each side of the body in the image, keyed by side.

        The joints are the middle joints (C) of the selected chain or limb and of its counterpart
        on the opposite side. The selected side is the last entry. The result is empty if the side
        or the segment of the selected chain is unknown.
        """
        document, chosen = self._document, pictured_chain(self._document)
        if chosen is None or not chosen.side or not chosen.segment or document.data is None:
            return {}
        found = {
            c.side: c.child
            for c in reversed(document.data.chains_and_limbs)
            if (type(c), c.segment, c.person) == (type(chosen), chosen.segment, chosen.person)
        }
        found.pop(chosen.side)
        return {**found, chosen.side: chosen.child}

    def is_current(self) -> bool:
        """Return True if the current frame's corrections have not changed since it was drawn."""
        return self._offsets() == self._drawn_offsets

    def _offsets(self) -> tuple[object, ...]:
        """Return all values that determine the current corrected pose, to detect changes."""
        document = self._document
        if document.data is None:
            return ()
        chains, corrected = document.data.chains_and_limbs, document.corrected
        parts = (corrected.offset, corrected.carried)
        sums = (float(of(c.name)[document.frame]) for of in parts for c in chains)
        return (*sums, *corrected.repairs(document.frame))


def selected_chain(document: Document) -> Chain | None:
    """Return the selected chain or limb, or None if there is no clip or no chain."""
    try:
        return document.find_chain(document.chain)
    except KeyError:
        return None


def pictured_chain(document: Document) -> Chain | None:
    """Return the chain, limb or single bone to show, or None.

    This is usually the selected chain or limb. If the selected interval is an error of a single
    joint outside this chain, for example in the spine, a bone of the joint is returned: a bone
    that begins at the joint or, if there is none, the bone that ends at it.
    """
    chain, judged = selected_chain(document), document.interval
    if chain is None or judged is None or document.data is None:
        return chain
    interval, skeleton = judged.interval, document.data.motion.skeleton
    if not document.is_of_chain(interval) or interval.joint not in skeleton.names:
        return chain
    joint = skeleton.index(interval.joint)
    own = {chain.parent, chain.child, chain.grandchild}
    if isinstance(chain, Limb):
        own |= set(joint_path(skeleton, chain.parent, chain.end))
    if joint in own:
        return chain
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    children = [j for j in skeleton.children[joint] if lengths[j] > _SHORT * lengths.max()]
    towards = set(joint_path(skeleton, -1, chain.parent)) & set(children)
    child = next(iter([*towards, *children]), -1)
    if child < 0:
        joint, child = int(skeleton.parents[joint]), joint
    if joint < 0:
        return chain
    axis = skeleton.offsets[child]
    return LoneJoint(interval.joint, joint, child, -1, axis, axis, person=chain.person)


def _ends(chain: Chain | None) -> tuple[int, ...]:
    """Return the parent P and child C of a chain, or the first joint P and the end E of a limb."""
    if chain is None:
        return ()
    return chain.parent, chain.end if isinstance(chain, Limb) else chain.child


def selected_unrepairable_interval(document: Document) -> Interval | None:
    """Return the selected interval, or None if it can be corrected.

    The result is also None if the interval does not contain the current frame.
    """
    judged = document.interval
    if judged is None or judged.interval.repairable:
        return None
    interval = judged.interval
    return interval if interval.start <= document.frame < interval.stop else None


def selected_limb(document: Document) -> Limb | None:
    """Return the selected limb, or None if no limb is selected."""
    chain = selected_chain(document)
    return chain if isinstance(chain, Limb) else None


def altered_pose(document: Document, scene: Scene, altered: tuple[Array, Array] | None) -> Pose:
    """Return the altered pose, with the captured pose as its ghost.

    Only bones that do not change their position have a ghost. All bones except those of the
    selected chain are translucent.

    Parameters
    ----------
    document
        The document, which determines the frame and the selected chain.
    scene
        The scene of the open clip.
    altered
        The global rotations (joints, 4) and positions (joints, 3) of the altered pose. None returns
        the captured pose without a ghost.
    """
    before, positions = document.pose(document.frame, after=False)
    roles = _roles(scene.bones, selected_chain(document), scene.data.motion.skeleton)
    faint = np.append(roles != Role.CHOSEN, np.ones(len(scene.fronts), dtype=bool))
    if altered is None:
        return Pose(before, positions, roles, faint=faint)
    rotations, moved = altered
    differs = scene.shapes.differing(before, rotations)
    roles[differs] = Role.AFTER
    still = np.array([np.allclose(moved[b.parent], positions[b.parent]) for b in scene.bones])
    return Pose(rotations, moved, roles, (before, differs & still), faint=faint)


def _roles(bones: tuple[BoneSegment, ...], chain: Chain | None, skeleton: Skeleton) -> Index:
    """Return the role of each bone, (bones,): CHOSEN for the bones of `chain`, PLAIN for others.

    If `chain` is a twist bone, the bone whose roll it distributes is also CHOSEN.
    """
    pairs = {(chain.parent, chain.child), (chain.child, chain.grandchild)} if chain else set()
    if isinstance(chain, Limb):
        pairs = set(limb_bones(chain, skeleton))
    elif isinstance(chain, LoneJoint):
        pairs = set(_own_bones(chain.parent, skeleton))
    elif isinstance(chain, Helper):
        pairs = {*_own_bones(chain.parent, skeleton), (skeleton.parents[chain.parent], chain.child)}
    chosen = np.array([(b.parent, b.child) in pairs for b in bones], dtype=bool)
    return np.where(chosen, Role.CHOSEN, Role.PLAIN).astype(np.int64)


def _own_bones(joint: int, skeleton: Skeleton) -> list[tuple[int, int]]:
    """Return the bones that begin at a joint, as (joint, child); the child of an End Site is −1."""
    return [(joint, child) for child in (*skeleton.children[joint], -1)]


def suggested_bones(document: Document, scene: Scene) -> NDArray[np.bool_]:
    """Return a mask of the bones with a correction that the user has not accepted, (bones,)."""
    skeleton = scene.data.motion.skeleton
    chains = map(document.find_chain, document.suggested_chains)
    wanted = {pair for chain in chains for pair in _moved_bones(chain, skeleton)}
    return np.array([(b.parent, b.child) in wanted for b in scene.bones], dtype=bool)


def _moved_bones(chain: Chain, skeleton: Skeleton) -> list[tuple[int, int]]:
    """Return all bones that a correction may rotate, as (parent, child).

    For a chain, the child's bone is included, because the correction of a carried roll (an error
    that rotates both bones) rotates it together with the parent's bone.
    """
    turned = _turned_bones(chain, skeleton)
    return [*turned, (chain.child, chain.grandchild)] if type(chain) is Chain else turned


def _turned_bones(chain: Chain, skeleton: Skeleton) -> list[tuple[int, int]]:
    """Return the bones that every correction of a chain, limb or twist bone rotates.

    A bone is a pair of joints, (parent, child).
    """
    if isinstance(chain, Limb):
        return limb_bones(chain, skeleton)
    if isinstance(chain, Helper):
        return _own_bones(chain.parent, skeleton)
    return [(chain.parent, chain.child)]


def _bone_offsets(document: Document, scene: Scene) -> Array:
    """Return the |offset| of each bone at the current frame in radians, (bones,).

    A bone may have several offsets: from its chain, from its limb, and from an error of its joint.
    The largest one is returned.
    """
    by_pair: dict[tuple[int, int], float] = {}
    for chain in scene.data.chains_and_limbs:
        pairs = _turned_bones(chain, scene.data.motion.skeleton)
        offset = abs(float(document.offset(chain.name)[document.frame]))
        by_pair |= {pair: max(offset, by_pair.get(pair, 0.0)) for pair in pairs}
    for interval in document.corrected.repairs(document.frame):
        skeleton = scene.data.motion.skeleton
        offset = abs(float(interval.offset[document.frame - interval.start]))
        pairs = _own_bones(skeleton.index(interval.joint), skeleton)
        by_pair |= {pair: max(offset, by_pair.get(pair, 0.0)) for pair in pairs}
    return np.array([by_pair.get((b.parent, b.child), 0.0) for b in scene.bones])
