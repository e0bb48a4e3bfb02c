"""The suffixes of all formats. Importing this module loads neither a reader nor numpy."""

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
    """A clip format, registered by a module in `known/`.

    Parameters
    ----------
    suffix : str
        Suffix of the files, in lower case and with the dot.
    read : str
        The reader, as 'module:function'. The function takes a path, `fps` and `tell`, and returns a
        Clip.
    place : int
        Position of the format in lists, which are sorted from common to rare.
    without_motion : str
        A function, as 'module:function', that returns True if a file with this suffix is not a
        clip. '' if all such files are clips.
    companion : str
        Suffix of a second file that belongs to each clip, in the same folder. '' if there is none.
    """

    suffix: str
    read: str
    place: int
    without_motion: str = ""
    companion: str = ""


@cache
def known_formats() -> Mapping[str, FormatInfo]:
    """Return all registered formats, keyed by suffix, in the order in which they are listed."""
    folder = import_module("twistcore.formats.known")
    names = [module.name for module in iter_modules(folder.__path__)]
    infos = [import_module(f"{folder.__name__}.{name}").FORMAT for name in names]
    return {info.suffix: info for info in sorted(infos, key=lambda info: info.place)}


CLIP_SUFFIXES = tuple(known_formats())
# Names of other motion formats, keyed by suffix. These cannot be written.
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
    """Return the suffix of a clip's file name in lower case, or '' for other names."""
    suffix = PurePath(name).suffix.lower()
    return suffix if suffix in CLIP_SUFFIXES else ""


def unsupported_format_name(name: PurePath | str) -> str:
    """Return the unsupported motion format that has a file's suffix, such as 'FBX', or ''."""
    return _OTHERS.get(PurePath(name).suffix.lower(), "")


def unsupported_suffix_message(name: PurePath | str, endings: str) -> str:
    """Return an error message if a file name has the suffix of an unsupported format, or ''.

    `endings` names the supported suffixes in the message, such as '.bvh'.
    """
    if PurePath(name).suffix.lower() == ".glb":
        return (
            f"expected a name that ends in {endings}, as the clip's own name does (`twistcore "
            "convert` then makes a .glb from it)"
        )
    kind = unsupported_format_name(name)
    return kind and (
        f"expected a name that ends in {endings}, as the clip's own name does, because {kind}"
        " files cannot be written (`twistcore export` makes a script for the scene that a "
        "clip came from)"
    )
