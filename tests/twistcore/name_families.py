"""Rigs of 60 and more families of names, from `name_families.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.skeleton.joint_names import ROLES
from twistcore.skeleton.motion import Motion, Skeleton

ARM, LEG = ROLES[:4], ROLES[4:]
LENGTHS_ARM, LENGTHS_LEG = (12.0, 28.0, 25.0, 8.0), (42.0, 40.0, 12.0, 6.0)
SEGMENTS = (  # of a chain: the bone's role, and of the joint that hangs on its end
    ("Shoulder", "shoulder", "arm"),
    ("Arm", "arm", "forearm"),
    ("ForeArm", "forearm", "hand"),
    ("UpLeg", "upleg", "leg"),
    ("Leg", "leg", "foot"),
)
_FILE = Path(__file__).with_suffix(".toml")


@dataclass(frozen=True)
class Family:
    """One family: what its file says, and the skeleton that is built of it."""

    entry: dict[str, Any]

    @property
    def name(self) -> str:
        return self.entry["name"]

    def limb(self, side: int) -> dict[str, list[str]]:
        """The joints of each role of a side, pieces from the top."""
        out = {}
        for role in ROLES:
            if (names := self.entry.get(role)) is not None:
                pieces = names if isinstance(names, list) else [names]
                out[role] = [self._sided(name, side) for name in pieces]
        return out

    def parents(self) -> dict[str, str | None]:
        """Every joint and what it hangs from, parents first."""
        trunk = self.entry["trunk"]
        out: dict[str, str | None] = dict(zip(trunk, [None, *trunk], strict=False))
        hips = self.entry.get("hips", trunk[0])
        for side in (0, 1):
            limb = self.limb(side)
            for roles, top in ((LEG, hips), (ARM, trunk[-1])):
                above = top
                for role in roles:
                    for joint in limb.get(role, ()):
                        if between := self._above(joint, side):
                            out[between], above = above, between
                        out[joint], above = above, joint
        for side in (0, 1):
            for parent, children in self.entry.get("next_to", {}).items():
                if (joint := self._sided(parent, side)) in out:
                    for child in children:
                        out.setdefault(self._sided(child, side), joint)
        return out

    def chains(self) -> list[tuple[str, str, str]]:
        """Side, segment and parent joint of every chain that the rig is to get."""
        out = []
        for side, label in enumerate(("Left", "Right")):
            limb = self.limb(side)
            for segment, role, below in SEGMENTS:
                if role in limb and below in limb and segment not in self.entry.get("lacks", {}):
                    out.append((label, segment, limb[role][-1]))
        return out

    def motion(self, frames: int = 40) -> Motion:
        """A body of this skeleton whose joints bend and whose pieces only twist."""
        parents = self.parents()
        names = tuple(parents)
        offsets = np.zeros((len(names), 3))
        bends = np.zeros(len(names))
        place = {name: k for k, name in enumerate(names)}
        for name, parent in parents.items():
            offsets[place[name]] = (0.0, 2.0, 1.0) if parent is None else (0.0, 10.0, 0.0)
        for parent in self.entry.get("next_to", {}):
            for side in (0, 1):
                for child in self.entry["next_to"][parent]:
                    x = 0.0 if self._sided(child, 0) == child else (3.0, -3.0)[side]
                    if (k := place.get(self._sided(child, side))) is not None:
                        offsets[k] = (x, 1.0, 3.0)
        for side, sign in enumerate((1.0, -1.0)):
            limb = self.limb(side)
            for roles, way in ((ARM, (1.0, 0.0, 0.0)), (LEG, (0.0, -1.0, 0.0))):
                longs = dict(zip(roles, (LENGTHS_ARM, LENGTHS_LEG)[roles is LEG], strict=True))
                above: list[str] = []
                for k, role in enumerate(roles):
                    pieces = limb.get(role, [])
                    for piece, joint in enumerate(pieces):
                        along = np.array([sign * way[0], way[1], way[2]])
                        if role == "toe":
                            along = np.array([0.0, -0.3, 1.0])
                        if piece:  # of the bone that the joint begins
                            offsets[place[joint]] = along * longs[role] / len(pieces)
                        elif above:
                            bone = longs[roles[k - 1]] if k else 0.0
                            offsets[place[joint]] = along * bone / len(above)
                        else:
                            start = (sign * 8.0, -3.0, 0.0) if roles is LEG else (sign * 4.0, 8, 0)
                            offsets[place[joint]] = start
                        if (between := self._above(joint, side)) and not piece:
                            offsets[place[between]] = (sign * 5.0, -1.0, 0.0)
                        bends[place[joint]] = 0.0 if piece else 1.0 + 0.1 * k
                    above = pieces or above
        skeleton = Skeleton(
            names,
            np.array([-1 if p is None else place[p] for p in parents.values()]),
            offsets,
        )
        turns = 0.6 * np.sin(np.arange(frames)[:, None] / 6.0 * bends) * (bends > 0.0)
        half = 0.5 * turns
        axis = np.array([0.48, 0.6, 0.64])
        rotations = np.zeros((frames, len(names), 4))
        rotations[..., 0] = np.cos(half)
        rotations[..., 1:] = np.sin(half)[..., None] * axis
        return Motion(skeleton, rotations, (), np.zeros((frames, 0, 3)), 1.0 / 30.0)

    def _above(self, joint: str, side: int) -> str:
        for below, name in self.entry.get("above", {}).items():
            if self._sided(below, side) == joint:
                return self._sided(name, side)
        return ""

    def _sided(self, name: str, side: int) -> str:
        return name.replace("*", self.entry["sides"][side])


FAMILIES = [Family(entry) for entry in tomllib.loads(_FILE.read_text("utf-8"))["family"]]
