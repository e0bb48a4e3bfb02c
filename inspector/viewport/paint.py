"""Colours of the bodies: which role a bone plays, and what its faces look like in it."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from inspector.theme import Theme
from inspector.viewport.bodies import BACK, FRONT, JOINT, SIDE, STRIPE, Soup

Colours = NDArray[np.uint8]


class Role(IntEnum):
    """What the colour of a bone says."""

    PLAIN = 0
    CHOSEN = 1  # of the selected chain
    BEFORE = 2
    AFTER = 3


def rgb(colour: str) -> NDArray[np.float64]:
    """'#rrggbb' as (3,) in 0…255."""
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], dtype=np.float64)


def mix(first: str, second: str, share: float) -> NDArray[np.float64]:
    """A colour with a share, 0…1, of a second one; (3,) in 0…255."""
    return (1.0 - share) * rgb(first) + share * rgb(second)


def palette(theme: Theme) -> NDArray[np.float64]:
    """Colours by role and part, (4, 5, 3) in 0…255."""
    out = np.empty((len(Role), 5, 3))
    black, white = "#000000", "#ffffff"
    for role, colour in (
        (Role.PLAIN, theme.bone),
        (Role.CHOSEN, theme.bone),
        (Role.BEFORE, theme.before),
        (Role.AFTER, theme.after),
    ):
        faces = out[role]
        faces[FRONT] = mix(colour, white, 0.10 if theme.dark else 0.34)
        faces[SIDE] = mix(colour, black, 0.06)
        faces[BACK] = mix(colour, black, 0.24)
        faces[STRIPE] = mix(colour, white, 0.55) if theme.dark else mix(colour, black, 0.60)
        faces[JOINT] = mix(theme.bone, theme.surface if theme.dark else black, 0.28)
    accent = out[Role.CHOSEN]
    accent[FRONT] = mix(theme.bone, theme.accent, 0.40)
    accent[SIDE] = mix(theme.bone, theme.accent, 0.55)
    accent[BACK] = mix(mixed_hex(theme.bone, theme.accent, 0.55), black, 0.30)
    accent[STRIPE] = rgb(theme.accent)
    return out


def mixed_hex(first: str, second: str, share: float) -> str:
    """A mixed colour as '#rrggbb'."""
    return "#" + "".join(f"{round(c):02x}" for c in mix(first, second, share))


def paint(soup: Soup, colours: NDArray[np.float64], roles: NDArray[np.int64]) -> Colours:
    """Colours (V, 3) of the vertices, from the roles (bones,)."""
    role = np.where(soup.bone >= 0, roles[soup.bone], Role.PLAIN)
    return np.clip(colours[role, soup.part], 0.0, 255.0).astype(np.uint8)


def ghost_paint(soup: Soup, theme: Theme) -> Colours:
    """Colours (V, 4) of the ghost: thin faces that let the solid through, a stripe to follow."""
    out = np.empty((5, 4))
    out[:, :3] = rgb(theme.before)
    out[BACK, :3] = mix(theme.before, "#000000", 0.15)
    out[:, 3] = 45.0
    out[[FRONT, BACK, STRIPE], 3] = (50.0, 80.0, 240.0)
    return out[soup.part].astype(np.uint8)
