"""A motion that has no BVH yet, as BVH text."""

from __future__ import annotations

import numpy as np

from twistcore.motion import Motion
from twistcore.rotation import Array, euler_from_quaternion

_ORDER = "ZXY"
_END = 0.05  # length of an End Site as a share of the skeleton's height


def bvh_text(motion: Motion) -> str:
    """BVH with positions and ZXY rotations on roots and rotations on all other joints.

    Joints without children get an End Site along their own offset. Angles are continuous over time
    but for the turn that the middle angle's range forces.
    """
    skeleton = motion.skeleton
    lines, order = ["HIERARCHY"], []

    def describe(joint: int, depth: int) -> None:
        order.append(joint)
        indent, root = "\t" * depth, skeleton.parents[joint] < 0
        lines.append(f"{indent}{'ROOT' if root else 'JOINT'} {skeleton.names[joint]}")
        lines.append(f"{indent}{{")
        lines.append(f"{indent}\tOFFSET {_words(skeleton.offsets[joint])}")
        rotations = " ".join(f"{letter}rotation" for letter in _ORDER)
        place = "Xposition Yposition Zposition " if root else ""
        lines.append(f"{indent}\tCHANNELS {6 if root else 3} {place}{rotations}")
        for child in skeleton.children[joint]:
            describe(child, depth + 1)
        if not skeleton.children[joint]:
            offset = skeleton.offsets[joint]
            length = float(np.linalg.norm(offset))
            tip = offset / length if length > 0.0 else np.array([0.0, 1.0, 0.0])
            lines.append(f"{indent}\tEnd Site")
            lines.append(f"{indent}\t{{")
            lines.append(f"{indent}\t\tOFFSET {_words(_END * skeleton.height * tip)}")
            lines.append(f"{indent}\t}}")
        lines.append(f"{indent}}}")

    for root in np.flatnonzero(skeleton.parents < 0).tolist():
        describe(root, 0)
    columns = []
    for joint in order:
        if skeleton.parents[joint] < 0:
            columns.append(np.broadcast_to(motion.translation(joint), (motion.frames, 3)))
        angles = euler_from_quaternion(_ORDER, motion.rotations[:, joint])
        columns.append(np.degrees(np.unwrap(angles, axis=0)))
    rows = np.concatenate(columns, axis=1)
    lines += ["MOTION", f"Frames: {motion.frames}", f"Frame Time: {motion.frame_time:.9g}"]
    form = " ".join(["%.6f"] * rows.shape[1])
    lines += [form % tuple(row) for row in rows.tolist()]
    return "\n".join(lines) + "\n"


def _words(vector: Array) -> str:
    return " ".join(f"{v:.6f}" for v in vector.tolist())
