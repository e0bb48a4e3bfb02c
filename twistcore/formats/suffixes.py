"""How files of each format end: known without loading any reader, or numpy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from types import MappingProxyType

CLIP_SUFFIXES = (".bvh", ".npz", ".amc", ".pkl")
# Other files of motion, by name: none of them is written, whatever is asked for.
_OTHERS: Mapping[str, str] = MappingProxyType(
    {
        ".fbx": "FBX",
        ".glb": "glTF",
        ".gltf": "glTF",
        ".vrm": "VRM",
        ".vrma": "VRM",
        ".blend": "Blender file",
        ".usd": "USD",
        ".usda": "USD",
        ".usdc": "USD",
        ".usdz": "USD",
        ".abc": "Alembic",
        ".dae": "Collada",
        ".ma": "Maya scene",
        ".mb": "Maya scene",
        ".bip": "Biped file",
        ".vmd": "MMD motion",
        ".c3d": "C3D",
        ".trc": "TRC",
        ".asf": "ASF",
        ".npy": "single array",
    }
)


def clip_suffix(name: PurePath | str) -> str:
    """The suffix of a clip's name, in small letters; '' where it is none of a clip."""
    suffix = PurePath(name).suffix.lower()
    return suffix if suffix in CLIP_SUFFIXES else ""


def other_format(name: PurePath | str) -> str:
    """Name of the format that a file ends as and that is not written here; '' for any other."""
    return _OTHERS.get(PurePath(name).suffix.lower(), "")


def not_written(name: PurePath | str, endings: str) -> str:
    """A sentence for a name that ends as a format that is not written; '' for any other name.

    endings: those that are expected, such as '.bvh'.
    """
    kind = other_format(name)
    return kind and (
        f"expected a name that ends in {endings}, as the clip's own does: no {kind} is written "
        "(`twistcore export` makes a script for the scene that a clip came from)"
    )
