"""The suffixes of all formats, available without loading a reader or numpy."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import PurePath
from pkgutil import iter_modules
from types import MappingProxyType

from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class FormatInfo:
    """A clip format, as registered by a module in `known/`.

    Parameters
    ----------
    suffix : str
        Suffix of the files, in lower case and with the dot.
    read : str
        The reader as 'module:function'; it takes a path, `fps` and `tell`, and returns a Clip.
    place : int
        Position in lists, which go from common to rare.
    without_motion : str
        A function as 'module:function' that returns True if a file with this suffix is not a clip;
        "" if all such files are clips.
    companion : str
        The suffix of a second file in the same folder that belongs to each clip; "" for none.
    """

    suffix: str
    read: str
    place: int
    without_motion: str = ""
    companion: str = ""


@cache
def known_formats() -> Mapping[str, FormatInfo]:
    """Return all registered formats, keyed by suffix, in the order used for lists."""
    folder = import_module("twistcore.formats.known")
    names = [module.name for module in iter_modules(folder.__path__)]
    infos = [import_module(f"{folder.__name__}.{name}").FORMAT for name in names]
    return {info.suffix: info for info in sorted(infos, key=lambda info: info.place)}


CLIP_SUFFIXES = tuple(known_formats())
# Other motion formats, keyed by suffix. None of them can be written.
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
    """Return the suffix of a clip's name in lower case, or '' for other names."""
    suffix = PurePath(name).suffix.lower()
    return suffix if suffix in CLIP_SUFFIXES else ""


def other_format(name: PurePath | str) -> str:
    """Return the name of an unsupported motion format with this suffix, or '' for other files."""
    return _OTHERS.get(PurePath(name).suffix.lower(), "")


def not_written(name: PurePath | str, endings: str) -> str:
    """Return a message for a file name with the suffix of an unsupported format, or ''.

    `endings` are the supported suffixes, such as '.bvh'.
    """
    kind = other_format(name)
    return kind and (
        f"expected a name that ends in {endings}, as the clip's own name does, because {kind}"
        " files cannot be written (`twistcore export` makes a script for the scene that a "
        "clip came from)"
    )
