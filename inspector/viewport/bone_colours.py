"""Colours of the bodies for each role and part."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from inspector.viewport.bodies import BACK, BAND, FIN, FRONT, JOINT, PARTS, SIDE, STRIPE, Soup
from inspector.viewport.striped_skin import Skin
from inspector.widgets.theme import Theme

Colours = NDArray[np.uint8]
Floats = NDArray[np.float64]
# Shift of each of PARTS towards white, or towards black if negative.
_LIGHT = np.array([0.34, -0.24, -0.06, -0.60, -0.28, 0.50, -0.45, 0.82])
_DARK = np.array([0.10, -0.24, -0.06, 0.55, -0.28, 0.34, -0.52, 0.75])
_SCALED = np.array([0.10, -0.24, -0.06, -0.55, -0.28, 0.15, -0.45, 0.6])
GHOST_ALPHA = (50.0, 80.0, 45.0, 240.0, 45.0, 0.0, 32.0, 60.0)  # alpha of the ghost's PARTS
_BRIGHT = 0.40  # share of white in the edge of a coloured fin, which may be in the shade
_SUGGESTED = 0.35  # share of the colour of after in a suggestion
_SCALE = ("#f3cf52", "#e8603c", "#b0308f")  # |offset| of 60°, 120°, 180°, which differ in lightness


class Role(IntEnum):
    """The role of a bone. The role determines the colour."""

    PLAIN = 0
    CHOSEN = 1  # in the selected chain
    BEFORE = 2
    AFTER = 3
    SUGGESTED = 4  # corrected, but nobody has decided so: pale, with the stripes of after


def rgb(colour: str) -> Floats:
    """Return a colour '#rrggbb' as (3,) in 0…255."""
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], dtype=np.float64)


def mix(first: str, second: str, share: float) -> Floats:
    """Return a mixture of two colours, (3,) in 0…255, with the share 0…1 of the second one."""
    return (1.0 - share) * rgb(first) + share * rgb(second)


def shaded(colour: Floats, share: Floats) -> Floats:
    """Return colours (…, 3) shifted towards white (share > 0) or black (share < 0)."""
    goal = np.where(share > 0.0, 255.0, 0.0)[..., None]
    out: Floats = colour + np.abs(share)[..., None] * (goal - colour)
    return out


def palette(theme: Theme) -> Floats:
    """Return the colours by role and part, (5, 8, 3) in 0…255."""
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


def paint(shape: Soup | Skin, colours: Floats, roles: NDArray[np.int64]) -> Colours:
    """Return the colours of the vertices, (V, 3), for the roles of the bones, (bones,)."""
    role = np.where(shape.bone >= 0, roles[shape.bone], Role.PLAIN)
    return np.clip(colours[role, shape.part], 0.0, 255.0).astype(np.uint8)


def ghost_paint(shape: Soup | Skin, theme: Theme) -> Colours:
    """Return the colours of the ghost, (V, 4): translucent faces and an opaque stripe."""
    out = np.column_stack([np.tile(rgb(theme.before), (len(PARTS), 1)), GHOST_ALPHA])
    out[BACK, :3] = mix(theme.before, "#000000", 0.15)
    return out[shape.part].astype(np.uint8)


def scale_colour(theme: Theme, angle: Floats) -> Floats:
    """Return the colours of the |offset| scale, (n, 3) in 0…255, for angles (n,) in radians."""
    stops = np.stack([rgb(theme.bone), *(rgb(c) for c in _SCALE)])
    at = np.abs(angle) / np.pi * (len(stops) - 1)
    return np.stack([np.interp(at, range(len(stops)), stops[:, k]) for k in range(3)], axis=1)


def scale_paint(shape: Soup | Skin, theme: Theme, offsets: Floats) -> Colours:
    """Return vertex colours, (V, 3), that show each bone's |offset| in radians, (bones,)."""
    plain = np.append(offsets, 0.0)  # bone −1 is a sphere
    return shaded(scale_colour(theme, plain)[shape.bone], _SCALED[shape.part]).astype(np.uint8)
