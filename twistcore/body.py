"""The limbs of a body: which joints are its arms and legs, by their names or by their shape.

Names find the hands and feet, and the hierarchy gives the joints above them, so that 'Shoulder' may
mean the collar in one rig and the upper arm in another. A limb whose hand or foot has an unknown
name is found by the joints of it that are known, and a limb without any known name by its shape,
each limb for itself.

A bone may be in *pieces*: twist bones in the chain (`upperarm01 → upperarm02`), which share out the
roll of the bone and never bend against each other. A joint bends.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from twistcore.joint_names import FEET, HANDS, TOES, JointName, joint_as_said, understood
from twistcore.motion import Motion, Skeleton
from twistcore.rotation import Array, normalise, rotate

# The bones of a limb from its first joint to its end, each called as the joint that it begins at.
BONES = {"arm": ("Shoulder", "Arm", "ForeArm"), "leg": ("UpLeg", "Leg")}
SIDES = ("Left", "Right")
LIMBS = tuple((side, kind) for side in SIDES for kind in BONES)
_SEGMENT_OF: Mapping[tuple[str, ...], str] = {
    ("shoulder",): "Shoulder",
    ("arm",): "Arm",
    ("forearm",): "ForeArm",
    ("upleg",): "UpLeg",
    ("leg",): "Leg",
}
_ROLES = {"arm": ("shoulder", "arm", "forearm", "hand"), "leg": ("upleg", "leg", "foot")}
_WORDS = {"hand": HANDS, "foot": FEET}  # the first word first

_ZERO = 1e-6  # of the skeleton's height: shorter offsets have no direction
_SHIFT = 1e-2  # of OFFSET's length: positions so short are shifts from it or rounding, no bone
_NUMBERED = np.radians(5.0)  # a joint told from a piece by its number alone bends by more than this
_UNKNOWN = np.radians(1.0)  # and one whose name says nothing
_BENT = np.radians(10.0)  # a limb in which nothing bends by so much tells no piece from a joint
_SHORT_LINE = 0.15  # of the skeleton's longest line: a finger, a foot, what hangs on the trunk
_FINGERS = 3  # lines of bones from one joint of a limb: there it ends
_SMALL_LIMB = 0.35  # of the longest limb: a neck, an ear
_NEARLY = 0.8  # of the longest two bones together: then the two farther from the trunk count


@dataclass(frozen=True)
class Bone:
    """A bone of a limb: the joint P that it begins at, and C, the joint that hangs on P.

    segment: 'Arm', 'Leg' … or '' where nothing says which it is; ends: whether C begins another
    bone, not another piece of this one; pieces: how many the whole bone has.
    """

    parent: int
    child: int
    segment: str = ""
    ends: bool = True
    pieces: int = 1


@dataclass(frozen=True)
class LimbLine:
    """A limb: its bones, the first one first, and what hangs on its end.

    side: 'Left', 'Right' or ''; kind: 'arm', 'leg' or ''; below: the joint that the last joint
    points to (a toe), or −1; by_shape: its end was found by the shape of the skeleton.
    """

    side: str
    kind: str
    bones: tuple[Bone, ...]
    below: int = -1
    by_shape: bool = False

    @property
    def joints(self) -> tuple[int, ...]:
        """All joints of the limb, the first one first."""
        return (*(bone.parent for bone in self.bones), self.bones[-1].child)


@dataclass(frozen=True)
class Unexamined:
    """A limb, or the end of one, of which no chain could be made.

    limb: 'left arm', 'left forearm'; why: a clause that says why; side, kind: of the limb, as
    :class:`LimbLine` has them.
    """

    limb: str
    why: str
    side: str = ""
    kind: str = ""

    def __str__(self) -> str:
        return f"The {self.limb} was not examined: {self.why}."

    def to_json(self) -> dict[str, str]:
        """The limb, its side ('Left', 'Right' or '') and why, by name."""
        return {"limb": self.limb, "side": self.side, "why": self.why}


@dataclass(frozen=True, eq=False)
class Body:
    """The limbs of a skeleton and what its joints were taken for.

    names: what each joint's name says; lines: its limbs; missing: arms and legs that were not
    found.
    """

    skeleton: Skeleton
    names: tuple[JointName, ...]
    lines: tuple[LimbLine, ...]
    missing: tuple[Unexamined, ...] = ()

    @cached_property
    def taken_for(self) -> tuple[str, ...]:
        """What each joint was taken for: 'Left Arm', 'Left Hand', 'piece of Left Arm', or ''."""
        out = [""] * len(self.skeleton)
        for line in self.lines:
            for bone in reversed(line.bones):
                whole = f"{line.side} {bone.segment}".strip() or "limb"
                out[bone.parent] = whole
                if not bone.ends:
                    out[bone.child] = f"piece of {whole}"
            tip = {"arm": "Hand", "leg": "Foot"}.get(line.kind, "end")
            last = line.bones[-1]
            if last.segment in ("ForeArm", "Leg", ""):
                out[last.child] = f"{line.side} {tip}".strip()
            if line.below >= 0:
                out[line.below] = f"{line.side} Toe".strip() if line.kind else "below the end"
        return tuple(out)


def find_body(
    motion: Motion,
    *,
    joints: Iterable[int] | None = None,
    said: Mapping[str, str] = MappingProxyType({}),
) -> Body:
    """Return the limbs of a motion's skeleton.

    joints: of one person where there are several, all by default; said: what a person takes
    single joints for, by name: 'left hand', 'helper', as :func:`joint_as_said` has it.
    """
    every = motion.skeleton.names
    own = {k: joint_as_said(name, said[name]) for k, name in enumerate(every) if name in said}
    names = tuple(own.get(k, name) for k, name in enumerate(understood(every)))
    members = frozenset(range(len(names)) if joints is None else joints)
    search = _Search(motion, names, members, frozenset(own))
    lines = search.named_lines()
    shapes = search.shapes({j for line in lines.values() for j in line.joints})
    if not lines:
        found = search.unnamed_lines(shapes)
        return Body(motion.skeleton, names, found, _few_limbs(len(found)))
    lines |= search.lines_by_shape(shapes, lines)
    found = tuple(lines[limb] for limb in LIMBS if limb in lines)
    return Body(motion.skeleton, names, found, tuple(search.missing(lines)))


def lower_pair(sums: Sequence[float]) -> int:
    """Index of the thigh and shin, or arm and forearm, among pairs of bones of a limb.

    sums: the length of both bones of each pair, the pair at the trunk first. The longest; of pairs
    of nearly that length the farthest from the trunk: a collar may be as long as a forearm.
    """
    return max(k for k, both in enumerate(sums) if both >= _NEARLY * max(sums))


def has_length(skeleton: Skeleton, offset: Array) -> bool:
    """True if a vector, or one of some, is long enough for a direction; (3,) or (frames, 3)."""
    return bool(np.linalg.norm(offset, axis=-1).max() > shortest(skeleton))


def bone_offset(motion: Motion, joint: int) -> Array:
    """Where a joint is from its parent: (3,) from OFFSET, (frames, 3) from position channels.

    Position channels next to zero are shifts from OFFSET, or rounding: then OFFSET counts.
    """
    rest, offset = motion.skeleton.offsets[joint], motion.translation(joint)
    length, longest = np.linalg.norm(rest), np.linalg.norm(offset, axis=-1).max()
    smallest = shortest(motion.skeleton)
    shifts = length > smallest and longest <= max(smallest, _SHIFT * length)  # never of OFFSET
    return np.asarray(rest) if shifts else offset


def shortest(skeleton: Skeleton) -> float:
    """The length, in the file's unit, up to which an offset has no direction."""
    return _ZERO * skeleton.height


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Joints above one, the nearest first."""
    out = []
    while (joint := int(skeleton.parents[joint])) >= 0:
        out.append(joint)
    return out


class _Search:
    """What the search of one body needs at every step."""

    def __init__(
        self,
        motion: Motion,
        names: Sequence[JointName],
        joints: frozenset[int],
        said: frozenset[int],
    ) -> None:
        self.motion, self.skeleton, self.names = motion, motion.skeleton, names
        self.joints, self.said = joints, said  # said: the joints that a person named
        self.parents = motion.skeleton.parents.tolist()
        self.children = [[c for c in below if c in joints] for below in self.skeleton.children]
        self.offsets = [bone_offset(motion, j) for j in range(len(names))]
        self.lengths = [float(np.linalg.norm(o, axis=-1).mean()) for o in self.offsets]
        self.solid = [has_length(self.skeleton, offset) for offset in self.offsets]
        self._bends: dict[tuple[int, int], float] = {}

    # -- by names ----------------------------------------------------------------------------------

    def named_lines(self) -> dict[tuple[str, str], LimbLine]:
        """The limbs whose end, or a joint above it, has a name that is known."""
        paths = {limb: path for limb in LIMBS if (path := self._path_to_tip(*limb))}
        taken = {j for path, _ in paths.values() for j in path}
        for limb in LIMBS:
            if limb not in paths and (path := self._path_below(*limb, taken)):
                paths[limb] = path
        return self._lines(paths)

    def _lines(
        self, paths: Mapping[tuple[str, str], tuple[list[int], int]], *, by_shape: bool = False
    ) -> dict[tuple[str, str], LimbLine]:
        """Lines of paths (joints from the end up, and which bone the first of them ends)."""
        trunk: set[int] = set()  # above both hands or both feet: no shoulder and no thigh
        for kind in BONES:
            both = [set(paths[side, kind][0][1:]) for side in SIDES if (side, kind) in paths]
            if len(both) == len(SIDES):
                trunk.update(set.intersection(*both))
        lines = {}
        for (side, kind), (path, last) in paths.items():
            bones = self._bones(path, BONES[kind][: last + 1])
            bones = [b for b in bones if b.parent not in trunk and not self._bare_root(b.parent)]
            if bones:
                lines[side, kind] = LimbLine(
                    side, kind, tuple(bones), self._toe(side, kind, last, path[0]), by_shape
                )
        return lines

    def _bare_root(self, joint: int) -> bool:
        """True for a root from which several lines go out and that is not called a limb's joint."""
        return (
            self.parents[joint] not in self.joints
            and not self.names[joint].roles
            and len(self.children[joint]) > 1
        )

    def _path_to_tip(self, side: str, kind: str) -> tuple[list[int], int] | None:
        """Joints from a hand or foot with a known name up to the root, and its bone's index.

        Of several the one under the most joints with known names, so that a hand in a second
        hierarchy does not take the arm away.
        """
        roles = _ROLES[kind]
        tips = [j for j in self._called(side, roles[-1]) if not self.names[j].helper]
        if not tips:
            return None
        words = _WORDS[roles[-1]]

        def rank(joint: int) -> tuple[int, int, bool, int]:
            above = ancestors(self.skeleton, joint)
            known = {r for j in above for r in self._roles(j, side) if r in roles[:-1]}
            stem = self.names[joint].stem
            word = words.index(stem) if stem in words else len(words)
            return (-len(known), word, any(j in tips for j in above), joint)

        tip = min(tips, key=rank)
        return [tip, *self._above(tip)], len(BONES[kind]) - 1

    def _path_below(
        self, side: str, kind: str, taken: Collection[int]
    ) -> tuple[list[int], int] | None:
        """The path to the end of a limb of which only joints above the end have known names.

        taken: joints of other limbs.
        """
        roles = _ROLES[kind]
        inner = [
            j
            for j in sorted(self.joints.difference(taken))
            if not self.names[j].helper and self._first_role(j, side) in roles[:-1]
        ]
        if not any(self._first_role(j, side) != "shoulder" for j in inner):
            return None
        lowest = max(inner, key=lambda j: (len(ancestors(self.skeleton, j)), -j))
        line = [lowest, *self._above(lowest)]
        known = [j for j in line if j in inner]
        at = roles.index(self._first_role(lowest, side))
        if len(known) > 1 and self._is_same_word(known[0], known[1]) and at + 1 < len(roles) - 1:
            at += roles.index(self._first_role(known[1], side)) == at  # Arm1 → Arm2
        here = lowest
        while at < len(roles) - 1:
            below = self._main_child(here)
            if below is None:
                break
            helper = self.names[below].helper
            if helper and self._main_child(below) is None:
                break
            line.insert(0, below)
            here = below
            at += not helper and self.solid[below]
        # From here up the hierarchy decides, as it does above a hand.
        return (line, at - 1) if at > 0 else None

    def _called(self, side: str, role: str) -> list[int]:
        return [j for j in sorted(self.joints) if self._first_role(j, side) == role]

    def _first_role(self, joint: int, side: str) -> str:
        roles = self._roles(joint, side)
        return roles[0] if roles else ""

    def _roles(self, joint: int, side: str) -> tuple[str, ...]:
        name = self.names[joint]
        return name.roles if name.side == side and not name.other else ()

    def _is_same_word(self, one: int, other: int) -> bool:
        a, b = self.names[one], self.names[other]
        return (a.side, a.stem) == (b.side, b.stem) and a.number != b.number

    def _above(self, joint: int) -> list[int]:
        return [j for j in ancestors(self.skeleton, joint) if j in self.joints]

    def _main_child(self, joint: int) -> int | None:
        """The child of the same side along which the longest line goes on; None for an end."""
        sides = ("", self.names[joint].side)
        below = [
            c
            for c in self.children[joint]
            if self.names[c].side in sides and not self.names[c].other
        ]
        return max(below, key=lambda c: (self.reach[c], self.lengths[c], -c), default=None)

    def _toe(self, side: str, kind: str, last: int, tip: int) -> int:
        if kind != "leg" or last < len(BONES[kind]) - 1:
            return -1
        below = list(self.children[tip])
        for j in below:
            below.extend(self.children[j])
        return next(
            (
                j
                for j in below
                if self.names[j].side == side and any(w in self.names[j].stem for w in TOES)
            ),
            -1,
        )

    # -- bones and their pieces --------------------------------------------------------------------

    def _bones(self, path: Sequence[int], segments: Sequence[str]) -> list[Bone]:
        """Bones of a limb from its end upward, the first one first; path: joints, the end first."""
        pieces = self._pieces(path)
        left = list(segments)
        bones: list[list[Bone]] = [[]]
        for child, parent in pairwise(path):
            if not left:
                break
            if not self.solid[child]:  # in the place of its parent: no bone
                continue
            segment = _SEGMENT_OF.get(self.names[parent].roles) if parent in self.said else None
            if segment in segments:
                left = [*segments[: segments.index(segment) + 1]]
            bones[-1].append(Bone(parent, child, left[-1]))
            if parent not in pieces:
                bones.append([])
                left.pop()
        return [
            replace(bone, ends=k == 0, pieces=len(one))
            for one in bones
            for k, bone in enumerate(one)
        ][::-1]

    def _pieces(self, path: Sequence[int]) -> set[int]:
        """Joints that continue the bone above them; path: the end first."""
        out = set()
        triples = list(zip(path, path[1:], path[2:], strict=False))
        named = [self._first_role(j, self.names[j].side) for j in path]
        known = [k for k, role in enumerate(named) if role]
        highest = max((k for k in known if named[k] != "shoulder"), default=-1)
        evident = any(self._bend(here, below) > _BENT for below, here, _ in triples[: highest + 1])
        for k, (below, here, above) in enumerate(triples, 1):
            name = self.names[here]
            bend = self._bend(here, below)
            if name.helper:
                out.add(here)
            elif name.number and self._is_same_word(here, above):
                if bend < _NUMBERED if evident else not self._ambiguous(path[:k], here):
                    out.add(here)
            elif not name.roles and k < highest and evident and bend < _UNKNOWN:
                out.add(here)
        return out

    def _ambiguous(self, below: Sequence[int], joint: int) -> bool:
        """True if a joint's word may mean two bones and nothing below is the lower one.

        below: the joints of the limb under it, the end first.
        """
        name = self.names[joint]
        inner = (self.names[j] for j in below[1:])
        return len(name.roles) > 1 and all(n.helper or n.stem == name.stem for n in inner)

    def _bend(self, joint: int, below: int) -> float:
        """By how much the angle between the bones above and below a joint varies, radians."""
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
        low, high = np.percentile(angle, (1.0, 99.0))
        return float(high - low)

    # -- by shape ----------------------------------------------------------------------------------

    @cached_property
    def _out_of_it(self) -> list[bool]:
        """Joints of the head, of fingers and of what is carried, and all below them."""
        out = [name.other for name in self.names]
        for joint, parent in enumerate(self.parents):
            out[joint] |= parent >= 0 and out[parent]
        return out

    @cached_property
    def reach(self) -> list[int]:
        """Bones below a joint along the longest line."""
        return self._below[0]

    @cached_property
    def _below(self) -> tuple[list[int], list[float], dict[int, int]]:
        """Bones below each joint, their length together, and the child along that line."""
        bones = [0] * len(self.names)
        far = [0.0] * len(self.names)
        main: dict[int, int] = {}
        for joint, end in self.skeleton.end_offsets.items():
            far[joint] = float(np.linalg.norm(end))
        for joint in reversed(range(len(self.names))):
            for child in self.children[joint]:
                if self._out_of_it[child]:
                    continue
                count = bones[child] + self.solid[child]
                if count > bones[joint] or joint not in main:
                    bones[joint], main[joint] = count, child
                far[joint] = max(far[joint], self.lengths[child] + far[child])
        return bones, far, main

    @cached_property
    def _longest(self) -> float:
        """Length of the skeleton's longest line."""
        return max((self._below[1][j] for j in self.joints), default=0.0)

    def shapes(self, taken: set[int]) -> list[list[int]]:
        """Lines of joints that hang from the trunk and have none of the joints taken.

        A joint is of the trunk if two long lines leave it, and so is every joint above it.
        """
        bones, far, main = self._below
        longest = self._longest
        trunk = {j for j in self.joints if self.parents[j] not in self.joints}
        for joint in self.joints:
            long = [
                c
                for c in self.children[joint]
                if not self._out_of_it[c]
                and bones[c] >= 2
                and self.lengths[c] + far[c] > _SHORT_LINE * longest
            ]
            if len(long) >= 2:
                trunk.update((joint, *ancestors(self.skeleton, joint)))
        lines = []
        for joint in sorted(self.joints - trunk):
            if self.parents[joint] not in trunk or self._out_of_it[joint]:
                continue
            line = [joint]
            while line[-1] in main and not self._branches(line[-1]):
                line.append(main[line[-1]])
            if len(line) >= 2 and taken.isdisjoint(line):
                lines.append(line)
        return lines

    def _branches(self, joint: int) -> bool:
        """True for a joint that ends a limb, as a hand with fingers or a paw does."""
        lines = (c for c in self.children[joint] if not self._out_of_it[c] and self.reach[c])
        return len(list(lines)) >= _FINGERS

    def unnamed_lines(self, shapes: Sequence[Sequence[int]]) -> tuple[LimbLine, ...]:
        """The limbs along lines of joints whose names say nothing; next to legs a neck is none."""
        found = [line for shape in shapes if (line := self.unnamed_line(shape))]
        sizes = [sum(self.lengths[b.child] for b in line.bones) for line in found]
        least = _SMALL_LIMB * max(sizes, default=0.0)
        return tuple(line for line, size in zip(found, sizes, strict=True) if size > least)

    def unnamed_line(self, joints: Sequence[int]) -> LimbLine | None:
        """The limb along a line of joints whose names say nothing; None without two bones."""
        bones = self._unnamed_bones(joints)
        if not bones:
            return None
        end = bones[-1].child
        below = self._below[2].get(end, -1)
        return LimbLine("", "", tuple(bones), self._pointed_at(end, below), by_shape=True)

    def _pointed_at(self, end: int, below: int) -> int:
        """The joint below a limb's end if the end is bent as a foot is; a hand is straight."""
        if below < 0 or not (self.solid[below] and self.solid[end]):
            return -1
        along = rotate(self.motion.rotations[:, end], normalise(self.offsets[below]))
        above = np.broadcast_to(normalise(self.offsets[end]), along.shape)
        cosine = float(np.median(np.einsum("...i,...i->...", along, above)))
        return below if abs(cosine) < np.cos(np.radians(30.0)) else -1

    def _unnamed_bones(self, joints: Sequence[int]) -> list[Bone]:
        """Bones down to the end of a limb: below its two longest ones only what is long, too."""
        pairs = [(p, c) for p, c in pairwise(joints) if self.solid[c]]
        if len(pairs) < 2:
            return []
        inner = [(c, d) for (_, c), (_, d) in pairwise(pairs)]
        evident = any(self._bend(c, d) > _BENT for c, d in inner)
        pieces = {c for c, d in inner if self.names[c].helper}
        if evident:
            pieces |= {c for c, d in inner if self._bend(c, d) < _UNKNOWN}
        whole: list[list[tuple[int, int]]] = []
        for pair in pairs:
            if whole and pair[0] in pieces:
                whole[-1].append(pair)
            else:
                whole.append([pair])
        size = [sum(self.lengths[c] for _, c in bone) for bone in whole]
        end = lower_pair([a + b for a, b in pairwise(size)]) + 1 if len(size) > 1 else 0
        far = self._below[1]
        longest = self._longest
        while end + 1 < len(whole):  # a long foot, as a horse has one
            above = whole[end + 1][0][0]
            if far[above] <= _SHORT_LINE * longest:
                break
            end += 1
        out = []
        for bone in whole[: end + 1]:
            for k, (p, c) in enumerate(bone):
                out.append(Bone(p, c, "", k == len(bone) - 1, len(bone)))
        return out

    def lines_by_shape(
        self, shapes: Sequence[Sequence[int]], known: Mapping[tuple[str, str], LimbLine]
    ) -> dict[tuple[str, str], LimbLine]:
        """Limbs without a known name that stand opposite to a known one, or on the bare trunk."""
        paths: dict[tuple[str, str], tuple[list[int], int]] = {}
        left = [list(s) for s in shapes if self._unnamed_bones(s)]
        across = self._across(known)
        for kind in BONES:
            wanted = [side for side in SIDES if (side, kind) not in known]
            if not wanted:
                continue
            here = self._candidates(left, kind, known)
            for side in wanted:
                own = [s for s in here if self._side(s, across) == side]
                if len(own) != 1:
                    continue
                bones = self._unnamed_bones(own[0])
                joints = own[0][: own[0].index(bones[-1].child) + 1]
                paths[side, kind] = (joints[::-1], len(BONES[kind]) - 1)
                left.remove(own[0])
        return self._lines(paths, by_shape=True)

    def _candidates(
        self,
        shapes: Sequence[list[int]],
        kind: str,
        known: Mapping[tuple[str, str], LimbLine],
    ) -> list[list[int]]:
        """Lines that may be arms or legs: those on the joint that the limb of the other side has.

        Without one: those on the trunk above the legs for arms, on the root's side for legs.
        """
        anchors = {k: self._anchors(known, k) for k in BONES}
        if anchors[kind]:
            return [s for s in shapes if self.parents[s[0]] in anchors[kind]]
        other = next(k for k in BONES if k != kind)
        return [s for s in shapes if self.parents[s[0]] not in anchors[other]]

    def _anchors(self, known: Mapping[tuple[str, str], LimbLine], kind: str) -> set[int]:
        """Joints that the limbs of a kind hang on."""
        return {self.parents[line.bones[0].parent] for (_, k), line in known.items() if k == kind}

    def _across(self, known: Mapping[tuple[str, str], LimbLine]) -> Array | None:
        """The direction from right to left at rest, (3,), by a pair of known limbs."""
        for kind in BONES:
            pair = [known.get((side, kind)) for side in SIDES]
            if all(pair):
                left, right = (self._rest[line.bones[-1].child] for line in pair if line)
                return np.asarray(left - right)
        return None

    @cached_property
    def _rest(self) -> Array:
        """Places of the joints at rest, (joints, 3)."""
        out = np.zeros((len(self.names), 3))
        for joint, parent in enumerate(self.parents):
            out[joint] = self.skeleton.offsets[joint] + (out[parent] if parent >= 0 else 0.0)
        return out

    def _side(self, shape: Sequence[int], across: Array | None) -> str:
        """The side that the names of a line say, or its place at rest; '' where neither does."""
        named = {self.names[j].side for j in shape} - {""}
        if len(named) == 1:
            return named.pop()
        if across is None or named:
            return ""
        middle = self._rest[self.parents[shape[0]]]
        far = (self._rest[list(shape)] - middle) @ across
        widest = float(far[np.abs(far).argmax()])
        span = float(np.abs(across @ across))
        if abs(widest) < 0.05 * span:
            return ""
        return "Left" if widest > 0.0 else "Right"

    # -- what was not found ------------------------------------------------------------------------

    def missing(self, lines: Mapping[tuple[str, str], LimbLine]) -> Iterable[Unexamined]:
        """Limbs of the four that were not found, and bones of those found that make no chain."""
        for side, kind in LIMBS:
            limb = f"{side.lower()} {kind}"
            if (side, kind) not in lines:
                yield Unexamined(limb, self._why_missing(side, kind), side, kind)
                continue
            have = {bone.segment for bone in lines[side, kind].bones}
            if kind == "arm" and "ForeArm" not in have:
                why = "no hand joint hangs on it"
                yield Unexamined(f"{side.lower()} forearm", why, side, kind)
            if kind == "leg" and "Leg" not in have:
                why = "no foot joint hangs on it"
                yield Unexamined(f"{side.lower()} shin", why, side, kind)

    def _why_missing(self, side: str, kind: str) -> str:
        end = _ROLES[kind][-1]
        unknown = [
            self.skeleton.names[j]
            for j in sorted(self.joints)
            if self.names[j].side == side
            and not (self.names[j].roles or self.names[j].helper or self.names[j].other)
        ]
        why = f"no joint is known as its {end}"
        if unknown:
            some = ", ".join(repr(name) for name in unknown[:3])
            why += f"; unknown: {some}" + (" …" if len(unknown) > 3 else "")
        return why


def _few_limbs(found: int) -> tuple[Unexamined, ...]:
    """The note of a skeleton whose names say nothing, with fewer than four limbs by shape."""
    if found >= len(LIMBS):
        return ()
    why = f"no joint has a known name and {found} of four limbs were found by shape"
    return (Unexamined("arms and legs" if not found else "other limbs", why),)
