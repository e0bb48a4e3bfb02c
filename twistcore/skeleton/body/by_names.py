"""Find limbs whose joints have known names."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from twistcore.skeleton.body.bones import limb_bones_by_name
from twistcore.skeleton.body.offsets import ancestors
from twistcore.skeleton.body.parts import BONES, LIMBS, SIDES, LimbLine
from twistcore.skeleton.body.shape import Shape
from twistcore.skeleton.joint_names import FEET, HANDS, TOES

ROLES = {"arm": ("shoulder", "arm", "forearm", "hand"), "leg": ("upleg", "leg", "foot")}
_STUB = 0.4  # share of the next bone; a shorter bone is not a thigh or an upper arm
_WORDS = {"hand": HANDS, "foot": FEET}  # names of the end of a limb; later ones are preferred

# The joints from a limb's end up to the root, and the index in BONES of the bone that ends at the
# first of them.
Path = tuple[list[int], int]


def find_limbs_by_name(shape: Shape) -> dict[tuple[str, str], LimbLine]:
    """Return the limbs in which the hand or foot, or a joint above it, has a known name.

    The dict is keyed by side and kind, such as ('Left', 'arm').
    """
    paths = {limb: path for limb in LIMBS if (path := _path_to_tip(shape, *limb))}
    taken = {j for path, _ in paths.values() for j in path}
    for limb in LIMBS:
        if limb not in paths and (path := _path_below(shape, *limb, taken)):
            paths[limb] = path
    return _lines_of(shape, paths)


def _lines_of(
    shape: Shape, paths: Mapping[tuple[str, str], Path]
) -> dict[tuple[str, str], LimbLine]:
    """Return the limbs along the given paths of joints, keyed by (side, kind)."""
    trunk: set[int] = set()  # joints above both hands or both feet cannot be a shoulder or thigh
    for kind in BONES:
        both = [set(paths[side, kind][0][1:]) for side in SIDES if (side, kind) in paths]
        if len(both) == len(SIDES):
            trunk.update(set.intersection(*both))
    lines = {}
    for (side, kind), (path, last) in paths.items():
        bones = limb_bones_by_name(shape, path, BONES[kind][: last + 1])
        bones = [b for b in bones if b.parent not in trunk and not _bare_root(shape, b.parent)]
        if bones:
            whole = kind == "leg" and last == len(BONES[kind]) - 1
            toe = toe_of(shape, side, path[0]) if whole else -1
            lines[side, kind] = LimbLine(side, kind, tuple(bones), toe)
    return lines


def _bare_root(shape: Shape, joint: int) -> bool:
    """Return True if a joint is a root with several children and is not named as a limb joint."""
    return (
        shape.parents[joint] not in shape.joints
        and not shape.names[joint].roles
        and len(shape.children[joint]) > 1
    )


def _path_to_tip(shape: Shape, side: str, kind: str) -> Path | None:
    """Return the joints from a limb's named hand or foot up to the root, or None if neither exists.

    If there are several hands or feet, the one below the most named joints is chosen, so that a
    hand in a second hierarchy, such as a control rig, does not replace the real one.
    """
    roles = ROLES[kind]
    tips = [j for j in _called(shape, side, roles[-1]) if not shape.names[j].helper]
    if not tips:
        return None
    words = _WORDS[roles[-1]]

    def rank(joint: int) -> tuple[int, bool, int, int, int]:
        above = ancestors(shape.skeleton, joint)
        known = {r for j in above for r in shape.roles(j, side) if r in roles[:-1]}
        stem = shape.names[joint].stem
        word = words.index(stem) if stem in words else -1
        # Prefer a wrist above the hand. A wrist next to the hand is a helper; in this case prefer
        # the joint with fingers.
        below = any(j in tips for j in above)
        return (-len(known), below, -shape.reach[joint], -word, joint)

    tip = min(tips, key=rank)
    return [tip, *shape.above(tip)], len(BONES[kind]) - 1


def _path_below(shape: Shape, side: str, kind: str, taken: Collection[int]) -> Path | None:
    """Return the joints from a hand or foot with an unknown name up to the root, or None.

    The hand or foot is found by the named joints of the limb above it. The result is None if no
    joint except the shoulder has a known name. `taken` contains the joints of other limbs.
    """
    roles = ROLES[kind]
    inner = [
        j
        for j in sorted(shape.joints.difference(taken))
        if not shape.names[j].helper and shape.first_role(j, side) in roles[:-1]
    ]
    if not any(shape.first_role(j, side) != "shoulder" for j in inner):
        return None
    lowest = max(inner, key=lambda j: (len(ancestors(shape.skeleton, j)), -j))
    line = [lowest, *shape.above(lowest)]
    known = [j for j in line if j in inner]
    at = roles.index(shape.first_role(lowest, side))
    if len(known) > 1 and shape.is_same_word(known[0], known[1]) and at + 1 < len(roles) - 1:
        at += roles.index(shape.first_role(known[1], side)) == at  # as in Arm1 → Arm2
    here = lowest
    while at < len(roles) - 1:
        below = _main_child(shape, here)
        if below is None:
            break
        helper = shape.names[below].helper
        if helper and _main_child(shape, below) is None:
            break
        line.insert(0, below)
        here = below
        at += not helper and shape.solid[below] and not (at == 0 and _is_stub(shape, below))
    # The hierarchy determines the joints above, as it does above a named hand.
    return (line, at - 1) if at > 0 else None


def _is_stub(shape: Shape, joint: int) -> bool:
    """Return True if the bone that ends at a joint is far shorter than the next bone.

    An example is LHipJoint → LeftUpLeg.
    """
    below = _main_child(shape, joint)
    return below is not None and shape.lengths[joint] < _STUB * shape.lengths[below]


def _called(shape: Shape, side: str, role: str) -> list[int]:
    return [j for j in sorted(shape.joints) if shape.first_role(j, side) == role]


def _main_child(shape: Shape, joint: int) -> int | None:
    """Return the child with the longest line of joints below it, or None if there is no child.

    Children whose names mean the opposite side of the body are ignored.
    """
    sides = ("", shape.names[joint].side)
    own = [c for c in shape.children[joint] if shape.names[c].side in sides]
    below = [c for c in own if not shape.names[c].other]
    if not below:  # a joint such as LeftHeel, above the toes
        below = [c for c in own if any(shape.names[j].roles for j in shape.children[c])]
    return max(below, key=lambda c: (shape.reach[c], shape.lengths[c], -c), default=None)


def toe_of(shape: Shape, side: str, foot: int) -> int:
    """Return the nearest joint below a foot that is named as a toe of the given side, or −1."""
    below = list(shape.children[foot])
    for j in below:
        below.extend(shape.children[j])
    named = (
        j
        for j in below
        if shape.names[j].side == side and any(w in shape.names[j].stem for w in TOES)
    )
    return next(named, -1)
