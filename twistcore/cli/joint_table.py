"""Print how each joint was recognised, for `twistcore info --names`."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from twistcore.cli.output import print_result, terminal_text
from twistcore.skeleton.body import Body
from twistcore.skeleton.joint_names import JointName

_WIDTH = 24  # minimum width of the column with joint names
_UNKNOWN = "unknown"


def recognised_bones_to_json(body: Body, own: Collection[str]) -> list[dict[str, Any]]:
    """Return the recognised bone of each joint, its side, other possible bones, and the reason.

    `own` are the joints that the user has named in a file.
    """
    by_shape = {joint for line in body.lines if line.by_shape for joint in line.joints}
    return [
        {
            "joint": joint,
            "taken_for": taken or _kind(name),
            "side": name.side,
            "roles": list(name.roles),
            "word": name.word,
            "by": "your own names" if joint in own else _why(name, taken, shape=k in by_shape),
        }
        for k, (joint, name, taken) in enumerate(
            zip(body.skeleton.names, body.names, body.joint_roles, strict=True)
        )
    ]


def print_joint_names(entries: Iterable[Mapping[str, Any]]) -> None:
    """Print one row for each joint."""
    rows = [(terminal_text(e["joint"]), e["taken_for"], e["by"]) for e in entries]
    if rows:
        width = max(_WIDTH, *(len(joint) for joint, *_ in rows))
        print_result(f"  {'joint':<{width}} {'body part':<24} recognised by", head=True)
        for joint, taken, by in rows:
            print_result(f"  {joint:<{width}} {taken:<24} {terminal_text(by)}".rstrip())


def _kind(name: JointName) -> str:
    """Return the kind of joint that a name describes, for a joint that belongs to no limb."""
    if name.other:
        return "head, finger or prop"
    if name.helper:
        return "helper"
    if name.trunk:
        return "trunk"
    return f"{name.side} {name.roles[0]}, not in a limb".strip() if name.roles else _UNKNOWN


def _why(name: JointName, taken: str, *, shape: bool) -> str:
    """Return a phrase with the reason why a joint was recognised.

    `taken` is the recognised bone, or ''. `shape` is True if the joint was recognised by its shape.
    """
    if name.word and (taken == "" or name.roles):
        return f"the word {name.word!r}"
    if taken:
        return "its shape" if shape else "its place in the hierarchy"
    return "" if _kind(name) == _UNKNOWN else "its name"
