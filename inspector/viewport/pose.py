"""What the figure looks like at the document's frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inspector.session.document import Document, Show
from inspector.viewport.bodies import Bone
from inspector.viewport.bone_colours import Role
from inspector.viewport.scene import Scene
from inspector.viewport.solid_and_ghost import Pose
from twistcore.chain import Chain
from twistcore.rotation import Array


def pose_of(
    document: Document, scene: Scene, show: Show, chain: Chain | None, by_offset: bool
) -> Pose:
    """The frame's figure before, after or both; colours by the selected chain, or by |offset|."""
    assert document.data is not None
    frame = document.frame
    before, positions = document.pose(frame, after=False)
    after, after_positions = document.pose(frame, after=True)
    differs = scene.shapes.differing(before, after)
    roles = np.where(_chosen(scene.bones, chain), Role.CHOSEN, Role.PLAIN).astype(np.int64)
    roles[differs] = Role.BEFORE if show == Show.BEFORE else Role.AFTER
    offsets = _offsets(document, scene.bones) if by_offset else None
    if show == Show.BEFORE:
        return Pose(before, positions, roles, None, offsets)
    ghost = (before, differs) if show == Show.BOTH else None
    return Pose(after, after_positions, roles, ghost, offsets)


def altered_pose(
    document: Document, scene: Scene, chain: Chain | None, altered: tuple[Array, Array] | None
) -> Pose:
    """The captured figure, or an altered one (global rotations, positions) with it as a ghost.

    Where an alteration moves a bone, the ghost stays behind only if it keeps the bone's place.
    """
    assert document.data is not None
    frame = document.frame
    before, positions = document.pose(frame, after=False)
    roles = np.where(_chosen(scene.bones, chain), Role.CHOSEN, Role.PLAIN).astype(np.int64)
    if altered is None:
        return Pose(before, positions, roles)
    rotations, moved = altered
    differs = scene.shapes.differing(before, rotations)
    roles[differs] = Role.AFTER
    still = np.array([np.allclose(moved[b.parent], positions[b.parent]) for b in scene.bones])
    return Pose(rotations, moved, roles, (before, differs & still))


def _chosen(bones: tuple[Bone, ...], chain: Chain | None) -> NDArray[np.bool_]:
    """Which bones belong to the selected chain: P→C and, where there is one, C→G; (bones,)."""
    if chain is None:
        return np.zeros(len(bones), dtype=bool)
    pairs = {(chain.parent, chain.child), (chain.child, chain.grandchild)}
    return np.array([(b.parent, b.child) in pairs for b in bones], dtype=bool)


def _offsets(document: Document, bones: tuple[Bone, ...]) -> Array:
    """|offset| at the frame of the chain whose P→C a bone is, radians, (bones,)."""
    by_pair = {
        (c.parent, c.child): abs(float(document.offset(c.name)[document.frame]))
        for c in (document.data.chains if document.data else ())
    }
    return np.array([by_pair.get((b.parent, b.child), 0.0) for b in bones])
