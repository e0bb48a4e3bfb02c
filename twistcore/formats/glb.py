"""Write a motion as binary glTF 2.0: joints, a skin without a mesh, and an animation."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import escape_invalid_utf8, json_bytes
from twistcore.skeleton.figure import vertical_axis_letter
from twistcore.skeleton.motion import Motion, check_motion
from twistcore.skeleton.rotation import (
    Array,
    continuous_quaternion_signs,
    quaternion_from_axis_angle,
)

_FLOAT = 5126  # glTF's number for 32-bit floats
_LARGEST = float(np.finfo(np.float32).max)  # the largest such float
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
_Words = dict[str, object]


def write_glb(motion: Motion, path: str | Path, *, unit: float = 1.0) -> None:
    """Write a motion as a .glb file, atomically.

    Joints keep their names, offsets and places in the hierarchy. The root joints are children of a
    node that is named after the file and converts Z up to Y up. End Sites are omitted.

    Parameters
    ----------
    motion
        The motion to write.
    path
        The file to write. An existing file is replaced.
    unit
        Length of one unit of the motion in metres, the unit of glTF.

    Raises
    ------
    TwistError
        If the motion has no frames, a number that is not finite, or a length that is too large for
        a 32-bit float.
    OSError
        If the file cannot be written.
    """
    check_motion(motion)
    path = Path(path)
    longest = _LARGEST * min(1.0, 1.0 / unit)
    lengths = (motion.positions, motion.skeleton.offsets)
    fits = all((np.abs(part) <= longest).all() for part in lengths)
    if not (motion.frames and fits and np.isfinite(motion.rotations).all()):
        raise TwistError(
            f"{path}: expected a motion with frames, finite numbers and lengths below "
            f"{_LARGEST:.1e} m"
        )
    write_atomically(path, glb_bytes(motion, path.stem, unit))


def glb_bytes(motion: Motion, name: str, unit: float = 1.0) -> bytes:
    """Return a motion as the bytes of a .glb file. `name` is the name of the animation."""
    skeleton, arrays = motion.skeleton, _Arrays()
    # Node j is joint j. The last node holds the figure.
    nodes: list[_Words] = [
        {
            "name": escape_invalid_utf8(joint),
            "translation": (unit * offset).tolist(),
            **({"children": list(below)} if below else {}),
        }
        for joint, offset, below in zip(
            skeleton.names, skeleton.offsets, skeleton.children, strict=True
        )
    ]
    figure: _Words = {
        "name": escape_invalid_utf8(name),
        "children": np.flatnonzero(skeleton.parents < 0).tolist(),
    }
    if vertical_axis_letter(motion) == "Z":
        turn = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), -np.pi / 2)
        figure["rotation"] = _scalar_last(turn).tolist()
    times = arrays.add(motion.times[:, None], limits=True)
    samplers: list[_Words] = []
    channels: list[_Words] = []

    def animate(joint: int, path: str, values: Array) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": joint, "path": path}})
        samplers.append({"input": times, "output": arrays.add(values)})

    for joint, q in enumerate(continuous_quaternion_signs(motion.rotations).swapaxes(0, 1)):
        animate(joint, "rotation", _scalar_last(q))
    for joint, places in zip(motion.positioned, motion.positions.swapaxes(0, 1), strict=True):
        animate(joint, "translation", unit * places)
    return _container(
        {
            "asset": {"version": "2.0", "generator": "Twist Inspector"},
            "scene": 0,
            "scenes": [{"nodes": [len(skeleton)]}],
            "nodes": [*nodes, figure],
            "skins": [{"joints": list(range(len(skeleton))), "skeleton": len(skeleton)}],
            "animations": [
                {"name": escape_invalid_utf8(name), "channels": channels, "samplers": samplers}
            ],
            "accessors": arrays.accessors,
            "bufferViews": arrays.views,
            "buffers": [{"byteLength": len(arrays.data)}],
        },
        bytes(arrays.data),
    )


@dataclass
class _Arrays:
    """The binary chunk of a GLB file under construction, with glTF descriptions of its arrays."""

    data: bytearray = field(default_factory=bytearray)
    views: list[_Words] = field(default_factory=list)
    accessors: list[_Words] = field(default_factory=list)

    def add(self, values: Array, *, limits: bool = False) -> int:
        """Append an array of rows, and return the index of its accessor.

        If `limits` is True, the accessor includes the minimum and maximum of each column.
        """
        single: NDArray[np.float32] = values.astype("<f4")
        about: _Words = {
            "bufferView": len(self.views),
            "componentType": _FLOAT,
            "count": len(single),
            "type": _TYPES[single.shape[1]],
        }
        if limits:
            about |= {"min": single.min(axis=0).tolist(), "max": single.max(axis=0).tolist()}
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": single.nbytes})
        self.data += single.tobytes()
        self.accessors.append(about)
        return len(self.accessors) - 1


def _scalar_last(q: Array) -> Array:
    """Return quaternions (…, 4) in glTF's order x, y, z, w."""
    return np.roll(q, -1, axis=-1)


def _container(document: _Words, data: bytes) -> bytes:
    """Return a GLB file with a glTF document and binary data, whose length is a multiple of 4."""
    text = json_bytes(document, indent=None)
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    parts = struct.pack("<4sII", b"glTF", 2, size), _chunk(b"JSON", text), _chunk(b"BIN\0", data)
    return b"".join(parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<I4s", len(content), kind) + content
