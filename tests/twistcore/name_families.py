"""Rigs of 60 and more families of names, from `name_families.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from twistcore.joint_names import ROLES

ARM, LEG = ROLES[:4], ROLES[4:]
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
        out: dict[str, str | None] = {}
        for above, joint in zip([None, *trunk], trunk, strict=False):
            out[joint] = above
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
            for parent, children in self.entry.get("beside", {}).items():
                if (joint := self._sided(parent, side)) in out:
                    for child in children:
                        out.setdefault(self._sided(child, side), joint)
        return out

    def _above(self, joint: str, side: int) -> str:
        for below, name in self.entry.get("above", {}).items():
            if self._sided(below, side) == joint:
                return self._sided(name, side)
        return ""

    def _sided(self, name: str, side: int) -> str:
        return name.replace("*", self.entry["sides"][side])


FAMILIES = [Family(entry) for entry in tomllib.loads(_FILE.read_text("utf-8"))["family"]]
