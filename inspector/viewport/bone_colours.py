"""Compute the colours of bodies from the role or the |offset| of each bone."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from inspector.viewport.bodies import BACK, BAND, FIN, FRONT, JOINT, PARTS, SIDE, STRIPE, Soup
from inspector.viewport.striped_skin import Skin
from inspector.widgets.theme import Theme

Colours = NDArray[np.uint8]
Floats = NDArray[np.float64]
# Lightness of each part in bodies.PARTS: the share of white that is mixed into the colour of the
# bone, or the share of black if negative. _LIGHT is for light themes and _DARK for dark themes, and
# _SCALED is for bones whose colour shows |offset|.
_LIGHT = np.array([0.34, -0.24, -0.06, -0.60, -0.28, 0.50, -0.45, 0.82])
_DARK = np.array([0.10, -0.24, -0.06, 0.55, -0.28, 0.34, -0.52, 0.75])
_SCALED = np.array([0.10, -0.24, -0.06, -0.55, -0.28, 0.15, -0.45, 0.6])
GHOST_ALPHA = (50.0, 80.0, 45.0, 240.0, 45.0, 0.0, 32.0, 60.0)  # opacity of PARTS, 0…255
_BRIGHT = 0.40  # share of white in the edge of a coloured fin, which may be in shadow
_SUGGESTED = 0.35  # share of the theme's `after` colour in a suggested correction
# Colours for an |offset| of 60°, 120° and 180°, which also differ in lightness
_SCALE = ("#f3cf52", "#e8603c", "#b0308f")


class Role(IntEnum):
    """The role of a bone in the image, which determines its colour."""

    PLAIN = 0
    CHOSEN = 1  # part of the selected chain or limb
    BEFORE = 2  # wrong, and shown before correction
    AFTER = 3  # shown after correction
    SUGGESTED = 4  # corrected, but not yet accepted: paler than AFTER, with the same stripes


def rgb(colour: str) -> Floats:
    """Return the red, green and blue values of a hex colour '#rrggbb', (3,) in 0…255."""
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], dtype=np.float64)


def mix(first: str, second: str, share: float) -> Floats:
    """Return a mixture of two hex colours '#rrggbb', (3,) in 0…255.

    `share` is the share of the second colour, 0…1.
    """
    return (1.0 - share) * rgb(first) + share * rgb(second)


def shaded(colour: Floats, share: Floats) -> Floats:
    """Mix colours with white (share > 0) or black (share < 0), and return them, (…, 3) in 0…255.

    Parameters
    ----------
    colour
        The colours, (…, 3) in 0…255.
    share
        The shares of white or black, (…) in −1…1.
    """
    goal = np.where(share > 0.0, 255.0, 0.0)[..., None]
    out: Floats = colour + np.abs(share)[..., None] * (goal - colour)
    return out


def bone_role_colours(theme: Theme) -> Floats:
    """Return the colour of each part of a bone in each role, (roles, parts, 3) in 0…255."""
    by_role = theme.bone, theme.bone, theme.before, theme.after
    colours = np.stack([*(rgb(c) for c in by_role), mix(theme.bone, theme.after, _SUGGESTED)])
    out = shaded(colours[:, None], _DARK if theme.dark else _LIGHT)
    if theme.dark:
        out[:, JOINT] = mix(theme.bone, theme.surface, 0.28)
    for role in (Role.BEFORE, Role.AFTER):
        out[role, FIN] = shaded(rgb(by_role[role]), np.array(_BRIGHT))
    accent = out[Role.CHOSEN]
    accent[FRONT] = mix(theme.bone, theme.accent, 0.40)
    accent[SIDE] = mix(theme.bone, theme.accent, 0.55)
    accent[BACK] = shaded(accent[SIDE], np.array(-0.30))
    accent[STRIPE] = rgb(theme.accent)
    accent[BAND] = mix(theme.accent, "#000000", 0.30)
    striped = [STRIPE, BAND, FIN]
    out[Role.SUGGESTED, striped] = out[Role.AFTER, striped]
    return out


def vertex_colours_by_role(
    shape: Soup | Skin, colours: Floats, roles: NDArray[np.int64]
) -> Colours:
    """Return the colour of each vertex of a shape according to its bone's role, (vertices, 3).

    Parameters
    ----------
    shape
        The bodies or the skin to colour.
    colours
        The result of :func:`bone_role_colours`, (roles, parts, 3).
    roles
        The role of each bone, (bones,).
    """
    role = np.where(shape.bone >= 0, roles[shape.bone], Role.PLAIN)
    return np.clip(colours[role, shape.part], 0.0, 255.0).astype(np.uint8)


def ghost_vertex_colours(shape: Soup | Skin, theme: Theme) -> Colours:
    """Return the colour and opacity of each vertex of the ghost, (vertices, 4) in 0…255.

    The ghost is the translucent figure before correction. Only its stripes are nearly opaque.
    """
    out = np.column_stack([np.tile(rgb(theme.before), (len(PARTS), 1)), GHOST_ALPHA])
    out[BACK, :3] = mix(theme.before, "#000000", 0.15)
    return out[shape.part].astype(np.uint8)


def offset_scale_colours(theme: Theme, angle: Floats) -> Floats:
    """Return the colours that represent |offset| on the colour scale, (n, 3) in 0…255.

    `angle` contains the offsets in radians, (n,).
    """
    stops = np.stack([rgb(theme.bone), *(rgb(c) for c in _SCALE)])
    at = np.abs(angle) / np.pi * (len(stops) - 1)
    return np.stack([np.interp(at, range(len(stops)), stops[:, k]) for k in range(3)], axis=1)


def vertex_colours_by_offset(shape: Soup | Skin, theme: Theme, offsets: Floats) -> Colours:
    """Return the colour of each vertex of a shape according to its bone's |offset|, (vertices, 3).

    Parameters
    ----------
    shape
        The bodies or the skin to colour.
    theme
        The theme of the window.
    offsets
        The |offset| of each bone in radians, (bones,).
    """
    plain = np.append(offsets, 0.0)  # for the spheres at joints, whose bone is −1
    return shaded(offset_scale_colours(theme, plain)[shape.bone], _SCALED[shape.part]).astype(
        np.uint8
    )
