"""Measurements of a skeleton's shape: bone lengths, lines of joints, and ranges of bends."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from twistcore.skeleton.body.offsets import ancestors, bone_offset, has_bone_offset_direction
from twistcore.skeleton.joint_names import JointName
from twistcore.skeleton.medians import quantile
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, normalise, rotate, vector_lengths

_SHORT_LINE = 0.15  # share of the longest line of joints; a shorter line is a finger or a foot
_WHOLE_BONE = 0.6  # share of the bone above; a forearm is longer, a finger shorter
_FINGERS = 3  # minimum number of lines of joints that begin at a hand or paw


class Shape:
    """Measurements of one person's joints, from which the person's limbs are found.

    Parameters
    ----------
    motion
        The motion, with its skeleton.
    names
        Meaning of each joint's name.
    joints
        The person's joints.
    said
        The joints whose meaning the user has given.

    Attributes
    ----------
    children, offsets, lengths
        For each joint, its children that belong to the person, its offset (:func:`bone_offset`) and
        the mean length of this offset.
    solid
        For each joint, True if its offset is long enough to have a direction.
    """

    def __init__(
        self,
        motion: Motion,
        names: Sequence[JointName],
        joints: frozenset[int],
        said: frozenset[int] = frozenset(),
    ) -> None:
        self.motion, self.skeleton, self.names = motion, motion.skeleton, names
        self.joints, self.said = joints, said
        self.parents = motion.skeleton.parents.tolist()
        self.children = [[c for c in below if c in joints] for below in self.skeleton.children]
        self.offsets = [bone_offset(motion, j) for j in range(len(names))]
        self.lengths = [float(vector_lengths(o).mean()) for o in self.offsets]
        self.solid = [has_bone_offset_direction(self.skeleton, offset) for offset in self.offsets]
        self._bends: dict[tuple[int, int], float] = {}

    def roles(self, joint: int, side: str) -> tuple[str, ...]:
        """Return the limb joints that a joint's name can mean, such as 'hand', most likely first.

        The result is empty if the name does not mean a joint on the given side.
        """
        name = self.names[joint]
        return name.roles if name.side == side and not name.other else ()

    def first_role(self, joint: int, side: str) -> str:
        """Return the most likely meaning of a joint's name as a limb joint, such as 'hand', or ''.

        The result is '' if the name does not mean a limb joint on the given side.
        """
        roles = self.roles(joint, side)
        return roles[0] if roles else ""

    def is_same_word(self, one: int, other: int) -> bool:
        """Return True if the names of two joints differ only in their numbers."""
        a, b = self.names[one], self.names[other]
        return (a.side, a.stem) == (b.side, b.stem) and a.number != b.number

    def above(self, joint: int) -> list[int]:
        """Return the person's joints above a joint, nearest first."""
        return [j for j in ancestors(self.skeleton, joint) if j in self.joints]

    def bend(self, joint: int, below: int) -> float:
        """Return how much the angle between the bones above and below a joint varies, in radians.

        The result is the difference between the 99th and the 1st percentile over all frames.
        """
        if (joint, below) not in self._bends:
            self._bends[joint, below] = self._bend_of(joint, below)
        return self._bends[joint, below]

    def _bend_of(self, joint: int, below: int) -> float:
        above, along = self.offsets[joint], self.offsets[below]
        if not (self.solid[joint] and self.solid[below]) or self.motion.frames < 2:
            return 0.0
        along = rotate(self.motion.rotations[:, joint], normalise(along))
        cosine = np.einsum("...i,...i->...", along, np.broadcast_to(normalise(above), along.shape))
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        return quantile(angle, 0.99) - quantile(angle, 0.01)

    @cached_property
    def outside_limbs(self) -> list[bool]:
        """Return a mask of the joints of heads, fingers and props, including their descendants."""
        out = [name.other for name in self.names]
        for joint, parent in enumerate(self.parents):
            out[joint] |= parent >= 0 and out[parent]
        return out

    @cached_property
    def reach(self) -> list[int]:
        """Return, for each joint, the number of bones on the longest line of joints below it."""
        return self.below[0]

    @cached_property
    def below(self) -> tuple[list[int], list[float], dict[int, int]]:
        """Return data about the longest line of joints below each joint.

        Returns
        -------
        bones : list of int
            Number of bones of the line, for each joint.
        far : list of float
            Length of the longest path below each joint.
        main : dict of int to int
            The child with which the line begins, keyed by joint.
        """
        bones = [0] * len(self.names)
        far = [0.0] * len(self.names)
        main: dict[int, int] = {}
        for joint, end in self.skeleton.end_offsets.items():
            far[joint] = float(np.linalg.norm(end))
        for joint in reversed(range(len(self.names))):
            for child in self.children[joint]:
                if self.outside_limbs[child]:
                    continue
                count = bones[child] + self.solid[child]
                if count > bones[joint] or joint not in main:
                    bones[joint], main[joint] = count, child
                far[joint] = max(far[joint], self.lengths[child] + far[child])
        return bones, far, main

    @cached_property
    def _longest(self) -> float:
        """Return the length of the person's longest line of joints, in the file's unit."""
        return max((self.below[1][j] for j in self.joints), default=0.0)

    def lines(self, taken: set[int]) -> list[list[int]]:
        """Return the lines of joints that begin below the trunk and contain no joint of `taken`.

        The trunk consists of all joints at which at least two long lines begin, and of the joints
        above them.
        """
        bones, far, main = self.below
        longest = self._longest
        trunk = {j for j in self.joints if self.parents[j] not in self.joints}
        for joint in self.joints:
            long = [
                c
                for c in self.children[joint]
                if not self.outside_limbs[c]
                and bones[c] >= 2
                and self.lengths[c] + far[c] > _SHORT_LINE * longest
            ]
            if len(long) >= 2:
                trunk.update((joint, *ancestors(self.skeleton, joint)))
        lines = []
        for joint in sorted(self.joints - trunk):
            if self.parents[joint] not in trunk or self.outside_limbs[joint]:
                continue
            line = [joint]
            while line[-1] in main and not self.branches(line[-1]):
                line.append(main[line[-1]])
            line += self._misnamed_end(line)
            if len(line) >= 2 and taken.isdisjoint(line):
                lines.append(line)
        return lines

    def _misnamed_end(self, line: Sequence[int]) -> list[int]:
        """Return the last joint of a line if its name was mistaken for a finger or a prop.

        The line must have at least two bones, and the joint must have children, as a hand does. The
        result is a list of this joint, or empty if there is none.
        """
        below = [c for c in self.children[line[-1]] if self.solid[c]]
        if len(line) < 3 or len(below) != 1 or not self.outside_limbs[below[0]]:
            return []
        if not self.children[below[0]]:
            return []
        return below if self.lengths[below[0]] > _WHOLE_BONE * self.lengths[line[-1]] else []

    def branches(self, joint: int) -> bool:
        """Return True if three or more lines of joints begin at a joint, as at a hand or a paw."""
        lines = (c for c in self.children[joint] if not self.outside_limbs[c] and self.reach[c])
        return len(list(lines)) >= _FINGERS

    @cached_property
    def rest(self) -> Array:
        """Return the positions of the joints in the rest pose, (joints, 3), in the file's unit."""
        out = np.zeros((len(self.names), 3))
        for joint, parent in enumerate(self.parents):
            out[joint] = self.skeleton.offsets[joint] + (out[parent] if parent >= 0 else 0.0)
        return out
