"""The data for the 3D figure in web pages: its mesh, its colours and its scripts.

The scripts are in assets/lesson_page. The 3D library three.js comes from the package trimesh, which
includes it for its own viewer.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

from inspector.bundled import ASSETS
from inspector.language import tr
from inspector.viewport.bodies import BoneSegment, build_soup
from inspector.viewport.bone_colours import bone_role_colours
from inspector.viewport.ground import Ground, ground_lines
from inspector.viewport.limb_circle import limb_bones
from inspector.viewport.striped_skin import STATIONS, build_skin
from inspector.widgets.theme import Theme
from twistcore.errors import TwistError
from twistcore.files.packed_numbers import encode_base64_array
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array

PAGE_PARTS = ASSETS / "lesson_page"
# The scripts that draw a figure, without the scripts for the page of a lesson.
FIGURE_SCRIPTS = (
    *("swing_twist.js", "clip_data.js", "orbit_camera.js", "striped_skin.js", "figure_view.js"),
    *("hand.js", "playback.js"),
)
_LIBRARY_ENDS = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


def figure_data(
    skeleton: Skeleton, bones: tuple[BoneSegment, ...], up: Array, height: float, ground: Ground
) -> dict[str, Any]:
    """Return the mesh of a figure without a skin, and the lines of the ground, as JSON data."""
    soup = build_soup(bones)
    points, lines, strength = ground_lines(ground)
    whole = "u2" if len(soup.vertices) < 1 << 16 else "u4"
    return {
        "parents": skeleton.parents.tolist(),
        "vertices": encode_base64_array(soup.vertices, "f4"),
        "joint": encode_base64_array(soup.joint, "u2"),
        "bone": encode_base64_array(soup.bone, "i2"),
        "part": encode_base64_array(soup.part, "u1"),
        "faces": encode_base64_array(soup.faces, whole),
        "edges": encode_base64_array(soup.edges, whole),
        "bones": [{"parent": b.parent, "tip": b.tip.tolist()} for b in bones],
        "ground": encode_base64_array(points[lines.ravel()], "f4"),
        "strength": encode_base64_array(strength[lines.ravel()], "f4"),
        "skin": None,
        "room": {
            "up": up.tolist(),
            "height": height,
            "level": ground.level,
            "radius": ground.radius,
        },
    }


def skin_data(
    bones: Sequence[BoneSegment], chains: Sequence[Chain], height: float
) -> dict[str, Any]:
    """Return the striped skin of the limbs as JSON data."""
    skin = build_skin(bones, chains, height)
    names = (
        *("parent", "child", "below", "above", "axis", "across", "radius", "circle"),
        *("fin", "fin_normals"),
    )
    return {name: getattr(skin, name).tolist() for name in names} | {
        "stations": STATIONS.tolist(),
        "bone": encode_base64_array(skin.bone, "i2"),
        "part": encode_base64_array(skin.part, "u1"),
        "faces": encode_base64_array(skin.faces[:, [0, 1, 2, 0, 2, 3]], "u4"),
        "edges": encode_base64_array(skin.edges, "u4"),
    }


def emphasised_bone_indices(
    bones: Sequence[BoneSegment], chain: Chain | None, skeleton: Skeleton
) -> list[int]:
    """Return the indices of the bones to emphasise on a page: those of a chain or limb."""
    if chain is None:
        return []
    pairs: Iterable[tuple[int, int]] = {
        (chain.parent, chain.child),
        (chain.child, chain.grandchild),
    }
    if isinstance(chain, Limb):
        pairs = set(limb_bones(chain, skeleton))
    return [k for k, bone in enumerate(bones) if (bone.parent, bone.child) in pairs]


def theme_data(theme: Theme) -> dict[str, Any]:
    """Return the colours of a theme as JSON data."""
    return {
        "dark": theme.dark,
        "roles": {name: value for name, value in vars(theme).items() if isinstance(value, str)},
        "palette": bone_role_colours(theme).clip(0.0, 255.0).round().astype(int).tolist(),
    }


def read_page_asset(name: str) -> str:
    """Return the text of a script or style sheet, given its file name."""
    return (PAGE_PARTS / name).read_text(encoding="utf-8")


def three_js() -> str:
    """Return the source text of three.js from the package trimesh, including its licence.

    Raises TwistError if three.js is missing.
    """
    package = find_spec("trimesh")
    if package is None or package.origin is None:
        raise _without_library(tr("trimesh is not installed"))
    try:
        with ZipFile(Path(package.origin).parent / "resources/templates/viewer.zip") as viewer:
            text = viewer.read("viewer.html.template").decode("utf-8")
        start, stop = text.index("/**\n * @license"), text.index(_LIBRARY_ENDS)
    except (OSError, KeyError, ValueError, BadZipFile):
        why = tr("the installed version does not contain three.js")
        raise _without_library(why) from None
    return text[start : stop + len(_LIBRARY_ENDS)]


def _without_library(why: str) -> TwistError:
    text = tr(
        "A web page with a figure needs three.js from the Python package trimesh, but {why}. "
        "Install the version of trimesh that this program requires.",
        why=why,
    )
    return TwistError(text)
