"""The user's changes to a skeleton's chains: added and removed chains, and meanings of joints."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from twistcore.errors import FormatError, TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import (
    check_choice,
    check_keys,
    check_string,
    check_string_list,
    format_value_for_message,
    parsed_toml,
    prefix_format_errors,
    read_bytes_limited,
    read_each,
)
from twistcore.files.encoding import (
    encode_utf8,
    escape_control_characters,
    toml_string,
    unescape_invalid_utf8,
)
from twistcore.skeleton.body import Body, find_body
from twistcore.skeleton.chain import VARYING, Chain, find_chains, make_chain
from twistcore.skeleton.helper import find_helpers
from twistcore.skeleton.joint_names import parse_joint_meaning
from twistcore.skeleton.limb import (
    Limb,
    as_limb,
    bone_lengths,
    find_limbs,
    joint_path,
    path_end_position,
)
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import normalise, vector_lengths
from twistcore.work.frozen import dataclass

_ZERO = 1e-6  # share of the skeleton's height; a shorter bone has no direction
_EXPECTED = (
    "expected [[chain]] tables with two or three joints each, and optionally a list of "
    "chain names in 'remove'"
)


@dataclass(frozen=True)
class OwnChain:
    """A chain that the user adds, given by the names of its joints.

    Parameters
    ----------
    joints : tuple of str
        Names of the parent, the child and, optionally, a joint below the child.
    limb : bool
        True to treat the three joints as a :class:`Limb`.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> tc.OwnChain(("Neck", "Neck1", "Head")).made(clip.motion)
    <Chain Neck: joints 14 → 15 → 16>
    """

    joints: tuple[str, ...]
    limb: bool = False

    @property
    def name(self) -> str:
        """Return the first joint's name or, for a limb, the names of its first joint and end."""
        return f"{self.joints[0]}-{self.joints[-1]}" if self.limb else self.joints[0]

    def made(self, motion: Motion) -> Chain:
        """Return the chain or limb in a motion's skeleton.

        Raises TwistError, with the reason, if the joints do not form a chain.
        """
        if len(self.joints) not in ((3,) if self.limb else (2, 3)):
            number = "three" if self.limb else "two or three"
            raise TwistError(f"expected {number} joints, found {len(self.joints)}")
        skeleton = motion.skeleton
        joints = [_joint(skeleton, name) for name in self.joints]
        for above, joint in pairwise(joints):
            _check_below(skeleton, above, joint)
        parent, child, below = (*joints, -1)[:3]
        if not self.limb and skeleton.parents[child] != parent:
            between = skeleton.names[joint_path(skeleton, parent, child)[0]]
            raise TwistError(
                f"{self.joints[1]} is not a child of {self.joints[0]}; choose {between}, "
                f"which lies between them, because {between} counter-rotates when an error twists "
                f"{self.joints[0]}"
            )
        chain = make_chain(motion, parent, child, below)
        if chain is not None and below >= 0 and skeleton.parents[below] != child:
            chain = _over_joints_between(motion, chain, below)
        if chain is None or chain.grandchild != below:
            at = 0 if chain is None else 1
            raise TwistError(f"{self.joints[at + 1]} is at the same position as {self.joints[at]}")
        if self.limb and min(bone_lengths(motion, chain)) <= _ZERO * skeleton.height:
            raise TwistError(f"a bone of {self.name} has no length")
        [person] = {p.name for p in find_people(skeleton) if parent in p.joints} or {""}
        chain = replace(chain, person=person)
        return as_limb(motion, chain) if self.limb else chain


@dataclass(frozen=True)
class Rig:
    """The user's changes to the chains that are found in a skeleton.

    A limb and its first chain are added and removed separately.

    Parameters
    ----------
    add : tuple of OwnChain
        Chains to add, in this order.
    remove : tuple of str
        Names of chains to remove.
    names : mapping of str to str
        Meanings of joints, keyed by joint name, such as ``{"Bone07": "left forearm"}``.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk.bvh")
    >>> rig = tc.Rig(add=(tc.OwnChain(("Neck", "Neck1")),), remove=("LeftShoulder",))
    >>> tc.analyse(clip, rig=rig).chains[-1]
    <Chain Neck: joints 14 → 15>
    """

    add: tuple[OwnChain, ...] = ()
    remove: tuple[str, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict, hash=False)

    def __bool__(self) -> bool:
        """Return True if the rig adds, removes or names anything."""
        return bool(self.add or self.remove or self.names)

    def body(self, motion: Motion) -> Body:
        """Return the limbs of a motion's skeleton, using the joint roles that the rig assigns."""
        return find_body(motion, said=self.names)

    def with_names(self, names: Mapping[str, str]) -> Rig:
        """Return a copy of the rig with different meanings of joints, keyed by joint name.

        Raises FormatError if a meaning is unknown.
        """
        for joint, said in names.items():
            parse_joint_meaning(joint, said)
        return replace(self, names=dict(names))

    def chains(self, motion: Motion) -> tuple[Chain, ...]:
        """Return the chains of a motion, followed by its limbs. Added ones come last in each group.

        Raises TwistError if the skeleton lacks a joint or a chain that the rig mentions, or if two
        chains would have the same name.
        """
        found = self._found(motion)
        names = {chain.name for chain in found}
        for name in self.remove:
            if name not in names:
                raise TwistError(
                    f"the rig removes the chain {format_value_for_message(name)}, "
                    "but the skeleton has no such chain"
                )
        chains = [chain for chain in found if chain.name not in self.remove]
        for own in self.add:
            made = own.made(motion)
            if any(chain.name == made.name for chain in chains):
                raise TwistError(
                    f"there is already a chain {format_value_for_message(made.name)}: remove it "
                    "first"
                )
            chains.append(made)
        return tuple(sorted(chains, key=lambda chain: isinstance(chain, Limb)))

    def with_chain(self, motion: Motion, own: OwnChain) -> Rig:
        """Return a copy of the rig with one more chain.

        If the rig removes this chain, the chain is restored instead. Raises TwistError if the
        joints do not form a chain, or if the name is already used.
        """
        made = own.made(motion)
        for chain in self._found(motion):
            if chain.name in self.remove and _same(chain, made):
                return replace(self, remove=tuple(n for n in self.remove if n != chain.name))
        rig = replace(self, add=(*self.add, own))
        rig.chains(motion)
        return rig

    def without(self, name: str) -> Rig:
        """Return a copy of the rig without the chain or limb of this name."""
        left = tuple(own for own in self.add if own.name != name)
        if len(left) < len(self.add):
            return replace(self, add=left)
        return replace(self, remove=(*self.remove, name))

    def own(self, name: str) -> OwnChain | None:
        """Return the added chain with this name, or None if the user did not add one."""
        return next((own for own in self.add if own.name == name), None)

    def _found(self, motion: Motion) -> tuple[Chain, ...]:
        body = self.body(motion)
        chains = find_chains(motion, body)
        return *chains, *find_helpers(motion, body), *find_limbs(motion, chains)

    def summary(self) -> str:
        """Summarise the changes as text, such as '2 added, 1 removed'."""
        counts = (
            (len(self.add), "added"),
            (len(self.remove), "removed"),
            (len(self.names), "named"),
        )
        return ", ".join(f"{n} {word}" for n, word in counts if n) or "unchanged"


AS_FOUND = Rig()


def skeleton_hash(skeleton: Skeleton) -> str:
    """Return a SHA-256 hash of the joint names and parents, which all clips of a rig share."""
    import hashlib  # slow to load; few commands need it

    text = json.dumps([list(skeleton.names), skeleton.parents.tolist()])
    return hashlib.sha256(encode_utf8(text)).hexdigest()


def rig_to_json(rig: Rig) -> dict[str, Any]:
    """Return the rig as JSON data for a session."""
    entries = [{"joints": list(o.joints)} | ({"kind": "limb"} if o.limb else {}) for o in rig.add]
    document: dict[str, Any] = {"add": entries, "remove": list(rig.remove)}
    return document | ({"names": dict(rig.names)} if rig.names else {})


def rig_from_json(entry: Any) -> Rig:
    """Return the rig that a session stores. Raises FormatError if the data are invalid."""
    rig = check_keys(entry, what="rig")
    add, remove = read_each(rig.get("add", []), "add", _own_from_json), rig.get("remove", [])
    names = {
        k: check_string(v, k) for k, v in check_keys(rig.get("names", {}), what="names").items()
    }
    return Rig(add, tuple(dict.fromkeys(check_string_list(remove, "remove")))).with_names(names)


def write_rig(path: Path, rig: Rig, skeleton: Skeleton, source: str) -> None:
    """Write a rig as a TOML file, atomically. Raises OSError if that fails.

    `source` names the clip in the file's first line.
    """
    lines = [
        f"# Chains of a rig, for twistcore --rig, made on {escape_control_characters(source)}.",
        f'skeleton = "{skeleton_hash(skeleton)}"',
        f"remove = {_toml(rig.remove)}",
    ]
    if rig.names:
        entries = (f"{toml_string(j)} = {toml_string(said)}" for j, said in rig.names.items())
        lines.append(f"names = {{ {', '.join(entries)} }}")
    for own in rig.add:
        lines += ["", "[[chain]]", f"joints = {_toml(own.joints)}"]
        lines += ['kind = "limb"'] if own.limb else []
    write_atomically(path, encode_utf8("\n".join(lines) + "\n"))


def read_rig(path: Path) -> Rig:
    """Read a rig from a TOML file. Raises TwistError or FormatError if the file is invalid."""
    with prefix_format_errors(path):
        document = parsed_toml(read_bytes_limited(path))
        if unknown := sorted(document.keys() - {"skeleton", "remove", "chain", "names"}):
            raise FormatError(f"{_EXPECTED}; found {format_value_for_message(unknown[0])}")
        try:
            rig = rig_from_json(
                {
                    "add": document.get("chain", []),
                    "remove": document.get("remove", []),
                    "names": document.get("names", {}),
                }
            )
        except FormatError as error:
            raise FormatError(f"{_EXPECTED}; {error}") from None
    add = tuple(
        OwnChain(tuple(map(unescape_invalid_utf8, own.joints)), own.limb) for own in rig.add
    )
    names = {unescape_invalid_utf8(joint): said for joint, said in rig.names.items()}
    return Rig(add, tuple(map(unescape_invalid_utf8, rig.remove))).with_names(names)


def _own_from_json(entry: Any) -> OwnChain:
    check_keys(entry, "joints", what="a chain of the rig")
    limb = check_choice(entry.get("kind", "chain"), "kind", ("chain", "limb")) == "limb"
    joints = check_string_list(entry["joints"], "joints")
    if len(joints) not in ((3,) if limb else (2, 3)):
        raise FormatError(f"found {len(joints)} joints")
    return OwnChain(joints, limb)


def _toml(names: Iterable[str]) -> str:
    return f"[{', '.join(map(toml_string, names))}]"


def _same(one: Chain, other: Chain) -> bool:
    joints = [(c.name, c.parent, c.child, c.grandchild) for c in (one, other)]
    return joints[0] == joints[1]


def _joint(skeleton: Skeleton, name: str) -> int:
    try:
        return skeleton.index(name)
    except KeyError:
        raise TwistError(
            f"there is no joint {format_value_for_message(name)} in this skeleton"
        ) from None


def _check_below(skeleton: Skeleton, above: int, joint: int) -> None:
    here = joint
    while (here := int(skeleton.parents[here])) >= 0:
        if here == above:
            return
    names = skeleton.names
    raise TwistError(f"{names[joint]} is not below {names[above]} in the skeleton")


def _over_joints_between(motion: Motion, chain: Chain, grandchild: int) -> Chain:
    """Return a chain whose `arm` points to a grandchild that is not a direct child of its child C.

    The direction varies over the frames if the joints in between bend. If the grandchild is too
    close to C in any frame, the chain has no grandchild.
    """
    bone = path_end_position(motion, joint_path(motion.skeleton, chain.child, grandchild))
    if vector_lengths(bone).min() <= _ZERO * motion.skeleton.height:
        return replace(chain, grandchild=-1)
    directions = normalise(bone)
    mean = normalise(directions.mean(axis=0))
    steady = (directions @ mean).min() >= VARYING
    return replace(chain, grandchild=grandchild, arm=mean if steady else directions)
